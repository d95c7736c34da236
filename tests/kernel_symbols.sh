#!/bin/sh
# Looks for kernel code of a wider instruction set that other code could use: symbols that others can link.
# SPDX-License-Identifier: MIT
# usage: kernel_symbols.sh NAMESPACE OBJECT...    Exits 0 if all are in the namespace, 1 if not, 77 if unknown.
set -u
name=$1
shift
command -v nm >/dev/null 2>&1 || exit 77
status=0
for object in "$@"; do
  # T: functions. D and R: tables of functions that are local themselves.
  [ "$(nm "$object" | grep -c ' [TDR] ')" -gt 0 ] || { echo "$object: found no function, expected kernels"; status=1; }
  # Lower case means local to the unit, except for weak (v, w) and unique (u) symbols.
  leaked=$(nm -C --defined-only "$object" | grep -E ' [A-Zuvw] ' | grep -v "::$name::")
  [ -z "$leaked" ] || { echo "$object: found symbols outside of $name:"; echo "$leaked"; status=1; }
done
exit $status
