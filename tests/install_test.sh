#!/usr/bin/env bash
# The installed program runs outside the source tree; a project of ten lines builds against the installed libraries and prints
# what is known. Use: tests/install_test.sh BUILD_FOLDER SOURCE_FOLDER [examples]; with `examples`, the installed examples too.
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

if [ "${3:-}" = examples ]; then
  cmake -S prefix/share/doc/tribotrack/examples -B examples -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
  cmake --build examples >/dev/null
  ./examples/simulate | grep '^alpha ' >/dev/null
  ./examples/track
  ./examples/fit | grep '^mu1 ' >/dev/null
fi

# Where the Python module is built, it is found in the prefix, for the Python it was built for.
python=$(sed -n 's/^Python3_EXECUTABLE:[A-Z]*=//p' "$build/CMakeCache.txt")
module=$(find prefix -path '*dist-packages/tribotrack/__init__.py')
if [ -n "$module" ]; then
  PYTHONPATH=$work/$(dirname "$(dirname "$module")") "$python" -B -c '
import tribotrack
assert tribotrack.__file__.startswith("'"$work"'"), tribotrack.__file__
print(tribotrack.__version__, tribotrack.simulate(cycles=1)["cycles"])' | tee said
  grep -q "^$(./prefix/bin/tribotrack --version | head -n 1 | cut -d" " -f2) 1.0$" said
elif [ -e "$build/apps/python/tribotrack" ]; then
  echo "the Python module is not installed"
  exit 1
fi
