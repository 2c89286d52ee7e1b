#!/usr/bin/env bash
# Would the tests see a wrong sign? Plants faults in a copy of the sources, one at a time: signs, comparisons, sines for cosines,
# off-by-ones, dropped squares, at places drawn at random from those where the pattern of a fault fits. Each must be caught by
# the tests of its own library. Takes minutes a fault; for a release.
# Use: tests/plant_faults.sh FOLDER [COUNT [SEED]]    builds in FOLDER; 30 faults by default
set -euo pipefail
folder=${1:?folder} count=${2:-30} seed=${3:-1}
cd "$(dirname "$0")/.."
mkdir -p "$folder"
folder=$(realpath "$folder")

mkdir -p "$folder/source"
tar c --exclude=./build --exclude=./out --exclude=./.git . | tar xm -C "$folder/source"
[ -f "$folder/build/build.ninja" ] ||
  cmake -S "$folder/source" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG -Wno-error" >"$folder/configure.log"
ninja -C "$folder/build" tests_model tests_vision tests_fit >"$folder/build.log" || { tail -n 40 "$folder/build.log" >&2; exit 1; }

# Patterns as perl's: what stands there, what it becomes. Lines of comments, texts and includes are left alone.
patterns=$(cat <<'END'
 \+ (?=[a-z])	 - 
 - (?=[a-z])	 + 
 \* (?=[a-z])	 / 
 < (?=[a-z(])	 <= 
 > (?=[a-z(])	 < 
 \+= 	 -= 
std::sin\(	std::cos(
std::cos\(	std::sin(
 \+ 1\b	 + 2
 - 1\b	 
\b0\.5 \*	
std::max\(	std::min(
&&	||
END
)
# "FILE LINE PATTERN BECOMES", tab-separated, in the order of a die that SEED throws.
places() {
  while IFS=$'\t' read -r pattern becomes; do
    grep -rnP --include='*.cpp' --include='*.h' -- "$pattern" model vision fit |
      grep -vP '^[^:]*:\d+:\s*(//|#|template|using|static_assert)|".*"|operator|constexpr' |
      sed -E "s/^([^:]*):([0-9]+):.*/\1\t\2/" | while IFS= read -r place; do printf '%s\t%s\t%s\n' "$place" "$pattern" "$becomes"; done
  done <<<"$patterns" | shuf -n "$count" --random-source=<(yes "$seed")
}

caught=0 tried=0
while IFS=$'\t' read -r file line pattern becomes; do
  PATTERN=$pattern BECOMES=$becomes perl -i -pe "if (\$. == $line) { s/\$ENV{PATTERN}/\$ENV{BECOMES}/ }" "$folder/source/$file"
  library=${file%%/*}
  fared="does not compile"
  if ninja -C "$folder/build" "tests_$library" >"$folder/fault.log" 2>&1; then
    tried=$((tried + 1))
    fared=MISSED
    # A test that never ends is caught by its time limit.
    if ! (cd "$folder" && timeout 900 "build/tests/tests_$library" --gtest_brief=1 --gtest_fail_fast \
      --gtest_filter='-*Campaign.*') >"$folder/tests.log" 2>&1; then
      fared="caught by $(grep -m 1 -oE '\[  FAILED  \] [^ ,]*' "$folder/tests.log" | cut -c14- || echo 'its end')"
      caught=$((caught + 1))
    fi
  fi
  printf '%s\t%s:%s\t%s\t%s\n' "$fared" "$file" "$line" "$pattern" "$(sed -n "${line}p" "$folder/source/$file" | sed 's/^ *//')" |
    tee -a "$folder/fared.tsv"
  cp "$file" "$folder/source/$file"
done < <(places)
# Some of what is planted changes nothing that anybody could see: whoever reads the list judges what was missed.
echo "planted faults: $caught of $tried caught; $folder/fared.tsv lists them"
