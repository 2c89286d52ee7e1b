#!/usr/bin/env bash
# Every named constant of the tracker, and what the results do when it is half as large again or smaller by as much.
# Use: tests/vision/vary_constants.sh check          fail where constants/table.csv does not list the constants as they are
#      tests/vision/vary_constants.sh run FOLDER     build a program whose constants can be varied in FOLDER, track the
#                                                    scenes of constants/*.toml with each in turn, and fail where an
#                                                    error changes by more than the table says; the new table is
#                                                    FOLDER/table.csv
set -euo pipefail
cd "$(dirname "$0")/../.."
readonly scenes=$PWD/tests/vision/constants table=$PWD/tests/vision/constants/table.csv
# Not vision/tags: no scene of ours has a tag; its constants are judged by its tests.
readonly rooms="audit discs following layers platform_motion registration tracking"
readonly step=1.5

# FILE:NAME,VALUE of each constant; the value as it is written.
constants() {
  local room
  for room in $rooms; do find "vision/$room" -name '*.h' -o -name '*.cpp'; done | LC_ALL=C sort | xargs perl -0777 -ne '
    while (/^(?:inline |static )?constexpr (?:double|float|int|std::size_t|std::int64_t) (k[A-Z]\w*)\s*=\s*([^;,]+);/mg) {
      my ($name, $value) = ($1, $2);
      $value =~ s/\s+/ /g;
      print "$ARGV:$name,$value\n";
    }'
}

check() {
  diff <(constants | LC_ALL=C sort) <(tail -n +2 "$table" | cut -d, -f1,2 | LC_ALL=C sort) ||
    { echo "tests/vision/constants/table.csv: constants have changed; run tests/vision/vary_constants.sh run FOLDER" >&2; exit 1; }
}

# A copy of the sources whose constants take VARY_BY times their value where VARY names them. Sizes of arrays and what
# else must be known to the compiler stay as they are.
build() {
  local source=$1/source
  mkdir -p "$source"
  tar c --exclude=./build --exclude=./out --exclude=./.git . | tar xm -C "$source"
  cp "$scenes/varied.h" "$source/varied.h"
  (cd "$source" && constants | cut -d: -f1 | uniq | xargs perl -0777 -i -pe '
    s/^(?:inline |static )?constexpr (double|float|int|std::size_t|std::int64_t) (k[A-Z]\w*)\s*=\s*([^;,]+);/static const $1 $2 = ::varied<$1>("$ARGV:$2", $3);/mg;
    $_ = "#include \"varied.h\"\n$_"')
  (cd "$source" && while read -r fixed; do
    sed -i -E "s|static const ([a-z_:0-9]+) ${fixed#*:} = ::varied<[^>]*>\(\"[^\"]*\", (.*)\);|constexpr \1 ${fixed#*:} = \2;|" "${fixed%:*}"
  done < "$scenes/fixed.txt")
  sed -i "s/ -Werror//" "$source/CMakeLists.txt"
  CXXFLAGS="-I$source ${CXXFLAGS:-}" cmake -S "$source" -B "$1/build" -G Ninja -DCMAKE_BUILD_TYPE=Release > "$1/configure.log"
  ninja -C "$1/build" tribotrack > "$1/build.log" || { grep -E 'error' "$1/build.log" >&2; exit 1; }
}

# "FRAMES RMS PULL" of a track against the truth: frames found, error without its mean, error over reported sd.
score() {
  awk -F, '
    FNR == 1 { for (i = 1; i <= NF; ++i) if (NR == 1) true[$i] = i; else own[$i] = i; next }
    NR == FNR { x[$1] = $true["x_px"]; y[$1] = $true["y_px"]; next }
    $own["status"] == "ok" {
      ++n; dx[n] = $own["x_px"] - x[$1]; dy[n] = $own["y_px"] - y[$1]
      vx[n] = $own["sigma_x_px"]^2; vy[n] = $own["sigma_y_px"]^2; mx += dx[n]; my += dy[n]
    }
    END {
      if (n < 2) { print 0, 0, 0; exit }
      for (i = 1; i <= n; ++i) {
        ex = dx[i] - mx / n; ey = dy[i] - my / n
        square += ex * ex + ey * ey; pull += ex * ex / vx[i] + ey * ey / vy[i]
      }
      printf "%d %.6f %.4f\n", n, sqrt(square / n), sqrt(pull / n / 2)
    }' "$1" "$2"
}

# Scores of all scenes in one line; the tracks go into a folder of their own.
track_all() {
  local folder=$1 scene tracks
  tracks=$(mktemp -d "$folder/tracks.XXXXXX")
  for scene in "$scenes"/*.toml; do
    local name mark=(--marker 32,32,14)
    name=$(basename "$scene" .toml)
    [ "$name" != no_mark ] || mark=()
    "$folder/build/apps/tribotrack" track "$folder/$name.cine" --mm-per-px 0.1 "${mark[@]}" -o "$tracks/$name.csv" -q > /dev/null 2>&1 || true
    if [ -f "$tracks/$name.csv" ]; then score "$folder/$name.cine.truth.csv" "$tracks/$name.csv"; else echo 0 0 0; fi
  done | tr '\n' ' '
  rm -r "$tracks"
}

# The largest of rms / usual rms and pull / usual pull over the scenes; "lost" where frames are lost.
change() {
  awk -v usual="$1" -v now="$2" 'BEGIN {
    n = split(usual, u, " "); split(now, v, " ")
    for (i = 1; i <= n; i += 3) {
      if (v[i] < 0.98 * u[i]) { print "lost"; exit }
      for (k = 1; k <= 2; ++k) if (v[i + k] / u[i + k] > worst) worst = v[i + k] / u[i + k]
    }
    printf "%.2f\n", worst }'
}

# NAME,VALUE,SMALLER,LARGER of one constant.
vary() {
  local folder=$1 usual=$2 entry=$3 name=${3%%,*} smaller=fixed larger=fixed
  if ! grep -qxF "$name" "$scenes/fixed.txt"; then
    smaller=$(change "$usual" "$(VARY=$name VARY_BY=$(awk "BEGIN { print 1 / $step }") track_all "$folder")")
    larger=$(change "$usual" "$(VARY=$name VARY_BY=$step track_all "$folder")")
  fi
  echo "$entry,$smaller,$larger"
}

run() {
  local folder=$1 scene
  mkdir -p "$folder"
  folder=$(cd "$folder" && pwd)
  build "$folder"
  for scene in "$scenes"/*.toml; do
    "$folder/build/apps/tribotrack" synth "$scene" -o "$folder/$(basename "$scene" .toml).cine" -q
  done
  {
    echo "constant,value,smaller,larger"
    constants | xargs -d '\n' -P "$(nproc)" -n 1 "$PWD/tests/vision/vary_constants.sh" vary "$folder" "$(track_all "$folder")" | LC_ALL=C sort
  } > "$folder/table.csv"
  # A twentieth more than the table says is chance.
  awk -F, 'NR == FNR { smaller[$1] = $3; larger[$1] = $4; next }
    FNR > 1 && ((worse($3, smaller[$1])) || worse($4, larger[$1])) { print "changes more than the table says: " $0; bad = 1 }
    function worse(now, before) { return now != before && (now == "lost" || now > 1.05 * (before < 1 ? 1 : before)) }
    END { exit bad }' "$table" "$folder/table.csv"
}

case ${1:-} in
  check) check ;;
  run) run "${2:?a folder to build in}" ;;
  vary) vary "$2" "$3" "$4" ;;
  *) sed -n '2,8p' "$0" >&2; exit 2 ;;
esac
