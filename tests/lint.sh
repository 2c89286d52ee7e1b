#!/usr/bin/env bash
# The form of the sources: clang-format on all, cppcheck on those that changed since the common ancestor with origin/main, or where
# that is this very commit, in the last one. With `all`: cppcheck and clang-tidy on all, which takes an hour.
# Use: tests/lint.sh BUILD_FOLDER [all]
set -euo pipefail
build=$(cd "${1:?build folder}" && pwd)
cd "$(dirname "$0")/.."

find model vision fit apps tests \( -name '*.cpp' -o -name '*.h' \) -print0 | xargs -0 -P "$(nproc)" -n 100 clang-format --dry-run -Werror || {
  echo "Format the sources named above with clang-format -i." >&2
  exit 1
}

product() { grep -E '^(model|vision|fit|apps)/.*\.cpp$' | grep -vE '^apps/bench/(peers|cvode)\.cpp$' || true; }
if [ "${2:-}" = all ]; then
  mapfile -t files < <(find model vision fit apps -name '*.cpp' | product)
else
  base=$(git merge-base HEAD origin/main 2>/dev/null) || base=
  if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; then base=HEAD~1; fi
  mapfile -t files < <(git diff --name-only --diff-filter=d "$base" 2>/dev/null | product)
fi
[ ${#files[@]} -gt 0 ] || exit 0

# What cppcheck cannot tell, and the compiler, clang-tidy or a sanitizer can.
suppressed=$(printf -- '--suppress=%s ' missingIncludeSystem missingReturn zerodiv containerOutOfBounds invalidContainerReference \
  uninitvar uninitMemberVar passedByValue unknownMacro compareBoolExpressionWithInt)
# shellcheck disable=SC2086  # one option a word
cppcheck --enable=warning,performance,portability --std=c++20 --quiet --error-exitcode=1 -I . -j "$(nproc)" $suppressed "${files[@]}"

[ "${2:-}" = all ] || exit 0
command -v clang-tidy >/dev/null || { echo "left out: clang-tidy is not installed"; exit 77; }
# Clang cannot read the headers that GCC has precompiled.
mkdir -p "$build/lint"
sed 's/ -Winvalid-pch//; s/ -include [^ ]*cmake_pch.hxx//; s/ -fpch-preprocess//' "$build/compile_commands.json" \
  >"$build/lint/compile_commands.json"
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$build/lint" --quiet \
  --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unknown-pragmas
