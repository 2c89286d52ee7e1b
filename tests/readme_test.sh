#!/usr/bin/env bash
# Runs every `tribotrack` command of the README's sh blocks, in order, in a folder of its own. Their inputs are the
# quickstart's recordings and data/.
set -euo pipefail
binary=$(cd "$(dirname "${1:?binary}")" && pwd)
source=${2:?source folder}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
ln -s "$source/data" "$work/data"
ln -s "$source/out" "$work/out"
awk '/^```sh/ { on = 1; next } /^```/ { on = 0 } on && /^tribotrack / { print }' "$source/README.md" >"$work/commands"
count=$(wc -l <"$work/commands")
test "$count" -ge 8 || { echo "only $count commands were found in the README"; exit 1; }
cd "$work"
export PATH="$binary:$PATH"
while read -r line; do
  echo "\$ $line"
  bash -c "$line" </dev/null || { echo "failed with exit code $?: $line"; exit 1; }
done <commands
