#!/usr/bin/env bash
# Installs what is missing, builds, checks the sources' form, runs every test, and closes with CTest's summary. Arguments
# go to ctest (tests/run.sh -L campaign runs the long campaigns, which are left out otherwise).
set -euo pipefail
cd "$(dirname "$0")/.."

apps/install/install_packages.sh test
cmake --preset release -DTRIBOTRACK_TESTS=ON >/dev/null
cmake --build build/release
if [ $# -gt 0 ]; then
  exec ctest --test-dir build/release --output-on-failure --no-tests=error -j"$(nproc)" "$@"
fi
tests/lint.sh build/release
exec ctest --test-dir build/release --output-on-failure --no-tests=error -j"$(nproc)" -LE campaign
