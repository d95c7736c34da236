#!/bin/sh
# udp_match.sh SOURCE LIBRARY: two processes of examples/udp_lockstep.c at 127.0.0.1, linked to the library. 20 clean matches
# raise no alarm; faults of one side are named alike by both; hello refuses others. Where the processor can, one side is
# built with fused products.
# SPDX-License-Identifier: MIT
set -u
source=$(cd "$1" && pwd) || exit 2
library=$2
command -v cc >/dev/null || exit 77
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT

build() {
  output=$1
  shift
  cc -std=c99 -O2 "$@" -I"$source/include" "$source/examples/udp_lockstep.c" "$library" \
    -Wl,-rpath,"$(dirname "$library")" -o "$work/$output"
}
build plain -ffp-contract=off || exit 1
program=$work/plain
fused=
if grep -qw fma /proc/cpuinfo 2>/dev/null && build fused -mfma -ffp-contract=fast 2>/dev/null; then fused=$work/fused; fi

failures=0
port=$((20000 + $$ % 20000))

complain() {
  printf 'udp_match: error: %s\n' "$1"
  failures=$((failures + 1))
  for file in "$work/0" "$work/1"; do sed 's/^/  /' "$file"; done
}

# match PROGRAM_1 WORDS_0 WORDS_1: exit codes in code_0 and code_1, reports in $work/0 and $work/1.
match() {
  port=$((port + 2))
  # shellcheck disable=SC2086 # words
  "$program" 0 --port "$port" $2 >"$work/0" 2>&1 &
  first=$!
  [ -n "${late:-}" ] && sleep "$late"
  # shellcheck disable=SC2086
  "$1" 1 --port "$port" $3 >"$work/1" 2>&1
  code_1=$?
  wait "$first"
  code_0=$?
  # A port that somebody has: another one, once for each.
  if grep -q '^udp_lockstep: port' "$work/0" "$work/1" && [ "${again:-0}" -lt 3 ]; then
    again=$((${again:-0} + 1))
    match "$1" "$2" "$3"
  fi
}

# named WORDS TEXT [PROGRAM_1]: both sides print the same desync, which has TEXT.
named() {
  match "${3:-$program}" "--loss 10 --anyway 1" "--anyway 1 $1"
  [ "$code_0,$code_1" = 1,1 ] || complain "$1: exit codes: found $code_0 and $code_1, expected 1"
  grep -q -- "$2" "$work/0" || complain "$1: expected $2, found:"
  grep -q '^  value   player 0: .*player 1: ' "$work/0" || complain "$1: expected the values of both players, found:"
  sed -n '/^desync/,$p' "$work/0" >"$work/report_0"
  sed -n '/^desync/,$p' "$work/1" >"$work/report_1"
  cmp -s "$work/report_0" "$work/report_1" || complain "$1: the two reports differ:"
}

run=0
while [ $run -lt 20 ]; do
  match "$program" "--seed $run --loss $((run * 2))" "--seed $run --loss $((run % 7 * 5))"
  [ "$code_0,$code_1" = 0,0 ] || complain "clean match $run: exit codes: found $code_0 and $code_1, expected 0"
  grep -q 'the same up to tick 299' "$work/0" || complain "clean match $run: expected all ticks compared, found:"
  run=$((run + 1))
done

# A player who is there first waits for the other.
late=.5
match "$program" "" ""
late=
[ "$code_0,$code_1" = 0,0 ] || complain "late player: exit codes: found $code_0 and $code_1, expected 0"

named "--bug flip --at 7" 'desync  udp-lockstep  tick 7$'
named "--bug flip --at 7" 'column  boats.points      row 5$'
named "--bug order --at 100" 'column  boats.speed'
named "--bug input --at 55" 'input   not the same for all'
named "--bug input --at 55" 'desync  udp-lockstep  tick 55$'
named "--bug clock --at 200" 'column  boats.speed       row 3, lane 0$'
if [ -n "$fused" ]; then
  named "" 'differs fused: player 0 no, player 1 yes (changes bits)' "$fused"
  match "$fused" "" ""
  [ "$code_0,$code_1" = 5,5 ] || complain "fused: exit codes: found $code_0 and $code_1, expected 5"
  grep -q 'fused: here no, there yes (changes bits)' "$work/0" || complain "fused: expected its name, found:"
fi
# Each side writes a bundle. That of the side without the bug runs again; that of the other needs its bug to do so.
cd "$work" || exit 2
match "$program" "--bundle b0.ttr --record p0.ttr" "--bundle b1.ttr --record p1.ttr --bug order"
for side in 0 1; do
  grep -q "note    bundle b$side.ttr: ticks 50..299 of the recording" "$work/$side" || complain "bundle $side: expected its note, found:"
done
again() {
  wanted=$1
  shift
  "$program" "$@" >"$work/0" 2>&1
  code=$?
  [ "$code" = "$wanted" ] || complain "bundle: $*: exit code: found $code, expected $wanted"
}
again 0 0 --verify b0.ttr
grep -q 'match  b0.ttr  250 of 250 ticks compared' "$work/0" || complain "bundle 0: expected a match, found:"
again 1 1 --verify b1.ttr
grep -q 'diverged  b1.ttr  tick 100 of 250' "$work/0" || complain "bundle 1: expected tick 100, found:"
again 0 1 --verify b1.ttr --bug order
rm -f p0.ttr p1.ttr b0.ttr b1.ttr
# Without a recording, from memory.
match "$program" "--bundle b0.ttr" "--bundle b1.ttr --bug flip --at 7"
grep -q 'bundle b0.ttr: ticks 0\.\..* of those in memory' "$work/0" || complain "bundle of memory: expected its note, found:"
again 0 0 --verify b0.ttr

match "$program" "--seed 1" "--seed 2"
[ "$code_0,$code_1" = 5,5 ] || complain "another level: exit codes: found $code_0 and $code_1, expected 5"
grep -q 'setup: byte 0 of 4: here 02, there 01' "$work/1" || complain "another level: expected its byte, found:"

[ $failures -eq 0 ] && echo "udp_match: 20 clean matches, faults and refusals are as expected"
exit $((failures > 0))
