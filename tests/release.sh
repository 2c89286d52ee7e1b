#!/usr/bin/env bash
# What is looked at once a release, beside the campaigns: one version, the Debian package and what lintian says of it, the package
# in a fresh root, the API pages, a smoke subset under valgrind, planted faults. What cannot be done here is left out, and said so.
# Use: tests/release.sh BUILD_FOLDER [STEP...]    STEP: version package fresh_root api memory planted_faults
set -euo pipefail
build=$(cd "${1:?build folder}" && pwd)
shift
cd "$(dirname "$0")/.."
source=$PWD tribotrack=$build/apps/tribotrack
work=$(mktemp -d)
finish() {
  ! mountpoint -q "$work/root/proc" || umount "$work/root/proc"
  rm -rf --one-file-system "$work"
}
trap finish EXIT

wrong() { echo "WRONG: $*" >&2; exit 1; }
lacks() { for tool in "$@"; do command -v "$tool" >/dev/null || { echo "left out: $tool is not installed"; return 0; }; done; return 1; }

# What CMakeLists.txt says the program, the citation and the newest heading of the changelog say, too.
version() {
  local stated
  stated=$(sed -n 's/^project(tribotrack VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
  [ "$("$tribotrack" --version | awk 'NR == 1 { print $2 }')" = "$stated" ] || wrong "tribotrack --version is not $stated"
  grep -qx "version: *$stated" CITATION.cff || wrong "CITATION.cff does not say $stated"
  [ "$(sed -n 's/^## \([0-9.]*\).*/\1/p' CHANGELOG.md | head -n 1)" = "$stated" ] || wrong "CHANGELOG.md does not begin with $stated"
}

package() {
  ! lacks cpack dpkg-shlibdeps lintian || return 0
  (umask 027 && cpack --config "$build/CPackConfig.cmake" -B "$work/package") >"$work/cpack.log" 2>&1 || { cat "$work/cpack.log"; exit 1; }
  local deb
  deb=$(echo "$work"/package/*.deb)
  dpkg-deb -c "$deb" | awk '{ print $6 }' >"$work/listing"
  for path in bin/tribotrack lib/libtribotrack_{model,vision,fit}.a lib/cmake/tribotrack/tribotrackConfig.cmake \
    include/tribotrack/fit/estimate.h share/man/man1/tribotrack.1.gz share/bash-completion/completions/tribotrack \
    share/doc/tribotrack/{copyright,changelog.gz,examples/track.cpp,example/campaign.toml}; do
    grep -qx "./usr/$path" "$work/listing" || wrong "not in the package: $path"
  done
  # A package that is not Debian's closes no bug of Debian's.
  lintian --allow-root --no-cfg --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs "$deb"
}

# apt installs the package where nothing else is, and program, module, consumer and examples work. Needs root and the network.
fresh_root() {
  [ "$(id -u)" -eq 0 ] && ! lacks debootstrap cpack || { echo "left out: a fresh root needs root's rights and debootstrap"; return 0; }
  local root=$work/root release mirror
  # Release and mirror of this machine: the first archive that apt knows for its own release.
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE) $(COMPONENT) $(CREATED_BY)' |
    awk -v release="$release" '$2 == release && $3 == "main" && $4 == "Packages" { print $1; exit }')
  debootstrap --variant=minbase "$release" "$root" "$mirror" >"$work/log" || { tail -n 20 "$work/log"; exit 1; }
  # Updates, too, where the machine has them: the package was built against these.
  apt-get indextargets --format '$(SITE) $(RELEASE) $(COMPONENT) $(CREATED_BY)' |
    awk -v release="$release" '$4 == "Packages" && $2 ~ "^" release { print "deb", $1, $2, $3 }' | sort -u >"$root/etc/apt/sources.list"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mount -t proc proc "$root/proc"
  cpack --config "$build/CPackConfig.cmake" -B "$root/packages" >/dev/null
  cp -r tests/consumer "$root/consumer"
  inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
  inside apt-get update -q
  # Without recommendations first: the program must do without figures and Python.
  inside sh -c 'apt-get install -y -q --no-install-recommends /packages/*.deb'
  # Six of the example's runs, from rendered recordings to the parameters that rendered them.
  inside sh -euc '
    tribotrack --version
    mkdir /campaign && cd /campaign
    awk "/^\[\[shot\]\]/ { n++ } n <= 11 && (n <= 1 || n % 2)" /usr/share/doc/tribotrack/example/scene.toml >scene.toml
    awk "/^\[\[run\]\]/ { n++ } n <= 11 && (n <= 1 || n % 2)" /usr/share/doc/tribotrack/example/campaign.toml >campaign.toml
    tribotrack synth scene.toml -o recordings --quiet
    tribotrack run campaign.toml -o result
    test -s result/report.html' | tee "$work/estimates"
  awk '$1 == "mu1" { found += $4 < 0.1 && 0.1 < $5 } $1 == "mu2" { found += $4 < 0.0125 && 0.0125 < $5 } END { exit found != 2 }' \
    "$work/estimates" || wrong "the truth is outside the intervals"
  inside sh -euc '
    apt-get install -y -q --no-install-recommends python3-matplotlib python3-numpy python3
    python3 -c "import tribotrack; print(tribotrack.simulate(cycles=1)[\"cycles\"])"
    cd /campaign && tribotrack report result -o again.html --figures figures && ls figures/*.pdf
    apt-get install -y -q --no-install-recommends make $(dpkg-query -W -f "\${Suggests}" tribotrack | tr -d ,)
    cmake -S /consumer -B /consumer/build && cmake --build /consumer/build && /consumer/build/consumer
    cmake -S /usr/share/doc/tribotrack/examples -B /examples && cmake --build /examples && /examples/simulate && /examples/fit
    apt-get purge -y -q tribotrack' >"$work/log" 2>&1 || { tail -n 30 "$work/log"; wrong "it does not work in a fresh root"; }
  [ -z "$(inside find /usr -name '*tribotrack*')" ] || wrong "files are left after the package was removed"
}

# The public headers as Doxygen reads them, without a warning.
api() {
  ! lacks doxygen || return 0
  (cat apps/install/Doxyfile && echo "OUTPUT_DIRECTORY = $work/api") | doxygen - || wrong "Doxygen warns"
}

# A read of what was never written, memory lost.
memory() {
  ! lacks valgrind || return 0
  (
    cd "$work"
    watched() { valgrind --quiet --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite --num-callers=30 "$@" || wrong "valgrind: $*"; }
    sed 's/^cycles = .*/cycles = 1/' "$source/tests/small_scene.toml" >scene.toml
    watched "$tribotrack" synth scene.toml -o a.cine -q
    watched "$tribotrack" track a.cine --disc-diameter-mm 6 -o a.csv -q
    watched "$tribotrack" simulate --cycles 3 -o s.csv -q
    watched "$build/tests/tests_fit" --gtest_brief=1 --gtest_filter='*Pool*:*Statistics*:*FitLaws.TheOrderOfRuns*/displacements'
  )
}

planted_faults() { tests/plant_faults.sh "${PLANTED_FAULTS_FOLDER:-$build/planted_faults}"; }

[ $# -gt 0 ] || set -- version package fresh_root api memory planted_faults
for step in "$@"; do
  echo "== $step"
  $step
done
