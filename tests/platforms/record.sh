#!/bin/sh
# The record of the last run of ./dev platforms in which every platform gave the same bits: tests/platforms/record.json.
# SPDX-License-Identifier: MIT
# usage, from the root of the tree:
#   record.sh digest            digest of the sources that the platforms verify: without comments, empty lines, layout, and
#                               the same on every machine. (That of `ticktrue env` covers flags, compiler and system headers:
#                               it differs between presets and machines.)
#   record.sh write             writes the record if out/platforms has ten platforms with the same bits and this digest
#   record.sh check             exits 1 if the record has another physics version, warns if it has another digest
set -u
record=tests/platforms/record.json
platform_count=10

complain() { printf 'record: error: %s\n  %s\n' "$1" "$2" >&2; }
advice='run ./dev platforms: it writes the record after ten of ten'

digest() {
  text=$(mktemp) || return 2
  find base engine replay -name '*.h' -o -name '*.cpp' | LC_ALL=C sort | xargs cat |
    "${CXX:-g++}" -fpreprocessed -dD -E -P -x c++ - >"$text" 2>/dev/null || { rm -f "$text"; return 2; }
  find cmake/determinism.cmake cmake/float_flags.cmake cmake/toolchains -name '*.cmake' | LC_ALL=C sort | xargs cat >>"$text"
  tr -s '[:space:]' ' ' <"$text" | sha256sum | cut -c 1-32
  rm -f "$text"
}

physics_version() { sed -n 's/^inline constexpr .* physics_version = \([0-9]*\);.*/\1/p' engine/engine.h; }
recorded() { sed -n 's/^  "'"$1"'": "\{0,1\}\([^",]*\)"\{0,1\},$/\1/p' "$record"; }
count_good() { grep -c '"ok": true' "$1"; }

write() {
  here=$(digest) || return 2
  good=$(grep -l '"ok": true' out/platforms/*/result.json | xargs grep -l "\"engine_digest\": \"$here\"")
  count=$(printf '%s' "$good" | grep -c .)
  if [ "$count" != "$platform_count" ]; then
    echo "record: $count of $platform_count platforms gave the same bits with these sources: $record stays as it is"
    return 0
  fi
  {
    printf '{\n  "schema": "ticktrue.platforms_record/1",\n  "physics_version": %s,\n  "engine_digest": "%s",\n' \
      "$(physics_version)" "$here"
    printf '  "date": "%s",\n  "commit": "%s",\n' "$(date -u +%Y-%m-%d)" \
      "$(git describe --always --dirty --abbrev=10 --exclude '*' 2>/dev/null || echo unknown)"
    echo '  "platforms": ['
    comma=
    for result in $good; do
      printf '%s' "$comma"
      grep -v '"engine_digest"' "$result"
      comma=,
    done
    printf '  ]\n}\n'
  } >"$record.new" && mv "$record.new" "$record" && echo "record: $record is written: commit it"
}

check() {
  if [ ! -f "$record" ]; then
    complain "$record: found no record" "$advice"
    return 1
  fi
  if [ "$(recorded physics_version)" != "$(physics_version)" ]; then
    complain "$record: physics version: found $(recorded physics_version), expected $(physics_version) of engine/engine.h" \
      "$advice"
    return 1
  fi
  good=$(count_good "$record")
  if [ "$good" != "$platform_count" ]; then
    complain "$record: found $good platforms with the same bits, expected $platform_count" "$advice"
    return 1
  fi
  here=$(digest) || { complain "cannot make the digest" "it needs g++ and sha256sum"; return 2; }
  if [ "$(recorded engine_digest)" != "$here" ]; then
    printf 'record: warning: engine digest: found %s of %s, expected %s: %s\n' "$(recorded engine_digest)" \
      "$(recorded date)" "$here" "$advice"
  else
    printf 'record: %s platforms, physics %s, %s\n' "$good" "$(physics_version)" "$(recorded date)"
  fi
}

case ${1-} in
  digest) digest ;;
  write) write ;;
  check) check ;;
  *)
    complain "found ${1-nothing}, expected digest, write or check" "the top of this file"
    exit 2
    ;;
esac
