#!/bin/sh
# package.sh [--build DIR] [--out DIR] [--windows DIR]: makes the archives of a release from what a build has made:
#   ticktrue-VERSION-linux-x86_64.tar.gz   tool, library, headers, CMake package, pkg-config files, examples, documents
#   ticktrue_VERSION-1_amd64.deb           the same for Debian 12 and later
#   ticktrue-VERSION-windows-x86_64.zip    of an install tree of the MinGW build (--windows)
#   ticktrue-VERSION.tar.gz                the sources of the commit
#   SHA256SUMS
# The same build and commit give the same bytes. Run it by `./dev package`, which builds the target ticktrue_packaged.
# SPDX-License-Identifier: MIT
set -u
LC_ALL=C TZ=UTC
export LC_ALL TZ
umask 022
source=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
build=$source/build/release
out=$source/out/package
windows=

fail() {
  printf 'package: error: %s\n  %s\n' "$1" "$2" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  [ $# -ge 2 ] || fail "$1: found nothing behind it" "package.sh [--build DIR] [--out DIR] [--windows DIR]"
  case $1 in
    --build) build=$2 ;;
    --out) out=$2 ;;
    --windows) windows=$2 ;;
    *) fail "unknown option: found $1" "package.sh [--build DIR] [--out DIR] [--windows DIR]" ;;
  esac
  shift 2
done
build=$(cd "$build" && pwd) || exit 2
mkdir -p "$out" && out=$(cd "$out" && pwd) || exit 2
[ -z "$windows" ] || windows=$(cd "$windows" && pwd) || exit 2
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")
[ -n "$version" ] || fail "$build: found no version in CMakeCache.txt" "./dev build"
for file in ticktrue libticktrue.a "libticktrue.so.$version"; do
  [ -f "$build/packaged/$file" ] || fail "$build/packaged/$file: found no such file" "cmake --build $build --target ticktrue_packaged"
done
# All times within the archives are the time of the commit. Sources without a repository use the time of their files.
if [ -z "${SOURCE_DATE_EPOCH-}" ]; then
  SOURCE_DATE_EPOCH=$(git -C "$source" log -1 --format=%ct 2>/dev/null || stat -c %Y "$source/CMakeLists.txt")
fi
export SOURCE_DATE_EPOCH
level=${PACKAGE_LEVEL-6} # of compression; the test of the archives takes 1
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT

# pack FOLDER NAME: the folder of that name in FOLDER as NAME.tar.gz, the same bytes from the same files.
pack() {
  tar -C "$1" --sort=name --format=ustar --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX \
    --mtime="@$SOURCE_DATE_EPOCH" -cf "$work/archive.tar" "$2" &&
    gzip "-${level}n" <"$work/archive.tar" >"$out/$2.tar.gz" && rm "$work/archive.tar" || exit 1
}

# bring_libraries PREFIX: copies shared libraries that the tool needs to lib/ticktrue, each under the name by which it is
# loaded. muParser needs OpenMP's library, which a machine without a compiler may lack.
bring_libraries() {
  mkdir -p "$1/lib/ticktrue" || exit 1
  for library in libbox2d libmuparser libfmt libgomp; do
    ldd "$1/bin/ticktrue" | awk -v name="$library" 'index($1, name ".so") == 1 { print $1, $3 }' >"$work/needed"
    read -r needed path <"$work/needed" && [ -f "$path" ] ||
      fail "$1/bin/ticktrue: found no $library that it needs" "./dev setup package"
    cp -L "$path" "$1/lib/ticktrue/$needed" || exit 1
  done
  chmod 644 "$1"/lib/ticktrue/*
}

# stage PREFIX: the installed files, with the programs and libraries of target ticktrue_packaged.
stage() {
  cmake --install "$build" --prefix "$1" --component sdk >"$work/log" || { cat "$work/log" >&2; exit 1; }
  cp "$build/packaged/ticktrue" "$1/bin/ticktrue" &&
    cp "$build/packaged/libticktrue.so.$version" "$build/packaged/libticktrue.a" "$1/lib/" || exit 1
  strip --strip-unneeded "$1/bin/ticktrue" "$1/lib/libticktrue.so.$version" "$1/lib/libticktrue_shim.so" || exit 1
  # libticktrue.a contains zstd.
  sed -i 's/-lzstd //' "$1/lib/pkgconfig/ticktrue-static.pc" &&
    sed -i '/INTERFACE_LINK_LIBRARIES/s/"zstd;/"/' "$1/lib/cmake/ticktrue/ticktrue-targets.cmake" || exit 1
  if grep -rq zstd "$1/lib/cmake" "$1/lib/pkgconfig"; then
    fail "$1/lib: zstd is still asked for" "$(grep -rl zstd "$1/lib/cmake" "$1/lib/pkgconfig")"
  fi
  chmod 644 "$1"/lib/*.so.* "$1"/lib/*.a "$1"/lib/libticktrue_shim.so
  bring_libraries "$1"
}

# add_papers FOLDER: documents and examples.
add_papers() {
  mkdir -p "$1/docs" && cp -r "$source/docs/." "$1/docs" && cp -r "$source/examples" "$1/examples" || exit 1
  rm -rf "$1"/examples/__pycache__
  # Links of docs/ from the folder above.
  sed 's/](\([a-z_]*\.\(md\|yml\)\)/](docs\/\1/g' "$source/docs/quickstart.md" >"$1/QUICKSTART.md" || exit 1
}

# The libraries that are linked into the programs, as packages of Debian; those of libticktrue first.
in_library='libzstd-dev libxxhash-dev nlohmann-json3-dev libstdc++-12-dev'
in_tool='libbox2d-dev libmuparser-dev libfmt-dev libgomp1 libdw-dev libelf-dev zlib1g-dev liblzma-dev libbz2-dev libcli11-dev
libstb-dev'

# add_licences FOLDER
add_licences() {
  mkdir -p "$1" || exit 1
  {
    echo "ticktrue is under the MIT licence (LICENSE). These libraries are linked into its programs, or lie in lib/ticktrue (Box2D,"
    echo "muParser, fmt, OpenMP), in the versions of Debian."
    echo "The file of a library's name has its copyright and licence."
    for part in library tool; do
      [ $part = library ] && packages=$in_library || packages=$in_tool
      printf '\nIn the %s%s:\n' "$part" "$([ $part = tool ] && echo ', besides')"
      for package in $packages; do
        cp "/usr/share/doc/$package/copyright" "$1/$package" || exit 1
        # shellcheck disable=SC2016 # dpkg's own fields
        dpkg-query -W -f '  ${source:Package} ${source:Version} (${Package})\n' "$package" || exit 1
      done
    done
    printf '\nlibdw and libelf (elfutils) are in the tool alone, under the LGPL 3 or later, or the GPL 2 or later. The sources of\n'
    echo "ticktrue and cmake/package/CMakeLists.txt in them link the tool with another version of elfutils. Debian has the"
    echo "sources of elfutils: apt-get source elfutils. The C++ runtime in libticktrue is under the GPL 3 with its runtime library exception."
  } >"$1/README" || exit 1
  cp /usr/share/common-licenses/LGPL-3 /usr/share/common-licenses/GPL-2 /usr/share/common-licenses/GPL-3 "$1" || exit 1
}

# glibc_version PREFIX: the newest version of the C library that the programs need.
glibc_version() {
  objdump -T "$1/bin/ticktrue" "$1"/lib/*.so | grep -o 'GLIBC_[0-9.]*' | sed 's/GLIBC_//' | sort -Vu | tail -n 1
}

linux_archive() {
  name=ticktrue-$version-linux-x86_64
  stage "$work/$name"
  add_papers "$work/$name"
  add_licences "$work/$name/licences"
  cp "$source/LICENSE" "$source/CHANGELOG.md" "$work/$name" || exit 1
  pack "$work" "$name"
}

debian_package() {
  root=$work/deb
  stage "$root/usr"
  doc=$root/usr/share/doc/ticktrue
  add_papers "$doc"
  add_licences "$doc/licences"
  rm -f "$doc/licences/LGPL-3" "$doc/licences/GPL-2" "$doc/licences/GPL-3" # /usr/share/common-licenses has them
  sed -i 's|^prefix=.*|prefix=/usr|' "$root"/usr/lib/pkgconfig/*.pc
  {
    echo 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/'
    printf 'Upstream-Name: ticktrue\n\nFiles: *\nCopyright: 2026 The ticktrue authors\nLicense: Expat\n'
    sed '1,4d; s/^$/./; s/^/ /' "$source/LICENSE"
    printf '\nComment:\n Libraries that are linked in have their licences in /usr/share/doc/ticktrue/licences.\n'
  } >"$doc/copyright"
  gzip -9n <"$source/CHANGELOG.md" >"$doc/changelog.gz"
  maintainer='The ticktrue authors <ticktrue@localhost>'
  printf 'ticktrue (%s-1) bookworm; urgency=medium\n\n  * Release %s: changelog.gz has what is new.\n\n -- %s  %s\n' \
    "$version" "$version" "$maintainer" "$(date -u -R -d "@$SOURCE_DATE_EPOCH")" | gzip -9n >"$doc/changelog.Debian.gz"
  mkdir -p "$root/DEBIAN" && cat >"$root/DEBIAN/control" <<CONTROL
Package: ticktrue
Version: $version-1
Section: devel
Priority: optional
Architecture: amd64
Maintainer: $maintainer
Installed-Size: $(du -sk --apparent-size "$root/usr" | cut -f 1)
Depends: libc6 (>= $(glibc_version "$root/usr")), libgcc-s1, libstdc++6 (>= 12)
Recommends: g++ | clang, pkg-config
Suggests: cmake, libsdl2-2.0-0
Description: deterministic replay and verification of simulations
 ticktrue records a simulation once and proves, on any machine and at every
 commit, that it still runs bit for bit the same. Where it does not, it names
 the tick, the column and the rows that went first.
 .
 This package has the tool, the library libticktrue for programs that own
 their loop, its headers for C and C++, the CMake package and the pkg-config
 files, documents and examples. \`ticktrue play\` opens its window where
 libsdl2-2.0-0 is installed.
CONTROL
  printf 'libticktrue 1 ticktrue (>= %s)\n' "$version" >"$root/DEBIAN/shlibs"
  echo 'activate-noawait ldconfig' >"$root/DEBIAN/triggers"
  (cd "$root" && find usr -type f | sort | xargs md5sum) >"$root/DEBIAN/md5sums"
  chmod -R u=rwX,go=rX "$root"
  find "$root" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
  dpkg-deb --root-owner-group -Zxz "-z$level" --build "$root" "$out/ticktrue_$version-1_amd64.deb" >"$work/log" ||
    { cat "$work/log" >&2; exit 1; }
}

# Packs the commit of the work tree, with the time of the commit; a tree without a repository is packed as it is.
source_archive() {
  name=ticktrue-$version
  mkdir -p "$work/$name"
  if git -C "$source" rev-parse --git-dir >/dev/null 2>&1; then
    git -C "$source" archive --format=tar HEAD | tar -C "$work/$name" -xf - || exit 1
    [ -z "$(git -C "$source" status --porcelain --untracked-files=no)" ] ||
      echo "package: warning: the work tree has changes: $name.tar.gz has those of the last commit alone" >&2
  else
    tar -C "$source" --exclude=./build --exclude=./out -cf - . | tar -C "$work/$name" -xf - || exit 1
  fi
  pack "$work" "$name"
}

# windows_archive TREE: the zip of an install tree of the MinGW build: bin/ (tool, libticktrue.dll), lib/ (import
# library, CMake package), include/. Builders for Windows call this function with the tree; it adds papers and licences.
windows_archive() {
  command -v zip >/dev/null || fail "found no zip" "apt-get install zip"
  [ -n "$(find "$1" -name '*.dll' -print -quit)" ] || fail "$1: found no .dll, expected an install tree" "cmake --install"
  name=ticktrue-$version-windows-x86_64
  cp -r "$1" "$work/$name" || exit 1
  add_papers "$work/$name"
  cp "$source/LICENSE" "$source/CHANGELOG.md" "$work/$name" || exit 1
  mkdir -p "$work/$name/licences"
  for package in libxxhash-dev libfmt-dev libcli11-dev nlohmann-json3-dev libstb-dev libstdc++-12-dev; do
    cp "/usr/share/doc/$package/copyright" "$work/$name/licences/$package" || exit 1
  done
  chmod -R u=rwX,go=rX "$work/$name"
  find "$work/$name" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
  rm -f "$out/$name.zip"
  # -X: without owners and times of access, which differ from run to run.
  (cd "$work" && find "$name" -type f | sort | zip -q -X -D "-$level" -@ "$out/$name.zip") || exit 1
}

rm -f "$out"/ticktrue[-_]* "$out/SHA256SUMS"
linux_archive
debian_package
[ -z "$windows" ] || windows_archive "$windows"
source_archive
(cd "$out" && sha256sum ticktrue[-_]* >SHA256SUMS) || exit 1
printf 'packed  %s\n' "$out"
(cd "$out" && for file in *; do printf '  %s  %s bytes\n' "$file" "$(wc -c <"$file" | tr -d ' ')"; done)
printf '  needs a C library of version %s or later; the tool also the C++ runtime of GCC 12 or later\n' "$(glibc_version "$work/ticktrue-$version-linux-x86_64")"
