#!/bin/sh
# Builds zstd for Windows from the sources of Debian's package: FOLDER/libzstd.a and FOLDER/zstd.h. Debian has no such
# package for MinGW, and traces of other builds hold packed checkpoints.
# SPDX-License-Identifier: MIT
# usage: zstd.sh FOLDER JOBS    TICKTRUE_ZSTD_SOURCE names an unpacked source folder of zstd: then nothing is fetched.
set -u
mkdir -p "$1" && folder=$(cd "$1" && pwd) || exit 2
jobs=$2
prefix=x86_64-w64-mingw32
complain() { printf 'zstd.sh: error: %s\n  %s\n' "$1" "$2" >&2; }
[ ! -e "$folder/libzstd.a" ] || [ ! -e "$folder/zstd.h" ] || exit 0

source=${TICKTRUE_ZSTD_SOURCE-}
if [ -z "$source" ]; then
  # Lists of sources apart from those of the machine, so that nothing of it changes.
  lists=$folder/lists
  mkdir -p "$lists/partial" "$folder/source" || exit 2
  sed 's/^Types: .*/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$folder/debian.sources" 2>/dev/null ||
    sed -n 's/^deb /deb-src /p' /etc/apt/sources.list >"$folder/debian.list" || exit 2
  list=$(find "$folder" -maxdepth 1 -name 'debian.*' -size +0 | head -n 1)
  set -- -qq -o "Dir::Etc::sourcelist=$list" -o Dir::Etc::sourceparts=- -o "Dir::State::lists=$lists" \
    -o APT::Sandbox::User=root
  if ! apt-get "$@" update || ! (cd "$folder/source" && apt-get "$@" --download-only source libzstd); then
    complain "the sources of libzstd: apt-get gave none" "set TICKTRUE_ZSTD_SOURCE to an unpacked source of zstd"
    exit 2
  fi
  mkdir -p "$folder/source/unpacked" &&
    tar -xf "$(find "$folder/source" -name 'libzstd_*.orig.tar.*' ! -name '*.asc')" -C "$folder/source/unpacked" \
      --strip-components=1 || exit 2
  source=$folder/source/unpacked
fi

mkdir -p "$folder/objects" || exit 2
find "$source/lib/common" "$source/lib/compress" "$source/lib/decompress" -name '*.c' |
  xargs -P "$jobs" -I FILE sh -c '"$1"-gcc-posix -O2 -w -DZSTD_DISABLE_ASM=1 -DXXH_NAMESPACE=ZSTD_ -DZSTD_LEGACY_SUPPORT=0 \
    -c "$3" -o "$2/$(basename "$3" .c).o"' sh "$prefix" "$folder/objects" FILE || exit 1
rm -f "$folder/libzstd.a"
"$prefix-ar" rcs "$folder/libzstd.a" "$folder"/objects/*.o && cp "$source/lib/zstd.h" "$source/lib/zstd_errors.h" "$folder"
