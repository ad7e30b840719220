# Sets up the devices of devices.env on the running kernel; sourced. Needs root.

set_up_links() {
  local link
  ip link set lo up
  for link in "$RIG_CAN" "$RIG_TEST_CAN" "$RIG_OTHER_TEST_CAN"; do
    [ -e "/sys/class/net/$link" ] || ip link add "$link" type vcan
    ip link set "$link" txqueuelen 1000
    ip link set "$link" up
  done
}

# One chip of gpio-sim. An attribute is written whole, so not by anything that splits it.
set_up_lines() {
  local chip=/sys/kernel/config/gpio-sim/$RIG_GPIO_CHIP bank line offset=0
  bank=$chip/bank0
  [ ! -d "$chip" ] || return 0
  local -a names
  read -ra names <<<"$RIG_GPIO_LINES"
  mkdir "$chip" "$bank"
  echo "${#names[@]}" >"$bank/num_lines"
  echo "$RIG_GPIO_CHIP" >"$bank/label"
  for line in "${names[@]}"; do
    mkdir "$bank/line$offset"
    echo "$line" >"$bank/line$offset/name"
    offset=$((offset + 1))
  done
  echo 1 >"$chip/live"
}

# Every set of every line, and every picture taken, with stamps of the clock that the controller has.
set_up_trace() {
  local tracing=/sys/kernel/tracing
  echo mono >$tracing/trace_clock
  echo 4096 >$tracing/buffer_size_kb
  echo 'get == 0' >$tracing/events/gpio/gpio_value/filter
  echo 1 >$tracing/events/gpio/gpio_value/enable
  echo 'type == 1' >$tracing/events/v4l2/v4l2_dqbuf/filter
  echo 1 >$tracing/events/v4l2/v4l2_dqbuf/enable
  echo 1 >$tracing/tracing_on
}

set_up_devices() {
  set_up_links
  set_up_lines
  set_up_trace
}
