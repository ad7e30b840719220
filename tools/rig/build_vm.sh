#!/usr/bin/env bash
# Makes what tools/rig/run --vm boots: Debian's PREEMPT_RT kernel with its modules, gpio-sim beside them (Debian leaves
# it out; built from linux-source against the kernel's headers), and a small first root. Prints the folder: vmlinuz,
# initrd, lib/modules. Kept in ${XDG_CACHE_HOME:-~/.cache}/vergence, by the version of the kernel and of these scripts.
# The kernel's package is unpacked there, not installed.
#
#   tools/rig/build_vm.sh            make what is missing, and print its folder
#   tools/rig/build_vm.sh --cached   print the folder, or fail where it is not made yet
set -euo pipefail
rig=$(cd "$(dirname "$0")" && pwd)
fail() { echo "tools/rig/build_vm.sh: $*" >&2; exit 1; }
case "${1:-}" in
  "" | --cached) ;;
  *) sed -n '2,8p' "$0" | sed 's/^# \{0,1\}//'; exit 2 ;;
esac
[ "$(uname -m)" = x86_64 ] || fail "only for x86-64"
export PATH=$PATH:/usr/sbin:/sbin

cache=${XDG_CACHE_HOME:-$HOME/.cache}/vergence
# That of the installed headers: what gpio-sim is built against.
release=
for candidate in /lib/modules/*-rt-amd64/build; do
  [ ! -e "$candidate/Makefile" ] || release=$(basename "$(dirname "$candidate")")
done
[ -n "$release" ] || fail "no headers of a PREEMPT_RT kernel: install them with tools/setup.sh vm"
version=$(dpkg-query -W -f='${Version}' "linux-headers-$release")
hash=$({ echo "$release $version"; cat "$0" "$rig/build_gpio_sim.sh" "$rig/guest/vm_first_root.sh"; } | sha256sum | cut -c1-16)
folder=$cache/vm-$hash
if [ -e "$folder/initrd" ]; then echo "$folder"; exit 0; fi
[ "${1:-}" != --cached ] || fail "it is not made yet: tools/rig/build_vm.sh makes it in a minute"

for tool in apt-get cpio dpkg-deb depmod modprobe busybox; do
  command -v $tool >/dev/null || fail "$tool is missing: install it with tools/setup.sh vm"
done
mkdir -p "$cache"
exec 9>"$cache/vm.lock"
flock 9
if [ -e "$folder/initrd" ]; then echo "$folder"; exit 0; fi

work=$folder.build
trap 'rm -rf "$work"' EXIT
rm -rf "$work"
mkdir -p "$work/package" "$work/root/bin" "$work/root/modules"
echo "Fetching the kernel $release $version" >&2
(cd "$work" && apt-get download -qq "linux-image-$release=$version" 2>"$work/log") ||
  fail "its package cannot be fetched; apt-get update, perhaps: $(tail -1 "$work/log")"
dpkg-deb -x "$work/linux-image-$release"_*.deb "$work/package"
rm "$work/linux-image-$release"_*.deb
modules=$work/package/lib/modules/$release
mkdir -p "$modules/extra"
"$rig/build_gpio_sim.sh" "$release" "$modules/extra" >&2
depmod -b "$work/package" "$release"

# The first root: what is needed to see the host's files, in the order they are loaded.
cp "$(command -v busybox)" "$work/root/bin/busybox"
cp "$rig/guest/vm_first_root.sh" "$work/root/init"
for module in virtio_pci 9pnet_virtio 9p overlay; do
  modprobe -d "$work/package" -S "$release" --show-depends $module
done | awk '$1 == "insmod" && !seen[$2]++ { print $2 }' | while read -r file; do
  cp "$file" "$work/root/modules/"
  basename "$file"
done >"$work/root/modules/order"
(cd "$work/root" && find . | cpio --quiet -o -H newc) >"$work/initrd"

mkdir -p "$folder"
cp "$work/package/boot/vmlinuz-$release" "$folder/vmlinuz"
rm -rf "$folder/lib"
mv "$work/package/lib" "$folder/lib"
mv "$work/initrd" "$folder/initrd"
echo "$folder"
