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
can/bit rate/skipped
can/bus state/skipped
can/error counters/skipped
END
# A virtual bus has no bits, and no errors.

# No rt: virtual time tells nothing of real time, and the kernel has no PREEMPT_RT.
"$RIG_BUILD/bin/vergence" bringup --config "$config" --only files,cameras,can,gpio --seconds 3 \
  --out pictures "$@" >bringup.txt
status=$?
cat bringup.txt

# The table's columns; a remedy's line is none.
sed -nE 's/^(files|cameras|can|gpio) +(.{26}) (pass|warn|FAIL|skipped).*/\1\/\2\/\3/p' bringup.txt |
  sed 's/ *\/\([^/]*\)$/\/\1/' | grep -v '/pass$' | sort >found
if ! diff expected found; then
  echo "bringup.sh: < is what was expected beside passes, > is what there was (status $status)"
  exit 1
fi
[ "$(grep -cE '^(files|cameras|can|gpio) ' bringup.txt)" -gt 60 ]
