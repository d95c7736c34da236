#!/bin/sh
# compilers.sh SOURCE: builds tests/math/digest.c in C and C++ with each compiler here, at many optimisations, with and
# without fused multiply-add. Each program must print the digests of digests.tsv. Exit 77 where libxxhash is missing.
# SPDX-License-Identifier: MIT
set -u
source=$(cd "$1" && pwd) || exit 2
cd "$source" || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
failures=0
program_count=0
here=$(uname -m)

complain() {
  printf 'math: error: %s\n' "$1"
  failures=$((failures + 1))
}
cpu_has() { for flag in "$@"; do grep -qw "$flag" /proc/cpuinfo 2>/dev/null || return 1; done; }
cut -f 1,2 tests/math/digests.tsv >"$work/expected"
cut -f 1,3 tests/math/digests.tsv >"$work/expected_many"
printf '#include <xxhash.h>\nint main(void) { return XXH3_64bits("", 0) == 0; }\n' >"$work/probe.c"
gcc "$work/probe.c" -lxxhash -o "$work/probe" 2>/dev/null || {
  echo "math: skipped: no gcc with libxxhash"
  exit 77
}

warnings='-Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -pedantic -Werror'
# check COMPILER FLAGS...: builds and runs.
check() {
  command -v "$1" >/dev/null 2>&1 || return 0
  # shellcheck disable=SC2086 # flags are words
  "$@" $warnings -I. tests/math/digest.c -lxxhash -o "$work/program" 2>"$work/log" || {
    cat "$work/log"
    complain "$*: build"
    return
  }
  "$work/program" >"$work/found" || complain "$*: does not run"
  diff "$work/expected" "$work/found" || complain "$*: other bits than digests.tsv"
  program_count=$((program_count + 1))
}
check gcc -std=c11 -O0
check gcc -std=c11 -O1
check gcc -std=c11 -O3 -flto
check g++ -x c++ -std=c++14 -O2
check clang-14 -std=c11 -O0
check clang++-14 -x c++ -std=c++20 -O3
check clang-19 -std=c17 -O2
if [ "$here" = x86_64 ] && cpu_has avx2 fma; then
  check gcc -std=c11 -O3 -march=x86-64-v3 -ffp-contract=fast
  check gcc -std=gnu11 -O3 -march=native -funroll-loops
  check g++ -x c++ -std=c++14 -O2 -mfma -ffp-contract=fast -flto
  check clang-14 -std=c11 -O3 -march=native -ffp-contract=fast
  check clang++-19 -x c++ -std=c++14 -O3 -march=native -ffp-contract=fast
  # The control: without its empty asm statements, the file gives other bits.
  mkdir -p "$work/control"
  cp -r include tests/math "$work/control"
  mkdir -p "$work/control/tests" && mv "$work/control/math" "$work/control/tests/math"
  sed 's/TTM_ROUNDED(product);//' include/ticktrue/math.h >"$work/control/include/ticktrue/math.h"
  (cd "$work/control" && gcc -std=c11 -O2 -march=x86-64-v3 -ffp-contract=fast -I. tests/math/digest.c -lxxhash \
    -o "$work/program") || complain "control: build"
  "$work/program" >"$work/found"
  cmp -s "$work/expected" "$work/found" && complain "control: found the same bits with contraction, expected others"
fi
gcc -std=c11 -O2 -I. tests/math/digest.c -lxxhash -o "$work/program" || complain "digest.c: build"
"$work/program" 1000000 >"$work/found"
diff "$work/expected_many" "$work/found" || complain "1,000,000 arguments: other bits than digests.tsv"

# No function of libm: the object may only need memcpy.
cat >"$work/names.c" <<'NAMES'
#include "include/ticktrue/math.h"
double f(double x, double y);
double f(double x, double y) { return ticktrue_pow(ticktrue_sin(x), ticktrue_sqrt(y)); }
NAMES
gcc -std=c11 -O0 -I. -c "$work/names.c" -o "$work/names.o" || complain "names: build"
names=$(nm -u "$work/names.o" | awk '{ print $NF }' | grep -vxE 'memcpy|_GLOBAL_OFFSET_TABLE_' | tr '\n' ' ')
[ -z "$names" ] || complain "names from libraries: found $names, expected none but memcpy"

# Flags that change results are refused, unless they are allowed by name.
refused() {
  "$@" -I. -fsyntax-only "$work/names.c" 2>"$work/log" && complain "$*: found no error, expected one"
  grep -q 'ticktrue/math.h' "$work/log" || complain "$*: the error does not name the file"
}
refused gcc -ffast-math
refused gcc -Ofast
refused gcc -funsafe-math-optimizations
[ "$here" = x86_64 ] && refused gcc -mfpmath=387
gcc -ffast-math -DTICKTRUE_MATH_ALLOW_FAST_MATH -I. -fsyntax-only "$work/names.c" || complain "fast-math cannot be allowed"

[ "$failures" = 0 ] || exit 1
echo "math: $program_count programs had the pinned digests"
