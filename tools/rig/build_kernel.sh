#!/usr/bin/env bash
# Builds the rig's kernel, User Mode Linux from Debian's linux-source package with kernel.config, and prints the path
# of its executable. It is kept in ${XDG_CACHE_HOME:-~/.cache}/vergence, by a hash of all that goes into it; there
# it is found the next time. Builds take about eight minutes on two idle cores.
#
#   tools/rig/build_kernel.sh            build where it is missing, and print its path
#   tools/rig/build_kernel.sh --cached   print its path, or fail where it is not built yet
set -euo pipefail
cd "$(dirname "$0")"
fail() { echo "tools/rig/build_kernel.sh: $*" >&2; exit 1; }
case "${1:-}" in
  "" | --cached) ;;
  *) sed -n '2,7p' "$0"; exit 2 ;;
esac

cache=${XDG_CACHE_HOME:-$HOME/.cache}/vergence
# Of the releases of Debian that are supported, the newest kernel that is installed.
package=
for candidate in linux-source-6.12 linux-source-6.1; do
  if [ -r "/usr/src/$candidate.tar.xz" ]; then package=$candidate; break; fi
done
[ -n "$package" ] || fail "no kernel source: install it with tools/setup.sh rig"
version=$(dpkg-query -W -f='${Version}' "$package")
# Registers of a process, in bytes: 11008 with AMX. Linux before 6.13 has room for 2696, and dies at once where there are more.
registers=12288
hash=$({ echo "$registers"; echo "$package $version $(gcc -dumpfullversion) $(uname -m)"; cat kernel.config; } | sha256sum | cut -c1-16)
kernel=$cache/uml-$hash/linux
if [ -x "$kernel" ]; then echo "$kernel"; exit 0; fi
[ "${1:-}" != --cached ] || fail "the kernel is not built yet: tools/rig/build_kernel.sh builds it in about ten minutes"

for tool in flex bison bc xz make gcc; do
  command -v "$tool" >/dev/null || fail "$tool is missing: install it with tools/setup.sh rig"
done
mkdir -p "$cache"
exec 9>"$cache/uml.lock"
# Whoever else is building it: wait, and take theirs.
flock 9
if [ -x "$kernel" ]; then echo "$kernel"; exit 0; fi

work=$cache/uml-$hash.build
log=$cache/uml-$hash.log
echo "Building the rig's kernel from $package $version; the log is $log" >&2
trap 'rm -rf "$work"' EXIT
rm -rf "$work"
mkdir -p "$work"
tar -C "$work" --strip-components=1 -xf "/usr/src/$package.tar.xz"
(
  cd "$work"
  ! grep -q 'HOST_FP_SIZE, 2696' arch/x86/um/user-offsets.c ||
    sed -i "s/HOST_FP_SIZE, 2696/HOST_FP_SIZE, $registers/" arch/x86/um/user-offsets.c
  make ARCH=um defconfig
  ARCH=um scripts/kconfig/merge_config.sh -m .config "$OLDPWD/kernel.config"
  make ARCH=um olddefconfig
) >"$log" 2>&1 || fail "configuring the kernel failed: see $log"
while read -r line; do
  case $line in
    CONFIG_*) grep -qx "$line" "$work/.config" || fail "the kernel did not take $line of kernel.config" ;;
    "# CONFIG_"*" is not set") ! grep -q "^${line:2:-11}=" "$work/.config" || fail "the kernel did not take: $line" ;;
  esac
done <kernel.config
nice -n 10 make -C "$work" ARCH=um -j"${JOBS:-$(nproc)}" linux >>"$log" 2>&1 || fail "building the kernel failed: see $log"
strip -o "$work/linux.stripped" "$work/linux"
mkdir -p "$(dirname "$kernel")"
cp "$work/.config" "$(dirname "$kernel")/config"
mv "$work/linux.stripped" "$kernel"
echo "$kernel"
