#!/usr/bin/env bash
# Writes tribotrack.1 and a page for each command into a folder, by help2man from --help. Use: apps/install/manual_pages.sh
# TRIBOTRACK VERSION FOLDER
set -euo pipefail
program=$(realpath "${1:?the program}")
version=${2:?its version}
folder=${3:?folder}
PATH=$(dirname "$program"):$PATH
mkdir -p "$folder"
page() {  # name of the page, what it is about, command
  help2man --no-info --version-string "$version" --name "$2" "$3" |
    sed "1,5{s/^$3 /$1 /; s/^\.TH TRIBOTRACK /.TH ${1^^} /}" >"$folder/$1.1"
}
page tribotrack 'friction parameters from high-speed video' tribotrack
tribotrack --help | sed '1,/^Subcommands:/d' | while read -r command meaning; do
  [ -n "$meaning" ] || break
  page "tribotrack-$command" "$meaning" "tribotrack $command"
done
