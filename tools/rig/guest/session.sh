#!/bin/bash
# What runs in the rig: sets the devices up, then runs the scenario. Its exit status is the scenario's.
set -euo pipefail
rig=$(cd "$(dirname "$0")/.." && pwd)
set -a
. "$rig/devices.env"
set +a
. "$rig/guest/devices.sh"
set_up_devices
cd "$RIG_OUT"
export RIG="$rig"
if [ -e "$rig/scenarios/$RIG_SCENARIO.toml" ]; then
  exec "$rig/guest/controller.sh" "$rig/scenarios/$RIG_SCENARIO.toml"
fi
exec "$rig/scenarios/$RIG_SCENARIO.sh"
