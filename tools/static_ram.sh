#!/usr/bin/env bash
# Prints the memory a program has from its start, and fails where that is more than it may be.
#
#   static_ram.sh SIZE-COMMAND PROGRAM MOST-MIB
set -euo pipefail
size_command=$1
program=$2
most_mib=$3
read -r _ data bss _ < <("$size_command" "$program" | tail -n 1)
bytes=$((data + bss))
printf '%s: %d.%d MiB of static memory, of %d\n' "$(basename "$program")" $((bytes >> 20)) $(((bytes * 10 >> 20) % 10)) "$most_mib"
[ "$bytes" -le $((most_mib << 20)) ]
