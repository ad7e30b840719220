#!/usr/bin/env bash
# vergence calibrate time-offset, from what vergenced saw while the arm was swayed by hand. The plant knows how old its
# pictures are at their stamps: what is found must be that to half a millisecond, and the interval that is stated with it
# must hold it.
#
#   time_offset.sh BUILD_FOLDER FOLDER_OF_RESULTS
set -euo pipefail
tolerance_ms=0.5
build=$1
cd "$2"

# The hand by its joints; and the target in the hand, once for each picture it was seen in.
mkdir -p sway
awk -F, -v OFS=, '
  NR == 1 {
    for (i = 1; i <= NF; ++i) at[$i] = i
    print "t_s,x_mm,y_mm,z_mm,e1,e2,e3" >"sway/hand.csv"
    print "t_s,x_mm,y_mm,z_mm,e1,e2,e3" >"sway/frames.csv"
    next
  }
  function pose(of) {
    return $at[of "_x_mm"] OFS $at[of "_y_mm"] OFS $at[of "_z_mm"] OFS $at[of "_e1"] OFS $at[of "_e2"] OFS $at[of "_e3"]
  }
  { print $at["t_s"], pose("hand") >"sway/hand.csv" }
  $at["track_state"] == 1 && $at["sighting"] != last && $at["sighting_s"] > 2 {
    last = $at["sighting"]
    print $at["sighting_s"], pose("seen") >"sway/frames.csv"
  }' log.csv
"$build/bin/vergence" calibrate time-offset sway --json sway/found.json
found() { sed -n "s/.*\"$1\": \([-0-9.e]*\).*/\1/p" sway/found.json; }
awk -v offset="$(found stamp_to_mid_exposure_ms)" -v half="$(found half_width_ms)" -v most=$tolerance_ms \
  -v age="$(sed -n 's/^pictures at their stamps: \([0-9.]*\) ms old.*/\1/p' notes.txt)" 'BEGIN {
    if (offset == "" || half == "" || age == "") { print "no offset, or no age of the pictures"; exit 1 }
    off = offset + age
    if (off < 0) off = -off
    met = off <= most && off <= half
    printf "found %.3f +- %.3f ms; pictures were %.3f ms old: off by %.3f ms, allowed %.3f: %s\n",
      offset, half, age, off, most, met ? "met" : "MISSED"
    exit !met
  }'
