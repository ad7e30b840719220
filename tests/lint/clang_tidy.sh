#!/usr/bin/env bash
# clang-tidy over our own code, with the compile commands of a build folder. A file that has not changed since it
# was last found clean, nor has any header of ours, is not checked again.
#
#   clang_tidy.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "$1")
cd "$(dirname "$0")/../.."
cache=$build/clang-tidy-clean
mkdir -p "$cache"
# Any header, the settings or the compiler's flags may change what is found.
common=$(find algo hal firmware_like tools -name '*.hpp' -print0 | sort -z |
  xargs -0 cat .clang-tidy cmake/flags.cmake | sha256sum | cut -c1-16)

check() {
  local file=$1 key
  # Of the two versions of libgpiod, the one that is not here.
  case $file in */libgpiod_[12]_*) grep -qF "$file" "$build/compile_commands.json" || return 0 ;; esac
  key=$(sha256sum <"$file" | cut -c1-16)-$common
  [ ! -e "$cache/$key" ] || return 0
  clang-tidy --quiet -p "$build" "$file" 2>/dev/null || { echo "clang-tidy: $file"; return 1; }
  touch "$cache/$key"
}
export -f check
export build cache common
find algo hal firmware_like tools -name '*.cpp' -print0 | sort -z | xargs -0 -P "$(nproc)" -I{} bash -c 'check {}'
