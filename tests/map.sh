#!/usr/bin/env bash
# Draws the map of rooms in CONTRIBUTING.md from the includes of the sources.
# Use: tests/map.sh          print the map
#      tests/map.sh write    put it into CONTRIBUTING.md
#      tests/map.sh check    fail where CONTRIBUTING.md shows another map, or it or fit/uncertainty.md names a file that does
#                            not exist
set -euo pipefail
cd "$(dirname "$0")/.."
page=CONTRIBUTING.md

# "FROM TO" for each include that leaves a room. A room is a folder; the sources lying directly in a library, its top
# loop, count as one room named LIBRARY/*.cpp, and the public headers beside them as LIBRARY/*.h.
arrows() {
  find model vision fit apps \( -name '*.h' -o -name '*.cpp' \) -print0 | LC_ALL=C sort -z | xargs -0 awk '
    function room(path,   name) {
      name = path
      sub(/\/[^\/]*$/, "", name)
      if (name ~ /\//) return name
      sub(/.*\./, "", path)
      return name "/*." path
    }
    match($0, /^ *# *include *"(model|vision|fit|apps)\/[^"]*"/) {
      target = $0
      sub(/^[^"]*"/, "", target)
      sub(/".*/, "", target)
      from = room(FILENAME)
      to = room(target)
      if (from != to && !seen[from, to]++) print from, to
    }'
}

# A Mermaid drawing of the arrows read, and of rooms that stand alone (lines of one word). An arrow that follows from
# others is left out.
draw() {
  echo '```mermaid'
  echo 'graph TD'
  LC_ALL=C sort -u | awk '
    NF == 1 { alone[++rooms] = $1; next }
    { from[++arrows] = $1; to[arrows] = $2; arrow[$1, $2] = 1; node[$1]; node[$2] }
    END {
      for (a in node) for (b in node) if ((a, b) in arrow) reach[a, b] = 1
      for (b in node) for (a in node) if ((a, b) in reach) for (c in node) if ((b, c) in reach) reach[a, c] = 1
      for (a in node) if ((a, a) in reach) print "  circle through " a
      for (k = 1; k <= arrows; ++k) {
        needless = 0
        for (b in node) if (b != from[k] && b != to[k] && (from[k], b) in arrow && (b, to[k]) in reach) needless = 1
        if (!needless) printf "  %s --> %s\n", label(from[k]), label(to[k])
      }
      for (k = 1; k <= rooms; ++k) if (!(alone[k] in node)) print "  " label(alone[k])
    }
    function label(path,   id) {  # named at its first use only
      id = path
      gsub(/[^a-z]/, "_", id)
      return named[id]++ ? id : id "[\"" path "\"]"
    }'
  echo '```'
}

map() {
  local all library
  all=$(arrows)
  echo 'Who uses whom, seen from afar:'
  echo
  echo "$all" | awk '{ split($1, a, "/"); split($2, b, "/"); if (a[1] != b[1]) print a[1], b[1] }' | draw
  for library in vision model fit apps; do
    echo
    echo "Inside \`$library/\`, without the public headers, which every room may use:"
    echo
    { find "$library" -mindepth 2 -name '*.cpp' -printf '%h\n'; echo "$all"; } | awk -v library="$library/" '
      NF == 1 || (index($1, library) == 1 && index($2, library) == 1 && $1 $2 !~ /\.h/)' | draw
  done
}

# The page with the map in its place.
page_with_map() {
  local drawn
  drawn=$(map)
  awk '/<!-- map begins/ { print; skip = 1; next } /<!-- map ends/ { while ((getline line < map) > 0) print line; skip = 0 } !skip' \
    map=<(echo "$drawn") "$page"
}

circles=$(map | grep circle || true)
if [ -n "$circles" ]; then
  echo "Includes run in a circle:" "$circles" >&2
  [ "${1:-print}" != check ] || exit 1
fi

case ${1:-print} in
  print) map ;;
  write)
    page_with_map >"$page.new"
    mv "$page.new" "$page"
    ;;
  check)
    status=0
    diff -u "$page" <(page_with_map) || {
      echo "The map in $page is not the one of the sources: run tests/map.sh write."
      status=1
    }
    for text in "$page" fit/uncertainty.md; do
      for path in $(grep -o '`[a-z_./]*/[a-z_./]*`' "$text" | tr -d '`'); do
        case $path in build/* | out/*) continue ;; esac
        [ -e "$path" ] || { echo "$text names $path, which does not exist."; status=1; }
      done
    done
    exit $status
    ;;
  *) sed -n '2,6p' "$0" >&2; exit 2 ;;
esac
