#!/usr/bin/env bash
# Makes the pictures of the README from the example campaign: the report, a figure for print, what the tracker sees, error
# against run time. Needs the quickstart's results, chromium, poppler-utils and python3-matplotlib; takes some minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."
tribotrack=$PWD/build/release/apps/tribotrack
result=$PWD/out/quickstart/result
[ -f "$result/report.html" ] || { echo "run ./apps/quickstart.sh first" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$tribotrack" report "$result" -o "$work/report.html" --figures "$work/figures" -q
chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1280,930 --virtual-time-budget=15000 \
  --screenshot="$work/report.png" "file://$work/report.html" 2>/dev/null

"$tribotrack" track out/quickstart/recordings/phi000_dtau120.cine --disc-diameter-mm 6 --marker 40,40,14 \
  -o "$work/track.csv" --debug "$work/debug" -q

"$tribotrack" bench model -o "$work/bench" -q >/dev/null
chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1280,1180 --virtual-time-budget=15000 \
  --screenshot="$work/bench.png" "file://$work/bench/bench.html#model-error-time" 2>/dev/null

png() { pdftoppm -r 150 -png -singlefile "$1" "${2%.png}"; }  # PDF, picture
cp "$work/report.png" data/example/report.png
png "$work/figures/alpha-phi-84mm.pdf" data/example/figure.png
cp "$work/bench.png" data/example/bench.png
cp "$work/debug/layers_part.png" data/example/debug.png
ls -l data/example/*.png
