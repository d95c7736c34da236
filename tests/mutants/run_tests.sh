#!/bin/sh
# run_tests.sh BUILD SECONDS: runs the tests of a build, quick tests first, and stops at the first failure. What only
# later tests need is built when they are reached.
# SPDX-License-Identifier: MIT
build=$1
seconds=$2
source=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt")

fail() {
  echo "failed: $1"
  exit 1
}

# test_group NAMES: the tests of ticktrue_tests with these tags; the first check that fails ends them.
test_group() {
  output=$(cd "$source" && timeout "$seconds" "$build/ticktrue_tests" --abort --use-colour no "$1" 2>&1)
  status=$?
  [ $status -eq 0 ] && return
  [ $status -eq 124 ] && fail "$1 Timeout"
  fail "$1 $(echo "$output" | sed -n 's/^\(tests\/[^ ]*:[0-9]*\): .*/\1/p; s/.*\/\(tests\/[^ ]*:[0-9]*\): FAILED.*/\1/p' | head -1)"
}

test_group '[capi]~[.slow]'
test_group '[verifier]~[.slow]'
test_group '[replay]~[.slow],[base]~[.slow],[portable]~[.slow]'
cmake --build "$build" >/dev/null 2>&1 || fail 'the build of all'
test_group '[cli]~[printed]~[.slow]'  # documents print the sizes of files of a release build
test_group '[worlds]~[.slow],[properties]~[.slow]'
test_group '[engine]~[properties]~[.]'
for names in 'damage|forged|examples' 'play|reduce|trail|unsaved|causes|page|program_corpus|campaign_restore|reduce_again'; do
  output=$(ctest --test-dir "$build" -R "^($names)\$" --stop-on-failure --timeout "$seconds" 2>&1) ||
    fail "$(echo "$output" | sed -n 's/.*Test *#[0-9]*: \([a-z_]*\) \.*\**\(.*\)/\1\2/p' | grep -v Passed | head -1)"
done
