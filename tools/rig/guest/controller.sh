#!/bin/bash
# A scenario with the controller in it, whose configuration tools/rig/run has made of the scenario's robot and scene: has
# the plant run it.
#
#   controller.sh SCENARIO.toml
set -euo pipefail
scenario=$1
value() { sed -n "s/^$1 = \"\(.*\)\"/\1/p" "$scenario"; }
mkdir -p /run/vergence /var/lib/vergence
case $(value program) in
  '' | vergenced) program=("$RIG_BUILD/bin/vergenced" --realtime=ignore) ;;
  bringup) program=("$RIG/guest/bringup.sh") ;;
  *) program=("$RIG_BUILD/bin/$(value program)") ;;
esac
read -ra arguments <<<"$(value arguments)"
config=$RIG_OUT/robot/robot.vcfg
pace=()
[ "$RIG_TIME" = virtual ] || pace=(--real-time)
exec "$RIG_BUILD/bin/vergence_rig_plant" "${pace[@]}" --scenario "$scenario" --config "$config" --out "$RIG_OUT" \
  --command "tools/rig/run $RIG_SCENARIO" -- "${program[@]}" --config "$config" "${arguments[@]}"
