#!/bin/sh
# float_flags.sh BUILD: installs that build, and builds loops of floats by find_package(ticktrue) with each compiler here,
# in C, in C++ and in both, for four architectures: no fused instruction, the same bits. Exit 77 where it cannot tell.
# SPDX-License-Identifier: MIT
set -u
build=$(cd "$1" && pwd) || exit 2
source=$(cd "$(dirname "$0")" && pwd) || exit 2
command -v objdump >/dev/null 2>&1 || exit 77
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
failures=0
program_count=0
fused_when_free=0

complain() {
  printf 'float_flags: error: %s\n' "$1"
  failures=$((failures + 1))
}
count_fused() { objdump -d "$1" | grep -cE 'vfn?m(add|sub)|vfc?maddc|vfc?mulc'; }
cpu_has() { for flag in "$@"; do grep -qw "$flag" /proc/cpuinfo 2>/dev/null || return 1; done; }
can_run() {
  case $1 in
    *v3) cpu_has avx2 bmi2 fma f16c movbe ;;
    *v4) cpu_has avx2 bmi2 fma avx512f avx512bw avx512cd avx512dq avx512vl ;;
  esac
}

cmake --install "$build" --prefix "$prefix" --component sdk >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
expected=

# check_program FILE NAME: no fused instruction in it, and the bits of all others.
check_program() {
  program_count=$((program_count + 1))
  fused=$(count_fused "$1")
  [ "$fused" = 0 ] || complain "$2: found $fused fused instructions, expected 0"
  can_run "$1" || return 0
  got=$("$1") || { complain "$2: does not run"; return 0; }
  expected=${expected:-$got}
  [ "$got" = "$expected" ] || complain "$2: bits: found $got, expected $expected"
}

# check_project C CXX LANGUAGES
check_project() {
  rm -rf "$work/build"
  set -- "$1" "$2" "$3" "$2, languages $3"
  cmake -S "$source/float_flags" -B "$work/build" -G Ninja -DCMAKE_C_COMPILER="$1" -DCMAKE_CXX_COMPILER="$2" \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" "-DFLOAT_FLAGS_LANGUAGES=$3" >"$work/log" 2>&1 &&
    cmake --build "$work/build" >"$work/log" 2>&1 || { cat "$work/log"; complain "$4: build"; return; }
  for program in "$work"/build/same_*_baseline "$work"/build/same_*_x86-64-v[34] "$work"/build/same_*_native; do
    check_program "$program" "$4: $(basename "$program")"
  done
  for program in "$work"/build/free_*_x86-64-v3; do
    [ "$(count_fused "$program")" = 0 ] || fused_when_free=$((fused_when_free + 1))
  done
}

for compilers in 'gcc g++' 'clang-14 clang++-14' 'clang-19 clang++-19'; do
  # shellcheck disable=SC2086 # two words
  set -- $compilers
  command -v "$1" >/dev/null 2>&1 && command -v "$2" >/dev/null 2>&1 || { echo "float_flags: note: no $1 here"; continue; }
  for languages in CXX C 'C;CXX'; do
    check_project "$1" "$2" "$languages"
  done
done
[ "$program_count" -gt 0 ] || exit 77
# The control: without ticktrue::determinism the same search finds fused instructions.
[ "$fused_when_free" -gt 0 ] || complain "control: found no fused instruction without the flags: the search is blind"

if command -v pkg-config >/dev/null 2>&1; then
  flags=$(PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name ticktrue.pc)") pkg-config --cflags ticktrue-determinism) ||
    complain "pkg-config: no ticktrue-determinism"
  for compiler in gcc clang-14 clang-19; do
    command -v "$compiler" >/dev/null 2>&1 || continue
    # shellcheck disable=SC2086 # flags are words
    "$compiler" -std=c99 -O3 -march=x86-64-v4 $flags "$source/float_flags/loops.c" -o "$work/by_pkg_config-v4" ||
      complain "$compiler: does not take the flags of pkg-config: $flags"
    check_program "$work/by_pkg_config-v4" "$compiler, flags of pkg-config"
  done
fi
[ "$failures" = 0 ] || exit 1
echo "float_flags: $program_count programs without a fused instruction, those that ran with the same bits: $expected"
