#!/bin/bash
# A scenario with the controller in it: makes its configuration from the scenario's scene and robot, then has the
# plant run it.
#
#   controller.sh SCENARIO.toml
set -euo pipefail
scenario=$1
folder=$(dirname "$scenario")
value() { sed -n "s/^$1 = \"\(.*\)\"/\1/p" "$scenario"; }
robot=$RIG_OUT/robot
rm -rf "$robot"
"$RIG_BUILD/bin/vergence" render "$folder/$(value scene)" -o "$robot" --frames 1 >/dev/null
script=$(mktemp)
for name in ${!RIG_*}; do printf 's|@%s@|%s|g\n' "$name" "${!name}"; done >"$script"
sed -f "$script" "$RIG/robots/$(value robot).toml" >"$robot/robot.toml"
"$RIG_BUILD/bin/vergence" config build "$robot/robot.toml" -o "$robot/robot.vcfg" >/dev/null
mkdir -p /run/vergence /var/lib/vergence
case $(value program) in
  '' | vergenced) program=("$RIG_BUILD/bin/vergenced" --realtime=ignore) ;;
  bringup) program=("$RIG/guest/bringup.sh") ;;
  *) program=("$RIG_BUILD/bin/$(value program)") ;;
esac
read -ra arguments <<<"$(value arguments)"
exec "$RIG_BUILD/bin/vergence_rig_plant" --scenario "$scenario" --config "$robot/robot.vcfg" --out "$RIG_OUT" \
  --command "tools/rig/run $RIG_SCENARIO" -- "${program[@]}" --config "$robot/robot.vcfg" "${arguments[@]}"
