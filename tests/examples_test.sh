#!/usr/bin/env bash
# What the example programs print: simulate what the program tribotrack does, track the truth that it renders, fit the
# parameters its table was made with. Called by install_test.sh and package_test.sh with what they installed.
# Use: tests/examples_test.sh FOLDER_OF_THE_EXAMPLES TRIBOTRACK
set -euo pipefail
examples=${1:?folder of the built examples}
tribotrack=${2:?the program}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

"$examples/simulate" | tee said
"$tribotrack" simulate --phi-rad pi/2 --dtau-rad pi/3 --cycles 20 -o run.csv | tee program
# The same alpha and v, rounded as the example prints them.
awk '
  $1 == "alpha" { alpha = $3; v = $7 }
  $1 == "alpha_rad" { a = $2 }
  $1 == "v_mm_s" { w = $2 }
  END { exit !(sprintf("%.4f", a) == alpha && sprintf("%.3f", w) == v && w > 0) }' said program

"$examples/track" | tee said
# Every frame; the error from the first frame to another is that of two places, sqrt 2 sds.
awk '{ exit !($1 == 120 && $3 == 120 && $13 < 0.005 && $8 > $13 && $8 < 2 * $13) }' said
if "$examples/track" missing.cine 1 1 1 2>said; then exit 1; fi
grep -q missing.cine said

"$examples/fit" | tee said
# Truth within the interval of each parameter, which is narrower than a third of it.
awk -v truths="mu1 0.1 mu2 0.0125 phase_lag_rad 0.2" '
  BEGIN { n = split(truths, t); for (k = 1; k < n; k += 2) truth[t[k]] = t[k + 1] }
  $1 in truth { found += $8 < truth[$1] && truth[$1] < $10 && $4 < truth[$1] / 6 }
  /^chi2/ && /good$/ { good = 1 }
  END { exit !(found == 3 && good) }' said
