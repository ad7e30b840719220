#!/usr/bin/env bash
# Measures every claim of accuracy and makes docs/accuracy.md and its figures anew: renders the data sets (once, into
# out/accuracy), runs them, judges. Under a quarter of an hour on two cores.
#
#   tools/accuracy.sh [--quick] [options of `vergence accuracy`]
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh build run
tools/build.sh release --target vergence
build/release/bin/vergence accuracy -o docs/accuracy.md "$@"
