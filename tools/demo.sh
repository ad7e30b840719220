#!/usr/bin/env bash
# From a fresh Debian 12 or 13 to poses: installs what is missing, builds, renders a small sequence of a crab seen
# by two cameras, and finds it in every frame from one photo of it.
#
#   tools/demo.sh [OUTPUT FOLDER]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/demo}
tools/setup.sh build run
tools/build.sh release --target vergence

vergence=build/release/bin/vergence
"$vergence" render tools/render/scenes/demo.toml -o "$out"
"$vergence" estimate "$out" --overlay "$out/overlay" --json "$out/poses.jsonl"
echo
echo "Pictures with the posed model:  $out/overlay/"
echo "Poses, one JSON object a line:  $out/poses.jsonl"
