#!/bin/sh
# dependencies.sh SOURCE: configures the project with headers in a separate prefix, and inside another project.
# CMAKE_PREFIX_PATH must decide where headers come from. Warnings must not be errors in the other project.
# SPDX-License-Identifier: MIT
set -u
source=$(cd "$1" && pwd) || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
failures=0

complain() {
  printf 'dependencies: error: %s\n' "$1"
  failures=$((failures + 1))
}

mkdir -p "$prefix/include" "$prefix/lib" "$work/outer"
for entry in CLI nlohmann fmt stb xxhash.h catch2 zstd.h; do
  [ -e "/usr/include/$entry" ] || exit 77
  cp -r "/usr/include/$entry" "$prefix/include/$entry"
done
cp "$(find /usr/lib -name 'libzstd.so' | head -n 1)" "$prefix/lib/libzstd.so" 2>/dev/null || exit 77
cat >"$work/outer/CMakeLists.txt" <<OUTER
cmake_minimum_required(VERSION 3.25)
project(outer LANGUAGES C CXX)
add_subdirectory($source ticktrue)
OUTER
cmake -S "$work/outer" -B "$work/build" -G Ninja "-DCMAKE_PREFIX_PATH=$prefix" -DTICKTRUE_BUILD_TESTS=ON \
  -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >"$work/log" 2>&1 || { cat "$work/log"; complain "configuration"; }

for entry in CLI nlohmann fmt stb xxhash.h catch2; do
  found=$(find "$work/build" -path "*header_farm/$entry" -exec readlink {} \;)
  [ "$found" = "$prefix/include/$entry" ] || complain "$entry: found ${found:-nothing}, expected $prefix/include/$entry"
done
commands=$work/build/compile_commands.json
payload=$(grep '"command".*replay' "$commands" | head -n 1)
case $payload in
  *"-isystem $prefix/include"*) ;;
  *) complain "zstd.h: found no -isystem $prefix/include in the command of replay/" ;;
esac
if grep -q -e '-Werror' "$commands"; then complain "-Werror: found it inside another project, expected it in our presets alone"; fi
grep -q '"CMAKE_COMPILE_WARNING_AS_ERROR": "ON"' "$source/CMakePresets.json" || complain "CMakePresets.json: warnings are no errors"

# Kernels are never compiled together, so a warning of -Wshadow in a kernel would break a build without TICKTRUE_UNITY.
for kernel in $(find "$source/engine" -name "*_kernels.cpp"); do
  c++ -std=c++20 -fsyntax-only -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Werror -DTICKTRUE_PRECISION=f64 \
    -DTICKTRUE_ISA=baseline -I"$source" "$kernel" || complain "$kernel: warnings"
done
[ "$failures" = 0 ] || exit 1
echo "dependencies: headers of CMAKE_PREFIX_PATH were taken, and warnings stay warnings"
