#!/bin/bash
# The first process of the rig's kernel. Its root is the host's file system, read-only; the session gets a copy of it
# that can be written to and is forgotten, and of the host one folder, where the results go.
# From the kernel's command line: RIG_SESSION RIG_SCENARIO RIG_OUT RIG_BUILD RIG_TIME.
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root
scratch=/tmp
root=$scratch/root

power_off() {
  # Not by a program that only full installations have.
  mount -t proc proc /proc 2>/dev/null
  echo o >/proc/sysrq-trigger
  sleep 60
}
trap power_off EXIT

set -e
mount -t tmpfs -o size=75% tmpfs $scratch
mkdir $scratch/upper $scratch/work $root
mount -t overlay -o lowerdir=/,upperdir=$scratch/upper,workdir=$scratch/work overlay $root
mount -t proc proc $root/proc
mount -t sysfs sysfs $root/sys
mount -t devtmpfs devtmpfs $root/dev
mkdir -p $root/dev/shm $root/dev/pts
mount -t tmpfs tmpfs $root/dev/shm
mount -t tmpfs tmpfs $root/run
mount -t tmpfs tmpfs $root/tmp
# Where the programs are and where the results go may lie below what was just covered; the results below the programs.
for folder in "$RIG_BUILD" "$(dirname "$(dirname "$RIG_SESSION")")"; do
  [ -d "$root$folder" ] || { mkdir -p "$root$folder"; mount -t hostfs -o ro,"$folder" none "$root$folder"; }
done
mkdir -p "$root$RIG_OUT"
mount -t hostfs -o "$RIG_OUT" none "$root$RIG_OUT"
mount -t configfs configfs $root/sys/kernel/config
mount -t debugfs debugfs $root/sys/kernel/debug
mount -t tracefs tracefs $root/sys/kernel/tracing
set +e
chroot $root "$RIG_SESSION" </dev/null >"$root$RIG_OUT/.console" 2>&1
echo $? >"$root$RIG_OUT/.status"
