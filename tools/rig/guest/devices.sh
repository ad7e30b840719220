# Sets up the devices of devices.env on the running kernel; sourced. Needs root. Programs are few: in User Mode Linux
# each that is started costs 50 ms.

set_up_links() {
  local link commands=$'link set lo up\n'
  for link in "$RIG_CAN" "$RIG_TEST_CAN" "$RIG_OTHER_TEST_CAN"; do
    [ -e "/sys/class/net/$link" ] || commands+="link add $link type vcan"$'\n'
    commands+="link set $link txqueuelen 1000"$'\n'"link set $link up"$'\n'
  done
  ip -batch - <<<"$commands"
}

# One chip of gpio-sim. An attribute is written whole, so not by anything that splits it.
set_up_lines() {
  local chip=/sys/kernel/config/gpio-sim/$RIG_GPIO_CHIP bank line
  bank=$chip/bank0
  [ ! -d "$chip" ] || return 0
  local -a names folders
  read -ra names <<<"$RIG_GPIO_LINES"
  for line in "${!names[@]}"; do folders+=("$bank/line$line"); done
  mkdir "$chip" "$bank"
  echo "${#names[@]}" >"$bank/num_lines"
  echo "$RIG_GPIO_CHIP" >"$bank/label"
  mkdir "${folders[@]}"
  for line in "${!names[@]}"; do echo "${names[line]}" >"$bank/line$line/name"; done
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
