#!/bin/sh
# Looks for code that kernels of a wider instruction set would lend to everything else: a symbol that others can link.
# SPDX-License-Identifier: MIT
# usage: kernel_symbols.sh NAMESPACE OBJECT...    Exits 0 if all are in the namespace, 1 if not, 77 if it cannot tell.
set -u
name=$1
shift
command -v nm >/dev/null 2>&1 || exit 77
status=0
for object in "$@"; do
  # T: functions; D and R: a table of functions that are local themselves.
  [ "$(nm "$object" | grep -c ' [TDR] ')" -gt 0 ] || { echo "$object: found no function, expected kernels"; status=1; }
  # Lower case: local to the unit, but for the weak (v, w) and unique (u) ones.
  leaked=$(nm -C --defined-only "$object" | grep -E ' [A-Zuvw] ' | grep -v "::$name::")
  [ -z "$leaked" ] || { echo "$object: found symbols outside of $name:"; echo "$leaked"; status=1; }
done
exit $status
