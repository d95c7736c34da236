#!/bin/sh
# Compiles engine sources with the project's flags for a machine with fused multiply-add by AVX-512 and by FMA, and
# looks for fused instructions.
# SPDX-License-Identifier: MIT
# usage: no_fused.sh SOURCE_DIR COMPILER FLAGS...    Exits 0 if there are none, 1 if there are some, 77 if unknown.
set -u
source_dir=$1
compiler=$2
shift 2
command -v objdump >/dev/null 2>&1 || exit 77
object=$(mktemp) || exit 77
trap 'rm -f "$object"' EXIT
status=0
for source in engine/narrow_phase/collide_polygons.cpp engine/solvers/impulse.cpp engine/joints/mouse_joint.cpp \
  engine/contacts/contact_kernels.cpp engine/joints/batched/revolute_kernels.cpp engine/integrators/motion_kernels.cpp; do
  "$compiler" -std=c++20 -O3 -march=x86-64-v4 "$@" -DTICKTRUE_PRECISION=f64 -I"$source_dir" -c "$source_dir/$source" \
    -o "$object" || exit 1
  count=$(objdump -d "$object" | grep -cE 'vfn?m(add|sub)')
  [ "$count" = 0 ] || { echo "$source: found $count fused instructions, expected 0"; status=1; }
done
exit $status
