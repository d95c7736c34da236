#!/bin/sh
# run_tests.sh BUILD SECONDS: runs the tests of a build, quick tests first, and stops at the first failure.
# SPDX-License-Identifier: MIT
build=$1
seconds=$2
for names in 'portable|base|damage|forged|capi' 'replay|worlds|verifier' 'properties|engine' 'cli|examples|trail|reduce|unsaved'; do
  output=$(ctest --test-dir "$build" -R "^($names)\$" --stop-on-failure --timeout "$seconds" 2>&1)
  if [ $? -ne 0 ]; then
    echo "failed: $(echo "$output" | sed -n 's/.*Test *#[0-9]*: \([a-z_]*\) \.*\**\(.*\)/\1\2/p' | grep -v Passed | head -1)"
    exit 1
  fi
done
