#!/usr/bin/env bash
# From a fresh Debian 12 or 13 to a simulated robot that follows a crab by one photo of it: installs what is missing,
# builds, runs one experiment, prints what came out and where its report is.
#
#   tools/demo.sh                     servo-position, about two minutes
#   tools/demo.sh SCENARIO [OPTION]   another; `tools/demo.sh --list` names them
#   tools/demo.sh poses [FOLDER]      no robot: renders 60 stereo pairs of a crab and finds its pose in each
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh build run
tools/build.sh release --target vergence
vergence=build/release/bin/vergence

if [ "${1:-}" != poses ]; then
  exec "$vergence" demo "$@"
fi
out=${2:-out/poses}
"$vergence" render tools/render/scenes/demo.toml -o "$out"
"$vergence" estimate "$out" --overlay "$out/overlay" --json "$out/poses.jsonl"
echo
echo "Pictures with the posed model:  $out/overlay/"
echo "Poses, one JSON object a line:  $out/poses.jsonl"
