#!/usr/bin/env bash
# Would the tests see a wrong sign? faults.tsv lists faults of the kinds that such code has: a sign, an off-by-one, a dropped
# term, a swapped frame of reference (columns: file, text, what it becomes, kind). Each is planted by itself and must be
# caught by the tests of its own library.
# Use: tests/planted_faults/plant.sh check                     every text still occurs exactly once in its file
#      tests/planted_faults/plant.sh run FOLDER [PATTERN]      build in FOLDER, plant each fault whose line matches PATTERN
set -euo pipefail
cd "$(dirname "$0")/../.."
readonly list=$PWD/tests/planted_faults/faults.tsv

# Replaces the fault's text in FOLDER/FILE; fails unless it occurs exactly once.
plant() {  # folder, line of the list
  perl -e '
    my ($folder, $line) = @ARGV;
    chomp $line;
    my ($file, $old, $new) = split /\t/, $line, -1;
    open(my $in, "<", "$folder/$file") or die "$file: there is no such file\n";
    local $/;
    my $text = <$in>;
    my $count = () = $text =~ /\Q$old\E/g;
    die "$file: \"$old\" occurs $count times, not once; correct tests/planted_faults/faults.tsv\n" if $count != 1;
    exit 0 if $folder eq ".";
    $text =~ s/\Q$old\E/$new/;
    # What a fault leaves unused is no reason not to compile.
    $text = join("", map { "#pragma GCC diagnostic ignored \"-Wunused-$_\"\n" }
                     qw(variable parameter but-set-variable function)) . $text;
    open(my $out, ">", "$folder/$file") or die;
    print $out $text;' "$1" "$2"
}

check() {
  local line count=0 wrong=0
  while IFS= read -r line; do
    plant . "$line" || wrong=$((wrong + 1))
    count=$((count + 1))
  done <"$list"
  echo "$count faults listed, $wrong that cannot be planted"
  [ $wrong = 0 ] && [ $count -ge 60 ]
}

# A copy of the sources, each compiled by itself: what a fault changes is all that is compiled anew. A build that was
# configured there before is kept.
build() {  # folder, pattern
  local libraries
  libraries=$(grep -E "$2" "$list" | cut -d/ -f1 | sort -u | sed 's/^/tests_/')
  mkdir -p "$1/source"
  tar c --exclude=./build --exclude=./out --exclude=./.git . | tar xm -C "$1/source"
  [ -f "$1/build/build.ninja" ] ||
    cmake -S "$1/source" -B "$1/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O1 -DNDEBUG -Wno-maybe-uninitialized" \
      -DTRIBOTRACK_UNITY=OFF >"$1/configure.log"
  # shellcheck disable=SC2086  # one word a library
  ninja -C "$1/build" $libraries >"$1/build.log" || { tail -n 40 "$1/build.log" >&2; exit 1; }
}

# The suites of the tests under the same path, as a filter; those of the library's own folder where there are none.
nearest_tests() {  # file
  local folder="tests/${1%/*}"
  grep -rhoE '^(TEST|TEST_F|TEST_P|TYPED_TEST)\(\w+' "$folder" 2>/dev/null | sed 's/.*(//' | sort -u |
    sed 's/.*/&.*:*\/&.*:&\/*.*/' | paste -sd:
}

# Prints how a fault fared: caught, missed, or why it could not be tried.
try() {  # folder, line
  local file library program filter said
  file=${2%%$'\t'*}
  library=${file%%/*}
  program=$1/build/tests/tests_$library
  plant "$1/source" "$2" || return 1
  if ! ninja -C "$1/build" "tests_$library" >"$1/fault.log" 2>&1; then
    echo "does not compile"
    return 1
  fi
  filter=$(nearest_tests "$file")
  for said in "${filter:-none}" '*'; do
    # A test that never ends is caught by its time limit, too.
    if ! (cd "$1" && timeout 900 "$program" --gtest_brief=1 --gtest_fail_fast --gtest_filter="$said-*Campaign.*") \
      >"$1/tests.log" 2>&1; then
      echo "caught by $(grep -m 1 -oE '\[  FAILED  \] [^ ,]*' "$1/tests.log" | cut -c14- || echo 'its end')"
      return 0
    fi
  done
  echo "MISSED"
  return 1
}

run() {
  local folder line fared caught=0 count=0
  mkdir -p "$1"
  folder=$(realpath "$1")
  build "$folder" "${2:-.}"
  while IFS= read -r line; do
    [[ $line =~ ${2:-.} ]] || continue
    count=$((count + 1))
    if fared=$(try "$folder" "$line" </dev/null); then caught=$((caught + 1)); fi
    printf '%s\t%s\n' "$fared" "$line" | tee -a "$folder/fared.tsv"
    cp "${line%%$'\t'*}" "$folder/source/${line%%$'\t'*}"
  done <"$list"
  echo "planted faults: $caught of $count caught"
  [ $caught = $count ]
}

case ${1:-} in
  check) check ;;
  run) run "${2:?folder}" "${3:-}" ;;
  *) sed -n '2,7s/^# //p' "$0" >&2; exit 2 ;;
esac
