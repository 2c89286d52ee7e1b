#!/usr/bin/env bash
# The Debian package where nothing else is: a fresh root of this machine's Debian release, in which apt installs the package and
# the program, a campaign, the Python module, the consumer and the examples are tried as a user would. Needs root's rights,
# the network and some minutes. Use: tests/package_test.sh BUILD_FOLDER SOURCE_FOLDER
set -euo pipefail
build=$(cd "${1:?build folder}" && pwd)
source=$(cd "${2:?source folder}" && pwd)
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "skipped: needs root's rights and debootstrap"
  exit 77
fi
"$source/tests/package_contents_test.sh" "$build"

work=$(mktemp -d)
root=$work/root
finish() {
  mountpoint -q "$root/proc" && umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap finish EXIT

# Release and mirror are those of this machine: the first archive that apt knows for its own release.
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
mirror=$(apt-get indextargets --format '$(SITE) $(RELEASE) $(COMPONENT) $(CREATED_BY)' |
  awk -v release="$release" '$2 == release && $3 == "main" && $4 == "Packages" { print $1; exit }')
debootstrap --variant=minbase "$release" "$root" "$mirror" >"$work/debootstrap.log" || {
  tail -n 20 "$work/debootstrap.log"
  exit 1
}
# Updates, too, where the machine has them: the package was built against these.
rm -f "$root/etc/apt/sources.list"
apt-get indextargets --format '$(SITE) $(RELEASE) $(COMPONENT) $(CREATED_BY)' |
  awk -v release="$release" '$4 == "Packages" && $2 ~ "^" release { print "deb", $1, $2, $3 }' | sort -u >"$root/etc/apt/sources.list"
cp /etc/resolv.conf "$root/etc/resolv.conf"
echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/test"
mount -t proc proc "$root/proc"

inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
cpack --config "$build/CPackConfig.cmake" -B "$work/package" >/dev/null
mkdir "$root/packages"
cp "$work"/package/*.deb "$root/packages/"
inside apt-get update -q
# Without recommendations first: the program must do without figures and Python.
inside sh -c 'apt-get install -y -q --no-install-recommends /packages/*.deb'
inside tribotrack --version
inside tribotrack doctor | tee "$work/doctor"
grep -q 'video files' "$work/doctor"

# A campaign from rendered recordings to the parameters that rendered them: six of the example's runs.
inside sh -euc '
  mkdir /campaign && cd /campaign
  examples=/usr/share/doc/tribotrack/example
  awk "/^\[\[shot\]\]/ { n++ } n <= 11 && (n <= 1 || n % 2)" $examples/scene.toml >scene.toml
  tribotrack synth scene.toml -o recordings --quiet
  awk "/^\[\[run\]\]/ { n++ } n <= 11 && (n <= 1 || n % 2)" $examples/campaign.toml >campaign.toml
  tribotrack run campaign.toml -o result
  test -s result/report.html' | tee "$work/estimates"
awk '
  $1 == "mu1" { found += $4 < 0.1 && 0.1 < $5 }
  $1 == "mu2" { found += $4 < 0.0125 && 0.0125 < $5 }
  $1 == "phase_lag_rad" { found += $4 < 0.2 && 0.2 < $5 }
  END { exit found != 3 }' "$work/estimates"

# With what it recommends: figures for print and the module.
inside sh -c 'apt-get install -y -q --no-install-recommends python3-matplotlib python3-numpy python3'
inside python3 -c '
import os, tribotrack
assert os.path.dirname(tribotrack.__file__) == "/usr/lib/python3/dist-packages/tribotrack", tribotrack.__file__
print(tribotrack.__version__, tribotrack.simulate(cycles=1)["cycles"])'
inside sh -c 'cd /campaign && tribotrack report result -o again.html --figures figures && ls figures/*.pdf'
inside man -w tribotrack >/dev/null 2>&1 || test -s "$root/usr/share/man/man1/tribotrack.1.gz"

# The libraries, with what the package suggests.
suggested=$(inside dpkg-query -W -f '${Suggests}' tribotrack | tr -d ,)
inside apt-get install -y -q --no-install-recommends make $suggested
cp -r "$source/tests/consumer" "$root/consumer"
inside sh -euc '
  cmake -S /consumer -B /consumer/build -DCMAKE_BUILD_TYPE=Release
  cmake --build /consumer/build
  cmake -S /usr/share/doc/tribotrack/examples -B /examples
  cmake --build /examples' >"$work/cmake.log" || {
  tail -n 30 "$work/cmake.log"
  exit 1
}
inside /consumer/build/consumer | grep -qx '5.470210819 -10.983961947 mm'
cp "$source/tests/examples_test.sh" "$root/examples_test.sh"
inside /examples_test.sh /examples /usr/bin/tribotrack

# It goes as it came.
inside apt-get purge -y -q tribotrack >/dev/null
left=$(inside find /usr -name '*tribotrack*')
[ -z "$left" ] || {
  echo "left after the package was removed: $left"
  exit 1
}
echo "the package works in a fresh $release"
