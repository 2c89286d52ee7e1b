#!/usr/bin/env bash
# clang-format on all sources, clang-tidy and cppcheck on those that changed: since the common ancestor with
# origin/main, or where that is this very commit, in the last one. clang-tidy takes 10 s a source, so that of more than 40
# changed ones it sees 40. Fails on wrong format, on what .clang-tidy counts as an error and on what cppcheck finds beyond
# tests/cppcheck.txt.
# Use: tests/lint.sh BUILD_FOLDER [all]
set -euo pipefail
build=$(cd "${1:?build folder}" && pwd)
cd "$(dirname "$0")/.."

sources() { find model vision fit apps tests \( -name '*.cpp' -o -name '*.h' \) -print0; }
sources | xargs -0 clang-format --dry-run -Werror || {
  echo "Format the sources named above with clang-format -i." >&2
  exit 1
}

changed() {
  local base
  if [ "${2:-}" = all ]; then
    sources | tr '\0' '\n'
    return
  fi
  base=$(git merge-base HEAD origin/main 2>/dev/null) || base=
  if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD 2>/dev/null)" ]; then base=HEAD~1; fi
  git diff --name-only --diff-filter=d "$base" 2>/dev/null || echo "No earlier commit: clang-tidy is not run." >&2
}
mapfile -t files < <(changed "$@" | grep -E '^(model|vision|fit|apps)/.*\.cpp$' | grep -v '^apps/bench/peers/')
if [ "${2:-}" != all ] && [ ${#files[@]} -gt 40 ]; then
  echo "${#files[@]} sources changed; clang-tidy looks at 40 (all: tests/lint.sh $1 all)." >&2
  mapfile -t files < <(printf '%s\n' "${files[@]}" | shuf -n 40 --random-source=<(yes))
fi
[ ${#files[@]} -gt 0 ] || exit 0
cppcheck --enable=warning,performance,portability --std=c++20 --quiet --error-exitcode=1 -I . -j "$(nproc)" \
  --suppress=missingIncludeSystem --suppressions-list=tests/cppcheck.txt "${files[@]}"
# Clang cannot read the headers that GCC has precompiled.
mkdir -p "$build/lint"
sed 's/ -Winvalid-pch//; s/ -include [^ ]*cmake_pch.hxx//; s/ -fpch-preprocess//' "$build/compile_commands.json" \
  >"$build/lint/compile_commands.json"
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$build/lint" --quiet \
  --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unknown-pragmas
