#!/usr/bin/env bash
# Errors on the twelve creatures as their relief is learned: renders each, standing still, and tracks it. The tables of
# docs/relief.md. Takes some minutes.
#
#   tools/relief.sh [FRAMES]
#   tools/relief.sh aside       learned from ahead, and then turned away in three ways
#   tools/relief.sh turned      never seen but turned away, in six ways: each from nothing, for a second
#   tools/relief.sh cold        forty random poses of each, from nothing, five seeds: what one look learned is forgotten
#   tools/relief.sh stay        the same poses, each standing still for thirty frames, one seed
#   tools/relief.sh backdrops   twelve random poses of each before other backgrounds than its photo's, two seeds: shares
#                               that are right in the first frame and within three, all creatures together
#
# VERGENCE: another program than build/release/bin/vergence, for comparison.
set -euo pipefail
cd "$(dirname "$0")/.."
vergence=${VERGENCE:-build/release/bin/vergence}

creatures=(C01 C02 C03 C04 C05 C06 C07 C08 C09 C10 C11 C12)

# errors_before CODE FRAME...: of estimates in JSON, mm and e over the five frames before each, a row of a table.
errors_before() {
  python3 -c '
import json, math, sys
rows = [json.loads(line) for line in sys.stdin]
def errors(part):
    part = [r["error"] for r in part if r["state"] == "tracking"]
    if not part: return "not found"
    rms = lambda of: math.sqrt(sum(of(e) for e in part) / len(part))
    return "%.2f, %.4f" % (rms(lambda e: e["x_mm"] ** 2 + e["y_mm"] ** 2 + e["z_mm"] ** 2), rms(lambda e: e["e"] ** 2))
print("| %s | %s |" % (sys.argv[1], " | ".join(errors(rows[int(end) - 5 : int(end)]) for end in sys.argv[2:])))' "$@"
}

if [ "${1:-}" = aside ]; then
  echo "| target | ahead, last five frames: mm, e | turned away by 0.2 | by 0.26 | by 0.29 |"
  echo "|---|---|---|---|---|"
  for code in "${creatures[@]}"; do
    set="out/relief/aside_$code"
    [ -d "$set/right" ] || "$vergence" render tools/render/scenes/creature_aside.toml --target "$code" -o "$set" >/dev/null
    "$vergence" estimate "$set" --no-progress --json - | errors_before "$code" 40 50 60 70
  done
  exit
fi

if [ "${1:-}" = turned ]; then
  echo "| target | turned by 0.05 | 0.1 | 0.1 | 0.15 | 0.15 | 0.2 |"
  echo "|---|---|---|---|---|---|---|"
  for code in "${creatures[@]}"; do
    set="out/relief/turned_$code"
    [ -d "$set/right" ] || "$vergence" render tools/render/scenes/creature_turned.toml --target "$code" -o "$set" >/dev/null
    for first in 0 30 60 90 120 150; do
      "$vergence" estimate "$set" --no-progress --frames "$first:$((first + 30))" --json -
    done | errors_before "$code" 30 60 90 120 150 180
  done
  exit
fi

if [ "${1:-}" = cold ] || [ "${1:-}" = stay ]; then
  for code in "${creatures[@]}"; do
    set="out/relief/cold_$code"
    [ -d "$set/right" ] || "$vergence" render tools/render/scenes/photo_random.toml --target "$code" --seed 11 --frames 40 \
      --set 'motion.pose=[0,0,500,0,0,0]' --set 'motion.amplitude=[180,180,180,0.35,0.35,0.35]' \
      --set 'motion.in_view=true' -o "$set" >/dev/null
  done
  how=(--seeds 5)
  [ "$1" = cold ] || how=(--seeds 1 --stay 30)
  exec "$vergence" accuracy --cold "${creatures[@]/#/out/relief/cold_}" --unlearned "${how[@]}"
fi

if [ "${1:-}" = backdrops ]; then
  blue=(--set 'model.background.hue_deg=212' --set 'model.background.saturation=0.65' --set 'model.background.value=0.62')
  # render_before NAME SCENE-OPTION...: every creature before that.
  render_before() {
    local name=$1
    shift
    for code in "${creatures[@]}"; do
      set="out/relief/$name-$code"
      [ -d "$set/right" ] || "$vergence" render tools/render/scenes/photo_random.toml --target "$code" --seed 17 --frames 12 \
        --set 'motion.pose=[0,0,500,0,0,0]' --set 'motion.amplitude=[180,180,180,0.35,0.35,0.35]' \
        --set 'motion.in_view=true' "${blue[@]}" "$@" -o "$set" >/dev/null
      case $name in hue-*) sed -i 's/^background = .*/background_hue_deg = 212.0/' "$set/model/model.toml" ;; esac
    done
    "$vergence" accuracy --cold "${creatures[@]/#/out/relief/$name-}" --unlearned --seeds 2 | awk -F'|' -v name="$name" '
      NR > 2 { looks++; first += $5; soon += $6 }
      END { printf "| %s | %.1f %% | %.1f %% |\n", name, first / looks, soon / looks }'
  }
  tan=(--set 'background.hue_deg=30')
  plain=(--set 'model.background.kind="plain"')
  masked=(--set 'model.mask=true' --set 'model.background.kind="clutter"')
  echo "| before | in the first frame | within 3 |"
  echo "|---|---|---|"
  render_before same
  render_before tan "${tan[@]}"
  render_before tan-30lx "${tan[@]}" --set 'light.preset="30lx"'
  render_before tan-2500lx "${tan[@]}" --set 'light.preset="2500lx"'
  render_before tan-clutter "${tan[@]}" --set 'background.kind="clutter"'
  render_before grey --set 'background.saturation=0.04'
  render_before white --set 'background.hue_deg=50' --set 'background.saturation=0.1' --set 'background.value=0.95'
  render_before half --set 'occluder=[{ width_mm = 1000, length_mm = 1000, depth_mm = 2, hue_deg = 30, saturation = 0.6, value = 0.6, motion = { kind = "still", pose = [500, 0, 850, 0, 0, 0] } }]'
  render_before hue-same "${plain[@]}"
  render_before hue-tan "${plain[@]}" "${tan[@]}"
  render_before mask-same "${masked[@]}"
  render_before mask-tan "${masked[@]}" "${tan[@]}"
  exit
fi

frames=${1:-40}
echo "| target | flat, first frame: x y z mm, e | first frame | first second, RMS | last five frames, RMS |"
echo "|---|---|---|---|---|"
for code in "${creatures[@]}"; do
  set="out/relief/$code"
  [ -d "$set/right" ] || "$vergence" render tools/render/scenes/creatures.toml --target "$code" -o "$set" --frames "$frames" >/dev/null
  flat=$("$vergence" estimate "$set" --no-progress --frames 0:1 --set-stage refined --json -)
  "$vergence" estimate "$set" --no-progress --json - | python3 -c '
import json, math, sys
rows = [json.loads(line) for line in sys.stdin]
def errors(part):
    part = [r["error"] for r in part if r["state"] == "tracking"]
    if not part: return "not found"
    rms = lambda k: math.sqrt(sum(e[k] ** 2 for e in part) / len(part))
    return "%.2f %.2f %.2f, %.4f" % (rms("x_mm"), rms("y_mm"), rms("z_mm"), rms("e"))
flat = json.loads(sys.argv[1])
print("| '"$code"' | %s | %s | %s | %s |" % (errors([flat]), errors(rows[:1]), errors(rows[:30]), errors(rows[-5:])))' "$flat"
done
