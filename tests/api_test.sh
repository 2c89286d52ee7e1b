#!/usr/bin/env bash
# The public headers as Doxygen reads them: not one warning, a page for every header, and on it what the header says of itself.
# Use: tests/api_test.sh SOURCE_FOLDER
set -euo pipefail
cd "${1:?source folder}"
command -v doxygen >/dev/null || {
  echo "skipped: doxygen is not installed"
  exit 77
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build() { (cat apps/install/Doxyfile && echo "OUTPUT_DIRECTORY = $work" && printf '%s\n' "$@") | doxygen -; }

build
for header in vision/*.h model/*.h fit/*.h; do
  name=$(basename "$header" .h)
  page=$work/html/${name//_/__}_8h.html
  first=$(sed -n '1s#^// *##p' "$header" | cut -d' ' -f1-4)
  sed "s/<[^>]*>//g; s/&#39;/'/g; s/&quot;/\"/g; s/&gt;/>/g; s/&lt;/</g" "$page" | grep -F -- "$first" >/dev/null || {
    echo "$page does not say \"$first\", as $header does"
    exit 1
  }
done

# Would a warning fail? A header that refers to what is not there.
printf '// A header.\n/// See \\ref nowhere_at_all.\nint f();\n' >"$work/wrong.h"
if build "INPUT = $work/wrong.h" 2>"$work/said"; then
  echo "a wrong reference was not noticed"
  exit 1
fi
grep -q nowhere_at_all "$work/said"
