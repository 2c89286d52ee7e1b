#!/usr/bin/env bash
# Line coverage of each library by the tests of its own: at least 90 % of model/, vision/ and fit/.
# Use: tests/coverage.sh [model|vision|fit ...]
set -euo pipefail
cd "$(dirname "$0")/.."
command -v gcovr >/dev/null || { echo "gcovr is missing: apt-get install gcovr" >&2; exit 77; }
[ $# -gt 0 ] || set -- model vision fit
cmake --preset coverage >/dev/null
cmake --build --preset coverage --target "${@/#/tests_}"
failed=0
for library in "$@"; do
  find build/coverage -name '*.gcda' -delete
  build/coverage/tests/tests_"$library" --gtest_brief=1 --gtest_filter='-*Campaign.*' || failed=1
  percent=$(gcovr --root . --object-directory "build/coverage/$library" --filter "$library/" --gcov-ignore-parse-errors \
    --json-summary | grep -oE '"line_percent": [0-9.]+' | tail -n 1 | grep -oE '[0-9.]+')
  echo "$library: $percent % of the lines"
  awk -v percent="$percent" 'BEGIN { exit !(percent >= 90) }' || failed=1
done
exit $failed
