#!/bin/sh
# Builds a program of the gallery for `ticktrue shake --rebuild`: build.sh SOURCE LIBRARY_FOLDER [MORE]
# SPDX-License-Identifier: MIT
set -e
tree=$(cd "$(dirname "$0")/../.." && pwd)
# shellcheck disable=SC2086
"$CXX" -std=c++20 -O1 -g1 -ffp-contract=off $CXXFLAGS -I "$tree" "$1" -o "$TICKTRUE_PROGRAM" -L "$2" -lticktrue \
  -Wl,-rpath,"$2"
