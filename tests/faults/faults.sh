#!/usr/bin/env bash
# `tribotrack run` under faults of the machine and of its user: killed, disk full, recordings that change, clocks that
# jump, no memory, no HOME, no /tmp. After each, whatever has its final name is whole, one error says what is wrong, and
# the next run ends with the bytes of a run that nothing disturbed, without doing finished work again.
# Use: tests/faults/faults.sh BINARY [short|whole] [FAULT...]    FAULT: a function below; short: killed once, one full disk
#      SEED=N repeats the moments of an earlier call
# A fault that cannot be made here (mounting needs root or user namespaces) is left out, and said so.
set -uo pipefail
binary=$(realpath "${1:?binary}")
size=${2:-short}
here=$(realpath "$(dirname "$0")")

# In a mount namespace of its own: what is mounted below is gone with this process, however it ends.
if [ -z "${FAULTS_MAY_MOUNT:-}" ]; then
  for namespace in "-m" "-Urm"; do
    if unshare $namespace mount -t tmpfs none /mnt 2>/dev/null; then
      FAULTS_MAY_MOUNT=yes exec unshare $namespace "$0" "$@"
    fi
  done
  export FAULTS_MAY_MOUNT=no
fi
shift; [ $# -gt 0 ] && shift

work=$(mktemp -d /var/tmp/tribotrack_faults.XXXXXX)
trap 'cd /; umount "$work"/out "$work"/sealed 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
if [ "$size" = whole ]; then kills=100 disks=30 changes=20 memory=25000; else kills=1 disks=1 changes=1 memory=150000; fi
RANDOM=${SEED:=$RANDOM}
echo "seed $SEED (SEED=$SEED repeats the moments)"
failures=0

complain() {  # what was wrong, files to show
  failures=$((failures + 1))
  echo "  WRONG: $1"
  shift
  for file in "$@"; do sed 's/^/    /' "$file" | cut -c1-300 | head -n 8; done
}

# ---- the campaign: six short recordings of small pictures

render() {
  {
    cat "$here/../small_scene.toml"
    for run in a:0:60 b:90:60 c:180:60 d:270:60 e:0:120 f:90:150 other:45:60; do
      IFS=: read -r name phi width <<<"$run"
      printf '[[shot]]\nname = "%s"\nphi_rad = "%d*pi/180"\ndtau_rad = "%d*pi/180"\nseed = %d\n' "$name" "$phi" "$width" \
        $((phi + width))
    done
  } >scene.toml
  {
    cat "$here/../small_campaign.toml"
    sed -n '/^\[\[shot/,$p' scene.toml | grep -v '^seed' | head -n -4 | sed 's/^\[\[shot/[[run/; s/^name = "\(.*\)"/video = "recordings\/\1.cine"/'
  } >campaign.toml
  "$binary" synth scene.toml -o pristine -q || { echo "the recordings could not be rendered"; exit 1; }
  cp -a pristine recordings
}

# Always into the folder `out`, whose name stands in the results. Exit code in $code, what it said in said.txt.
run() {
  "$binary" run campaign.toml -o out >/dev/null 2>said.txt
  code=$?
}

now() { date +%s%N; }

# run.json is the log: times and host.
same() { diff -rq --exclude=run.json --exclude=.lock "$1" out >differences.txt 2>&1; }

# Files under their final names are whole. Measurements are written a second time with the scale of all runs.
nothing_half_written() {
  local file good=0
  while read -r file; do
    case $file in
      *.partial-* | */.lock | */run.json) ;;
      */measurements/*.json) tail -c 2 "$file" | cmp -s - <(printf '}\n') || { echo "$file is cut"; good=1; } ;;
      *) cmp -s "$file" "undisturbed/${file#out/}" || { echo "$file is not what it will be"; good=1; } ;;
    esac
  done < <(find out -type f 2>/dev/null) >half.txt
  return $good
}

# Tracks are finished when their meta file is there: the file, and when it was written.
finished_tracks() {
  local meta
  for meta in out/tracks/*.csv.meta.json; do
    [ -e "$meta" ] && stat -c '%n %i %y' "${meta%.meta.json}"
  done
}

no_partial_files() { ! find . -name '*.partial-*' | grep . >partial.txt; }

resumes() {  # what happened
  finished_tracks >finished.txt
  run
  [ $code = "$undisturbed_code" ] || { complain "$1: the next run ends with $code" said.txt; return 1; }
  same undisturbed || { complain "$1: other bytes" differences.txt; return 1; }
  no_partial_files || { complain "$1: partial files stay" partial.txt; return 1; }
  finished_tracks >after.txt
  comm -23 finished.txt after.txt >lost.txt
  [ ! -s lost.txt ] || { complain "$1: finished tracks were made again" lost.txt; return 1; }
}

# One error that teaches: no crash, no riddle. $1: exit codes allowed, $2: what it must name, $3: what happened
clear_error() {
  [[ " $1 " = *" $code "* ]] || { complain "$3: exit code $code" said.txt; return 1; }
  [ "$code" = 0 ] && return
  grep -q '^tribotrack: ' said.txt && grep -qE "$2" said.txt && ! grep -qE 'unexpected|terminate|report it' said.txt ||
    { complain "$3: the error is not clear" said.txt; return 1; }
}

left_out() { echo "$1: left out, $2"; }

# ---- the faults

killed() {
  local k passed=0 moment
  for ((k = 0; k < kills; ++k)); do
    rm -rf out
    moment=$(awk -v t="$undisturbed_s" -v r=$RANDOM 'BEGIN { printf "%.4f", 1.02 * t * r / 32768 }')
    "$binary" run campaign.toml -o out >/dev/null 2>&1 &
    local process=$!
    sleep "$moment"
    kill -9 $process 2>/dev/null
    wait $process 2>/dev/null
    nothing_half_written || { complain "killed after $moment s: half-written" half.txt; continue; }
    resumes "killed after $moment s" && passed=$((passed + 1))
  done
  echo "kill -9: $passed of $kills resumed to the same bytes"
}

disk_full() {
  [ "$FAULTS_MAY_MOUNT" = yes ] || { left_out "disk full" "no file system can be mounted here"; return; }
  local k passed=0 pages used
  rm -rf out
  mkdir out
  mount -t tmpfs none out
  run
  used=$(($(df --output=used -B4096 out | tail -n 1)))
  umount out
  for ((k = 0; k < disks; ++k)); do
    pages=$((2 + (2 * k + 1) * (used - 2) / (2 * disks)))
    mount -t tmpfs -o size=$((4096 * pages)) none out
    run
    if clear_error "3" "No space left" "$((4 * pages)) of $((4 * used)) kB"; then
      if ! nothing_half_written; then
        complain "$((4 * pages)) kB: half-written" half.txt
      elif ! no_partial_files; then
        complain "$((4 * pages)) kB: partial files stay" partial.txt
      else
        mount -o remount,size=$((4096 * 4 * used)) out
        resumes "disk of $((4 * pages)) kB" && passed=$((passed + 1))
      fi
    fi
    umount out
  done
  echo "disk full: $passed of $disks said so and resumed to the same bytes"
}

read_only() {
  [ "$FAULTS_MAY_MOUNT" = yes ] || { left_out "read-only folder" "no file system can be mounted here"; return; }
  mkdir -p sealed
  local passed=0
  mount -t tmpfs none sealed
  cp -a undisturbed sealed/finished
  mount -o remount,ro sealed
  for folder in sealed/new sealed/finished; do
    "$binary" run campaign.toml -o $folder >/dev/null 2>said.txt
    code=$?
    clear_error "3" "sealed.*Read-only" "read-only $folder" && passed=$((passed + 1))
  done
  umount sealed
  echo "read-only folder: $passed of 2 said so"
}

# A recording that vanishes, shrinks, grows or is replaced while the program stands still at a random moment.
recording_changes() {
  local k passed=0 total=0 how moment recording
  for how in vanishes shrinks grows "is replaced" "is overwritten"; do
    for ((k = 0; k < changes; ++k)); do
      total=$((total + 1))
      rm -rf out recordings
      cp -a pristine recordings
      recording=recordings/$(shuf -n 1 -e a b c d e f --random-source=<(yes $RANDOM)).cine
      moment=$(awk -v t="$undisturbed_s" -v r=$RANDOM 'BEGIN { printf "%.4f", t * (0.02 + 0.6 * r / 32768) }')
      "$binary" run campaign.toml -o out >/dev/null 2>said.txt &
      local process=$!
      sleep "$moment"
      kill -STOP $process 2>/dev/null
      case $how in
        vanishes) rm $recording ;;
        shrinks) truncate -s $(($(stat -c %s $recording) * (RANDOM % 100) / 100)) $recording ;;
        grows) head -c 100000 pristine/other.cine >>$recording ;;
        "is replaced") cp pristine/other.cine replacement; mv replacement $recording ;;
        "is overwritten") cat pristine/other.cine >$recording ;;
      esac
      kill -CONT $process 2>/dev/null
      wait $process
      code=$?
      local what="$recording $how after $moment s"
      no_partial_files || { complain "$what: partial files stay" partial.txt; continue; }
      # A run that does not complain of the recording has used one state of it, before or after.
      if [ $code = 3 ] || [ $code = 4 ]; then
        clear_error "3 4" "${recording#recordings/}" "$what" || continue
      elif [ $code != 0 ] && [ $code != 5 ]; then
        complain "$what: exit code $code" said.txt
        continue
      elif ! same undisturbed; then
        rm -rf disturbed
        mv out disturbed
        run
        same disturbed || { complain "$what: neither the result before nor after it" differences.txt; continue; }
      fi
      rm -rf recordings
      cp -a pristine recordings
      run
      same undisturbed || { complain "$what: other bytes when it is back" differences.txt said.txt; continue; }
      passed=$((passed + 1))
    done
  done
  rm -rf recordings
  cp -a pristine recordings
  echo "recordings that vanish, shrink, grow, are replaced or overwritten: $passed of $total answered and resumed to the same bytes"
}

clock() {
  local passed=0 total=2
  # Files from the future and from 1970.
  rm -rf out
  touch -d 2038-01-20 recordings/a.cine
  touch -d @0 recordings/b.cine
  resumes "recordings from 2038 and 1970" && passed=$((passed + 1))
  rm -rf recordings
  cp -a pristine recordings
  if c++ -shared -fPIC -O1 -o jumping_clock.so "$here/jumping_clock.cpp" 2>compiler.txt; then
    rm -rf out
    LD_PRELOAD=$work/jumping_clock.so run
    same undisturbed && passed=$((passed + 1)) || complain "clock: other bytes" differences.txt said.txt
  else
    total=1
    left_out "jumping clock" "no compiler: $(head -n 1 compiler.txt)"
  fi
  echo "clock: $passed of $total gave the same bytes"
}

# From too little to load the program to enough: it ends well or says that memory is short.
no_memory() {
  local passed=0 total=0 kilobytes enough=0 done=0
  for kilobytes in $(seq 350000 $memory 1100000); do
    rm -rf out
    (ulimit -v $kilobytes; "$binary" run campaign.toml -o out >/dev/null 2>said.txt)
    code=$?
    [ $code = 127 ] && continue  # the loader's own word: the libraries do not fit
    total=$((total + 1))
    if [ $code = 0 ]; then
      same undisturbed && passed=$((passed + 1)) || complain "$kilobytes kB: other bytes" differences.txt
      done=$((done + 1))
      [ $done -ge 3 ] && break
      continue
    fi
    enough=1
    if clear_error "1" "out of memory" "ulimit -v $kilobytes"; then
      no_partial_files || { complain "$kilobytes kB: partial files stay" partial.txt; continue; }
      resumes "ulimit -v $kilobytes" && passed=$((passed + 1))
    fi
  done
  echo "ulimit -v: $passed of $total ended well or said so and resumed to the same bytes"
}

file_size_limit() {
  local passed=0 total=0 blocks
  for blocks in 1 4 16 64 256; do  # of 1024 bytes
    total=$((total + 1))
    rm -rf out
    (ulimit -f $blocks; "$binary" run campaign.toml -o out >/dev/null 2>said.txt)
    code=$?
    clear_error "3" "File too large" "ulimit -f $blocks" || continue
    no_partial_files || { complain "ulimit -f $blocks: partial files stay" partial.txt; continue; }
    resumes "ulimit -f $blocks" && passed=$((passed + 1))
  done
  echo "files limited in size (SIGXFSZ): $passed of $total said so and resumed to the same bytes"
}

environment() {
  local passed=0 total=0
  gave_the_same() {  # what; the command ran already
    total=$((total + 1))
    same undisturbed && passed=$((passed + 1)) || complain "$1: other bytes" differences.txt said.txt
    rm -rf out
  }
  rm -rf out
  env -i "$binary" run campaign.toml -o out >/dev/null 2>said.txt
  gave_the_same "nothing in the environment"
  HOME=/nowhere XDG_CACHE_HOME=/nowhere TMPDIR=/nowhere run
  gave_the_same "HOME and TMPDIR that are not there"
  if [ "$FAULTS_MAY_MOUNT" = yes ]; then
    mount -t tmpfs -o ro none /tmp
    run
    umount /tmp
    gave_the_same "no /tmp to write to"
  else
    left_out "no /tmp" "no file system can be mounted here"
  fi
  # A decoded recording is kept in the temporary folder where there is one.
  sed 's/^mm_per_px = .*/&/; /^\[\[shot/,$d' scene.toml >one.toml
  "$binary" synth one.toml -o one.mp4 -q 2>/dev/null
  "$binary" track one.mp4 --fps 250 --marker 18,18,8 -o with.csv -q 2>/dev/null
  TMPDIR=/nowhere "$binary" track one.mp4 --fps 250 --marker 18,18,8 -o without.csv -q 2>said.txt
  total=$((total + 1))
  [ -s with.csv ] && cmp -s with.csv without.csv && passed=$((passed + 1)) ||
    complain "a coded recording without a temporary folder: other bytes" said.txt
  echo "no HOME, no TMPDIR, no /tmp: $passed of $total gave the same bytes"
}

# Ten thousand runs of earlier campaigns, and the leavings of ten thousand killed processes.
crowded_folder() {
  rm -rf out
  mkdir -p out/tracks out/measurements
  (cd out/tracks && seq -f 'old%.0f.csv' 10000 | xargs touch && seq -f '.partial-99999999-%.0f-a.csv' 10000 | xargs touch)
  local begin
  begin=$(now)
  run
  local seconds=$((($(now) - begin) / 1000000000)) good=1
  [ $code = "$undisturbed_code" ] || { complain "10000 old runs: exit code $code" said.txt; good=0; }
  no_partial_files || { complain "10000 old runs: partial files stay" partial.txt; good=0; }
  find out -name 'old*' -delete
  for file in $(cd undisturbed && find . -type f ! -name run.json); do
    cmp -s "undisturbed/$file" "out/$file" || { complain "10000 old runs: $file is another"; good=0; }
  done
  echo "10000 old runs and 10000 leavings in the folder: $good of 1 gave the same bytes, in $seconds s"
}

render
begin=$(now)
run
mv out undisturbed
undisturbed_s=$(awk -v t=$(($(now) - begin)) 'BEGIN { print t / 1e9 }')
undisturbed_code=$code
[ -s undisturbed/report.html ] || { echo "the undisturbed run failed:"; cat said.txt; exit 1; }
echo "undisturbed run: $undisturbed_s s, exit code $undisturbed_code"
if [ $# = 0 ] && [ "$size" = short ]; then
  set -- killed disk_full
elif [ $# = 0 ]; then
  set -- killed disk_full read_only recording_changes clock no_memory file_size_limit environment crowded_folder
fi
for fault in "$@"; do
  $fault
done
if [ $failures -gt 0 ]; then echo "$failures faults were not answered as they should be"; exit 1; fi
