#!/bin/bash
# `vergence bringup` against the rig's devices, while the plant makes pictures and answers for the drives: each of its
# checks must pass but those that cannot here, which are named below. Its exit status says so.
#
#   bringup.sh --config ROBOT.vcfg [options of vergence bringup]
set -uo pipefail
config=${2%.vcfg}.toml
shift 2

# What may be something else than a pass, and why: group, check, outcome; a row that is here and passes is an error, too.
cat >expected <<'END'
cameras/left rate/warn
cameras/right rate/warn
cameras/left frames/fail
cameras/right frames/fail
cameras/left exposure/skipped
cameras/right exposure/skipped
cameras/left white_balance/skipped
cameras/right white_balance/skipped
cameras/left gain/warn
cameras/right gain/warn
can/bit rate/skipped
can/bus state/skipped
can/error counters/skipped
can/restart after bus-off/skipped
END
# rate, frames: vivid counts 60 pictures a second, of which it gives 40, each at a tick of the kernel (docs/rig.md).
# exposure, white_balance: it has neither. gain: the robot leaves it to the camera, whose gain changes no picture.
# A virtual bus has no bits, and no errors to count or to recover from.
# In real time that is as the machine is.
any='^cameras/\(\(left\|right\) \(rate\|frames\)\|skew of the pair\)/'
[ "$RIG_TIME" = real ] || any='^$'
case " $* " in *' --move '*) echo 'gpio/loop-back/skipped' >>expected ;; esac # no step line is wired to an input

# No rt: virtual time tells nothing of real time, and the kernel has no PREEMPT_RT.
"$RIG_BUILD/bin/vergence" bringup --config "$config" --only files,cameras,can,gpio --seconds 3 \
  --out pictures --json findings.json "$@"
echo "status $?"

awk -F'"' '/"check"/ { check = $4 } /"group"/ { group = $4 } /"outcome"/ { outcome = $4 }
  /}/ && group != "" { print group "/" check "/" outcome; group = "" }' findings.json >all
[ "$(grep -c . all)" -ge 80 ] || { echo "bringup.sh: there are too few rows"; exit 1; }
# By files: this root has no /dev/fd.
grep -v "$any" expected | sort >wanted
grep -v '/pass$' all | grep -v "$any" | sort >found
if ! diff wanted found; then
  echo "bringup.sh: < is what was expected beside passes, > is what there was"
  exit 1
fi
