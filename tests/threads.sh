#!/usr/bin/env bash
# --threads N is obeyed by all that the program is made of: OpenCV, FFmpeg, Ceres and its own work. Looks at /proc/PID/task
# every millisecond while commands run: besides N threads at work there is one that waits for signals.
# Use: tests/threads.sh BINARY
set -euo pipefail
binary=$(realpath "${1:?binary}")
here=$(realpath "$(dirname "$0")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
{
  cat "$here/small_scene.toml"
  cat <<'SHOTS'
[[shot]]
name = "a"
phi_rad = 0
dtau_rad = "60deg"
[[shot]]
name = "b"
phi_rad = "90deg"
dtau_rad = "90deg"
[[shot]]
name = "c"
phi_rad = "180deg"
dtau_rad = "120deg"
SHOTS
} >scene.toml
{
  cat "$here/small_campaign.toml"
  printf 'data = "trajectory"\n'
  printf '[[run]]\nvideo = "videos/a.mp4"\nphi_rad = 0\ndtau_rad = "60deg"\n'
  printf '[[run]]\nvideo = "videos/b.mp4"\nphi_rad = "90deg"\ndtau_rad = "90deg"\n'
  printf '[[run]]\nvideo = "videos/c.mp4"\nphi_rad = "180deg"\ndtau_rad = "120deg"\n'
} >campaign.toml
"$binary" synth scene.toml --extension mp4 -o videos -q

cat >most_threads.py <<'PYTHON'
"""The most threads a command has at once: most_threads.py COMMAND..."""
import os, subprocess, sys, time

PF_EXITING = 0x4  # of the kernel's include/linux/sched.h: set before anybody who waits for the thread is told


def at_work(stat):
    """False for a thread that has ended and is still listed. The name, in brackets, may hold anything."""
    return not int(stat.rpartition(")")[2].split()[6]) & PF_EXITING


def threads_now(tasks):
    """Those listed that are at work after the list is complete, so all at the end of the listing. The length of the list
    is not their number: a list is made thread by thread while some end and others begin."""
    count = 0
    for task in os.listdir(tasks):
        try:
            with open(f"{tasks}/{task}/stat") as stat:
                count += at_work(stat.read())
        except OSError:
            pass
    return count


process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
most = 0
while process.poll() is None:
    try:
        most = max(most, threads_now(f"/proc/{process.pid}/task"))
    except OSError:
        pass
    time.sleep(0.001)
if process.returncode not in (0, 4, 5):
    sys.exit(process.stderr.read().decode())
print(most)
PYTHON

wrong=0
check() {  # what, threads, command...
  local what=$1 threads=$2 most
  shift 2
  most=$(python3 most_threads.py "$binary" "$@" --threads "$threads" -q)
  echo "$what, --threads $threads: at most $most threads"
  if [ "$most" -gt $((threads + 1)) ]; then
    echo "  WRONG: more than $threads and the one that waits for signals"
    wrong=1
  fi
  reached[threads]=$((most > ${reached[threads]:-0} ? most : ${reached[threads]:-0}))
}
reached=()
for threads in 1 3; do
  check "track, H.264" $threads track videos/a.mp4 --fps 250 --disc-diameter-mm 6 --marker 18,18,8 -o a.csv --overlay a.mp4
  check "run" $threads run campaign.toml -o out
  check "fit" $threads fit campaign.toml --tracks out/tracks -o fit.json --bootstrap 20
  check "sweep" $threads sweep --over phi_rad=0:6:100 --over dtau_rad=0.1:3:100 -o sweep.csv
  rm -rf out
done
# Somebody did work side by side, so that the count above sees threads.
[ "${reached[3]}" -ge 4 ] || { echo "WRONG: with --threads 3 there were never 3 at work"; wrong=1; }
exit $wrong
