#!/usr/bin/env bash
# Runs every `tribotrack` command of the README's sh blocks, and its python blocks, in order, in a folder of its own, and
# compares what they print with the block that follows: words exactly, numbers to 1 % of the value (other processors round otherwise), times
# (numbers followed by " s", and the table "time of each stage") not at all. Inputs are the quickstart's recordings and data/.
# Use: readme_test.sh BINARY SOURCE PYTHON [--update]; --update writes what was printed into the README. PYTHON is the
# interpreter of the module beside the binary, or empty where that was not built.
set -euo pipefail
binary=$(cd "$(dirname "${1:?binary}")" && pwd)
source=${2:?source folder}
python=${3?interpreter}
update=${4:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
ln -s "$source/data" "$work/data"
ln -s "$source/out" "$work/out"
export PATH="$binary:$PATH"
cd "$work"

# The README in pieces: block N.sh or N.py, and N.out where a block of output follows directly.
awk '
  /^```(sh|python)$/ { n++; file = n (/sh$/ ? ".sh" : ".py"); printf "" > file; in_sh = 1; next }
  /^```$/ && in_sh { in_sh = 0; expect = 1; next }
  /^```$/ && expect { file = n ".out"; printf "" > file; in_out = 1; expect = 0; next }
  /^```$/ && in_out { in_out = 0; next }
  in_sh || in_out { print > file; next }
  NF { expect = 0 }
' "$source/README.md"

blocks=$(ls ./*.sh ./*.py | wc -l)
commands=$(cat ./*.sh | grep -c '^tribotrack ')
test "$commands" -ge 8 || { echo "only $commands commands were found in the README"; exit 1; }

# What takes longer than 10 s on a busy machine says so now and then.
without_progress() { grep -vE '^[a-z, ]+: [0-9]+/[0-9]+ \([0-9]+ %\)' "$1" || true; }

same() {  # expected, printed
  awk '
    function tokens(line, t) { gsub(/[][(),;:%]/, " & ", line); return split(line, t, " ") }
    function number(x) { return x ~ /^[-+]?[0-9.]+(e[-+]?[0-9]+)?$/ }
    NR == FNR { want[++lines] = $0; next }
    {
      if (++k > lines) { print "printed and not in the README: " $0; bad = 1; next }
      if (want[k] ~ /^time of each stage/) stages = 1
      else if (want[k] !~ /^  /) stages = 0
      n = tokens(want[k], w); m = tokens($0, p)
      differs = n != m
      for (i = 1; i <= n && !differs; i++) {
        if (number(w[i]) && number(p[i])) {
          time = stages || (i < n && w[i + 1] == "s")
          size = w[i] < 0 ? -w[i] : w[i]
          off = w[i] - p[i]
          if (!time && (off < 0 ? -off : off) > 0.01 * size + 1e-12) differs = 1
        } else if (w[i] != p[i]) differs = 1
      }
      if (differs) { print "README:  " want[k]; print "printed: " $0; bad = 1 }
    }
    END { for (k++; k <= lines; k++) { print "in the README and not printed: " want[k]; bad = 1 }; exit bad }
  ' "$1" "$2"
}

failed=0
compare() {  # block
  if [ ! -f "$1.out" ] || [ -n "$update" ]; then return; fi
  same "$1.out" <(without_progress "$1.printed") || { echo "block $1 differs from what README.md shows; refresh it with --update"; failed=1; }
}
for n in $(seq "$blocks"); do
  if [ -f "$n.py" ]; then
    [ -n "$python" ] || { echo "block $n is not run: the Python module is not built"; cp "$n.out" "$n.printed"; continue; }
    PYTHONPATH=$binary/python "$python" -B "$n.py" </dev/null >"$n.printed" 2>&1 || { cat "$n.printed"; echo "block $n failed"; exit 1; }
    compare "$n"
    continue
  fi
  grep '^tribotrack ' "$n.sh" >"$n.run" || true
  : >"$n.printed"
  while read -r line; do
    echo "\$ $line"
    bash -c "$line" </dev/null >>"$n.printed" 2>&1 || { cat "$n.printed"; echo "failed with exit code $?: $line"; exit 1; }
  done <"$n.run"
  compare "$n"
done

if [ -n "$update" ]; then
  awk '
    /^```(sh|python)$/ { n++; in_sh = 1 }
    /^```$/ && in_sh { in_sh = 0; expect = 1; print; next }
    /^```$/ && expect { print; while ((getline line < (n ".printed")) > 0) print line; skip = 1; expect = 0; next }
    /^```$/ && skip { skip = 0 }
    skip { next }
    !in_sh && NF && !/^```/ { expect = 0 }
    { print }
  ' "$source/README.md" >updated.md
  cat updated.md >"$source/README.md"
fi
exit $failed
