#!/bin/busybox sh
# The first process of the rig's virtual machine, in a root of its own (tools/rig/build_vm.sh): loads what is needed to
# see the host's files, puts an overlay in memory over them, and has native.sh run the session there. The host's files are
# shared read-only, but for one folder, where the results go.
# From the kernel's command line: RIG_SESSION RIG_SCENARIO RIG_OUT RIG_BUILD RIG_TIME.
/bin/busybox mkdir -p /proc /dev /host /modules
/bin/busybox --install -s /bin
export PATH=/bin

power_off() {
  sync
  poweroff -f
}
trap power_off EXIT

set -e
mount -t proc proc /proc
mount -t devtmpfs devtmpfs /dev
while read -r module; do insmod "/modules/$module"; done </modules/order
share() { mount -t 9p -o "trans=virtio,version=9p2000.L,msize=512000,$3" "$1" "$2"; }
share host /host ro,cache=loose
mkdir /scratch
mount -t tmpfs -o size=75% tmpfs /scratch
root=/scratch/root
mkdir /scratch/upper /scratch/work $root
mount -t overlay -o lowerdir=/host,upperdir=/scratch/upper,workdir=/scratch/work overlay $root
for folder in proc sys dev run tmp; do mkdir -p $root/$folder; done
mount -t proc proc $root/proc
mount -t sysfs sysfs $root/sys
mount -t devtmpfs devtmpfs $root/dev
mkdir -p $root/dev/shm $root/dev/pts
for folder in dev/shm run tmp; do mount -t tmpfs tmpfs $root/$folder; done
modules=/lib/modules/$(uname -r)
mkdir -p "$root$modules"
share modules "$root$modules" ro,cache=loose
# Where the programs are and where the results go may lie below what was just covered, and the latter below the former.
mkdir -p "$root$RIG_OUT" "$root$RIG_BUILD" "$root${RIG_SESSION%/guest/*}"
share build "$root$RIG_BUILD" ro,cache=loose
share rig "$root${RIG_SESSION%/guest/*}" ro,cache=loose
share out "$root$RIG_OUT" rw,cache=none
set +e
export RIG_OWN_CLOCK=1  # to be stepped by a scenario
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root
/bin/busybox chroot $root "${RIG_SESSION%/*}/native.sh" </dev/null >"$root$RIG_OUT/.console" 2>&1
echo $? >"$root$RIG_OUT/.status"
export PATH=/bin
umount "$root$RIG_OUT"
