#!/bin/bash
# What must keep the controller from starting, or from moving: each is refused with its reason, and no drive is enabled.
# robot: moving_eyes
# scene: ../scenes/marker.toml
set -uo pipefail
daemon=$RIG_BUILD/bin/vergenced
robot=$RIG_OUT/robot
socket=/run/vergence/command
failed=0

say() {
  printf '%-34s %s\n' "$1" "$2"
  [ "$2" = met ] || { failed=1; cat log; }
}
# name, expected status, words the log must hold, what was run
expect() {
  local name=$1 wanted=$2 words=$3 status=0
  shift 3
  "$@" >log 2>&1 || status=$?
  if [ $status = "$wanted" ] && grep -q "$words" log; then say "$name" met; else say "$name" "status $status, wanted $wanted with '$words'"; fi
}
# As long as it takes to come up; in virtual time that is never long.
run_for_2s() { timeout -s TERM 2 "$daemon" --realtime=ignore --config "$robot/robot.vcfg"; }

mkdir -p /run/vergence /var/lib/vergence

# Configurations.
cp "$robot/robot.vcfg" bad.vcfg
printf '\xff' | dd of=bad.vcfg bs=1 seek=2000 conv=notrunc status=none
expect "configuration corrupted" 2 "check sum" "$daemon" --realtime=ignore --config bad.vcfg
head -c 1000 "$robot/robot.vcfg" >bad.vcfg
expect "configuration cut short" 2 "ends too early" "$daemon" --realtime=ignore --config bad.vcfg
expect "configuration missing" 2 "No such file" "$daemon" --realtime=ignore --config none.vcfg
expect "machine that cannot keep time" 1 "cannot keep time" "$daemon" --config "$robot/robot.vcfg"

# Lines that somebody else has.
read -ra lines <<<"$RIG_GPIO_LINES"
chip=$(gpiodetect | sed -n "s/ \[$RIG_GPIO_CHIP\].*//p")
case $(gpioset --version | head -1) in
  *" v1."*) hold=(--mode=signal "$chip") ;;
  *) hold=(--chip "$chip") ;;
esac
gpioset "${hold[@]}" 1=0 &
holder=$!
sleep 0.2
expect "GPIO line taken" 1 "${lines[1]}" "$daemon" --realtime=ignore --config "$robot/robot.vcfg"
kill $holder
wait $holder 2>/dev/null

# A bus that is not there.
ip link delete "$RIG_CAN"
expect "CAN interface missing" 1 "$RIG_CAN" "$daemon" --realtime=ignore --config "$robot/robot.vcfg"
set_up_links() { ip link add "$RIG_CAN" type vcan && ip link set "$RIG_CAN" txqueuelen 1000 up; }
set_up_links

# A full disk costs the black box, not the controller.
mount -t tmpfs -o size=64k tmpfs /var/lib/vergence
# `timeout` answers 124 where it had to end it; what it ended is told by its log.
run_for_2s >log 2>&1
grep -q "no room" log && grep -q "ready" log && grep -q "arm .* runs" log
say "disk full" "$([ $? = 0 ] && echo met || echo "not said, or it did not run")"
umount /var/lib/vergence

# Drives that never boot: whatever the operator says, none is enabled.
candump -L "$RIG_CAN" >bus.log &
dump=$!
"$daemon" --realtime=ignore --config "$robot/robot.vcfg" >log 2>&1 &
controller=$!
sleep 1
"$RIG_BUILD/bin/vergence" ctl arm --socket $socket >/dev/null
sleep 6
"$RIG_BUILD/bin/vergence" ctl arm --socket $socket >/dev/null
sleep 1
state=$("$RIG_BUILD/bin/vergence" ctl status --socket $socket)
kill -TERM $controller
wait $controller
status=$?
kill $dump
wait $dump 2>/dev/null
# Controlwords go to 0x300 + node; 0F is "enable operation".
enabled=$(grep -cE ' 30[1-7]#0F' bus.log)
syncs=$(grep -c ' 080#' bus.log)
case $state in 'ok search'* | 'ok track'* | 'ok servo'* | 'ok hold'*) armed=1 ;; *) armed=0 ;; esac
say "drives that never boot" "$([ "$enabled" = 0 ] && [ $armed = 0 ] && [ $status = 0 ] && [ "$syncs" -gt 1000 ] && echo met ||
  echo "'$state', $enabled enabled, status $status, $syncs SYNC")"
exit $failed
