#!/usr/bin/env bash
# Runs every experiment on the simulated robot and writes docs/experiments.md; about a quarter of an hour on two cores.
# Reports of each are left in out/SCENARIO/report.html.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh build run
tools/build.sh release --target vergence
build/release/bin/vergence demo --all --page docs/experiments.md "$@"
