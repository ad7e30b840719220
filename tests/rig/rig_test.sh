#!/usr/bin/env bash
# The rig itself: the device tests run in its kernel, nothing on this machine changes, and the probe of each driver
# finds what the plant did, twice the same to the byte; and single scenarios of the controller. Skipped (77) where Debian's kernel source is not installed and
# cannot be, or no kernel is built yet and none is to be.
#
#   rig_test.sh BUILD_FOLDER self_check|probe|SCENARIO_WITH_UNDERSCORES
set -euo pipefail
build=$1
part=$2
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$build/rig-test
rm -rf "$out/$part"
mkdir -p "$out/$part"
if ! ls /usr/src/linux-source-6.*.tar.xz >/dev/null 2>&1; then
  echo "skipped: Debian's linux-source package is not installed (tools/setup.sh rig)"
  exit 77
fi
"$root/tools/rig/build_kernel.sh" >/dev/null

run() { "$root/tools/rig/run" "$@" --build "$build" --limit 1200; }
fail() { echo "$*"; exit 1; }

case $part in
  self_check)
    mark=/usr/share/vergence-rig-was-here
    run self-check --out "$out/$part"
    [ ! -e "$mark" ] || fail "the guest could write $mark on this machine"
    ;;
  probe)
    run probe --out "$out/$part/first"
    run probe --out "$out/$part/second"
    for file in log.csv controller.log notes.txt; do
      cmp "$out/$part/first/$file" "$out/$part/second/$file" || fail "two runs differ in $file"
    done
    # What the probe believes of joint and motor is what the plant's were.
    said=$(tail -1 "$out/$part/first/controller.log")
    did=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i }
      END { printf "joint 4 at %.6f rad, tilt at %d steps", $at["q4_rad"], $at["tilt_steps"] }' \
      "$out/$part/first/log.csv")
    # To a count of the encoder (6e-6 rad).
    awk -v a="$said" -v b="$did" 'BEGIN { split(a, x, " "); split(b, y, " "); d = x[4] - y[4]
      exit !(d < 1.2e-5 && d > -1.2e-5 && x[8] == y[8]) }' || fail "the probe says '$said', the plant '$did'"
    ;;
  # vergenced itself, judged by what the plant's motors did.
  *) run "${part//_/-}" --out "$out/$part" ;;
esac
