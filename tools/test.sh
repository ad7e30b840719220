#!/usr/bin/env bash
# Everything a change must pass, on a fresh Debian 12 or 13: installs what is missing, builds, and runs every test
# through CTest: in release, under sanitizers, and (the core) on an emulated arm64. Ends with CTest's summary.
#
#   tools/test.sh            all of it
#   tools/test.sh --quick    release build only
set -euo pipefail
cd "$(dirname "$0")/.."
quick=0
case "${1:-}" in
  "") ;;
  --quick) quick=1 ;;
  *) sed -n '2,7p' "$0"; exit 2 ;;
esac

jobs=$(nproc)
tools/setup.sh build run test lint
# Without it the tests of the rig are skipped, and say so.
tools/setup.sh rig || echo "tools/test.sh: the rig is left out: its packages cannot be installed"
if [ "$(uname -m)" = x86_64 ]; then
  tools/setup.sh vm || echo "tools/test.sh: the rig's virtual machine is left out: its packages cannot be installed"
fi
if [ "$quick" = 0 ]; then
  echo "== sanitizers"
  tools/build.sh asan-ubsan
  ctest --preset asan-ubsan -j "$jobs" --output-on-failure
  echo "== arm64, emulated"
  tools/setup.sh cross
  tools/cross-sysroot.sh
  tools/build.sh aarch64
  ctest --preset aarch64 -j "$jobs" --output-on-failure
fi
echo "== release"
tools/build.sh release
ctest --preset release -j "$jobs" --output-on-failure
