#!/bin/sh
# A scripted person at the window, under Xvfb: clicks 50 bodies, drags three, pauses, steps, ends. What was played
# verifies, what was clicked is where it was clicked, and what is drawn is where the state says.
# usage: window.sh TOOL [TRACE_CHECK]   TRACE_CHECK: of another build or preset, verifies the recording, too
# Exit 77: there is no Xvfb, no xdotool, or the tool has no window.
# SPDX-License-Identifier: MIT
set -u
tool=$(realpath "$1")
other=${2:+$(realpath "$2")}
command -v Xvfb >/dev/null 2>&1 && command -v xdotool >/dev/null 2>&1 || {
  echo "no Xvfb or no xdotool: skipped"
  exit 77
}
work=$(mktemp -d) || exit 1
server= player=
cleanup() {
  [ -z "$player" ] || kill "$player" 2>/dev/null
  [ -z "$server" ] || kill "$server" 2>/dev/null
  rm -rf "$work"
}
trap cleanup EXIT
fail() {
  echo "window: $*" >&2
  cat "$work/err" >&2 2>/dev/null
  exit 1
}

Xvfb -displayfd 3 -screen 0 1024x768x24 -nolisten tcp 3>"$work/display" >/dev/null 2>&1 &
server=$!
tries=0
while [ ! -s "$work/display" ]; do
  tries=$((tries + 1))
  [ $tries -lt 100 ] || fail "Xvfb did not start"
  sleep 0.1
done
DISPLAY=:$(cat "$work/display")
export DISPLAY
unset WAYLAND_DISPLAY
cd "$work" || exit 1

# The thesis' window is 32 x 24 m: 31.25 px to the metre here. Without gravity what is clicked stays there.
"$tool" play 'thesis?gravity=0' --size 1000x750 -o played.ttr --dump-frame end.json --json >out.json 2>err &
player=$!
window=$(timeout 20 xdotool search --sync --onlyvisible --name 'ticktrue - thesis' | head -n 1)
if [ -z "$window" ]; then
  grep -q 'this build has none' err && exit 77
  fail "no window came"
fi
xdotool windowfocus "$window" sleep 0.5

# x y button ctrl, in rows; the pieces do not touch each other.
rows() {
  awk 'BEGIN {
    for (i = 0; i < 10; ++i) print 90 + 88 * i, 60, 1, 0
    for (i = 0; i < 10; ++i) print 90 + 88 * i, 140, 3, 0
    for (i = 0; i < 10; ++i) print 90 + 88 * i, 220, 1, 0
    for (i = 0; i < 10; ++i) print 90 + 88 * i, 510, 1, 1
    for (i = 0; i < 7; ++i) print 90 + 88 * i, 600, 3, 0
    print 110, 360, 2, 0; print 440, 370, 2, 0; print 860, 370, 2, 0
  }'
}
rows >clicks
while read -r x y button ctrl; do
  [ "$ctrl" = 0 ] || printf 'keydown ctrl '
  printf 'mousemove --window %s %s %s click %s sleep 0.03 ' "$window" "$x" "$y" "$button"
  [ "$ctrl" = 0 ] || printf 'keyup ctrl '
done <clicks >commands
xargs xdotool <commands || fail "xdotool failed"
sleep 0.3
for from in '90 600' '354 600' '618 600'; do
  # shellcheck disable=SC2086 # two numbers
  xdotool mousemove --window "$window" $from mousedown 1 sleep 0.1 mousemove_relative 3 20 sleep 0.1 \
    mousemove_relative 3 12 sleep 0.1 mouseup 1
done
sleep 0.2
xdotool key space sleep 0.3 key period sleep 0.1 key period sleep 0.1 key period sleep 0.2 key space sleep 0.3 key q
tries=0
while kill -0 "$player" 2>/dev/null; do
  tries=$((tries + 1))
  [ $tries -lt 100 ] || fail "the window did not close on q"
  sleep 0.1
done
wait "$player" || fail "exit code $?"
player=

"$tool" verify played.ttr >/dev/null || fail "the recording does not verify"
if [ -n "$other" ]; then
  "$other" played.ttr || fail "the recording does not verify in the other build"
fi
"$tool" show played.ttr --inputs >inputs.jsonl || fail "no inputs"
for expected in 'spawn 50' 'press 3' 'release 3'; do
  kind=${expected% *}
  count=$(grep -c "\"kind\":\"$kind\"" inputs.jsonl)
  [ "$count" = "${expected#* }" ] || fail "inputs: found $count $kind, expected ${expected#* }"
done
[ "$(grep -c '"kind":"drag"' inputs.jsonl)" -ge 3 ] || fail "no drags"
[ "$(grep -c static_circle inputs.jsonl)" = 10 ] || fail "static pieces: found others than 10"

# Each click, in its order, made a piece within a pixel of where it was.
grep '"kind":"spawn"' inputs.jsonl | tr ',{}' '\n\n\n' | sed -n 's/^"\([xy]\)":/\1 /p' >places
awk 'NR == FNR { click_x[NR] = $1; click_y[NR] = $2; next }
  $1 == "x" { ++n; x = $2 }
  $1 == "y" {
    dx = x * 31.25 - click_x[n]; dy = (24 - $2) * 31.25 - click_y[n]
    if (dx < -1 || dx > 1 || dy < -1 || dy > 1) { print "click " n ": is " dx ", " dy " px away"; bad = 1 }
  }
  END { if (n != 50) { print n " places, expected 50"; bad = 1 }; exit bad }' clicks places || fail "clicks and pieces differ"

# The last picture: every body is drawn where the state has it, on a pixel that is not the ground.
hash=$(sed -n 's/^ *"hash": "\([0-9a-f]*\)".*/\1/p' out.json | head -n 1)
[ -n "$hash" ] && grep -q "\"hash\": \"$hash\"" end.json || fail "the picture is not of the last state"
tr -d ' ,"' <end.json | awk -F: '
  $1 == "x" { x = $2 } $1 == "y" { y = $2 } $1 == "px" { px = $2 }
  $1 == "py" {
    ++n; dx = x * 31.25 - px; dy = (24 - y) * 31.25 - $2
    if (dx * dx + dy * dy > 0.01) { print "body " n " is drawn beside its place"; bad = 1 }
  }
  $1 == "color" && $2 ~ /^(161a21|1d222b|262d39)$/ { print "body " n " is not drawn"; bad = 1 }
  END { if (n != 55) { print n " bodies, expected 55"; bad = 1 }; exit bad }' || fail "drawn positions differ from the state"
echo "50 clicks, 3 drags: $(sed -n 's/^ *"ticks": \([0-9]*\).*/\1/p' out.json | head -n 1) ticks verified"
