#!/usr/bin/env bash
# Installs the Debian packages of the named groups (tools/packages.txt) that are missing; needs root or sudo, and
# the network, only then.
#
#   tools/setup.sh build run test lint cross rt
set -euo pipefail
cd "$(dirname "$0")/.."

missing=()
for group in "$@"; do
  found=0
  while read -r name packages; do
    [ "$name" = "$group:" ] || continue
    found=1
    for package in $packages; do
      dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
    done
  done <tools/packages.txt
  [ "$found" = 1 ] || { echo "tools/setup.sh: no package group '$group' in tools/packages.txt" >&2; exit 2; }
done
[ ${#missing[@]} -gt 0 ] || exit 0

echo "Installing: ${missing[*]}"
as_root=()
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "tools/setup.sh: run as root, or install sudo" >&2; exit 1; }
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
