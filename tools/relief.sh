#!/usr/bin/env bash
# Errors on the twelve creatures, flat and with the learned relief: renders each, standing still, and tracks it. The
# table of docs/relief.md. Takes some minutes.
#
#   tools/relief.sh [FRAMES]
set -euo pipefail
cd "$(dirname "$0")/.."
frames=${1:-30}
vergence=build/release/bin/vergence
echo "| target | flat: RMS x y z mm, e | learned: RMS x y z mm, e |"
echo "|---|---|---|"
for code in C01 C02 C03 C04 C05 C06 C07 C08 C09 C10 C11 C12; do
  set="out/relief/$code"
  [ -d "$set/right" ] || "$vergence" render tools/render/scenes/creatures.toml --target "$code" -o "$set" --frames "$frames" >/dev/null
  "$vergence" estimate "$set" --no-progress --json - | python3 -c '
import json, math, sys
rows = [json.loads(line) for line in sys.stdin]
def errors(part):
    part = [r["error"] for r in part if r["state"] == "tracking"]
    if not part: return "not found"
    rms = lambda k: math.sqrt(sum(e[k] ** 2 for e in part) / len(part))
    return "%.2f %.2f %.2f, %.4f" % (rms("x_mm"), rms("y_mm"), rms("z_mm"), rms("e"))
print("| '"$code"' | %s | %s |" % (errors(rows[:10]), errors(rows[-5:])))'
done
