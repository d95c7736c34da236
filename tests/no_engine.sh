#!/bin/sh
# no_engine.sh LIBRARY...: fails if a library of the C API defines or needs a symbol of the engine.
command -v nm >/dev/null || exit 77
status=0
for library in "$@"; do
  symbols=$(nm -C "$library" 2>/dev/null)
  if [ "$(printf '%s\n' "$symbols" | grep -c 'ticktrue')" -eq 0 ]; then
    echo "no_engine: error: $library: found no symbols at all"
    status=1
  fi
  found=$(printf '%s\n' "$symbols" | grep -c 'ticktrue::engine::')
  echo "$library: $(wc -c <"$library" | tr -d ' ') bytes, $found symbols of the engine"
  [ "$found" -eq 0 ] || status=1
done
exit $status
