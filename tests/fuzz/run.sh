#!/bin/sh
# Runs fuzz harnesses that are built: run.sh CORES SECONDS [NAME...]; a line each, and what they found in out/fuzz/found.
# With --short BUILD before them: those of that build, which change seeds at random, without libFuzzer; FUZZ_SEED fixes
# the changes.
# SPDX-License-Identifier: MIT
set -u
cd "$(dirname "$0")/../.." || exit 2
build=build/fuzz
out=out/fuzz

# one SECONDS NAME LONGEST: a line of what it did. What it learns is kept in out/fuzz/corpus for the next run.
if [ "${1-}" = one ]; then
  seconds=$2
  name=$3
  longest=$4
  mkdir -p "$out/corpus/$name" "$out/found"
  set -- -max_total_time="$seconds" -timeout=5 -rss_limit_mb=2560 -malloc_limit_mb=256 -max_len="$longest" -artifact_prefix="$out/found/$name-"
  [ ! -f "$out/seeds/$name.dict" ] || set -- "$@" -dict="$out/seeds/$name.dict"
  "$build/fuzz_$name" "$@" -print_final_stats=1 "$out/corpus/$name" "$out/seeds/$name" >"$out/$name.log" 2>&1
  status=$?
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$out/$name.log")
  features=$(sed -n 's/.* ft: \([0-9]*\) .*/\1/p' "$out/$name.log" | tail -n 1)
  verdict=nothing
  [ "$status" = 0 ] || verdict="exit $status, see $out/$name.log"
  printf '%-14s %10s runs in %5s s, %6s features, found %s\n' "$name" "${runs:-?}" "$seconds" "${features:-?}" "$verdict"
  exit $((status != 0))
fi

# random BUILD SEED SECONDS NAME LONGEST: the same without libFuzzer.
if [ "${1-}" = random ]; then
  build=$2
  mkdir -p "$out/found"
  ASAN_OPTIONS=hard_rss_limit_mb=2560 "$build/fuzz_short" "$4" "$3" "$5" "$6" "$out/seeds" "$out/found" 2>"$out/$5.log" && exit 0
  printf '%s: seed %s, see %s\n' "$5" "$3" "$out/$5.log"
  exit 1
fi

how=one
if [ "${1-}" = --short ]; then
  build=$2
  how="random $build ${FUZZ_SEED:-$(date +%s)}"
  shift 2
fi
cores=$1
seconds=$2
shift 2
if [ $# = 0 ]; then
  # shellcheck disable=SC2046 # names are words
  set -- $(cut -d ' ' -f 1 "$build/fuzz.list")
fi
mkdir -p "$out"
"$build/fuzz_seeds" "$out/seeds" || exit 1
for name in "$@"; do
  if ! grep "^$name " "$build/fuzz.list"; then
    printf 'dev: error: unknown harness: found %s\n  one of: %s\n' "$name" "$(cut -d ' ' -f 1 "$build/fuzz.list" | tr '\n' ' ')" >&2
    exit 2
  fi
done >"$out/todo" || exit 2
# shellcheck disable=SC2086 # words on purpose
xargs -P "$cores" -L 1 sh tests/fuzz/run.sh $how "$seconds" <"$out/todo"
