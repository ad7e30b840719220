#!/usr/bin/env bash
# Runs a command (tools/test.sh --quick, if none is given) on Debian 13 beside this Debian: in a folder that holds one,
# made with debootstrap from the mirror that apt uses here, where it is not there yet. The source is seen as it is; its
# build folder is one of its own, DIRECTORY/vergence-build. Needs root; leaves no mounts behind; 3 GB or more.
#
#   tools/debian13.sh DIRECTORY [COMMAND...]
set -euo pipefail
cd "$(dirname "$0")/.."
fail() { echo "tools/debian13.sh: $*" >&2; exit 1; }
case "${1:-}" in "" | -*) sed -n '2,6p' "$0"; exit 2 ;; esac
[ "$(id -u)" = 0 ] || fail "run as root: it makes a Debian and mounts into it"
mkdir -p "$1"
root=$(realpath "$1")
source=$PWD
shift
case $root/ in "$source"/*) fail "$root is inside the source: choose a folder outside" ;; esac
[ $# -gt 0 ] || set -- tools/test.sh --quick

# The repository of this machine's apt with such a label, without the slash it may end with.
mirror_of() {
  apt-get indextargets --format '$(LABEL) $(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' |
    sed -n "s|^$1 \(.*[^/]\)/*$|\1|p" | sort -u | head -1
}

if [ ! -e "$root/.complete" ]; then
  tools/setup.sh debian13
  mirror=$(mirror_of Debian)
  [ -n "$mirror" ] || { apt-get update -qq; mirror=$(mirror_of Debian); }
  [ -n "$mirror" ] || fail "apt names no repository of Debian here: see apt-get indextargets"
  security=$(mirror_of Debian-Security)
  # apt's proxy is debootstrap's too.
  eval "$(apt-config shell http_proxy Acquire::http::Proxy https_proxy Acquire::https::Proxy)"
  [ -z "${http_proxy:-}" ] || export http_proxy
  [ -z "${https_proxy:-}" ] || export https_proxy
  rm -rf "$root/debootstrap"
  debootstrap --variant=minbase --include=ca-certificates trixie "$root" "$mirror"
  {
    echo "deb $mirror trixie main"
    echo "deb $mirror trixie-updates main"
    [ -z "$security" ] || echo "deb $security trixie-security main"
  } >"$root/etc/apt/sources.list"
  apt-config dump --no-empty Acquire | grep -v "^Acquire::IndexTargets" >"$root/etc/apt/apt.conf.d/90acquire"
  touch "$root/.complete"
fi

mkdir -p "$root/vergence" "$root/vergence-build" build
cp --dereference /etc/resolv.conf "$root/etc/resolv.conf"
# Mounts of a namespace end with it, and reach no other.
exec unshare --mount --propagation private -- bash -euc '
  root=$1 source=$2
  shift 2
  mount -t proc proc "$root/proc"
  mount --rbind /sys "$root/sys"
  mount --rbind /dev "$root/dev"
  mount --bind "$source" "$root/vergence"
  mount --bind "$root/vergence-build" "$root/vergence/build"
  exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM="${TERM:-dumb}" \
    LC_ALL=C.UTF-8 chroot "$root" bash -c "cd /vergence && exec \"\$@\"" bash "$@"
' bash "$root" "$source" "$@"
