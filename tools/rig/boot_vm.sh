# Boots Debian's PREEMPT_RT kernel in a virtual machine and waits for its end; sourced by run. Its messages go to
# $scratch/kernel, and its status to $status. $vm: kvm, or tcg for a processor that is emulated.

machine=$("$rig/build_vm.sh")
for tool in qemu-system-x86_64 timeout; do
  command -v $tool >/dev/null || fail "$tool is missing: install it with tools/setup.sh vm"
done
processors=$(nproc)
[ "$processors" -le 4 ] || processors=4
accelerator=(-accel kvm -cpu host)
if [ $vm = tcg ]; then
  # One processor whose clock counts its instructions, one a nanosecond, however long they take.
  accelerator=(-accel tcg -cpu max -icount shift=0,sleep=off)
  processors=1
elif [ ! -w /dev/kvm ]; then
  fail "/dev/kvm cannot be written to: enable virtualisation and join the group kvm, or use --vm=emulated, which keeps no time"
fi
share() { echo "local,path=$2,mount_tag=$1,security_model=none,multidevs=remap$3"; }
# The whole group of processes is killed when the time is up.
timeout -k 5 "$limit" qemu-system-x86_64 "${accelerator[@]}" -smp "$processors" -m 2048 -nodefaults -no-user-config -no-reboot \
  -display none -serial "file:$scratch/kernel" -kernel "$machine/vmlinuz" -initrd "$machine/initrd" \
  -virtfs "$(share host / ,readonly=on)" -virtfs "$(share out "$out" '')" -virtfs "$(share build "$build" ,readonly=on)" \
  -virtfs "$(share rig "$rig" ,readonly=on)" \
  -virtfs "$(share modules "$(echo "$machine"/lib/modules/*)" ,readonly=on)" \
  -append "console=ttyS0 quiet panic=-1 RIG_SESSION=$RIG_SESSION RIG_SCENARIO=$scenario RIG_OUT=$out RIG_BUILD=$build RIG_TIME=$time" \
  >"$scratch/qemu" 2>&1 </dev/null &
qemu=$!
# Where virtual machines are nested, KVM may be there and get nowhere.
for ((second = 0; second < 60; ++second)); do
  [ ! -e "$out/.console" ] && kill -0 $qemu 2>/dev/null || break
  sleep 1
done
if [ $vm = kvm ] && [ ! -e "$out/.console" ] && kill -0 $qemu 2>/dev/null; then
  kill $qemu
  fail "with this machine's KVM the kernel has not started after a minute: use --vm=emulated, which keeps no time"
fi
wait $qemu || status=$?
cat "$scratch/qemu" >>"$scratch/kernel"
