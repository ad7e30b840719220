#!/usr/bin/env bash
# Fails where docs/safety.md names a test that is not there.
set -euo pipefail
cd "$(dirname "$0")/../.."
names=$(grep -oE '`[A-Z][A-Za-z0-9]+\.[A-Z][A-Za-z0-9]+`' docs/safety.md | tr -d '`' | sort -u)
[ "$(wc -l <<<"$names")" -gt 25 ]
bad=0
for name in $names; do
  suite=${name%.*}
  if ! grep -rqE "TEST(_F|_P)?\($suite, ${name#*.}\)" tests; then
    echo "docs/safety.md names $name, which is no test"
    bad=1
  fi
done
exit $bad
