#!/bin/sh
# Whether a job of Slurm is running, has succeeded or has failed, for Snakemake: killed jobs tell nobody themselves.
# Use: slurm_status.sh JOB
state=$(scontrol -o show job "$1" 2>/dev/null | sed -n 's/.* JobState=\([A-Z_]*\).*/\1/p')
# Slurm forgets jobs after minutes; its accounting, where there is one, does not.
[ -n "$state" ] || state=$(sacct -j "$1" -X -n -o State 2>/dev/null | awk '{ print $1; exit }')
case $state in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED | RESIZING | SIGNALING | STAGE_OUT) echo running ;;
  *) echo failed ;;
esac
