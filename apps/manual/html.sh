#!/usr/bin/env bash
# Renders the manual as HTML by Debian's mkdocs, with the keys of campaigns where the program is built.
# Use: apps/manual/html.sh [FOLDER, default build/manual]
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "${1:-build/manual}")
program=build/release/apps/tribotrack
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/docs"
cp apps/manual/*.md apps/manual/*.svg data/example/*.png "$work/docs"
mv "$work/docs/start-here.md" "$work/docs/index.md"
sed -i 's#\.\./\.\./data/example/##g; s#(start-here\.md)#(index.md)#g' "$work"/docs/*.md
if [ -x $program ]; then
  { printf '# Keys of a campaign\n\n```\n'; $program help campaign; printf '```\n'; } >"$work/docs/campaign-keys.md"
fi
printf 'site_name: tribotrack\nuse_directory_urls: false\ntheme: readthedocs\n' >"$work/mkdocs.yml"
mkdocs build --quiet -f "$work/mkdocs.yml" -d "$out"
echo "$out/index.html"
