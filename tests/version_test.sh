#!/usr/bin/env bash
# One version: what CMakeLists.txt says is what the program, the Python module, the citation and the newest heading of the
# changelog say; no other file of the project states it. Use: tests/version_test.sh SOURCE TRIBOTRACK [PYTHON MODULE_FOLDER]
set -euo pipefail
source=${1:?source folder}
tribotrack=${2:?the program}
cd "$source"
version=$(sed -n 's/^project(tribotrack VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
[ -n "$version" ]

check() {
  [ "$2" = "$version" ] || {
    echo "$1 says ${2:-nothing}, CMakeLists.txt says $version" >&2
    exit 1
  }
}
check "tribotrack --version" "$("$tribotrack" --version | awk 'NR == 1 { print $2 }')"
check CITATION.cff "$(sed -n 's/^version: *//p' CITATION.cff)"
check "the newest heading of CHANGELOG.md" "$(sed -n 's/^## \([0-9.]*\).*/\1/p' CHANGELOG.md | head -n 1)"
if [ -n "${3:-}" ]; then
  check "tribotrack.__version__" "$(PYTHONPATH=$4 "$3" -B -c 'import tribotrack; print(tribotrack.__version__)')"
fi

# Tests feed files of an earlier program to the readers; packages of others have versions of their own.
copies=$(grep -rnE "(^|[^0-9.])${version//./\\.}([^0-9.]|\.?$)" --include='*.cpp' --include='*.h' --include='*.in' --include='*.py' \
  --include='*.pyi' --include='*.md' --include='*.txt' --include='*.cmake' --include='*.sh' --include='*.toml' --include=Containerfile \
  README.md CONTRIBUTING.md SECURITY.md apps data fit model vision || true)
if [ -n "$copies" ]; then
  printf 'The version is written down again; let the build or the program say it:\n%s\n' "$copies" >&2
  exit 1
fi
