#!/usr/bin/env bash
# The controller's configuration for a scenario: rig and model as the scene has them, the robot with this rig's devices.
# On the host: in User Mode Linux the same takes half a minute.
#
#   make_robot.sh ROBOT SCENE.toml BUILD_FOLDER FOLDER [STAMP_TO_MID_EXPOSURE_MS]
set -euo pipefail
rig=$(cd "$(dirname "$0")" && pwd)
robot=$1 scene=$2 programs=$3/bin folder=$4
script=()
while IFS='=' read -r name value; do
  case $name in RIG_*) value=${value#\'} script+=(-e "s|@$name@|${value%\'}|g") ;; esac
done <"$rig/devices.env"
[ -z "${5:-}" ] || script+=(-e "s|^\(stamp_to_mid_exposure_ms = \)[-0-9.]*|\1$5|")
rm -rf "$folder"
"$programs/vergence" render "$scene" -o "$folder" --frames 1 >/dev/null
sed "${script[@]}" "$rig/robots/$robot.toml" >"$folder/robot.toml"
"$programs/vergence" config build "$folder/robot.toml" -o "$folder/robot.vcfg" >/dev/null
