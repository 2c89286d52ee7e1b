#!/usr/bin/env bash
# Runs every `tribotrack` command of the sh blocks of the README and the manual, and their python blocks, in order, in one
# folder: each ends with exit code 0, every file named by an option is there afterwards, and the numbers of the quantities
# below are those that the page shows, within their sd where one is shown, else to 1 %. Other words are free. Inputs are the
# quickstart's recordings and data/.
# Use: readme_test.sh BINARY SOURCE PYTHON [--update]; --update writes what was printed into the pages. PYTHON is the
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

# NAME NUMBER... of each line that begins with the name of a quantity; 0.1000(23) is 0.1000 with its sd.
numbers() {
  grep -oE '^ *(mu1|mu2|phase_lag_rad|alpha|v|A|w|scale|mm_per_px) +[-0-9.].*|^(tracked|measured|simulated):.*' "$1" |
    awk '{ printf "%s", $1; for (i = 2; i <= NF; ++i) if ($i ~ /^[-+]?[0-9.]+(e[-+]?[0-9]+)?(\([0-9.]+\))?$/) printf " %s", $i; print "" }'
}
same() {  # page, expected, printed
  awk -v page="$1" 'function sd_of(text, value,  digits, places) {
      if (!match(text, /\(.*\)/)) return 0.01 * (value < 0 ? -value : value)
      digits = substr(text, RSTART + 1, RLENGTH - 2)
      places = match(text, /\.[0-9]*\(/) && digits !~ /\./ ? RLENGTH - 2 : 0
      return digits / 10 ^ places
    }
    NR == FNR { want[FNR] = $0; lines = FNR; next }
    {
      n = split(want[FNR], w); bad = n != NF
      for (i = 1; i <= n && !bad; ++i) bad = i == 1 ? w[i] != $i : (w[i] - $i)^2 > sd_of(w[i], w[i] + 0)^2 + 1e-24
      if (bad) { print page ": " want[FNR] "\nprinted: " $0; failed = 1 }
    }
    END { if (FNR != lines) { print page ": not as many lines"; failed = 1 } exit failed }' <(numbers "$2") <(numbers "$3")
}

failed=0
for page in "$source/README.md" "$source"/apps/manual/*.md; do
  # The page in pieces: block N.sh or N.py, and N.out where a block of output follows directly.
  rm -f ./[0-9]*.sh ./[0-9]*.py ./[0-9]*.out ./[0-9]*.printed
  awk '
    /^```(sh|python)$/ { n++; file = n (/sh$/ ? ".sh" : ".py"); printf "" > file; in_sh = 1; next }
    /^```$/ && in_sh { in_sh = 0; expect = 1; next }
    /^```$/ && expect { file = n ".out"; printf "" > file; in_out = 1; expect = 0; next }
    /^```$/ && in_out { in_out = 0; next }
    in_sh || in_out { print > file; next }
    NF { expect = 0 }
  ' "$page"
  for block in $(find . -maxdepth 1 -name '[0-9]*.sh' -o -maxdepth 1 -name '[0-9]*.py' | sort -t/ -k2 -n); do
    n=${block%.*}
    if [ "$block" = "$n.py" ] && [ -z "$python" ]; then
      echo "$page: Python is not run: the module is not built"
      [ ! -f "$n.out" ] || cp "$n.out" "$n.printed"
      continue
    fi
    : >"$n.printed"
    while read -r line; do
      bash -c "$line" </dev/null >>"$n.printed" 2>&1 || { cat "$n.printed"; echo "$page: failed: $line"; exit 1; }
      for made in $(grep -oE -- '(-o|--overlay|--figures) [^ ]+' <<<"$line" | cut -d' ' -f2); do
        [ -e "$made" ] || { echo "$page: there is no $made after: $line"; failed=1; }
      done
    done < <(if [ "$block" = "$n.py" ]; then echo "PYTHONPATH=$binary/python $python -B $block"; else grep '^tribotrack ' "$block"; fi)
    [ ! -f "$n.out" ] || [ -n "$update" ] || same "$page" "$n.out" "$n.printed" || failed=1
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
    ' "$page" >updated.md
    cat updated.md >"$page"
  fi
done
[ $failed = 0 ] || echo "the pages' numbers are not those printed (--update writes them)"
exit $failed
