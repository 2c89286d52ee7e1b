#!/usr/bin/env bash
# The profile of a short command: functions by their time, and a flame graph of well-formed boxes. Skipped (exit code 77)
# where perf is not installed or this machine does not let it sample.
# Use: tests/profile_test.sh BINARY
set -euo pipefail
binary=$(realpath "${1:?binary}")
cd "$(dirname "$0")/.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Without perf it says which package to install.
mkdir "$out/bin"
for tool in bash realpath mkdir dirname; do ln -s "$(command -v $tool)" "$out/bin/"; done
if PATH=$out/bin apps/bench/profile.sh "$binary" "$out/none" sweep 2>"$out/said"; then
  echo "profile.sh is content without perf"
  exit 1
fi
grep -q 'linux-perf' "$out/said"

if ! perf record -q -e cpu-clock -o "$out/perf.data" true >/dev/null 2>&1; then
  echo "perf is not installed or may not sample here: skipped"
  exit 77
fi
apps/bench/profile.sh "$binary" "$out" sweep
grep -q 'sweep' "$out/sweep.txt"
awk '$2 == "%" && NF > 2 { ++functions } END { exit functions < 10 }' "$out/sweep.txt"
grep -q '<title>_start, ' "$out/sweep.svg"
test "$(grep -c '<g>' "$out/sweep.svg")" = "$(grep -c '</g>' "$out/sweep.svg")"
test "$(tail -n 1 "$out/sweep.svg")" = '</svg>'
test ! -e "$out/sweep.perf"
if apps/bench/profile.sh "$binary" "$out" walk 2>"$out/said"; then exit 1; fi
grep -q '"walk"' "$out/said"
