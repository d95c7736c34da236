#!/bin/sh
# A corpus verified by a Slurm cluster and by GNU parallel on this machine, while workers, nodes and disks fail.
# SPDX-License-Identifier: MIT
# usage: run.sh TOOL INJECT_FAULT [--traces N] [--keep]    from the root of the tree, as `./dev cluster` does.
#
# Three runs, each with a separate store: a corpus of N random worlds by Slurm; the same corpus plus a diverging trace
# by Slurm; the corpus by GNU parallel. Each run must end with one verdict for each trace, in the store, in the history
# and in the report. All files are in out/cluster. Exits 0 if every condition holds, 1 if not, 2 if a run was
# impossible.
set -u
tool=$(realpath "$1")
inject_fault=$(realpath "$2")
shift 2
trace_count=2000
keep=no
while [ $# -gt 0 ]; do
  case $1 in
    --traces) trace_count=${2-} && shift ;;
    --keep) keep=yes ;;
    *) trace_count= ;;
  esac
  shift
done
case $trace_count in
  '' | 0 | *[!0-9]*)
    echo "cluster: error: usage: [--traces N] [--keep]" >&2
    exit 2
    ;;
esac

out=$PWD/out/cluster
traces=$out/traces
shared=$out/shared  # visible to all nodes; a small disk if one can be mounted
lease_s=5
task_count=8
core_count=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
begin=$(date +%s)
failures=0
table=

say() { printf '%4d s  %s\n' "$(($(date +%s) - begin))" "$*"; }
complain() { printf 'cluster: error: %s\n' "$1" >&2; if [ $# -gt 1 ]; then printf '  %s\n' "$2" >&2; fi; }
fail() { complain "$@"; failures=$((failures + 1)); }
row() { table="$table$(printf '%-12s %s' "$1" "$2")
"; }

case $out in
  *[[:space:]]*)
    complain "$out: found a blank in the path, which Slurm does not take" "use a tree in another place"
    exit 2
    ;;
esac
PATH=$PATH:/usr/sbin:/sbin
# A slurmstepd whose spool is on a full disk ends with SIGBUS. Some shells lack this option.
# shellcheck disable=SC3045
ulimit -c 0 2>/dev/null
# shellcheck source=tests/cluster/slurm.sh
. tests/cluster/slurm.sh

# --- clean-up, also after a failed or stopped run ---------------------------------------------------------------------

mounts=
# small_disk FOLDER SIZE: mounts a file system in memory. Fails if mounting is not permitted.
small_disk() {
  mkdir -p "$1"
  [ "$(id -u)" = 0 ] && mount -t tmpfs -o "size=$2" ticktrue "$1" 2>/dev/null && mounts="$1 $mounts"
}

parallel_id=
clean_up() {
  trap - EXIT
  trap '' INT TERM HUP PIPE
  [ -z "$parallel_id" ] || kill "$parallel_id" 2>/dev/null
  for file in "$out"/workers/*; do
    if [ -f "$file" ] && worker_of "${file##*/}"; then
      kill -9 "$worker"
      kill -CONT "$worker"
    fi
  done
  stop_slurm
  # Unmounting removes the contents of a disk in memory.
  if [ "$keep" = yes ] && [ -d "$shared" ]; then rm -rf "$out/stores" && cp -r "$shared" "$out/stores"; fi
  for folder in $mounts; do
    umount "$folder" 2>/dev/null || umount -l "$folder"
  done
  [ "$keep" = yes ] || rm -rf "$shared" "$traces" "$out/stores" "$out/parallel_store" "$out/workers" "$out/nodes" "$out/worker"
}
trap clean_up EXIT
trap 'clean_up; echo "cluster: stopped" >&2; exit 130' INT TERM HUP PIPE

# --- the corpus -----------------------------------------------------------------------------------------------------

# Worlds 1 to N of the generator. A world that ends with a state that is not finite is replaced by another. Worlds that
# the same tool made earlier are reused.
make_corpus() {
  worlds=$out/worlds
  mkdir -p "$worlds"
  stamp=$(cksum <"$tool")
  if [ "$(cat "$out/worlds.stamp" 2>/dev/null)" != "$stamp" ]; then
    rm -rf "$worlds" "$out/diverging.ttr"
    mkdir -p "$worlds"
    printf '%s\n' "$stamp" >"$out/worlds.stamp"
  fi
  say "a corpus of $trace_count random worlds"
  # shellcheck disable=SC2016 # the words of the inner shell
  seq "$trace_count" | TOOL=$tool WORLDS=$worlds xargs -P "$core_count" -n 1 sh -c '
    trace=$WORLDS/world_$1.ttr
    [ ! -e "$trace" ] || exit 0
    cd "$WORLDS" || exit 255
    for seed in "$1" "$(($1 + 1000000))" "$(($1 + 2000000))"; do
      "$TOOL" scenes --random "$seed" --bodies-max 1000 --ticks-max 1000 -o "$1.json" --inputs "$1.jsonl" --force \
        2>"$1.log" &&
        "$TOOL" record "$1.json" --inputs "$1.jsonl" -o "$1.part" --force >"$1.log" 2>&1 && mv "$1.part" "$trace" &&
        rm "$1.json" "$1.jsonl" "$1.log" && exit 0
    done
    exit 255' sh || return 2
  rm -rf "$traces"
  mkdir -p "$traces"
  seq "$trace_count" | sed "s,.*,$worlds/world_&.ttr," | xargs ln -t "$traces" || return 2
  [ ! -e "$out/diverging.ttr" ] || return 0
  "$tool" record 'stack?boxes=5' --ticks 300 -o "$out/good.ttr" --force >/dev/null &&
    "$inject_fault" "$out/good.ttr" "$out/diverging.ttr" 100 2 3 cells && rm "$out/good.ttr"
}

# --- workers and their failures -------------------------------------------------------------------------------------

# Writes a script that stores the process id of a worker and then becomes the tool. On a node, its output goes to the
# node's disk.
write_worker() {
  mkdir -p "$out/workers"
  cat >"$out/worker" <<WORKER
#!/bin/sh
if [ "\${2-}" = verify ]; then
  echo "\$\$ \$PPID" >"$out/workers/\${SLURMD_NODENAME:-p\${PARALLEL_SEQ:-0}}"
  [ -z "\${SLURMD_NODENAME-}" ] || exec >>"$out/nodes/\$SLURMD_NODENAME/\$SLURM_ARRAY_JOB_ID-\$SLURM_ARRAY_TASK_ID.txt"
fi
exec "$tool" "\$@"
WORKER
  chmod +x "$out/worker"
}

# worker_of PLACE: sets $worker and $parent if a worker runs there
worker_of() {
  worker=
  parent=
  read -r worker parent <"$out/workers/$1" 2>/dev/null
  [ -n "$worker" ] && [ "$(readlink "/proc/$worker/exe")" = "$tool" ]
}

# await_worker PLACE: waits up to 20 s for a worker there
await_worker() {
  tries=0
  until worker_of "$1"; do
    [ "$tries" -lt 100 ] || return 1
    sleep 0.2
    tries=$((tries + 1))
  done
}

verdict_count() { find "$1" -path "$1/[0-9a-f][0-9a-f]/*" -type f 2>/dev/null | wc -l; }

# await_verdicts STORE PERCENT: waits until the store has this share of the verdicts; fails if no worker is left
await_verdicts() {
  wanted=$((trace_count * $2 / 100))
  tries=0
  while found=$(verdict_count "$1") && [ "$found" -lt "$wanted" ]; do
    if [ "$tries" -ge 3600 ] || { [ $((tries % 8)) = 7 ] && ! is_going_on; }; then
      fail "$1: found $found verdicts at the end, expected $wanted"
      return 1
    fi
    sleep 0.25
    tries=$((tries + 1))
  done
}
is_going_on() {
  if [ -n "$parallel_id" ]; then
    kill -0 "$parallel_id" 2>/dev/null
  else
    start_queued
    [ -n "$(squeue --noheader --states=pending,running,completing --name=ticktrue)" ]
  fi
}

# fill FOLDER: fills the disk of the folder
fill() { ! dd if=/dev/zero of="$1/ballast" bs=4k 2>/dev/null; }

# Slurm starts a requeued task after two minutes. This function starts it now.
start_queued() {
  for id in $(squeue --noheader --array --states=pending --format='%i %r' | sed -n 's/ BeginTime$//p'); do
    scontrol update JobId="$id" StartTime=now
  done
}

# need_worker PLACE
need_worker() { await_worker "$1" || { fail "$1: found no worker any more" "take more traces"; return 1; }; }
kill_worker() {
  need_worker "$1" && kill -9 "$worker" && say "kill -9 of the worker on $1"
}
# Also kills the script that would have requeued the task.
kill_task() {
  need_worker "$1" && kill -9 "$parent" "$worker" && say "kill -9 of the whole task on $1"
}
stopped=
stop_worker() {
  need_worker "$1" && kill -STOP "$worker" && stopped=$worker && say "the worker on $1 is stopped (SIGSTOP)"
}
# Waits until the lease has expired and other workers have done the units of the stopped worker.
continue_worker() {
  sleep $((lease_s + 1))
  [ -z "$stopped" ] || { kill -CONT "$stopped" && say "the worker on $1 goes on"; }
  stopped=
}
node_down() {
  need_worker "$1"
  scontrol update NodeName="$1" State=DOWN Reason=test
  say "node $1 is down"
}

# --- conditions at the end ------------------------------------------------------------------------------------------

# group_text WORD: counts equal lines: "3 WORD line, 1 WORD other"
group_text() {
  sort | uniq -c | awk -v word="$1 " '{ printf "%s%d %s%s", s, $1, word, $2; s = ", " }' | sed 's/  / /g'
}

# check_store NAME STORE COUNT EXIT TRACES...: each trace has one verdict in the report, the store and the history
check_store() {
  name=$1
  store=$2
  count=$3
  wanted_code=$4
  shift 4
  report=$out/$name.json
  $clock "$tool" corpus report "$store" "$@" --json --junit "$out/$name.xml" --html "$out/$name.html" >"$report"
  code=$?
  [ "$code" = "$wanted_code" ] || fail "$name: exit code of the report: found $code, expected $wanted_code"
  keys=$(sed -n 's/^      "key": "\(.*\)",\{0,1\}$/\1/p' "$report")
  files=$(sed -n 's/^      "file": "\(.*\)",\{0,1\}$/\1/p' "$report")
  key_count=$(printf '%s\n' "$keys" | sort -u | grep -c .)
  file_count=$(printf '%s\n' "$files" | sort -u | grep -c .)
  row_count=$(printf '%s\n' "$files" | grep -c .)
  stored=$(verdict_count "$store")
  history=$(find "$store/history" -type f | wc -l)
  test_cases=$(grep -c '<testcase' "$out/$name.xml")
  # shellcheck disable=SC2016 # the words of the inner shell
  logged=$(printf '%s\n' "$files" | TOOL=$tool STORE=$store xargs -P "$core_count" -n 1 sh -c '
    "$TOOL" corpus log "$1" --cache "$STORE" --json | grep -c "^      \"key\":"' sh | group_text with)
  missing=$(sed -n 's/^  "missing": \([0-9]*\),$/\1/p' "$report")
  [ "$missing" = 0 ] || fail "$name: lost verdicts: found $missing, expected 0"
  for pair in "rows:$row_count" "traces:$file_count" "keys:$key_count" "stored:$stored" "history:$history" \
    "junit:$test_cases"; do
    [ "${pair#*:}" = "$count" ] || fail "$name: ${pair%:*}: found ${pair#*:}, expected $count"
  done
  [ "$logged" = "$count with 1" ] || fail "$name: rows of corpus log: found $logged, expected $count with 1"
  for folder in damaged conflicts; do
    [ ! -d "$store/$folder" ] || fail "$name: $store/$folder: found files, expected none"
  done
  say "$name: exit $code; $row_count rows, $key_count keys, $stored stored, $history rows of history, log: $logged"
  row "" "exit $code; lost $missing; report $row_count, store $stored, history $history, corpus log $logged"
}

# add_verified NAME COUNT FILE...: sums the verdict counts that workers print at their end. A killed worker prints
# nothing.
add_verified() {
  name=$1
  count=$2
  shift 2
  said=$(cat "$@" 2>/dev/null | sed -n 's/.* cached, \([0-9]*\) verified.*/\1/p' | grep -v '^0$' | sort -rn | awk '
    { sum += $1; list = list (NR > 1 ? " + " : "") $1 } END { printf "%d = %s", sum, list }')
  [ "${said%% *}" -le "$count" ] || fail "$name: verdicts that workers count: found $said, expected at most $count"
  row "" "verified by workers that ended: $said"
}

# --- Slurm ----------------------------------------------------------------------------------------------------------

# submit NAME STORE TRACES...: sets $array and $report_job
submit() {
  name=$1
  store=$2
  shift 2
  "$tool" corpus slurm "$@" --cache "$store" --minutes 1 --lease $lease_s --html "$out/$name.html" \
    --sbatch "--output=$out/tasks/%A-%a.txt" >"$out/$name.sized.sh" || return 2
  # So little work would be one task. Several tasks are needed, so that some can be lost.
  sed "s/--array=1-[0-9]*/--array=1-$task_count/" "$out/$name.sized.sh" >"$out/$name.sh"
  TICKTRUE=$out/worker sh "$out/$name.sh" >"$out/$name.submitted" || return 2
  report_job=$(sed -n 's/^Submitted batch job //p' "$out/$name.submitted")
  array=$(job_field "$report_job" Dependency | sed 's/^afterany:\([0-9]*\).*/\1/')
  say "$name: Slurm has the job $array with $task_count tasks, and the report $report_job"
}

# finish NAME: waits for the report; its exit code is $report_code
finish() {
  tries=0
  while :; do
    start_queued
    case $(job_field "$report_job" JobState) in COMPLETED | FAILED | CANCELLED | TIMEOUT) break ;; esac
    if [ "$tries" -ge 900 ]; then
      fail "$1: the report did not run" "squeue and the logs are in $out/log"
      squeue >"$out/log/squeue"
      return 1
    fi
    sleep 1
    tries=$((tries + 1))
  done
  scontrol show job >"$out/$1.jobs"
  report_code=$(job_field "$report_job" ExitCode)
  report_code=${report_code%%:*}
  states=$(job_field "$array" JobState | tr '[:upper:]' '[:lower:]' | group_text "")
  restarts=$(job_field "$array" Restarts | awk '{ sum += $1 } END { print sum + 0 }')
  codes=$(job_field "$array" ExitCode | group_text with)
  say "$1: tasks: $states; exit code:signal: $codes; queued again $restarts times"
}

run_slurm() {
  store=$shared/store
  row slurm "4 nodes, $task_count tasks, lease $lease_s s, a fresh store"
  submit slurm "$store" "$traces" || return 2
  await_verdicts "$store" 5 && kill_worker n1
  await_verdicts "$store" 15 && kill_task n2
  await_verdicts "$store" 25 && stop_worker n4
  await_verdicts "$store" 32 && node_down n3
  if [ "$has_disks" = yes ]; then
    await_verdicts "$store" 40 && fill "$out/nodes/n1" && say "the disk of n1 (spool, output) is full" && kill_worker n1
    await_verdicts "$store" 55 && fill "$shared" && say "the disk of the store is full"
    await_full_disk
    say "room again on both: $(verdict_count "$store") verdicts are stored"
    rm "$shared/ballast" "$out/nodes/n1/ballast"
    scontrol update NodeName=n1 State=RESUME 2>/dev/null
    start_queued
  fi
  await_verdicts "$store" 100
  continue_worker n4
  finish slurm
  [ "${report_code:-x}" = 0 ] || fail "slurm: exit code of the report job: found ${report_code:-none}, expected 0"
  row "" "kill -9 of a worker and of a task, a worker stopped past its lease, node n3 down"
  if [ "$has_disks" = yes ]; then
    row "" "disk of n1 full, disk of the store full: workers that met it, exit 2: $full_errors"
  else
    row "" "full disks: skipped, this needs root"
  fi
  row "" "tasks: $states; queued again $restarts times"
  add_verified slurm "$trace_count" "$out"/nodes/*/"$array"-*.txt
  check_store slurm "$store" "$trace_count" 0 "$traces"
}

# Waits until only the stopped worker is left and no task can start: every task has met the full disk.
await_full_disk() {
  tries=0
  while [ "$tries" -lt 240 ]; do
    active=
    for node in n1 n2 n3; do ! worker_of "$node" || active=$node; done
    states=$(squeue --noheader --array --states=pending,configuring,completing --format='%T %r' |
      grep -v -e '^PENDING BeginTime' -e '^PENDING Dependency')
    [ -z "$active$states" ] && [ "$tries" -gt 8 ] && break
    sleep 0.25
    tries=$((tries + 1))
  done
  full_errors=$(cat "$out"/tasks/*.txt 2>/dev/null | grep -c 'exit code 2: the task is queued again')
  [ "$full_errors" -gt 0 ] || fail "slurm: workers that met the full disk: found none, expected one or more"
}

run_diverging() {
  store=$shared/diverging_store
  row diverging "the same corpus and diverging.ttr, by Slurm, a fresh store"
  scontrol update NodeName=n3 State=RESUME 2>/dev/null
  submit diverging "$store" "$traces" "$out/diverging.ttr" || return 2
  await_verdicts "$store" 20 && kill_worker n1
  await_verdicts "$store" 40 && node_down n2
  await_verdicts "$store" 100
  finish diverging
  [ "${report_code:-x}" = 1 ] || fail "diverging: exit code of the report job: found ${report_code:-none}, expected 1"
  grep -q '^diverged  .*/diverging.ttr  tick 100 of 300' "$out/tasks/$report_job"-*.txt ||
    fail "diverging: the report job does not name diverging.ttr"
  row "" "kill -9 of a worker, node n2 down; tasks: $states; queued again $restarts times"
  check_store diverging "$store" $((trace_count + 1)) 1 "$traces" "$out/diverging.ttr"
  named=$(grep -c '"verdict": "diverged"' "$out/diverging.json")
  [ "$named" = 1 ] || fail "diverging: verdicts that diverged: found $named, expected 1"
  grep -q 'diverging.ttr' "$out/diverging.xml" || fail "diverging: JUnit does not name diverging.ttr"
  row "" "named: $(sed -n 's/^\(diverged  .*\)/\1/p' "$out/tasks/$report_job"-*.txt | sed "s,$PWD/,," | head -n 1)"
}

# --- GNU parallel ---------------------------------------------------------------------------------------------------

run_parallel() {
  store=$out/parallel_store
  rm -rf "$store"
  faketime=
  for library in /usr/lib/*/faketime/libfaketimeMT.so.1; do [ ! -e "$library" ] || faketime=$library; done
  if [ -n "$faketime" ]; then
    # Shifts the clocks that people set. Nobody can set the monotonic clock.
    clock="env LD_PRELOAD=$faketime FAKETIME_DONT_FAKE_MONOTONIC=1 FAKETIME=+0s"
    # shellcheck disable=SC2016 # the words of the shell that parallel starts
    words='FAKETIME=-300s; [ $(({} % 2)) = 0 ] || FAKETIME=+300s; export FAKETIME; '
    words="${words}LD_PRELOAD=$faketime FAKETIME_DONT_FAKE_MONOTONIC=1"
    row parallel "4 workers by GNU parallel, clocks ten minutes apart, a fresh store"
  else
    words=
    row parallel "4 workers by GNU parallel, a fresh store (no faketime: one clock)"
  fi
  say "GNU parallel: four workers"
  seq 4 | parallel --will-cite -j 4 --retries 2 --joblog "$out/parallel.log" \
    "$words $out/worker corpus verify $traces --cache $store --claim --lease $lease_s -j 1" >"$out/parallel.txt" 2>&1 &
  parallel_id=$!
  await_verdicts "$store" 20 && kill_worker p1
  await_verdicts "$store" 30 && stop_worker p2
  await_verdicts "$store" 100
  continue_worker p2
  wait "$parallel_id"
  code=$?
  parallel_id=
  [ "$code" = 0 ] || fail "parallel: exit code: found $code, expected 0"
  row "" "kill -9 of a worker (run again by parallel), a worker stopped past its lease; exit $code"
  add_verified parallel "$trace_count" "$out/parallel.txt"
  check_store parallel "$store" "$trace_count" 0 "$traces"
  clock=
}

# --- all runs -------------------------------------------------------------------------------------------------------

clock=
rm -rf "$shared" "$out/nodes" "$out/tasks" "$out/workers" "$out/log"
mkdir -p "$out/tasks" "$shared"
make_corpus || { complain "the corpus cannot be made" "see the logs in $out/worlds"; exit 2; }
row corpus "$trace_count random worlds, $(du -sm "$traces" | cut -f 1) MB"
write_worker
has_disks=no
# A verdict and its row of history are two files of one page each, plus their folders.
if small_disk "$shared" $((32 + trace_count / 20))m && small_disk "$out/nodes/n1" 8m; then
  has_disks=yes
else
  say "full disks are skipped: a small file system can be mounted by root only"
fi
say "Slurm: slurmctld and four slurmd"
start_slurm || exit 2
run_slurm || fail "slurm: not submitted"
run_diverging || fail "diverging: not submitted"
stop_slurm
run_parallel

line=-------------------------------------------------------------------------------------------
printf '\n%s\n%s%s\n' $line "$table" $line
printf '%s\n' "Made in $(($(date +%s) - begin)) s. The reports are in out/cluster."
if [ "$failures" != 0 ]; then
  complain "$failures checks failed" "what Slurm and the workers said is in out/cluster"
  keep=yes
  exit 1
fi
