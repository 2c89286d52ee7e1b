#!/usr/bin/env bash
# The Debian package of a build folder: what it holds, what it depends on, lintian without a word, and the same bytes from a
# second run of cpack. Use: tests/package_contents_test.sh BUILD_FOLDER
set -euo pipefail
build=$(cd "${1:?build folder}" && pwd)
for program in cpack dpkg-shlibdeps file lintian; do
  command -v "$program" >/dev/null || {
    echo "skipped: $program is not installed"
    exit 77
  }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The time of the last commit, said and, the second time, found by cpack itself. Sources outside git have none to be found.
source=$(sed -n 's/^set(CPACK_TRIBOTRACK_SOURCE "\(.*\)")/\1/p' "$build/CPackConfig.cmake")
grep -q '^git .*package' "$source/apps/install/packages.txt" || {
  echo "packages.txt does not list git for packages"
  exit 1
}
unset SOURCE_DATE_EPOCH
commit_time=$(git -C "$source" log -1 --format=%ct 2>/dev/null) || {
  commit_time=1700000000
  export SOURCE_DATE_EPOCH=$commit_time
}
# A umask that keeps others out must not reach the files.
(
  umask 027
  SOURCE_DATE_EPOCH=$commit_time cpack --config "$build/CPackConfig.cmake" -B first
  sleep 1
  cpack --config "$build/CPackConfig.cmake" -B second
) >cpack.log 2>&1 || {
  cat cpack.log
  exit 1
}
package=$(basename first/*.deb)
cmp "first/$package" "second/$package"

version=$(sed -n 's/^set(CPACK_PACKAGE_VERSION "\(.*\)")/\1/p' "$build/CPackConfig.cmake")
[ "$(dpkg-deb -f "first/$package" Version)" = "$version-1" ]
dpkg-deb -c "first/$package" >listing
dpkg-deb -x "first/$package" root
dpkg-deb -e "first/$package" control

# All that belongs in it; the module where it was built.
while read -r path; do
  [ -e "root/$path" ] || {
    echo "not in the package: $path"
    exit 1
  }
done <<'END'
usr/bin/tribotrack
usr/lib/libtribotrack_model.a
usr/lib/libtribotrack_vision.a
usr/lib/libtribotrack_fit.a
usr/lib/cmake/tribotrack/tribotrackConfig.cmake
usr/lib/cmake/tribotrack/tribotrackConfigVersion.cmake
usr/include/tribotrack/model/trajectory.h
usr/include/tribotrack/vision/tracker.h
usr/include/tribotrack/fit/estimate.h
usr/share/man/man1/tribotrack.1.gz
usr/share/man/man1/tribotrack-run.1.gz
usr/share/man/man5/tribotrack-campaign.5.gz
usr/share/bash-completion/completions/tribotrack
usr/share/zsh/vendor-completions/_tribotrack
usr/share/fish/vendor_completions.d/tribotrack.fish
usr/share/doc/tribotrack/copyright
usr/share/doc/tribotrack/changelog.gz
usr/share/doc/tribotrack/changelog.Debian.gz
usr/share/doc/tribotrack/examples/track.cpp
usr/share/doc/tribotrack/example/campaign.toml
END
if [ -e "$build/apps/python/tribotrack" ]; then
  ls root/usr/lib/python3/dist-packages/tribotrack/{__init__.py,_core.*.so,py.typed} >/dev/null
  dpkg-deb -f "first/$package" Recommends | grep -q python3-numpy
fi
zcat root/usr/share/doc/tribotrack/changelog.gz | head -n 1 | grep -qx '# Changes'
zcat root/usr/share/doc/tribotrack/changelog.Debian.gz | grep -q " $(LC_ALL=C date -u -d "@$commit_time" '+%a, %d %b %Y %H:%M:%S') +0000$"
grep -q 'Redistribution and use' root/usr/share/doc/tribotrack/copyright
grep -q 'Plotly' root/usr/share/doc/tribotrack/copyright

# What is linked, and what is loaded when a file needs it: each library that the program names is in a package it depends on.
depends=$(dpkg-deb -f "first/$package" Depends)
loaded=$(grep -aoE 'libopencv-imgcodecs|libavformat' root/usr/bin/tribotrack | sort -u | wc -l)
[ "$loaded" -eq 2 ]
for library in libavformat libopencv-imgcodecs; do
  name=$(grep -oE "$library[0-9]+" <<<"$depends")
  dpkg-query -W "$name" >/dev/null
done
grep -qE 'libc6 \(>= ' <<<"$depends"
grep -q python3-matplotlib <<<"$(dpkg-deb -f "first/$package" Recommends)"

# Nothing of this machine: folders of the build, its user, its times.
if grep -vE '^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--) ' listing; then
  echo "files that not everybody may read"
  exit 1
fi
if grep -v " root/root .* $(date -d "@$commit_time" '+%F %H:%M') " listing; then
  echo "files of another owner or time"
  exit 1
fi
for folder in "$build" "$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt")/"; do
  if grep -raFl -- "$folder" root control; then
    echo "the files above name the folder $folder"
    exit 1
  fi
done

# A package that is not Debian's closes no bug of Debian's.
lintian --allow-root --no-cfg --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs "first/$package"
