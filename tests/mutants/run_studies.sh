#!/bin/sh
# run_studies.sh TOOL SECONDS: runs the studies, quick ones first, and stops at the first that fails.
# SPDX-License-Identifier: MIT
tool=$1
seconds=$2

# study WORDS...
study() {
  output=$(timeout "$seconds" "$tool" "$@" 2>&1)
  status=$?
  [ $status -eq 0 ] && return
  echo "failed: $*: exit $status: $(echo "$output" | grep -wE 'fail|failed|FAILED|differs|error:' | head -1)"
  exit 1
}

study accuracy --no-times --precision f64
study stress --precision f64
study stress --precision f32
# The suite fails if the verdict of a scene is not the one in docs/crosscheck.md.
output=$(timeout "$seconds" sh "$(dirname "$0")/../tool/suite.sh" "$tool" "$(dirname "$0")/../..")
if [ $? -ne 0 ]; then
  echo "failed: crosscheck --suite: $(echo "$output" | grep '^>' | head -1)"
  exit 1
fi
study accuracy --no-times --precision f32
