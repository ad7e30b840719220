# Boots the rig's User Mode Linux kernel and waits for its end; sourced by run. Its messages go to $scratch/kernel, and its
# status to $status.

kernel=$("$rig/build_kernel.sh")
for tool in flock ip taskset timeout; do
  command -v $tool >/dev/null || fail "$tool is missing: install it with tools/setup.sh rig"
done
# The guest's memory is a file that grows as it is used; where shared memory is small, on disk.
memory_mib=1024
free_kib=$(df --output=avail /dev/shm 2>/dev/null | tail -1 || echo 0)
[ "${free_kib:-0}" -gt $((memory_mib * 1024 * 5 / 4)) ] || export TMPDIR=$scratch

options=()
# Since a fixed date, so that stamps of files do not differ either.
[ $time = real ] || options=(time-travel=inf-cpu time-travel-start=1767225600000000000)
# One processor, since the guest has one: the first that no other rig is on.
processor=
for candidate in $(taskset -cp $$ | sed 's/.*: //' | tr , ' '); do
  for number in $(seq "${candidate%-*}" "${candidate#*-}"); do
    [ -n "$processor" ] || processor=$number
    exec 8>"${XDG_RUNTIME_DIR:-/tmp}/vergence-rig-processor-$number-$(id -u)"
    if flock -n 8; then processor=$number; break 2; fi
  done
done
# The whole group of processes is killed when the time is up.
HOME=$scratch timeout -k 5 "$limit" taskset -c "$processor" \
  "$kernel" mem=${memory_mib}M root=/dev/root rootfstype=hostfs rootflags=/ ro init="$rig/guest/init.sh" \
  con=null con0=null,fd:1 quiet uml_dir="$scratch" \
  vivid.n_devs=2 vivid.node_types=0x101,0x101 vivid.vid_cap_nr=0,4 vivid.vid_out_nr=1,5 \
  "${options[@]}" RIG_SESSION="$RIG_SESSION" RIG_SCENARIO="$scenario" RIG_OUT="$out" RIG_BUILD="$build" RIG_TIME=$time \
  >"$scratch/kernel" 2>&1 </dev/null || status=$?
