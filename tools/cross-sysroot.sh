#!/usr/bin/env bash
# Unpacks the arm64 libraries that cross builds need into build/sysroot-arm64, beside the host's own packages,
# which it leaves alone.
set -euo pipefail
cd "$(dirname "$0")/.."
sysroot=build/sysroot-arm64
# Debian 12 has other names of the libraries than those since.
case $(. /etc/os-release && echo "${VERSION_ID:-}") in
  12) shared=(libhwy1 libgpiod2) ;;
  *) shared=(libhwy1t64 libgpiod3) ;;
esac
packages=("${shared[@]/%/:arm64}" libhwy-dev:arm64 librapidcheck-dev:arm64 libgtest-dev:arm64 libgpiod-dev:arm64
  libeigen3-dev)
stamp="$sysroot/.complete"
[ "$(cat "$stamp" 2>/dev/null)" != "${packages[*]}" ] || exit 0

if ! dpkg --print-foreign-architectures | grep -qx arm64; then
  as_root=()
  [ "$(id -u)" = 0 ] || as_root=(sudo)
  "${as_root[@]}" dpkg --add-architecture arm64
  "${as_root[@]}" apt-get update -qq
elif ! apt-cache show "${packages[0]}" >/dev/null 2>&1; then
  as_root=()
  [ "$(id -u)" = 0 ] || as_root=(sudo)
  "${as_root[@]}" apt-get update -qq
fi
rm -rf "$sysroot"
mkdir -p "$sysroot/packages"
(cd "$sysroot/packages" && apt-get download -qq "${packages[@]}")
for package in "$sysroot"/packages/*.deb; do dpkg -x "$package" "$sysroot"; done
rm -r "$sysroot/packages"
echo "${packages[*]}" >"$stamp"
