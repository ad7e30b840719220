#!/usr/bin/env bash
# Builds gpio-sim.ko for a kernel that was made without it (as Debian's are), from Debian's linux-source package and the
# kernel's headers. The interrupt simulator it rests on is left out of such kernels as well, and is linked to it.
#
#   tools/rig/build_gpio_sim.sh [RELEASE [FOLDER]]
#
# RELEASE is `uname -r` unless it is given; without FOLDER the module is installed: as root, and modprobe finds it.
set -euo pipefail
fail() { echo "tools/rig/build_gpio_sim.sh: $*" >&2; exit 1; }
case "${1:-}" in -*) sed -n '2,7p' "$0" | sed 's/^# \{0,1\}//'; exit 2 ;; esac
release=${1:-$(uname -r)}
folder=${2:-/lib/modules/$release/extra}
headers=/lib/modules/$release/build
export PATH=$PATH:/usr/sbin:/sbin
[ -e "$headers/Makefile" ] || fail "no headers of $release: apt install linux-headers-$release"
source=linux-source-$(cut -d. -f1,2 <<<"$release")
[ -r "/usr/src/$source.tar.xz" ] || fail "no source of it: apt install $source"
for tool in make gcc xz; do
  command -v $tool >/dev/null || fail "$tool is missing: apt install make gcc xz-utils"
done
# The driver knows the inside of the kernel's GPIO library: another version's would be built, and break.
has=$(dpkg-query -W -f='${Version}' "linux-headers-$release" 2>/dev/null || true)
needs=$(dpkg-query -W -f='${Version}' "$source" 2>/dev/null || true)
[ "$has" = "$needs" ] || fail "$source is $needs, the headers of $release are ${has:-from elsewhere}: make them the same (apt upgrade)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tar -C "$work" --strip-components=1 -xf "/usr/src/$source.tar.xz" \
  "$source/drivers/gpio" "$source/kernel/irq/irq_sim.c"
mkdir "$work/module"
cp "$work"/drivers/gpio/*.h "$work/kernel/irq/irq_sim.c" "$work/module/"
cp "$work/drivers/gpio/gpio-sim.c" "$work/module/driver.c"
# Of a kernel's own; modules are given this in its place.
sed -i 's/handle_simple_irq(irq_to_desc(\(.*\)));/generic_handle_irq_safe(\1);/' "$work/module/irq_sim.c"
printf 'obj-m := gpio-sim.o\ngpio-sim-objs := driver.o irq_sim.o\n' >"$work/module/Kbuild"
make -C "$headers" M="$work/module" modules >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "building it failed"; }
mkdir -p "$folder"
cp "$work/module/gpio-sim.ko" "$folder/"
[ -n "${2:-}" ] || depmod "$release"
echo "$folder/gpio-sim.ko"
