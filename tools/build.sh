#!/usr/bin/env bash
# Configures and builds a preset of CMakePresets.json (default: release), with ccache where it is installed.
#
#   tools/build.sh [PRESET] [cmake --build options]
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true

launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake --preset "$preset" "${launcher[@]}" >/dev/null
cmake --build --preset "$preset" "$@"
