#!/usr/bin/env bash
# tools/rig/run --native on a kernel that has its modules: Debian's PREEMPT_RT kernel with gpio-sim beside it, in a virtual
# machine with an emulated processor. The device tests run there, none is skipped. Skipped (77) where the packages or the
# kernel cannot be had.
#
#   vm_test.sh BUILD_FOLDER
set -euo pipefail
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$build/rig-test/vm
rm -rf "$out"
mkdir -p "$out"
if ! command -v qemu-system-x86_64 >/dev/null || ! ls -d /lib/modules/*-rt-amd64/build >/dev/null 2>&1; then
  echo "skipped: QEMU or the headers of a PREEMPT_RT kernel are not installed (tools/setup.sh vm)"
  exit 77
fi
if ! "$root/tools/rig/build_vm.sh" >"$out/log" 2>&1; then
  cat "$out/log"
  # Its package comes from the network; what else fails is ours.
  ! grep -q "cannot be fetched" "$out/log" || { echo "skipped: the kernel cannot be fetched"; exit 77; }
  exit 1
fi
"$root/tools/rig/run" self-check --vm=emulated --build "$build" --limit 600 --out "$out"
