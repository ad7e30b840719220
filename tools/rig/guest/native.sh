#!/bin/bash
# The same session on this machine's own kernel, by its modules; what it set up is taken down again. Needs root.
# RIG_SESSION RIG_SCENARIO RIG_OUT RIG_BUILD as in init.sh.
set -euo pipefail
rig=$(cd "$(dirname "$0")/.." && pwd)
. "$rig/devices.env"
fail() { echo "tools/rig/run --native: $*" >&2; exit 1; }

for module in vivid vcan gpio-sim; do
  modprobe --dry-run "$module" 2>/dev/null ||
    fail "this kernel has no module $module: take one that has, or leave --native out"
done
for device in "$RIG_LEFT_CAMERA" "$RIG_LEFT_DISPLAY" "$RIG_RIGHT_CAMERA" "$RIG_RIGHT_DISPLAY"; do
  [ ! -e "$device" ] || fail "$device is there already: unplug it, or change tools/rig/devices.env"
done
[ ! -e "/sys/class/net/$RIG_CAN" ] || fail "$RIG_CAN is there already: change tools/rig/devices.env"

take_down() {
  local chip=/sys/kernel/config/gpio-sim/$RIG_GPIO_CHIP
  if [ -d "$chip" ]; then
    echo 0 >"$chip/live"
    rmdir "$chip"/bank0/line* "$chip/bank0" "$chip"
  fi
  ip link del "$RIG_CAN" 2>/dev/null
  ip link del "$RIG_TEST_CAN" 2>/dev/null
  rmmod vivid 2>/dev/null
  echo 0 >/sys/kernel/tracing/events/gpio/gpio_value/enable
  echo 0 >/sys/kernel/tracing/events/v4l2/v4l2_dqbuf/enable
}
trap take_down EXIT
number() { echo "${1#/dev/video}"; }
modprobe vivid n_devs=2 node_types=0x101,0x101 \
  vid_cap_nr="$(number "$RIG_LEFT_CAMERA"),$(number "$RIG_RIGHT_CAMERA")" \
  vid_out_nr="$(number "$RIG_LEFT_DISPLAY"),$(number "$RIG_RIGHT_DISPLAY")"
modprobe vcan
modprobe gpio-sim
[ -d /sys/kernel/config/gpio-sim ] || mount -t configfs configfs /sys/kernel/config
[ -d /sys/kernel/tracing/events ] || mount -t tracefs tracefs /sys/kernel/tracing
[ -e /sys/kernel/debug/gpio ] || mount -t debugfs debugfs /sys/kernel/debug
"$RIG_SESSION"
