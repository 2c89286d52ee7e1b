#!/usr/bin/env bash
# From a fresh Debian 12 to a report: installs what is missing, builds the program and the Python module, renders a small
# campaign of recordings whose truth is known, and runs the whole pipeline on it. A second call skips what is there.
set -euo pipefail
cd "$(dirname "$0")/.."

cores=$(nproc)
if [ -x build/release/apps/tribotrack ]; then
  echo "This takes a minute or two, unless much has to be built again."
else
  # Measured: 15 minutes of one core for the build, one for the example.
  echo "This takes about $((15 / cores + 2)) minutes on this machine ($cores cores), most of it compiling."
fi
apps/install/install_packages.sh build
# A build that was configured for the tests as well is kept as it is.
[ -f build/release/build.ninja ] || cmake --preset release -DTRIBOTRACK_TESTS=OFF >/dev/null
targets=(tribotrack)
if grep -q '^build tribotrack_python:' build/release/build.ninja; then targets+=(tribotrack_python); fi
cmake --build build/release --target "${targets[@]}"
tribotrack=build/release/apps/tribotrack

out=out/quickstart
if ! cmp -s data/example/scene.toml $out/rendered_from.toml; then
  rm -rf $out
  mkdir -p $out
  echo "Rendering 14 recordings (0.7 GB) into $out/recordings ..."
  $tribotrack synth data/example/scene.toml -o $out/recordings
  cp data/example/scene.toml $out/rendered_from.toml
fi
cp data/example/campaign.toml $out/campaign.toml

echo "Tracking, measuring, fitting ..."
$tribotrack run $out/campaign.toml -o $out/result >$out/estimates.txt

# The recordings were rendered from the values in the scene; the fit was not told them.
awk '
  FNR == NR { if ($1 == "mu1" || $1 == "mu1_over_mu2" || $1 == "lag_rad") truth[$1] = $3; next }
  $1 == "parameter" { printf "\n%-16s%12s%12s%12s%14s%14s\n", "", "truth", "estimate", "sd", "95 % from", "to"; next }
  $1 == "mu1" { t = truth["mu1"] }
  $1 == "mu2" { t = truth["mu1"] / truth["mu1_over_mu2"] }
  $1 == "phase_lag_rad" { t = truth["lag_rad"] }
  /^(mu1|mu2|phase_lag_rad) / { printf "%-16s%12.6g%12s%12s%14s%14s\n", $1, t, $2, $3, $4, $5 }
' data/example/scene.toml $out/estimates.txt
echo
echo "Report: $PWD/$out/result/report.html"
echo "Next: $tribotrack open $out (in a browser), or $tribotrack help start-here"
