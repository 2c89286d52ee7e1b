#!/usr/bin/env bash
# The plotting library is had with network and without, and never with other contents than the pinned ones. The registry
# is a folder, and the library a small archive with a lock file of its own.
set -euo pipefail
source=${1:?source folder}
cmake=$(command -v cmake)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

name=plotly.js-cartesian-dist-min
archive=$name-1.2.3.tgz
mkdir -p package registry/$name/- tools home other/$name/-
echo "the library" >package/plotly-cartesian.min.js
tar -czf registry/$name/-/$archive package
echo "something else" >other/$name/-/$archive
hash=$(sha512sum registry/$name/-/$archive | cut -c1-128 | sed 's/../\\x&/g')
cat >lock.json <<LOCK
{ "packages": { "node_modules/$name": { "version": "1.2.3", "integrity": "sha512-$(printf "$hash" | base64 -w0)" } } }
LOCK
cat >fetch.cmake <<SCRIPT
cmake_minimum_required(VERSION 3.25)
include("$source/apps/page/assets/fetch_libraries.cmake")
set(TRIBOTRACK_LIBRARY_LOCK "$work/lock.json")
tribotrack_fetch_plotly(file)
file(READ "\${file}" text)
message("embeds \${text}")
SCRIPT
# What cmake needs, but neither npm nor apt-get.
ln -s "$cmake" tools/cmake

# fetch BUILD_FOLDER [NAME=VALUE of the environment...] [-- cmake's options]: what was said goes to the file said.
fetch() {
  local build=$1 set=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do set+=("$1"); shift; done
  shift || true
  mkdir -p "$build"
  (cd "$build" && env -i HOME="$work/home" PATH="$work/tools" "${set[@]}" "$cmake" "$@" -P ../fetch.cmake) >said 2>&1
}
must_embed() { grep -q "^embeds $1" said || { echo "line $2: not embedded:"; cat said; exit 1; }; }
must_fail() { ! fetch "$@" || { echo "fetch $* succeeded:"; cat said; exit 1; }; }
must_say() { tr -s ' \n' ' ' <said | grep -q -- "$1" || { echo "not said: $1"; cat said; exit 1; }; }

# Nothing given, nothing cached, no network.
must_fail nothing
must_say "$name 1.2.3, which was not found"
must_say "no registry: npm is not installed"
must_say "npm_config_registry=ADDRESS"
must_say "npm pack $name@1.2.3 on another machine, and copy the archive to $work/home/.cache/tribotrack/$archive"
must_say "TRIBOTRACK_PLOTLY_JS=FILE"

# A file given is embedded as it is; a wrong name is named.
echo "given" >given.js
fetch given -- -DTRIBOTRACK_PLOTLY_JS="$work/given.js"
must_embed given $LINENO
must_fail given -- -DTRIBOTRACK_PLOTLY_JS="$work/missing.js"
must_say "TRIBOTRACK_PLOTLY_JS names $work/missing.js, which does not exist"

# Other contents are refused and not kept; an unreachable registry is named.
must_fail forged npm_config_registry="file://$work/other"
must_say "do not have the pinned hash"
must_fail away npm_config_registry="file://$work/nowhere"
must_say "file://$work/nowhere: "
test ! -e home/.cache/tribotrack/$archive

# Fetched from ~/.npmrc's registry into a cache that the environment names.
echo "registry=file://$work/registry/" >home/.npmrc
fetch npmrc XDG_CACHE_HOME="$work/elsewhere"
must_embed "the library" $LINENO
test -s elsewhere/tribotrack/$archive
rm home/.npmrc

# Fetched from the environment's registry; then had again without network, in this build folder and in another one.
fetch first npm_config_registry="file://$work/registry"
must_embed "the library" $LINENO
fetch second
must_embed "the library" $LINENO
echo "spoilt" >home/.cache/tribotrack/$archive
fetch first
must_embed "the library" $LINENO

# A spoilt cache is refused, and mended by the next fetch.
must_fail third
must_say "$archive: its contents do not have the pinned hash"
fetch third npm_config_registry="file://$work/registry"
fetch fourth
must_embed "the library" $LINENO

# No home: the cache lies in the build folder.
fetch homeless HOME= npm_config_registry="file://$work/registry"
must_embed "the library" $LINENO
test -s homeless/cache/tribotrack/$archive
