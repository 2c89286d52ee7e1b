#!/usr/bin/env bash
# Installs what is missing of apps/install/packages.txt. Use: apps/install/install_packages.sh build|package|test|campaign
set -euo pipefail
kind=${1:?build, package, test or campaign}
list=$(dirname "$0")/packages.txt

wanted() {
  awk -v kind="$kind" '!/^#/ && NF == 2 && ($2 == "build" || "," $2 "," ~ "," kind "," || (kind == "campaign" && $2 ~ /test/)) { print $1 }' "$list"
}

missing=()
for package in $(wanted); do
  if ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed'; then missing+=("$package"); fi
done
[ ${#missing[@]} -gt 0 ] || exit 0

if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif command -v sudo >/dev/null; then
  as_root=(sudo)
else
  echo "These Debian packages are missing: ${missing[*]}" >&2
  echo "Install them as root (there is no sudo here), then run this again." >&2
  exit 1
fi
echo "Installing ${#missing[@]} Debian packages: ${missing[*]}" >&2
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"
