#!/usr/bin/env bash
# What a change is judged by: installs what is missing, builds, checks the sources' form, runs the tests of the tiers `unit` and
# `whole`, prints how long each took, and closes with CTest's summary of both. Arguments go to ctest instead of the tiers:
# tests/run.sh -L campaign runs the long campaigns.
set -euo pipefail
cd "$(dirname "$0")/.."
kind=test
[[ " $* " != *" campaign "* ]] || kind=campaign
times=
begun=$SECONDS
tier_ends() {  # name
  times+=$(printf '%-8s %4d s' "$1" $((SECONDS - begun)))$'\n'
  begun=$SECONDS
}

apps/install/install_packages.sh $kind
tier_ends install
cmake --preset release -DTRIBOTRACK_TESTS=ON >/dev/null
cmake --build build/release
tier_ends build
tests=(ctest --test-dir build/release --output-on-failure --no-tests=error -j"$(nproc)")
[ $# -eq 0 ] || exec "${tests[@]}" "$@"

tests/lint.sh build/release
tier_ends form
code=0
for tier in unit whole; do
  "${tests[@]}" -L "^$tier$" 2>&1 | tee build/release/$tier.log || code=1
  tier_ends $tier
done
printf '\n%s\n' "$times"
# The two summaries as one, as CTest writes it.
awk '/tests passed, .* tests failed out of / { failed += $4; count += $9 }
  END { printf "%d%% tests passed, %d tests failed out of %d\n", count ? 100 * (count - failed) / count : 0, failed, count }' \
  build/release/{unit,whole}.log
exit $code
