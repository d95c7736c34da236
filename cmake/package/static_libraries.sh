#!/bin/sh
# static_libraries.sh FOLDER: Box2D, muParser and fmt as static libraries in FOLDER. Debian has them as shared libraries
# alone, so they are compiled from Debian's source packages, in the versions of the headers that are installed.
# SPDX-License-Identifier: MIT
set -u
[ $# = 1 ] || { echo 'usage: static_libraries.sh FOLDER' >&2; exit 2; }
mkdir -p "$1" && folder=$(cd "$1" && pwd) || exit 2
compiler=${CXX:-g++}

fail() {
  printf 'static_libraries: error: %s\n  %s\n' "$1" "$2" >&2
  exit 1
}

# Source packages come from where the machine's binary packages come from, by lists of their own: nothing of the machine
# is changed, and root is not needed.
state=$folder/apt
mkdir -p "$state/lists/partial" "$state/cache/archives/partial"
key=/usr/share/keyrings/debian-archive-keyring.gpg
[ -r "$key" ] && signed="[signed-by=$key] " || signed=
list_sources() {
  # shellcheck disable=SC2016 # apt's own fields
  apt-get indextargets --format '$(ORIGIN) $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    awk -v signed="$signed" '$1 == "Debian" && NF == 4 { print "deb-src " signed $2, $3, $4 }' | sort -u >"$state/sources.list"
  [ -s "$state/sources.list" ]
}
# A new machine has no lists yet.
list_sources || { apt-get -qq update; list_sources; } || fail "found no list of Debian packages" "run apt-get update as root"
cat >"$state/conf" <<CONF
Dir::Etc::sourcelist "$state/sources.list";
Dir::Etc::sourceparts "/dev/null";
Dir::State::lists "$state/lists";
Dir::Cache "$state/cache";
APT::Sandbox::User "root";
CONF
APT_CONFIG=$state/conf
export APT_CONFIG
apt-get -qq update >"$state/log" 2>&1 || { cat "$state/log" >&2; fail "apt-get update: failed" "is the network there?"; }

# add_library NAME PACKAGE PATTERN FLAGS...: lib NAME.a of the sources that match the pattern.
add_library() {
  name=$1
  package=$2
  pattern=$3
  shift 3
  # shellcheck disable=SC2016 # dpkg's own fields
  source=$(dpkg-query -W -f '${source:Package}=${source:Version}' "$package") ||
    fail "$package is not installed" "./dev setup"
  work=$folder/$name
  rm -rf "$work" && mkdir -p "$work/source" "$work/objects" || exit 2
  (cd "$work" && apt-get -q source --download-only "$source") >"$state/log" 2>&1 ||
    { cat "$state/log" >&2; fail "$source: found no source package" "apt-get upgrade $package"; }
  tar -xf "$work"/*.orig.tar.* -C "$work/source" --strip-components 1 || exit 1
  # shellcheck disable=SC2086 # a pattern is to be expanded
  files=$(cd "$work/source" && find src -name "$pattern" | grep -vE '/(fmt\.cc|muParserDLL\.cpp|muParserTest\.cpp)$' | LC_ALL=C sort)
  objects=
  for file in $files; do
    object=$work/objects/$(printf '%s' "${file%.*}" | tr / _).o
    (cd "$work/source" && "$compiler" -O2 -fPIC "-ffile-prefix-map=$work=." "$@" -c "$file" -o "$object") ||
      fail "$source: $file: does not compile" "see above"
    objects="$objects $object"
  done
  rm -f "$folder/lib$name.a"
  # shellcheck disable=SC2086 # words on purpose
  ar qcsD "$folder/lib$name.a" $objects || exit 1
  printf '%s\n' "$source" >"$folder/$name.version"
}

add_library box2d libbox2d-dev '*.cpp' -Iinclude -Isrc
add_library muparser libmuparser-dev '*.cpp' -Iinclude -DMUPARSER_STATIC
add_library fmt libfmt-dev '*.cc' -Iinclude
