#!/usr/bin/env bash
# A campaign as jobs of Snakemake: one recording cannot be used, the job of another is killed and done again, and the folder ends
# with the bytes of a `run` on this machine alone, but for run.json.
# Use: tests/workflow.sh BINARY short|whole|slurm
#      short: 3 recordings; whole: 20; slurm: 20 through Slurm (Debian's slurm-wlm and munge, started here; needs root)
# Ends with 77 where Snakemake, or for `slurm` Slurm, is not installed.
set -uo pipefail
binary=$(realpath "${1:?binary}")
size=${2:?short, whole or slurm}
here=$(realpath "$(dirname "$0")")
command -v snakemake >/dev/null || { echo "left out: snakemake is not installed"; exit 77; }
if [ "$size" = slurm ]; then
  for program in munged slurmctld slurmd sbatch; do
    [ -n "$(PATH=$PATH:/usr/sbin command -v $program)" ] || { echo "left out: $program is not installed"; exit 77; }
  done
  [ "$(id -u)" = 0 ] || { echo "left out: Slurm is started as root"; exit 77; }
fi
work=$(mktemp -d /var/tmp/tribotrack_workflow.XXXXXX)
trap 'cd /; [ "$size" != slurm ] || stop_slurm; [ -n "${KEEP:-}" ] || rm -rf "$work"' EXIT
cd "$work" || exit 1
export XDG_CACHE_HOME=$work/cache  # Snakemake's
[ "$size" = short ] && count=3 || count=20

fail() {  # what was wrong, files to show
  echo "WRONG: $1"
  shift
  for file in "$@"; do tail -n 40 "$file" | cut -c1-300 | sed 's/^/    /'; done
  exit 1
}

# ---- the campaign: short recordings of small pictures; one is cut off; one track and one alpha, v come from elsewhere

name_of() { printf 'phi%03d dtau%03d' $(($1 % 4 * 90)) $((40 + $1 / 4 * 25)); }  # with a blank, as people name things
{
  cat "$here/small_scene.toml"
  for k in $(seq 0 $count); do
    printf '[[shot]]\nname = "%s"\nphi_rad = "%ddeg"\ndtau_rad = "%ddeg"\nseed = %d\n' "$(name_of "$k")" $((k % 4 * 90)) \
      $((40 + k / 4 * 25)) "$k"
  done
} >scene.toml
"$binary" synth scene.toml -o recordings -q || fail "the recordings could not be rendered"
mkdir elsewhere
mv "recordings/$(name_of $count).cine" elsewhere/last.cine
"$binary" track elsewhere/last.cine --disc-diameter-mm 6 --marker 18,18,8 -o elsewhere/last.csv -q || fail "no track"
bad=$(name_of $((count - 1))) killed=$(name_of 1)
truncate -s 700 "recordings/$bad.cine"
{
  cat "$here/small_campaign.toml"
  for k in $(seq 0 $((count - 1))); do
    printf '[[run]]\nvideo = "recordings/%s.cine"\nphi_rad = "%ddeg"\ndtau_rad = "%ddeg"\n' "$(name_of "$k")" $((k % 4 * 90)) \
      $((40 + k / 4 * 25))
  done
  printf '[[run]]\ntrack = "elsewhere/last.csv"\nphi_rad = "%ddeg"\ndtau_rad = "%ddeg"\n' $((count % 4 * 90)) $((40 + count / 4 * 25))
  printf '[[run]]\nname = "given"\nphi_rad = 0\ndtau_rad = "30deg"\nalpha_rad = 5.93\nalpha_sd_rad = 0.4\nv_mm_s = 1.78\nv_sd_mm_s = 1.0\n'
} >campaign.toml

# Into a folder of the same name: names stand in the results.
"$binary" run campaign.toml -o out >run.txt 2>&1
run_code=$?
[ $run_code = 4 ] || [ $run_code = 5 ] || fail "run ends with $run_code where a recording cannot be used" run.txt
mv out undisturbed

# ---- the engine

start_slurm() {
  PATH=$PATH:/usr/sbin
  local host
  host=$(hostname -s)
  mkdir -p slurm_machine/{state,spool}
  chmod 700 slurm_machine
  dd if=/dev/urandom of=slurm_machine/key bs=1 count=1024 2>/dev/null
  chmod 400 slurm_machine/key
  munged --force --key-file="$work/slurm_machine/key" --socket="$work/slurm_machine/munge.socket" \
    --pid-file="$work/slurm_machine/munged.pid" --log-file="$work/slurm_machine/munged.log" \
    --seed-file="$work/slurm_machine/munged.seed" || fail "munged does not start" slurm_machine/munged.log
  cat >slurm_machine/slurm.conf <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/slurm_machine/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
StateSaveLocation=$work/slurm_machine/state
SlurmdSpoolDir=$work/slurm_machine/spool
SlurmctldPidFile=$work/slurm_machine/slurmctld.pid
SlurmdPidFile=$work/slurm_machine/slurmd.pid
SlurmctldLogFile=$work/slurm_machine/slurmctld.log
SlurmdLogFile=$work/slurm_machine/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 RealMemory=$(awk '/MemTotal/ {print int($2 / 1100)}' /proc/meminfo) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$work/slurm_machine/slurm.conf
  slurmctld -f "$SLURM_CONF" || fail "slurmctld does not start" slurm_machine/slurmctld.log
  slurmd -f "$SLURM_CONF" || fail "slurmd does not start" slurm_machine/slurmd.log
  local k
  for k in $(seq 60); do
    sinfo -h -o %t 2>/dev/null | grep -q '^idle$' && return
    sleep 1
  done
  fail "no node of Slurm is idle after a minute" slurm_machine/slurmctld.log slurm_machine/slurmd.log
}

stop_slurm() {
  local daemon
  for daemon in slurmd slurmctld munged; do
    [ ! -s "$work/slurm_machine/$daemon.pid" ] || kill "$(cat "$work/slurm_machine/$daemon.pid")" 2>/dev/null
  done
  sleep 1
}

snakemake_says() {  # arguments; exit code in $code, what it said in said.txt
  local how=(-k --cores 2)
  [ "$size" != slurm ] || how=(--profile out/slurm --latency-wait 20)
  (cd elsewhere && snakemake -s "$work/out/Snakefile" "${how[@]/#out/$work/out}" "$@") >said.txt 2>&1
  code=$?
}

[ "$size" != slurm ] || start_slurm

# The first time it tracks one recording, it is killed half-way: by the node's memory killer, or by Slurm.
cat >killed_once.sh <<WRAPPER
#!/bin/bash
if [[ "\$*" == *"--run $killed "* ]] && mkdir "$work/was_killed" 2>/dev/null; then
  "$binary" "\$@" &
  sleep 0.05
  if [ -n "\${SLURM_JOB_ID:-}" ]; then scancel \$SLURM_JOB_ID; sleep 30; fi
  kill -9 \$!
  wait \$!
  exit
fi
exec "$binary" "\$@"
WRAPPER
chmod +x killed_once.sh

finished() { stat -c '%n %i %y' out/tracks/*.csv; }

"$binary" run campaign.toml -o out --emit snakemake >commands.txt 2>said.txt || fail "no jobs are emitted" said.txt
grep -q "snakemake -s out/Snakefile" commands.txt || fail "the commands are not said" commands.txt
begin=$(date +%s%N)

# 1. One is killed, one cannot be used: all others are tracked, and nothing is fitted.
snakemake_says --config program="$work/killed_once.sh"
[ $code != 0 ] || fail "two recordings have failed and Snakemake is content" said.txt
[ -d was_killed ] || fail "no job was killed" said.txt
[ ! -e "out/tracks/$killed.csv" ] || fail "a killed job has left a track"
[ ! -s "out/tracks/$killed.log" ] || fail "a killed job has left its word on the recording"
grep -q "$bad.cine" "out/tracks/$bad.log" || fail "nothing says why $bad was not tracked" said.txt
[ "$(finished | wc -l)" = $((count + 1 - 2)) ] || fail "$(finished | wc -l) of $((count + 1)) tracks are there" said.txt
[ ! -e out/fit.json ] || fail "a fit without two recordings"
finished >before.txt

# 2. The killed one alone is done again; one is still missing, and nobody has allowed for it.
snakemake_says
[ $code != 0 ] || fail "a recording cannot be used and Snakemake is content" said.txt
[ -e "out/tracks/$killed.csv" ] || fail "the killed job was not done again" said.txt
[ ! -e out/fit.json ] || fail "a fit without a recording that nobody has allowed for"
finished | grep -vF "/$killed.csv" | cmp - before.txt || fail "finished tracks were made again" said.txt

# 3. Allowed for: all of it, the same bytes as `run`.
snakemake_says --config allow_missing=1
fit_code=$(cat out/fit.exit 2>/dev/null) || fail "no fit with allow_missing=1" said.txt
[ $run_code != 5 ] || [ "$fit_code" = 5 ] || fail "the fit ends with $fit_code, run's with $run_code"
[ $((code == 0)) = $((fit_code == 0)) ] || fail "Snakemake ends with $code, the fit with $fit_code" said.txt
finished | grep -vF "/$killed.csv" | cmp - before.txt || fail "finished tracks were made again" said.txt
end=$(date +%s%N)
# Of the engine and of the jobs' own; all else is `run`'s.
diff -r --exclude={run.json,Snakefile,workflow.json,slurm,.snakemake,.snakemake_timestamp,fit.exit,"*.log"} \
  undisturbed out >differences.txt || fail "not the bytes of run" differences.txt

# 4. What is there stays.
stat -c '%n %i %y' out/*.* out/*/*.* >before.txt
snakemake_says --config allow_missing=1
stat -c '%n %i %y' out/*.* out/*/*.* | cmp - before.txt || fail "what was there was made again" said.txt

# 5. Another campaign: the list of jobs is not followed blindly.
printf '[fit.guess]\nmu1 = 0.11\n' >>campaign.toml
snakemake_says --config allow_missing=1
[ $code != 0 ] && grep -q -- '--emit snakemake' said.txt || fail "the campaign has changed and Snakemake goes on" said.txt

echo "$((count + 1)) tracks through Snakemake ($size), one job killed, one recording left out: the bytes of run," \
  "in $(((end - begin) / 1000000000)) s"
