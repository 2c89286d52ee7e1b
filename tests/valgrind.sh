#!/usr/bin/env bash
# A smoke subset under valgrind: a recording is rendered, probed and tracked, a motion simulated, displacements fitted. Fails on a
# read of what was never written and on memory lost.
# Use: tests/valgrind.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath "${1:?build folder}")
command -v valgrind >/dev/null || { echo "valgrind is missing: apt-get install valgrind" >&2; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
watched() {
  valgrind --quiet --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite --num-callers=30 "$@" >said.txt 2>&1 ||
    { cat said.txt; echo "valgrind: $*"; exit 1; }
  echo "clean: ${*##*/}"
}
cat >scene.toml <<'SCENE'
[platform]
amplitude_mm = 0
[friction]
mu1 = 0.2
[run]
velocity_x_mm_s = 100
[video]
width = 96
height = 64
frame_rate_hz = 1000
exposure_s = 0.2e-3
frames = 12
[camera]
mm_per_px = 0.1
[disc]
radius_px = 10
SCENE
watched "$build/apps/tribotrack" synth scene.toml -o a.cine -q
watched "$build/apps/tribotrack" probe a.cine --json
watched "$build/apps/tribotrack" track a.cine -o a.csv --mm-per-px 0.1 -q
watched "$build/apps/tribotrack" simulate --mu1 0.1 --mu2 0.0125 --phi-rad 0 --dtau-rad 1 --cycles 3 -o s.csv
# Counts allocations by an operator new of its own, whose delete the compiler inlines: no mismatch of the two.
watched --show-mismatched-frees=no "$build/tests/tests_model" --gtest_brief=1 --gtest_filter='Gate*:Friction*:Drive*'
watched "$build/tests/tests_fit" --gtest_brief=1 --gtest_filter='*Pool*:*Statistics*:*FitLaws.TheOrderOfRuns*/displacements'
