#!/bin/sh
# suite.sh TOOL ROOT: runs the whole suite of the cross-check and compares what it prints with docs/crosscheck.md. The
# exit code must be 1 if a scene differs there, otherwise 0.
# SPDX-License-Identifier: MIT
set -u
tool=$1
root=$2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT

command='ticktrue crosscheck --suite --solver tgs_soft'
sed -n "/^\\$ $command\$/,/^\`\`\`\$/p" "$root/docs/crosscheck.md" | sed '1d;$d' > "$work/expected"
[ -s "$work/expected" ] || { echo "suite: error: docs/crosscheck.md does not show '$command'"; exit 1; }

wanted=0
grep -q '^[a-z0-9_]* *tgs_soft *differ ' "$work/expected" && wanted=1
# shellcheck disable=SC2086
"$tool" ${command#ticktrue } > "$work/found" 2> "$work/errors"
status=$?
if [ $status -eq 2 ] && grep -q 'not in this build' "$work/errors"; then
  echo 'skipped: a build without Box2D'
  exit 77
fi
cat "$work/errors"
echo "suite: exit $status, expected $wanted: $(tail -1 "$work/found")"
diff "$work/expected" "$work/found" && [ $status -eq $wanted ]
