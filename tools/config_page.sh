#!/usr/bin/env bash
# Writes the list of settings in docs/config.md anew from the program's own table.
#
#   tools/config_page.sh [VERGENCE]           after a setting was changed
#   tools/config_page.sh --check [VERGENCE]   fails where the page is not what it would write
set -euo pipefail
cd "$(dirname "$0")/.."
check=0
if [ "${1:-}" = --check ]; then
  check=1
  shift
fi
vergence=${1:-build/release/bin/vergence}
page=docs/config.md
fresh=$(mktemp)
trap 'rm -f "$fresh"' EXIT
sed '/<!-- settings -->/q' "$page" >"$fresh"
"$vergence" config settings >>"$fresh"
if [ "$check" = 1 ]; then
  diff -u "$page" "$fresh" || { echo "run tools/config_page.sh"; exit 1; }
else
  cp "$fresh" "$page"
fi
