#!/bin/sh
# The record of the platforms: changes that make `record.sh check` fail, changes that only warn, and changes without
# effect.
# SPDX-License-Identifier: MIT
# usage: record_test.sh RECORD.SH
set -u
script=$1
command -v g++ >/dev/null && command -v sha256sum >/dev/null || exit 77
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
status=0

# expect WHAT CODE PATTERN WORDS...: exit code and a line of the output of `record.sh WORDS`.
expect() {
  what=$1
  code=$2
  pattern=$3
  shift 3
  found=$(sh "$script" "$@" 2>&1)
  found_code=$?
  if [ "$found_code" = "$code" ] && printf '%s\n' "$found" | grep -q -- "$pattern"; then
    echo "ok: $what"
  else
    printf 'record_test: error: %s: found exit code %s, expected %s and "%s":\n%s\n' "$what" "$found_code" "$code" "$pattern" \
      "$found"
    status=1
  fi
}
same_digest() { expect "$1" 0 "^$first\$" digest; }

# run COUNT DIGEST: makes results of ten platforms, of which COUNT gave equal bits.
run() {
  for number in 1 2 3 4 5 6 7 8 9 10; do
    [ "$number" -le "$1" ] && ok=true || ok=false
    mkdir -p "out/platforms/p$number"
    printf '    {\n      "platform": "p%s", "ok": %s,\n      "engine_digest": "%s",\n      "ticks": 1\n    }\n' "$number" "$ok" "$2" \
      >"out/platforms/p$number/result.json"
  done
}

make_tree() {
  mkdir -p "$1" && cd "$1" && mkdir -p base engine replay cmake/toolchains tests/platforms || exit 2
  printf '#pragma once\ninline constexpr unsigned physics_version = 7;\n' >engine/engine.h
  printf '// Adds.\nint add(int a, int b) {\n  return a + b;\n}\nconst char* web = "http://x";\n' >base/add.cpp
  echo 'set(flags -ffp-contract=off)' | tee cmake/determinism.cmake cmake/float_flags.cmake >cmake/toolchains/a.cmake
}

make_tree "$work/a"
first=$(sh "$script" digest)
expect "no record: fails" 1 'found no record' check
run 9 "$first"
expect "nine of ten: not written" 0 '^record: 9 of 10 platforms' write
expect "still no record" 1 'found no record' check
run 10 ''
expect "sources changed during the run: not written" 0 '^record: 0 of 10 platforms' write
run 10 "$first"
sed -i 's/"engine_digest": "./"engine_digest": "x/' out/platforms/p4/result.json
expect "a platform that ran with other sources: not written" 0 '^record: 9 of 10 platforms' write
expect "still none" 1 'found no record' check
run 10 "$first"
expect "ten of ten: written" 0 'is written' write
expect "nothing changed: passes" 0 '^record: 10 platforms, physics 7' check
printf '/* Adds\n   two. */\nint add(int a, int b) { return a + b; }  // sum\n\nconst char* web = "http://x";\n' >base/add.cpp
same_digest "comments, empty lines and layout: the same digest"
expect "comments: no warning" 0 '^record: 10 platforms' check
printf 'int add(int a, int b) { return b + a; }\nconst char* web = "http://x";\n' >base/add.cpp
expect "another source: a warning" 0 '^record: warning: engine digest' check
lines=$(sh "$script" check 2>&1 | grep -c .)
[ "$lines" = 1 ] || { echo "record_test: error: warning: found $lines lines, expected 1"; status=1; }
printf 'int add(int a, int b) { return a + b; }\nconst char* web = "http://y";\n' >base/add.cpp
expect "another text in quotes: a warning" 0 '^record: warning: engine digest' check
printf 'int add(int a, int b) { return a + b; }\nconst char* web = "http://x";\n' >base/add.cpp
echo 'set(flags -ffast-math)' >cmake/float_flags.cmake
expect "another flag: a warning" 0 '^record: warning: engine digest' check
echo 'set(flags -ffp-contract=off)' >cmake/float_flags.cmake
expect "as before: passes" 0 '^record: 10 platforms' check
sed -i 's/= 7;/= 8;/' engine/engine.h
expect "another physics version: fails" 1 'physics version: found 7, expected 8' check
sed -i 's/= 8;/= 7;/' engine/engine.h
sed -i '0,/"ok": true/s//"ok": false/' tests/platforms/record.json
expect "a record with nine platforms: fails" 1 'found 9 platforms' check
make_tree "$work/another/folder"
same_digest "another folder: the same digest"
exit $status
