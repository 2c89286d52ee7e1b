#!/usr/bin/env bash
# Runs every `tribotrack` command of the README's sh blocks, and its python blocks, in order, in a folder of its own: each ends
# with exit code 0, every file named by an option is there afterwards, and the numbers of the quantities below are, to 1 %, those
# that the README shows. Its other words are free. Inputs are the quickstart's recordings and data/.
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

# NAME NUMBER... of each line that begins with the name of a quantity: 0.1000(23) is 0.1000.
numbers() {
  grep -oE '^ *(mu1|mu2|phase_lag_rad|alpha|v|A|w|scale|mm_per_px) +[-0-9.].*|^(tracked|measured|simulated):.*' "$1" |
    sed -E 's/\([0-9.]+\)//g' | awk '{ printf "%s", $1; for (i = 2; i <= NF; ++i) if ($i ~ /^[-+]?[0-9.]+(e[-+]?[0-9]+)?$/) printf " %s", $i; print "" }'
}
same() {  # expected, printed
  awk 'NR == FNR { want[FNR] = $0; lines = FNR; next }
    {
      n = split(want[FNR], w); bad = n != NF
      for (i = 1; i <= n && !bad; ++i) bad = i == 1 ? w[i] != $i : (w[i] - $i)^2 > (0.01 * w[i])^2 + 1e-24
      if (bad) { print "README: " want[FNR] "\nprinted: " $0; failed = 1 }
    }
    END { if (FNR != lines) { print "not as many lines"; failed = 1 } exit failed }' <(numbers "$1") <(numbers "$2")
}

failed=0
for block in $(ls ./*.sh ./*.py | sort -t/ -k2 -n); do
  n=${block%.*}
  if [ "$block" = "$n.py" ] && [ -z "$python" ]; then
    echo "$block is not run: the Python module is not built"
    [ ! -f "$n.out" ] || cp "$n.out" "$n.printed"
    continue
  fi
  : >"$n.printed"
  while read -r line; do
    bash -c "$line" </dev/null >>"$n.printed" 2>&1 || { cat "$n.printed"; echo "failed with exit code $?: $line"; exit 1; }
    for made in $(grep -oE -- '(-o|--overlay|--figures) [^ ]+' <<<"$line" | cut -d' ' -f2); do
      [ -e "$made" ] || { echo "there is no $made after: $line"; failed=1; }
    done
  done < <(if [ "$block" = "$n.py" ]; then echo "PYTHONPATH=$binary/python $python -B $block"; else grep '^tribotrack ' "$block"; fi)
  [ ! -f "$n.out" ] || [ -n "$update" ] || same "$n.out" "$n.printed" ||
    { echo "the numbers of block $n are not those of README.md (--update refreshes it)"; failed=1; }
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
