#!/usr/bin/env bash
# Installs the Debian packages of the named groups (tools/packages.txt) that are missing; needs root or sudo, and
# the network, only then.
#
#   tools/setup.sh build run test lint cross rt
set -euo pipefail
cd "$(dirname "$0")/.."

is_installed() { dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'; }
# Of A|B, the one that is installed, or the first that this release has.
first_there() {
  local choice
  for choice in ${1//|/ }; do if is_installed "$choice"; then echo "$choice"; return; fi; done
  for choice in ${1//|/ }; do if [ -n "$(apt-cache madison "$choice" 2>/dev/null)" ]; then echo "$choice"; return; fi; done
  # A machine that never heard of any package: the release tells.
  case $(. /etc/os-release && echo "${VERSION_ID:-}") in 12) echo "${1%%|*}" ;; *) echo "${1##*|}" ;; esac
}

missing=()
for group in "$@"; do
  found=0
  while read -r name packages; do
    [ "$name" = "$group:" ] || continue
    found=1
    for package in $packages; do
      case $package in *"|"*) package=$(first_there "$package") ;; esac
      is_installed "$package" || missing+=("$package")
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
