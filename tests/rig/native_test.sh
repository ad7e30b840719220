#!/usr/bin/env bash
# tools/rig/run --native where something is missing: each thing is named with its remedy, and nothing was loaded,
# made or mounted. Skipped (77) without root, whom --native is for.
#
#   native_test.sh BUILD_FOLDER
set -euo pipefail
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
fail() { echo "$*"; cat "$work/said" "$work/asked"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
: >"$work/said" >"$work/asked"

run() {
  local status=0
  "$root/tools/rig/run" "$1" --native --build "$build" --out "$work/out" >"$work/said" 2>&1 || status=$?
  [ $status = 1 ] || fail "status $status, wanted 1"
}

if [ "$(id -u)" != 0 ]; then
  run probe
  grep -q "run it as root" "$work/said" || fail "who must run it is not said"
  echo "skipped: needs root"
  exit 77
fi

# A kernel that has all modules but one, as Debian's PREEMPT_RT kernel has not gpio-sim; each question is kept.
mkdir "$work/bin"
cat >"$work/bin/modprobe" <<END
#!/bin/sh
echo "modprobe \$*" >>"$work/asked"
case "\$*" in *gpio-sim*) exit 1 ;; esac
END
chmod +x "$work/bin/modprobe"
before=$(cat /proc/mounts)
PATH=$work/bin:$PATH run faults-controller
grep -q "no module gpio-sim" "$work/said" || fail "the missing module is not named"
! grep -q "no module vivid" "$work/said" || fail "a module is missed that is there"
grep -q -- "-> tools/rig/build_gpio_sim.sh builds it" "$work/said" || fail "its remedy is not named"
grep -q "sets the clock" "$work/said" || fail "a scenario that sets the machine's clock is not refused"
[ "$(grep -c "" "$work/asked")" -gt 2 ] || fail "modprobe was not asked"
! grep -v -- --dry-run "$work/asked" || fail "a module was loaded"
[ "$before" = "$(cat /proc/mounts)" ] || fail "something was mounted"
echo "refused, with its reasons; nothing changed"
