#!/usr/bin/env bash
# The quickstart recovers the truth its recordings were rendered from: inside the 95 % intervals, mu1 within 1 %; and a
# second call keeps what is there.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p out
apps/quickstart.sh | tee /dev/stderr >out/quickstart_said.txt
awk '
  $1 == "mu1" || $1 == "mu2" || $1 == "phase_lag_rad" {
    seen++
    if ($2 < $5 || $2 > $6) { print $1 ": the truth " $2 " lies outside " $5 " .. " $6; bad = 1 }
    if ($1 == "mu1" && ($3 < 0.99 * $2 || $3 > 1.01 * $2)) { print "mu1 is off by more than 1 %"; bad = 1 }
  }
  END { if (seen != 3) { print "not all parameters were printed"; bad = 1 } exit bad }
' out/quickstart_said.txt
test -s "$(sed -n 's/^Report: //p' out/quickstart_said.txt)"

before=$(stat -c %Y out/quickstart/result/tracks/phi000_dtau060.csv)
apps/quickstart.sh >/dev/null
test "$before" = "$(stat -c %Y out/quickstart/result/tracks/phi000_dtau060.csv)"
