#!/usr/bin/env bash
# Makes docs/accuracy.md and its figure anew: renders the sequences, runs both methods over them from many random
# starts. Takes some minutes.
#
#   tools/accuracy.sh [SEEDS]
set -euo pipefail
cd "$(dirname "$0")/.."
seeds=${1:-10}
tools/setup.sh build run
tools/build.sh release --target vergence
vergence=build/release/bin/vergence
sets=()
for scene in marker_still marker_lateral_slow marker_lateral_medium marker_lateral_fast crab_still card_flat; do
  "$vergence" render "tools/render/scenes/$scene.toml" -o "out/accuracy/$scene" --frames 45
  sets+=("out/accuracy/$scene")
done
"$vergence" accuracy "${sets[@]}" --seeds "$seeds" --frames 45 -o docs/accuracy.md --figure docs/images/accuracy.png
