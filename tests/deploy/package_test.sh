#!/usr/bin/env bash
# Makes the Debian package and looks into it: everything a robot's computer needs is there, where it belongs.
#
#   package_test.sh CPACK BUILD-DIRECTORY
set -euo pipefail
cpack=$1
build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$cpack" --config "$build/CPackConfig.cmake" -B "$work" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
package=$(ls "$work"/*.deb)
dpkg-deb --contents "$package" >"$work/contents"
for path in usr/bin/vergenced usr/bin/vergence lib/systemd/system/vergenced.service lib/udev/rules.d/60-vergence.rules \
  lib/sysusers.d/vergence.conf usr/share/doc/vergence/docs/safety.md \
  usr/share/doc/vergence/examples/pa10_vergence/robot.toml \
  usr/share/doc/vergence/examples/pa10_two_buses/robot.toml usr/share/doc/vergence/copyright; do
  grep -qE "\./(usr/)?$path" "$work/contents" || { echo "the package has no $path"; cat "$work/contents"; exit 1; }
done
dpkg-deb --field "$package" Depends | grep -q libc6 || { echo "the package depends on nothing"; exit 1; }
dpkg-deb --extract "$package" "$work/root"
# What was installed works where it lies.
for robot in pa10_vergence pa10_two_buses; do
  "$work/root/usr/bin/vergence" config build "$work/root/usr/share/doc/vergence/examples/$robot/robot.toml" \
    -o "$work/robot.vcfg"
done
"$work/root/usr/bin/vergenced" --version
if command -v systemd-analyze >/dev/null; then
  # Of a unit whose program is not installed here, only what is wrong with the unit itself counts.
  sed "s|/usr/bin/|$work/root/usr/bin/|; /Documentation/d" "$work/root"/usr/lib/systemd/system/vergenced.service \
    >"$work/vergenced.service"
  systemd-analyze verify "$work/vergenced.service" 2>&1 | tee "$work/verify"
  ! grep -q "vergenced.service:[0-9]" "$work/verify"
fi
echo "$(basename "$package"): $(wc -l <"$work/contents") entries"
