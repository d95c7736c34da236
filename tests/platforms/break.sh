#!/bin/sh
# Breaks the arithmetic of a copy of the tree in three ways, and shows that the traces name the place.
# SPDX-License-Identifier: MIT
# usage: break.sh JOBS [KIND...]    from the root of the tree. Exits 0 if each is found, with tick, table, column, row.
#
# contract: products and sums fuse (aarch64). libm: a body's rotation uses the C library's sine and cosine (x86-64).
# flush: subnormal results become zero (x86-64); trace_check runs this kind, because the tool refuses such settings.
set -u
jobs=$1
shift
[ $# -gt 0 ] || set -- contract libm flush
root=$(pwd)
out=$root/out/broken
rm -rf "$out"
mkdir -p "$out"
CCACHE_SLOPPINESS=pch_defines,time_macros
export CCACHE_SLOPPINESS

fail() {
  printf 'break: error: %s\n' "$1" >&2
  exit 1
}

# change FILE FROM TO: replaces the text, which must exist.
change() {
  grep -qF -- "$2" "$1" || fail "$1: found no \"$2\", which is what would be broken"
  awk -v from="$2" -v to="$3" '
    (at = index($0, from)) { $0 = substr($0, 1, at - 1) to substr($0, at + length(from)) }
    { print }' "$1" >"$1.new" && mv "$1.new" "$1"
}

# copy_tree KIND: copies the sources to out/broken/KIND, in which all further steps of this kind happen.
copy_tree() {
  mkdir -p "$out/$1"
  for part in "$root"/*; do
    case ${part##*/} in build | out) ;; *) cp -R "$part" "$out/$1/" ;; esac
  done
  cd "$out/$1" || fail "cannot enter $out/$1"
}

# find_place KIND PRESET: builds the broken copy, and runs it on recordings with all states, then on the golden traces.
find_place() {
  CCACHE_BASEDIR=$(pwd)
  export CCACHE_BASEDIR
  { cmake --preset "$2" && cmake --build "build/$2" -j "$jobs" --target trace_check; } >build.log 2>&1 ||
    fail "$1: does not build: see $out/$1/build.log"
  found=
  for trace in "$out"/*.ttr; do
    if ! "build/$2/run" trace_check "$trace" >one.log 2>&1; then
      found=$(grep -m 1 'error' one.log | sed "s|$out/||; s|trace_check: error: ||")
      break
    fi
  done
  "build/$2/run" trace_check "$root"/traces/*.ttr >goldens.log 2>&1
  summary=$(sed -n 's/.*-bit: //p' goldens.log)
  printf '%-9s %-8s %s\n%18s of the golden traces: %s\n' "$1" "$2" "${found:-NOTHING FOUND}" '' "$summary"
  printf '%s' "$found" | grep -q 'tick [0-9]*: .*table .*, column .*, row [0-9]*, lane [0-9]*' ||
    fail "$1: found no place, expected tick, table, column and row"
  cd "$root" || fail "cannot return"
}

# An unbroken build makes the recordings.
cmake --preset gcc >"$out/gcc.log" 2>&1 && cmake --build build/gcc -j "$jobs" --target ticktrue >>"$out/gcc.log" 2>&1 ||
  fail "gcc: does not build: see $out/gcc.log"
build/gcc/run ticktrue record 'stack?boxes=3&precision=f32&substeps=4' --ticks 60 --detail full --no-compress -o "$out/a_stack.ttr" >/dev/null &&
  build/gcc/run ticktrue record 'mixed_pile?bodies=60&precision=f32&substeps=4' --ticks 100 --detail full --no-compress \
    -o "$out/b_pile.ttr" >/dev/null &&
  build/gcc/run ticktrue record tests/platforms/drift.json --ticks 120 --detail full --no-compress -o "$out/c_drift.ttr" \
    >/dev/null || fail "cannot record"

for kind in "$@"; do
  case $kind in
    contract)
      copy_tree contract
      change cmake/determinism.cmake '-ffp-contract=off ' '-ffp-contract=fast '
      find_place contract aarch64
      ;;
    libm)
      copy_tree libm
      change engine/math/vec2.h 'if (quadrant == 0) return {cosine, sine};' \
        'if (quadrant >= 0) return {Real(__builtin_cos(angle)), Real(__builtin_sin(angle))};'
      change engine/integrators/motion_kernels.cpp '  return {is_even ?' \
        '  Real c[wide_count], s[wide_count];
  for (int i = 0; i < wide_count; ++i) c[i] = Real(__builtin_cos(angle[i])), s[i] = Real(__builtin_sin(angle[i]));
  if (wide_count > 0) return {load_wide(c), load_wide(s)};
  return {is_even ?'
      find_place libm gcc
      ;;
    flush)
      copy_tree flush
      change tests/trace_check/trace_check.cpp '  int failed = 0;' \
        '  __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040); int failed = 0;'
      find_place flush gcc
      ;;
    *) fail "unknown kind: found $kind, expected contract, libm or flush" ;;
  esac
done
echo "broken on purpose: each found at its tick, table, column and row"
