#!/usr/bin/env bash
# The experiment in closed loop: 30 recordings of 505 frames arrive in random order, one of them in two halves, one of a part that
# is not the campaign's (4 mm instead of 6). `watch` must end with the bytes that `run` gives on all of them. Prints how long after
# the last byte of each recording the run to film next was said.
# Use: tests/watch_campaign.sh BINARY [SEED]
set -euo pipefail
binary=$(realpath "${1:?binary}")
seed=${2:-1}
work=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$work"' EXIT
cd "$work"

scene() {  # diameter in mm
  cat <<SCENE
[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
phase_shift_rad = "pi/2"
[friction]
mu1 = 0.1
mu1_over_mu2 = 8
lag_rad = 0.2
[run]
cycles = 20
[video]
width = 320
height = 320
frame_rate_hz = 250
exposure_s = 0.4e-3
[camera]
mm_per_px = 0.1
[disc]
diameter_mm = $1
[marker]
position_px = [40, 40]
radius_px = 14
SCENE
}
{
  scene 6
  for k in $(seq 0 28); do
    phi=$((k / 4 * 45)) dtau=$((60 + k % 4 * 30))
    printf '[[shot]]\nname = "phi%03d_dtau%03d"\nphi_rad = "%ddeg"\ndtau_rad = "%ddeg"\n' $phi $dtau $phi $dtau
  done
} >scene.toml
{ scene 4; printf '[[shot]]\nname = "phi315_dtau180"\nphi_rad = "315deg"\ndtau_rad = "180deg"\n'; } >other.toml
"$binary" synth scene.toml -o filmed -q
"$binary" synth other.toml -o filmed -q
mkdir arriving
"$binary" watch arriving --disc-diameter-mm 6 --until-idle-s 20 -o watched >watched.txt 2>watched.err &
watcher=$!
sleep 2

lines() { grep -c '^film next' watched.txt || true; }
latest=0 count=0
for file in $(ls filmed/*.cine | shuf --random-source=<(yes "$seed")); do
  before=$(lines)
  count=$((count + 1))
  if [ $count = 10 ]; then
    head -c $(($(stat -c %s "$file") / 2)) "$file" >"arriving/$(basename "$file")"
    sleep 2
    test "$(lines)" = "$before" || { echo "a half of $file was taken for the whole"; exit 1; }
  fi
  cp "$file" arriving/
  begun=$(date +%s%N)
  until [ "$(lines)" -gt "$before" ]; do
    sleep 0.02
    kill -0 $watcher || { cat watched.err; exit 1; }
  done
  took=$((($(date +%s%N) - begun) / 1000000))
  echo "$count: $(basename "$file") next run said after $took ms"
  [ $took -gt $latest ] && latest=$took
  sleep 0.$((RANDOM % 5))
done
wait $watcher || echo "watch ended with $?"
"$binary" run arriving/campaign.toml -o again -q || echo "run ended with $?"
cmp watched/fit.json again/fit.json
cmp watched/runs.csv again/runs.csv
for track in again/tracks/*.csv; do cmp "$track" "watched/tracks/$(basename "$track")"; done
echo "$count recordings: the same bytes as run; the next run was said at most $latest ms after the last byte"
tail -n 3 watched.txt
