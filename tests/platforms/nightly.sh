#!/bin/sh
# Ten times the golden ticks: random worlds, sessions of ten minutes and crowds, recorded by gcc and verified elsewhere.
# SPDX-License-Identifier: MIT
# usage: nightly.sh JOBS SHARE MINUTES NAME...    from the root of the tree. SHARE: 50 means a 50th of the work. No new
# batch begins after MINUTES. build/gcc has ticktrue, and build/NAME has trace_check. out/nightly/verified/NAME lists
# verified traces. The same program does not verify a trace with equal bytes again. Exits 0 if everything was verified
# and nothing differs.
set -u
jobs=$1
share=$2
minutes=$3
shift 3
tab=$(printf '\t')
out=out/nightly
mkdir -p "$out/traces" "$out/verified" "$out/rows" "$out/logs"
end_time=$(($(date +%s) + minutes * 60))
tool() { build/gcc/run ticktrue "$@"; }
complain() { printf 'nightly: error: %s\n' "$1" >&2; }
# divided COUNT: its share of the work, at least 1
divided() { echo $((($1 + share - 1) / share)); }

# --- the traces -----------------------------------------------------------------------------------------------------

# There are 28,792 golden ticks. This run has ten times as many: 1,250 random worlds of 117 ticks on average, four
# sessions of 36,000 ticks, and crowds.
world_count=$(divided 1250)
session_seconds=$(divided 600)
session_scenes='thesis thesis?precision=f32 thesis?solver=tgs_soft thesis?solver=tgs_soft&precision=f32'
# scene, bodies, ticks
crowds='mixed_pile 10000 600
gas 20000 300
resting 40000 120'

# record_trace NAME WORDS...: records a trace unless the file exists.
record_trace() {
  name=$1
  shift
  [ ! -e "$out/traces/$name.ttr" ] || return 0
  tool record "$@" --detail root --checkpoint-interval 600 --no-compress --force -o "$out/traces/new.ttr" \
    </dev/null >"$out/logs/record" 2>&1
  code=$?
  case $code in
    0 | 1) mv "$out/traces/new.ttr" "$out/traces/$name.ttr" ;; # 1: ended before a value that is not finite
    *)
      complain "$name: $(head -n 1 "$out/logs/record")"
      return 1
      ;;
  esac
}

make_traces() {
  failed=0
  seed=1
  while [ "$seed" -le "$world_count" ]; do
    if [ ! -e "$out/traces/world_$seed.ttr" ]; then
      tool scenes --random "$seed" --bodies-max 300 --ticks-max 300 -o "$out/world.json" --inputs "$out/world.jsonl" \
        --force </dev/null >"$out/logs/world" 2>&1 &&
        record_trace "world_$seed" "$out/world.json" --inputs "$out/world.jsonl" || failed=1
    fi
    echo "world_$seed.ttr" >>"$out/list"
    seed=$((seed + 1))
  done
  number=1
  for scene in $session_scenes; do
    name=session_${session_seconds}_$number
    if [ ! -e "$out/traces/$name.ttr" ]; then
      tool import mouse --model "$number" --seconds "$session_seconds" --scene "$scene" -o "$out/session.jsonl" --force \
        </dev/null >"$out/logs/session" 2>&1 && record_trace "$name" "$scene" --inputs "$out/session.jsonl" || failed=1
    fi
    echo "$name.ttr" >>"$out/list"
    number=$((number + 1))
  done
  while read -r scene bodies ticks; do
    ticks=$(divided "$ticks")
    record_trace "crowd_${scene}_${bodies}_$ticks" "$scene?bodies=$bodies&substeps=4" --ticks "$ticks" || failed=1
    echo "crowd_${scene}_${bodies}_$ticks.ttr" >>"$out/list"
  done <<CROWDS
$crowds
CROWDS
  return $failed
}

# --- verification ---------------------------------------------------------------------------------------------------

# A digest of the compiled objects, without the object that holds the commit.
program_digest() {
  (cd "build/$1" && find base engine replay tests/CMakeFiles/trace_check.dir \( -name '*.o' -o -name '*.obj' \) \
    ! -name 'build_info*') | sed "s|^|build/$1/|" | LC_ALL=C sort | xargs cat | sha256sum | cut -c 1-32
}

# verify_platform NAME: verifies batches of at most 20 traces, and notes each trace that passes.
verify_platform() {
  platform=$1
  program=$(program_digest "$platform")
  known=$out/verified/$platform
  touch "$known"
  begin=$(date +%s)
  : >"$out/logs/$platform"
  sed "s/^/$program /" "$out/sums" | grep -vxF -f "$known" >"$out/rows/$platform.todo"
  total=$(grep -c . "$out/sums")
  todo=$(grep -c . "$out/rows/$platform.todo")
  verified=0
  ticks=0
  first=none
  rm -f "$out/rows/$platform".batch.*
  split -l 20 "$out/rows/$platform.todo" "$out/rows/$platform.batch."
  for batch in "$out/rows/$platform".batch.*; do
    [ -e "$batch" ] || break
    if [ "$(date +%s)" -ge "$end_time" ]; then
      [ "$first" != none ] || first="time is over"
      break
    fi
    # shellcheck disable=SC2046 # names have no blanks
    if "build/$platform/run" trace_check $(sed "s|.* |$out/traces/|" "$batch") </dev/null >"$out/logs/$platform.batch" 2>&1; then
      cat "$batch" >>"$known"
      verified=$((verified + $(grep -c . "$batch")))
      ticks=$((ticks + $(sed -n 's/.* traces, \([0-9]*\) ticks.*/\1/p' "$out/logs/$platform.batch")))
    elif [ "$first" = none ]; then
      first=$(grep -m 1 error "$out/logs/$platform.batch" || echo "trace_check failed")
    fi
    cat "$out/logs/$platform.batch" >>"$out/logs/$platform"
  done
  rm -f "$out/rows/$platform".batch.*
  printf '%s\n' "$platform$tab$total$tab$((total - todo))$tab$verified$tab$ticks$tab$(($(date +%s) - begin))$tab$first" \
    >"$out/rows/$platform"
}

if [ "${NIGHTLY_PLATFORM-}" ]; then
  end_time=$NIGHTLY_END
  verify_platform "$NIGHTLY_PLATFORM"
  exit 0
fi

begin=$(date +%s)
: >"$out/list"
engine=$(sh tests/platforms/record.sh digest)
if [ "$(cat "$out/engine" 2>/dev/null)" != "$engine" ]; then
  rm -f "$out"/traces/*  # traces of another engine
  echo "$engine" >"$out/engine"
fi
make_traces || { complain "a trace could not be recorded"; exit 1; }
(cd "$out/traces" && xargs sha256sum) <"$out/list" | sed 's/  / /' >"$out/sums"
printf 'nightly: %s traces, recorded in %s s\n' "$(grep -c . "$out/sums")" $(($(date +%s) - begin))
for platform in "$@"; do rm -f "$out/rows/$platform"; done
printf '%s\n' "$@" | NIGHTLY_END=$end_time xargs -P "$jobs" -I NAME env NIGHTLY_PLATFORM=NAME sh "$0" 1 "$share" "$minutes"

# --- the table ------------------------------------------------------------------------------------------------------

status=0
printf '%-8s %6s %7s %8s %8s %6s  %s\n' platform traces before verified ticks s 'first difference'
comma=
{
  printf '{\n  "schema": "ticktrue.nightly/1",\n  "date": "%s",\n  "commit": "%s",\n  "engine_digest": "%s",\n' \
    "$(date -u +%Y-%m-%d)" "$(git rev-parse --short=10 HEAD 2>/dev/null || echo unknown)" "$engine"
  printf '  "share": %s,\n  "seconds": %s,\n  "platforms": [' "$share" $(($(date +%s) - begin))
} >out/nightly.json
for platform in "$@"; do
  IFS=$tab read -r name total before verified ticks seconds first <"$out/rows/$platform" || { status=1; continue; }
  printf '%-8s %6s %7s %8s %8s %6s  %s\n' "$name" "$total" "$before" "$verified" "$ticks" "$seconds" "$first"
  [ "$first" = none ] || status=1
  ok=true
  [ $((before + verified)) = "$total" ] || { status=1; ok=false; }
  printf '%s\n    { "platform": "%s", "ok": %s, "traces": %s, "verified_before": %s, "verified": %s, "ticks": %s, "seconds": %s }' \
    "$comma" "$name" "$ok" "$total" "$before" "$verified" "$ticks" "$seconds" >>out/nightly.json
  comma=,
done
printf '\n  ]\n}\n' >>out/nightly.json
printf 'nightly: %s s; out/nightly.json\n' $(($(date +%s) - begin))
exit $status
