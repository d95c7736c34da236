# A Slurm cluster of four nodes on this machine, under the user's own id, with a separate key and ports. Source this
# file.
# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2154 # out: of who sources this
#
# Needs $out (absolute, no blanks). start_slurm sets $slurm (a short folder, because a socket needs a short name) and
# SLURM_CONF. Node nK has the folder $out/nodes/nK for its spool and for the output of its tasks. stop_slurm ends all
# processes that it started.

slurm=
slurm_nodes='n1 n2 n3 n4'

# start_daemon NAME COMMAND...: runs it in the background; its id is in $slurm/NAME.id, its output in $out/log/NAME.out
start_daemon() {
  name=$1
  shift
  "$@" >"$out/log/$name.out" 2>&1 </dev/null &
  echo $! >"$slurm/$name.id"
}

# end_daemon NAME: asks the daemon to end, and kills it after ten seconds
end_daemon() {
  [ -f "$slurm/$1.id" ] || return 0
  id=$(cat "$slurm/$1.id")
  rm -f "$slurm/$1.id"
  kill "$id" 2>/dev/null || return 0
  waited=0
  while kill -0 "$id" 2>/dev/null && [ "$waited" -lt 50 ]; do
    sleep 0.2
    waited=$((waited + 1))
  done
  kill -9 "$id" 2>/dev/null
  wait "$id" 2>/dev/null
}

start_slurm() {
  user=$(id -un)
  host=$(hostname -s)
  port=$((20000 + $$ % 2000 * 10))
  slurm=$(mktemp -d "${TMPDIR:-/tmp}/ticktrue-slurm-XXXXXX") || return 2
  chmod 711 "$slurm"  # munge requires that its socket is reachable
  mkdir -p "$out/log" "$slurm/state"
  dd if=/dev/urandom of="$slurm/munge.key" bs=1024 count=1 2>/dev/null
  chmod 400 "$slurm/munge.key"
  start_daemon munged munged --foreground --key-file="$slurm/munge.key" --socket="$slurm/munge.socket" \
    --pid-file="$slurm/munge.pid" --log-file="$slurm/munge.log" --seed-file="$slurm/munge.seed"
  cat >"$slurm/slurm.conf" <<CONF
ClusterName=ticktrue
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$slurm/munge.socket
CredType=cred/munge
SlurmctldPort=$port
StateSaveLocation=$slurm/state
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmctldLogFile=$out/log/slurmctld
SlurmdSpoolDir=$out/nodes/%n/spool
SlurmdPidFile=$slurm/%n.pid
SlurmdLogFile=$out/log/%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=5
MailProg=/bin/true
ReturnToService=1
SlurmdTimeout=120
KillWait=5
MinJobAge=36000
NodeName=n[1-4] NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1))-$((port + 4)) CPUs=1
PartitionName=all Nodes=n[1-4] Default=YES MaxTime=60
CONF
  SLURM_CONF=$slurm/slurm.conf
  export SLURM_CONF
  start_daemon slurmctld slurmctld -D -c
  for node in $slurm_nodes; do
    mkdir -p "$out/nodes/$node/spool"
    start_daemon "$node" slurmd -D -N "$node"
  done
  waited=0
  while [ "$(sinfo --noheader --Node --states=idle 2>/dev/null | wc -l)" -lt 4 ]; do
    if [ "$waited" -ge 60 ]; then
      complain "the cluster does not start" "the logs are in $out/log"
      return 2
    fi
    sleep 1
    waited=$((waited + 1))
  done
}

# Tasks end first, because a slurmd that ends leaves its tasks running.
stop_slurm() {
  [ -n "$slurm" ] || return 0
  if [ -f "$slurm/slurmctld.id" ]; then
    timeout 10 scancel --quiet --user="$(id -un)" 2>/dev/null
    waited=0
    while [ "$waited" -lt 40 ] && [ -n "$(timeout 5 squeue --noheader --states=running,completing 2>/dev/null)" ]; do
      sleep 0.5
      waited=$((waited + 1))
    done
  fi
  for node in $slurm_nodes; do end_daemon "$node"; done
  end_daemon slurmctld
  end_daemon munged
  rm -rf "$slurm"
  slurm=
}

# job_field JOB FIELD: prints one line for each task of the job
job_field() { scontrol show job "$1" 2>/dev/null | tr ' ' '\n' | sed -n "s/^$2=//p"; }
