#!/bin/sh
# A scripted person uses the window under Xvfb: clicks 50 bodies, drags three, pauses, steps, ends. The recording
# verifies, clicked bodies are at the clicked places, and the screen shows bodies at their places in the state. The
# window then plays the recording to its end, and the wheel zooms in.
# usage: window.sh TOOL [TRACE_CHECK]   TRACE_CHECK: of another build or preset; also verifies the recording
# Exit 77: Xvfb or xdotool is missing, or the tool has no window.
# SPDX-License-Identifier: MIT
set -u
tool=$(realpath "$1")
other=${2:+$(realpath "$2")}
command -v Xvfb >/dev/null 2>&1 && command -v xdotool >/dev/null 2>&1 || {
  echo "no Xvfb or no xdotool: skipped"
  exit 77
}
work=$(mktemp -d) || exit 1
server="" player=""
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

mkdir "$work/screen"
Xvfb -displayfd 3 -screen 0 1024x768x24 -fbdir "$work/screen" -nolisten tcp 3>"$work/display" >/dev/null 2>&1 &
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

# open TITLE ARGUMENT...: starts the tool with a window in the background.
open() {
  title=$1
  shift
  "$tool" play "$@" >out.json 2>err &
  player=$!
  window="" tries=0
  while [ -z "$window" ]; do
    grep -q 'this build has none' err && exit 77
    tries=$((tries + 1))
    [ $tries -lt 200 ] || fail "no window came"
    sleep 0.1
    window=$(xdotool search --onlyvisible --name "$title" 2>/dev/null | head -n 1)
  done
  xdotool windowfocus "$window" sleep 0.5
}
# close: presses q, and waits until the tool has ended without an error.
close() {
  xdotool key q
  tries=0
  while kill -0 "$player" 2>/dev/null; do
    tries=$((tries + 1))
    [ $tries -lt 100 ] || fail "the window did not close on q"
    sleep 0.1
  done
  wait "$player" || fail "exit code $?"
  player=""
}

# Xvfb keeps its screen in an XWD file: big-endian words, a table of colours, rows of pixels.
word() {
  od -An -v -tu1 -j $(($1 * 4)) -N 4 screen.xwd | awk '{ print (($1 * 256 + $2) * 256 + $3) * 256 + $4 }'
}
take_screen() {
  cp screen/Xvfb_screen0 screen.xwd
  [ "$(word 7) $(word 11)" = "0 32" ] || fail "the screen has other pixels than expected: $(word 7) $(word 11)"
  pixels=$(($(word 0) + 12 * $(word 19)))
  row_size=$(word 12)
  eval "$(xdotool getwindowgeometry --shell "$window" | grep '^[XY]=')"
}
# shown X Y: prints the colour at a place in the window.
shown() {
  od -An -v -tx1 -j $((pixels + (Y + $2) * row_size + (X + $1) * 4)) -N 3 screen.xwd | awk '{ print $3 $2 $1 }'
}

# The window of the thesis scene is 32 x 24 m: 31.25 px per metre here. Without gravity, new bodies stay in place.
open 'ticktrue - thesis' 'thesis?gravity=0' --size 1000x750 -o played.ttr --dump-frame end.json --json

# x y button ctrl, in rows; the bodies do not touch each other.
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
xdotool key space sleep 0.3 key period sleep 0.1 key period sleep 0.1 key period sleep 0.2 key space sleep 0.3 \
  key space sleep 0.5
take_screen # paused: this is the last state
close

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

# Each click, in order, made a body within a pixel of its place.
grep '"kind":"spawn"' inputs.jsonl | tr ',{}' '\n\n\n' | sed -n 's/^"\([xy]\)":/\1 /p' >places
awk 'NR == FNR { click_x[NR] = $1; click_y[NR] = $2; next }
  $1 == "x" { ++n; x = $2 }
  $1 == "y" {
    dx = x * 31.25 - click_x[n]; dy = (24 - $2) * 31.25 - click_y[n]
    if (dx < -1 || dx > 1 || dy < -1 || dy > 1) { print "click " n ": is " dx ", " dy " px away"; bad = 1 }
  }
  END { if (n != 50) { print n " places, expected 50"; bad = 1 }; exit bad }' clicks places || fail "clicks and pieces differ"

# The last picture draws every body at its place in the state.
hash=$(sed -n 's/^ *"hash": "\([0-9a-f]*\)".*/\1/p' out.json | head -n 1)
[ -n "$hash" ] && grep -q "\"hash\": \"$hash\"" end.json || fail "the picture is not of the last state"
# bodies FILE: prints x, y (m), px, py and colours of the bodies in a dumped frame.
bodies() {
  tr -d ' ,"' <"$1" | awk -F: '
    $1 == "id" { ++n } $1 == "color" || $1 == "px" || $1 == "py" || $1 == "x" || $1 == "y" { value[n, $1] = $2 }
    END { for (i = 1; i <= n; ++i)
      print value[i, "x"], value[i, "y"], value[i, "px"], value[i, "py"], value[i, "color"] }'
}
bodies end.json >drawn
awk '{ dx = $1 * 31.25 - $3; dy = (24 - $2) * 31.25 - $4
    if (dx * dx + dy * dy > 0.01) { print "body " NR " is drawn beside its place"; bad = 1 } }
  END { if (NR != 55) { print NR " bodies, expected 55"; bad = 1 }; exit bad }' drawn || fail "drawn positions differ from the state"

# At the place from the state, the screen shows the body and not the background.
ground='161a21 1d222b 262d39'
seen=0
while read -r _ _ px py color; do
  [ -n "$color" ] || continue
  on_screen=$(shown "${px%.*}" "${py%.*}")
  [ "$on_screen" = "$color" ] || fail "the screen shows $on_screen at $px, $py, expected $color"
  case " $ground " in *" $on_screen "*) fail "at $px, $py is no body on the screen" ;; esac
  seen=$((seen + 1))
done <drawn
[ $seen -ge 50 ] || fail "only $seen bodies are on the screen"
empty=$(shown 500 440)
case " $ground " in *" $empty "*) ;; *) fail "where no body is the screen shows $empty" ;; esac

# Plays the recording in the window: its last tick, zoomed in by two notches of the wheel around the pointer.
open 'ticktrue - played.ttr' played.ttr --size 800x600 --dump-frame seen.json --json
xdotool key End sleep 0.5 mousemove --window "$window" 200 150 click 4 click 4 click 4 click 5 sleep 0.4
close
ticks=$(sed -n 's/^ *"ticks": \([0-9]*\).*/\1/p' out.json)
position=$(sed -n 's/^ *"position": \([0-9]*\).*/\1/p' out.json)
[ -n "$ticks" ] && [ "$position" = "$ticks" ] || fail "End went to $position of $ticks"
grep -q '"first_difference": null' out.json || fail "playing the recording found a difference"
grep -q "\"hash\": \"$hash\"" seen.json || fail "the recording does not end as the session did"
bodies seen.json | awk '{ x = 200.5 + ($1 * 25 - 200.5) * 1.21; y = 150.5 + ((24 - $2) * 25 - 150.5) * 1.21
    if ((x - $3) ^ 2 + (y - $4) ^ 2 > 0.01) { print "body " NR " is at " $3 ", " $4 ", expected " x ", " y; bad = 1 } }
  END { if (NR != 55) { print NR " bodies, expected 55"; bad = 1 }; exit bad }' || fail "the wheel zooms wrongly"
echo "50 clicks, 3 drags: $ticks ticks verified; $seen bodies seen on the screen"
