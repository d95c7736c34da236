#!/bin/sh
# Runs the corpus tests under ThreadSanitizer. Rebuilds the sources with threads, and takes all other objects from a
# build.
# SPDX-License-Identifier: MIT
# usage: thread_sanitizer.sh BUILD [TEST...]    from the root of the tree; BUILD is a finished build by g++ with Ninja.
#
# The sanitizer observes every lock of the process, and every access in the sources below. Simulation loops are not
# rebuilt, because they have no thread. Exits 0 if it finds nothing, 1 if it finds something or a test fails.
set -eu
build=$1
shift
[ $# -gt 0 ] || set -- '[corpus]~[.slow],[claims]~[.slow],[store]~[.slow]'
out=$build/thread_sanitizer
sources="base/parallel/*.cpp tool/corpus/*.cpp verifier/store/*.cpp verifier/programs/*.cpp verifier/runs/*.cpp
  replay/file/*.cpp tests/verifier/claims_test.cpp tests/verifier/store_test.cpp tests/tool/corpus_test.cpp
  tests/tool/corpus_parts_test.cpp tests/tool/corpus_log_test.cpp tests/support/engine_runs.cpp"
flags='-std=c++20 -O1 -g1 -fno-omit-frame-pointer -fsanitize=thread -ffp-contract=off'
mkdir -p "$out"
objects=$build/tests/CMakeFiles/ticktrue_sanitized_test_objects.dir/main.cpp.o
for source in $sources; do
  object=$out/$(echo "$source" | tr / _).o
  objects="$objects $object"
  # A changed header does not trigger a rebuild: remove the folder in this case.
  [ "$object" -nt "$source" ] ||
    g++ $flags -I. -DTICKTRUE_HAS_THREADS -DTICKTRUE_SOURCE_DIR="\"$PWD\"" -DTICKTRUE_TOOL="\"$PWD/$build/ticktrue\"" -c "$source" -o "$object"
done
# The objects that the tests link, without the tests' own objects. Symbols of these sources are in both; the first one
# counts.
libraries=$(ninja -C "$build" -t commands ticktrue_tests | tail -n 1 | tr ' ' '\n' | grep -E '\.(a|so)$' |
  sed "s|^\([a-z]\)|$build/\1|")
g++ -fsanitize=thread -Wl,--allow-multiple-definition -o "$out/tests" $objects $libraries -ldl
status=0
TSAN_OPTIONS=exitcode=1:halt_on_error=0 "$out/tests" "$@" >"$out/log" 2>&1 || status=1
grep -A 30 'WARNING: ThreadSanitizer' "$out/log" || tail -n 3 "$out/log"
if grep 'skipped: this' "$out/log"; then
  echo "thread_sanitizer: error: a test was skipped, expected that all run" >&2
  status=1
fi
exit $status
