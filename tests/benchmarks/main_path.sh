#!/usr/bin/env bash
# The main job from a CT without labels to pictures, timed as a user would: import with segmentation, two approaches,
# hooks, plan with pictures. Prints seconds and the peak memory of each program; exit 1 beyond the budget.
#   tests/benchmarks/main_path.sh chest    the real chest CT of the shared data: 120 s, 4 GB on 2 cores
#   tests/benchmarks/main_path.sh phantom  a phantom of 512 x 512 x 250 voxels: 180 s, 6 GB (making it is not counted)
# Needs GNU time (Debian package "time"). RETRACTOR names the program, RETRACTOR_SHARED_DATA the shared data.
set -euo pipefail
cd "$(dirname "$0")/../.."
retractor=${RETRACTOR:-build/release/bin/retractor}
data=${RETRACTOR_SHARED_DATA:-../shared/data}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

case "${1:-}" in
  chest)
    ct=$data/ct/chest_half/ricord_chest_half.nii.gz
    target=25,-10,190,20 seconds_allowed=120 gigabytes_allowed=4
    [[ -e $ct ]] || { echo "SKIPPED: no $ct"; exit 0; }
    ;;
  phantom)
    "$retractor" phantom thorax --out "$out/patient" --fov 360 --spacing 0.703125,0.703125,1.2 >/dev/null
    ct=$out/patient/ct
    target=30,20,60,27 seconds_allowed=180 gigabytes_allowed=6
    ;;
  *)
    sed -n '2,7s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac

peak_kb=0
step() {
  command time -o "$out/time" -f '%e %M' "$retractor" "$@" >"$out/log" || { cat "$out/log"; exit 1; }
  read -r seconds kb <"$out/time"
  ((kb > peak_kb)) && peak_kb=$kb
  printf '%8.1f s %8.2f GB  %s\n' "$seconds" "$(awk "BEGIN { print $kb / 1048576 }")" "${*:1:2}"
}

started=$(date +%s.%N)
step import "$ct" --autosegment --out "$out/case/case.json"
step approach add "$out/case/case.json" --template median --target "$target"
step approach add "$out/case/case.json" --template intercostal:4 --target "$target"
step hooks "$out/case/case.json" --approach median --template 2 --opening 60
step hooks "$out/case/case.json" --approach intercostal_4 --template 2 --opening 40
step plan "$out/case/case.json" --accuracy none --out "$out/plan" --render
awk -v from="$started" -v to="$(date +%s.%N)" -v kb="$peak_kb" -v s="$seconds_allowed" -v g="$gigabytes_allowed" 'BEGIN {
  printf "%8.1f s %8.2f GB  in all (allowed: %d s, %d GB)\n", to - from, kb / 1048576, s, g
  exit !(to - from <= s && kb / 1048576 <= g)
}'
