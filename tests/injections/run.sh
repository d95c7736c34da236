#!/bin/sh
# run.sh TOOL [COUNT] [SEED]: flips COUNT bits (10,000) in traces with cells of about 1,000 bodies; prints a line per
# kind.
# SPDX-License-Identifier: MIT
#
# Flips at the end of a tick: tick, table and columns must be exact, every affected row must be listed, and the median
# list must only have the affected rows. Flips in two to four bodies at once: the median list has at most six rows.
# Flips inside the solver: tick and table must be exact, and the body must be listed; the length of the list is only
# printed. Exits 0 if every condition holds.
set -u
tool=$1
count=${2-10000}
seed=${3-1}
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
failures=0

value() { sed -n 's/^ *"'"$2"'": \([0-9]*\),\{0,1\}$/\1/p' "$1" | head -n 1; }

# flip NAME LONGEST ARGUMENT...: LONGEST limits the median list; empty: no limit; same: the affected rows.
flip() {
  name=$1
  longest=$2
  shift 2
  seed=$((seed + 1))
  "$tool" inject "$work/$name.ttr" --count "$count" --seed "$seed" --json "$@" >"$work/report.json"
  code=$?
  for key in passed failed not_applicable waived median max median_concerned; do
    eval "$key=\$(value \"$work/report.json\" $key)"
  done
  [ "$longest" != same ] || longest=${median_concerned:-0}
  verdict=ok
  [ "$code" = 0 ] && [ "${median:-x}" != x ] || verdict="FAILED, exit $code"
  [ -z "$longest" ] || [ "${median:-0}" -le "$longest" ] || verdict="FAILED, median list $median, expected at most $longest"
  [ "$verdict" = ok ] || failures=$((failures + 1))
  printf '%-12s %-18s seed %-6s found %6s, missed %s, not applicable %4s, waived %4s; list %3s (median), %4s at most, concerned %s: %s\n' \
    "$name" "$*" "$seed" "$passed" "$failed" "$not_applicable" "$waived" "$median" "$max" "$median_concerned" "$verdict"
}

record() { "$tool" record "$2" --ticks "$3" --detail cells -o "$work/$1.ttr" >/dev/null || exit 2; }

record pile 'mixed_pile?bodies=1000' 600
record pile_f64 'mixed_pile?bodies=1000&precision=f64&seed=5' 400
record net 'joint_grid?columns=32' 300
record sleepers 'resting?bodies=1000&substeps=4' 400
record shapes 'shapes?bodies=1000' 400
for name in pile pile_f64 net sleepers shapes; do flip "$name" same; done
for bodies in 2 3 4; do flip pile 6 --bodies "$bodies"; done
for substep in 0 1 2 3; do flip pile '' --after-substep "$substep"; done
[ "$failures" = 0 ]
