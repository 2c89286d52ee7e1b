#!/usr/bin/env bash
# The installed program runs outside the source tree, and a project of ten lines builds against the installed libraries.
set -euo pipefail
build=${1:?build folder}
source=${2:?source folder}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >/dev/null
cd "$work"
./prefix/bin/tribotrack --version
./prefix/bin/tribotrack simulate --cycles 2 --dtau-rad pi/3 -o t.csv --quiet
test -s t.csv.meta.json

cp -r "$source/tests/consumer" consumer
cmake -S consumer -B consumer/build -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build consumer/build >/dev/null
./consumer/build/consumer | tee said
# The end point that the model is known to reach.
grep -q '^5.470210819 -10.983961947 mm$' said
for page in man1/tribotrack.1 man1/tribotrack-run.1 man5/tribotrack-campaign.5; do test -s "prefix/share/man/$page"; done
test -s prefix/share/bash-completion/completions/tribotrack
