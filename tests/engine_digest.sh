#!/bin/sh
# The digest of a build: changes that must change it, and changes that must not.
# SPDX-License-Identifier: MIT
# usage: engine_digest.sh ENGINE_DIGEST.CMAKE CMAKE CXX
set -u
script=$1
cmake=$2
cxx=$3
sed=$(command -v sed) && sha=$(command -v sha256sum) || exit 77
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
status=0

keeps_objects=
# digest FOLDER [FLAG...]: prints the digest of the two units in FOLDER
digest() {
  folder=$1
  shift
  flags=$*
  [ -z "$flags" ] || flags=" $flags"
  {
    echo '['
    for unit in one two; do
      printf '{\n  "directory": "%s",\n  "command": "%s -DTICKTRUE_COMMIT=\\\\\\"%s\\\\\\" -I%s%s -O2 -o x/part.dir/%s.cpp.o -c %s/%s.cpp",\n' \
        "$folder" "$cxx" "$folder" "$folder" "$flags" "$unit" "$folder" "$unit"
      printf '  "file": "%s/%s.cpp"\n},\n' "$folder" "$unit"
    done
    echo ']'
  } >"$folder/compile_commands.json"
  mkdir -p "$folder/x/part.dir"
  # One clock step later, because files of equal time count as edited.
  [ -n "$keeps_objects" ] || { sleep 0.1; touch "$folder/x/part.dir/one.cpp.o" "$folder/x/part.dir/two.cpp.o"; }
  "$cmake" -D UNIT=part.dir/ -D PART="$folder/part.txt" -D BUILD="$folder" -D CXX="$cxx" -D SED="$sed" -D SHA256SUM="$sha" \
    -P "$script" >&2 || echo failed
  cat "$folder/part.txt"
}

fail() {
  echo "engine_digest: error: $3: found:"
  printf '%s\n' "$1" "$2"
  status=1
}
same() {
  if [ "$1" = "$2" ]; then echo "ok: $3"; else fail "$@"; fi
}
other() {
  if [ "$1" != "$2" ]; then echo "ok: $3"; else fail "$@"; fi
}

# One clock step of any file system.
change() {
  sleep 1.1
  cat >"$1"
}

a=$work/a
mkdir "$a"
printf '#pragma once\ninline int twice(int x) { return 2 * x; }\n' >"$a/shared.h"
printf '#include "shared.h"\nint one(int x) { return twice(x) + 1; }\nconst char* place() { return __FILE__; }\nint line() { return __LINE__; }\n' >"$a/one.cpp"
printf 'int two() { return 2; }\n' >"$a/two.cpp"
first=$(digest "$a")
same "$(echo "$first" | grep -c .)" 2 "two units give two lines"
same "$(digest "$a")" "$first" "nothing changed: the same"
mkdir "$work/b"
cp "$a"/*.cpp "$a"/*.h "$work/b"
same "$(digest "$work/b")" "$first" "another folder and commit: the same"
printf '// A comment.\n\n#include "shared.h"  // another\nint one(int x) { /* a third */ return twice(x) + 1; }\n\n\n\nconst char* place() { return __FILE__; }\n/* of\n   several\n   lines */\nint line() { return __LINE__; }\n' | change "$a/one.cpp"
same "$(digest "$a")" "$first" "comments and empty lines: the same"
other "$(digest "$a" -DX)" "$first" "a flag: another"
other "$(digest "$a" -O1)" "$first" "another flag: another"
same "$(digest "$a")" "$first" "the flags of before: the same"
printf '#pragma once\ninline int twice(int x) { return 3 * x; }\n' | change "$a/shared.h"
header=$(digest "$a")
other "$header" "$first" "a header: another"
same "$(printf '%s\n%s\n' "$header" "$first" | sort | uniq -d | grep -c .)" 1 "the unit without that header: the same"
printf '#pragma once\ninline int twice(int x) { return 2 * x; }\n' | change "$a/shared.h"
same "$(digest "$a")" "$first" "the header of before: the same"
printf 'int two() { return 3; }\n' | change "$a/two.cpp"
other "$(digest "$a")" "$first" "a source: another"
printf 'int two() { return 4; }\n' | change "$a/two.cpp"
touch -d '2020-01-01' "$a/two.cpp"
other "$(digest "$a")" "$first" "a source with an older time: another"
printf 'int two() { return 2; }\n' | change "$a/two.cpp"
same "$(digest "$a")" "$first" "the source of before: the same"
printf 'int two() { return 2; }\n' | change "$a/two.cpp"
keeps_objects=yes
other "$(digest "$a" | grep -c 'edited while the build ran')" 0 "a source that is newer than its object: a digest of its own"
keeps_objects=
same "$(digest "$a")" "$first" "and after the object was made again: the same"
printf '#error no\n' >>"$a/two.cpp"
other "$(digest "$a" 2>/dev/null | grep -c failed)" 0 "a unit that cannot be preprocessed: refused"
exit $status
