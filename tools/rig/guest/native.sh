#!/bin/bash
# The same session on this machine's own kernel, by its modules; what it set up is taken down again. Needs root.
# RIG_SESSION RIG_SCENARIO RIG_OUT RIG_BUILD as in init.sh. First it looks for all that is needed, says what is
# missing and what to do about it, and changes nothing where something is.
set -uo pipefail
rig=$(cd "$(dirname "$0")/.." && pwd)
. "$rig/devices.env"

missing=0
need() {
  echo "tools/rig/run --native: $1" >&2
  echo "  -> $2" >&2
  missing=1
}

# module, option of the kernel's configuration, since which version, whether a kernel has it built in or can load it
need_module() {
  modprobe --dry-run --quiet "$1" 2>/dev/null ||
    need "this kernel ($(uname -r)) has no module $1" \
      "boot one with CONFIG_$2 (since Linux $3; on Ubuntu it is in linux-modules-extra), or leave --native out"
}

need_file_system() {
  grep -qw "$1" /proc/filesystems || modprobe --dry-run --quiet "$1" 2>/dev/null ||
    need "this kernel has no $1" "boot one with CONFIG_$2, or leave --native out"
}

look() {
  local tool device
  for tool in modprobe:kmod ip:iproute2 unshare:util-linux; do
    command -v "${tool%:*}" >/dev/null || need "${tool%:*} is missing" "apt install ${tool#*:}"
  done
  if [ ! -e /proc/modules ]; then
    need "this kernel loads no modules" "run on a machine whose kernel does, or leave --native out"
  fi
  need_module vivid VIDEO_VIVID 3.18
  need_module vcan CAN_VCAN 2.6.25
  need_module can-raw CAN_RAW 2.6.25
  modprobe --dry-run --quiet gpio-sim 2>/dev/null ||
    need "this kernel ($(uname -r)) has no module gpio-sim" \
      "tools/rig/build_gpio_sim.sh builds it for kernels of Debian; or boot one with CONFIG_GPIO_SIM (since Linux 5.17)"
  need_file_system configfs CONFIGFS_FS
  need_file_system tracefs FTRACE
  need_file_system debugfs DEBUG_FS
  [ ! -d /sys/module/vivid ] || need "vivid is loaded already, with other options" "rmmod vivid"
  for device in "$RIG_LEFT_CAMERA" "$RIG_LEFT_DISPLAY" "$RIG_RIGHT_CAMERA" "$RIG_RIGHT_DISPLAY"; do
    [ ! -e "$device" ] || need "$device is there already" "unplug it, or change tools/rig/devices.env"
  done
  for device in "$RIG_CAN" "$RIG_TEST_CAN" "$RIG_OTHER_TEST_CAN"; do
    [ ! -e "/sys/class/net/$device" ] || need "$device is there already" "change tools/rig/devices.env"
  done
  [ ! -d "/sys/kernel/config/gpio-sim/$RIG_GPIO_CHIP" ] ||
    need "the chip $RIG_GPIO_CHIP is there already" "change tools/rig/devices.env"
  [ ! -S /run/vergence/command ] || need "/run/vergence/command is there: vergenced runs" "systemctl stop vergenced"
  [ -n "${RIG_OWN_CLOCK:-}" ] || ! grep -qs '^kind = "clock-step"' "$rig/scenarios/$RIG_SCENARIO.toml" ||
    need "$RIG_SCENARIO sets the clock, which here is this machine's" "leave --native out"
}

look
[ $missing = 0 ] || exit 1

tracing=/sys/kernel/tracing
# The trace's settings as they were: file and value.
declare -A trace_was
keep_trace() {
  local file
  for file in trace_clock buffer_size_kb tracing_on events/gpio/gpio_value/enable events/v4l2/v4l2_dqbuf/enable; do
    # Of the clocks, the one in brackets is set.
    trace_was[$file]=$(sed 's/.*\[\(.*\)\].*/\1/; s/ .*//' "$tracing/$file")
  done
}

# Each by itself: what was not set up yet is no reason to leave the rest.
take_down() {
  local status=$? file chip=/sys/kernel/config/gpio-sim/$RIG_GPIO_CHIP
  if [ -d "$chip" ]; then
    echo 0 >"$chip/live"
    rmdir "$chip"/bank0/line* "$chip/bank0" "$chip"
  fi
  for file in "${!trace_was[@]}"; do echo "${trace_was[$file]}" >"$tracing/$file"; done
  if [ "${#trace_was[@]}" -gt 0 ]; then
    echo 0 >$tracing/events/gpio/gpio_value/filter
    echo 0 >$tracing/events/v4l2/v4l2_dqbuf/filter
  fi
  ip link del "$RIG_CAN" 2>/dev/null
  ip link del "$RIG_TEST_CAN" 2>/dev/null
  ip link del "$RIG_OTHER_TEST_CAN" 2>/dev/null
  [ ! -d /sys/module/vivid ] || rmmod vivid
  exit $status
}
trap take_down EXIT

fail() { echo "tools/rig/run --native: $*" >&2; exit 1; }
number() { echo "${1#/dev/video}"; }
modprobe vivid n_devs=2 node_types=0x101,0x101 \
  vid_cap_nr="$(number "$RIG_LEFT_CAMERA"),$(number "$RIG_RIGHT_CAMERA")" \
  vid_out_nr="$(number "$RIG_LEFT_DISPLAY"),$(number "$RIG_RIGHT_DISPLAY")" || fail "vivid cannot be loaded: see dmesg"
modprobe vcan || fail "vcan cannot be loaded: see dmesg"
modprobe can-raw || fail "can-raw cannot be loaded: see dmesg"
modprobe gpio-sim || fail "gpio-sim cannot be loaded: see dmesg"
[ -d /sys/kernel/config/gpio-sim ] || mount -t configfs configfs /sys/kernel/config || fail "configfs cannot be mounted"
[ -d $tracing/events ] || mount -t tracefs tracefs $tracing || fail "tracefs cannot be mounted"
[ -e /sys/kernel/debug/gpio ] || mount -t debugfs debugfs /sys/kernel/debug || fail "debugfs cannot be mounted"
for event in gpio/gpio_value v4l2/v4l2_dqbuf; do
  [ -d "$tracing/events/$event" ] || fail "this kernel does not trace $event: boot one with CONFIG_FTRACE and its events"
done
keep_trace
# The controller's folders are the session's own; those of a service stay as they are.
export RIG_NATIVE=1
unshare --mount --propagation private /bin/bash -c '
  mkdir -p /run/vergence /var/lib/vergence &&
    mount -t tmpfs tmpfs /run/vergence && mount -t tmpfs tmpfs /var/lib/vergence && exec "$RIG_SESSION"'
