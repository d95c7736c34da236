#!/bin/sh
# header.sh SOURCE: include/ticktrue.h alone, by each compiler there is: no warning in C99, C11, C++98 and C++14, and the
# facts that TICKTRUE_CALLER_FACTS gives for flags that are known. MSVC and Apple clang are played by clang for their
# targets, with their macros.
# SPDX-License-Identifier: MIT
set -u
source=$(cd "$1" && pwd) || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
failures=0
count=0

complain() {
  printf 'header: error: %s\n' "$1"
  failures=$((failures + 1))
}

cat >unit.c <<'UNIT'
#include "ticktrue.h"
const char* facts_of_unit(void);
const char* facts_of_unit(void) { return TICKTRUE_CALLER_FACTS; }
#if !defined(__cplusplus) || __cplusplus >= 201103L
typedef struct Place { float x, y; } Place;
typedef struct Unit { Place place; double position[2]; unsigned char kind; } Unit;
extern const ticktrue_member unit_members[4];
const ticktrue_member unit_members[4] = {
    TICKTRUE_MEMBER(Unit, place.y, TICKTRUE_F32), TICKTRUE_MEMBER(Unit, position, TICKTRUE_F64),
    TICKTRUE_MEMBER(Unit, position[1], TICKTRUE_F64), TICKTRUE_MEMBER(Unit, kind, TICKTRUE_U8)};
#endif
UNIT
cat >program.c <<'PROGRAM'
#include "ticktrue.h"
int puts(const char*);
int main(void) { return puts(TICKTRUE_CALLER_FACTS) < 0; }
PROGRAM
sed 's/^int puts/extern "C" int puts/; s/main(void)/main()/' program.c >program.cpp
sed 's/(void)/()/' unit.c >unit.cpp
warnings='-Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wfloat-equal -Wundef -pedantic -Werror'

# quiet COMPILER FLAGS... FILE: compiles without a warning.
quiet() {
  command -v "$1" >/dev/null 2>&1 || return 0
  # shellcheck disable=SC2086 # flags are words
  "$@" $warnings -I"$source/include" -fsyntax-only >log 2>&1 || { cat log; complain "$*: expected no warning"; }
  count=$((count + 1))
}
# tells "FACT..." COMPILER FLAGS... FILE: the program prints each of the facts, which stand between commas.
tells() {
  facts=$1
  shift
  command -v "$1" >/dev/null 2>&1 || return 0
  "$@" -I"$source/include" -o program >log 2>&1 || { cat log; complain "$*: build"; return; }
  ./program >found || complain "$*: does not run"
  check_facts "$*"
}
check_facts() {
  count=$((count + 1))
  printf '%s\n' "$facts" | tr ',' '\n' >wanted
  while IFS= read -r fact; do
    grep -qxF -- "$fact" found || { cat found; complain "$1: found no $fact"; }
  done <wanted
}
# plays "FACT..." COMPILER FLAGS...: the literals in the preprocessed unit are the facts.
plays() {
  facts=$1
  shift
  command -v "$1" >/dev/null 2>&1 || return 0
  # shellcheck disable=SC2086
  "$@" $warnings -Wno-reserved-identifier -ffreestanding -I"$source/include" -fsyntax-only unit.c >log 2>&1 ||
    { cat log; complain "$*: expected no warning"; }
  "$@" -ffreestanding -I"$source/include" -E -P unit.c 2>/dev/null | tr '\n' ' ' |
    sed 's/.*rest > 0.0 ? //; s/ : .*//; s/" *"//g; s/^ *"//; s/".*//; s/\\n/\n/g' >found
  check_facts "$*"
}

for compiler in gcc clang clang-14 clang-19; do
  for standard in c99 c11; do quiet "$compiler" "-std=$standard" unit.c; done
done
for compiler in g++ clang++ clang++-14 clang++-19; do
  for standard in c++98 c++11 c++14 c++20; do quiet "$compiler" "-std=$standard" unit.cpp; done
done
for compiler in cc gcc clang clang-14 clang-19; do
  tells 'language=c11,optimize=no,fast_math=no,finite_math=no,unsafe_math=no,ndebug=no' "$compiler" -std=c11 program.c
  tells 'optimize=speed,fast_math=yes,finite_math=yes,unsafe_math=yes,ndebug=yes' "$compiler" -O2 -ffast-math -DNDEBUG program.c
  tells 'optimize=size,flags=-Os' "$compiler" -Os '-DTICKTRUE_UNIT_FLAGS="-Os"' program.c
  if grep -qw fma /proc/cpuinfo 2>/dev/null && "$compiler" -mfma -fsyntax-only unit.c -I"$source/include" 2>/dev/null; then
    tells 'fma=yes,fused=yes' "$compiler" -O2 -mfma -ffp-contract=fast program.c
    tells 'fma=yes,fused=yes,fast_math=yes' "$compiler" -O2 -mfma -ffast-math program.c
    tells 'fma=yes,fused=no' "$compiler" -O2 -mfma -ffp-contract=off program.c
    tells 'fma=no,fused=no,flt_eval_method=0' "$compiler" -O2 program.c
    tells 'fused=no,flt_eval_method=2' "$compiler" -O2 -mfpmath=387 -mno-sse program.c
  fi
done
for compiler in g++ clang++; do
  tells 'language=c++14' "$compiler" -std=c++14 program.cpp
  tells 'language=c++17' "$compiler" -std=c++17 program.cpp
done
for compiler in clang-14 clang-19; do
  msvc="-fms-extensions -fms-compatibility -fms-compatibility-version=19.38 -U__clang__ -U__GNUC__ -U__llvm__"
  # shellcheck disable=SC2086
  plays 'compiler=msvc 193800000,fast_math=no,long=32,pointer=64,simd=sse2,target=x86_64 windows' \
    "$compiler" --target=x86_64-pc-windows-msvc $msvc -std=c11
  # shellcheck disable=SC2086
  plays 'fast_math=yes,finite_math=yes,fma=yes,simd=neon,target=aarch64 windows' \
    "$compiler" --target=aarch64-pc-windows-msvc $msvc -std=c11 -D_M_FP_FAST
  # shellcheck disable=SC2086
  plays 'compiler=apple clang '"${compiler#clang-}"'.0.0,fma=yes,char=signed,long=64,target=aarch64 apple' \
    "$compiler" --target=arm64-apple-macos11 -D__apple_build_version__=1 -std=c11 -U__clang_minor__ -D__clang_minor__=0 \
    -U__clang_patchlevel__ -D__clang_patchlevel__=0 -Wno-builtin-macro-redefined
done
[ "$count" -gt 0 ] || { echo "header: skipped: no compiler"; exit 77; }
[ "$failures" = 0 ] || exit 1
echo "header: $count checks"
