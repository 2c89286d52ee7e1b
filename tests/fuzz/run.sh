#!/usr/bin/env bash
# Fuzzes one kind of file by hand: tests/fuzz/run.sh NAME MINUTES, such as `tests/fuzz/run.sh cine 60`; NAME is that of a folder in
# tests/fuzz/corpus. Needs clang and its runtime (libclang-rt-dev). Prints how many inputs were run and how many of them are
# finds; these are kept in build/fuzz/finds. A find that is mended becomes a file of the corpus, which every test run reads.
set -euo pipefail
cd "$(dirname "$0")/../.."
if [ $# -ne 2 ] || [ ! -d "tests/fuzz/corpus/$1" ]; then
  echo "usage: tests/fuzz/run.sh NAME MINUTES; NAME is one of: $(cd tests/fuzz/corpus && echo *)" >&2
  exit 2
fi
name=$1 end=$((SECONDS + $2 * 60))

cmake --preset fuzz >/dev/null
cmake --build build/fuzz --target "fuzz_$name"
mkdir -p "build/fuzz/finds/$name" "build/fuzz/found/$name"
executions=0
while [ $SECONDS -lt $end ]; do # after a find libFuzzer ends
  log=$(nice -n 19 "build/fuzz/tests/fuzz/fuzz_$name" -max_len=16384 -max_total_time=$((end - SECONDS)) -malloc_limit_mb=512 \
    -rss_limit_mb=1500 -timeout=25 -print_final_stats=1 -artifact_prefix="build/fuzz/finds/$name/" "build/fuzz/found/$name" \
    "tests/fuzz/corpus/$name" 2>&1) || grep -E "FIND|ERROR|runtime error" <<<"$log" || true
  executions=$((executions + $(grep -oE 'number_of_executed_units: [0-9]+' <<<"$log" | grep -oE '[0-9]+' || echo 0)))
done
finds=$(find "build/fuzz/finds/$name" -type f | wc -l)
echo "$name: $executions executions, $finds finds in build/fuzz/finds/$name"
[ "$finds" -eq 0 ]
