#!/usr/bin/env bash
# clang-tidy over our own code, with the compile commands of a build folder. A file that has not changed since it
# was last found clean, nor has any header of ours that it includes, is not checked again.
#
#   clang_tidy.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "$1")
cd "$(dirname "$0")/../.."
cache=$build/clang-tidy-clean
mkdir -p "$cache"
# The settings or the compiler's flags may change what is found.
common=$(cat .clang-tidy cmake/flags.cmake | sha256sum | cut -c1-16)
# What each file includes, as the build has seen it: lines of "file header". All headers where it has not.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
{ ninja -C "$build" -t deps 2>/dev/null || true; } | awk -v root="$PWD/" '
  /^[^ ]/ { file = ""; next }
  {
    path = $1
    if (index(path, root) == 1) path = substr(path, length(root) + 1)
    sub(/^(\.\.\/)+/, "", path)
    if (path !~ /^(algo|hal|firmware_like|tools)\/.*\.[ch]pp$/) next
    if (file == "") file = path; else print file, path
  }' | sort -u >"$work/includes"
all=$(find algo hal firmware_like tools -name '*.hpp' | sort)

check() {
  local file=$1 key headers
  # Of the two versions of libgpiod, the one that is not here.
  case $file in */libgpiod_[12]_*) grep -qF "$file" "$build/compile_commands.json" || return 0 ;; esac
  headers=$(awk -v file="$file" '$1 == file { print $2 }' "$work/includes")
  key=$(cat "$file" ${headers:-$all} | sha256sum | cut -c1-16)-$common
  [ ! -e "$cache/$key" ] || return 0
  clang-tidy --quiet -p "$build" "$file" 2>/dev/null || { echo "clang-tidy: $file"; return 1; }
  touch "$cache/$key"
}
export -f check
export build cache common work all
find algo hal firmware_like tools -name '*.cpp' -print0 | sort -z | xargs -0 -P "$(nproc)" -I{} bash -c 'check {}'
