#!/bin/sh
# The Windows build under wine: sessions in C and C++, the tool, plug-ins, paths, and traces exchanged with Linux.
# SPDX-License-Identifier: MIT
# usage: run.sh BUILD STAGE LINUX    BUILD: folder of the Windows build. STAGE: the folder that a Windows archive holds.
# LINUX: folder of a build for this machine, with `ticktrue` and libticktrue.so.
#
# Not verified: Windows itself, MSVC (a program for its binary interface is compiled by clang and linked by lld).
set -u
build=$(cd "$1" && pwd) && stage=$(cd "$2" && pwd) && linux=$(cd "$3" && pwd) || exit 2
source=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
work=$(mktemp -d) || exit 2
holder=
trap '[ -z "$holder" ] || kill "$holder" 2>/dev/null; rm -rf "$work"' EXIT
out=$work/out
failures=0
LC_ALL=C.UTF-8 # file names as bytes of UTF-8
WINEDEBUG=-all
WINEPREFIX=$build/wine
export LC_ALL WINEDEBUG WINEPREFIX
unset DISPLAY WAYLAND_DISPLAY
cc=x86_64-w64-mingw32-gcc-posix
cxx=x86_64-w64-mingw32-g++-posix
carriage_return=$(printf '\r')

complain() {
  printf 'windows: error: %s\n' "$1"
  failures=$((failures + 1))
}

# expect EXIT TEXT COMMAND...: the command must end with EXIT and print TEXT. Of a text with several lines, it must
# print each.
expect() {
  wanted=$1
  text=$2
  shift 2
  timeout 300 "$@" >"$out" 2>&1
  code=$?
  [ "$code" = "$wanted" ] || { complain "$*: exit code: found $code, expected $wanted"; cat "$out"; }
  printf '%s\n' "$text" | while IFS= read -r line; do
    [ -z "$line" ] || grep -qF -- "$line" "$out" || printf '%s\n' "$line"
  done >"$work/missing"
  [ ! -s "$work/missing" ] || { complain "$*: output: expected \"$(cat "$work/missing")\", found:"; cat "$out"; }
}
run() { /usr/lib/wine/wine64 "$@"; }
expect_run() {
  wanted_of_run=$1
  text_of_run=$2
  shift 2
  expect "$wanted_of_run" "$text_of_run" /usr/lib/wine/wine64 "$@"
}
tool=$stage/bin/ticktrue.exe

# packed: Linux recordings with packed checkpoints match, or are refused by a build without zstd.
packed() {
  wanted_text=$1
  shift
  if [ "$has_zstd" = yes ]; then expect_run 0 "$wanted_text" "$@"; else expect_run 5 "use a build with zstd" "$@"; fi
}

cd "$work" || exit 2
run cmd /c exit >/dev/null 2>&1 # creates the folder of wine
cp "$stage/bin/ticktrue.dll" .
has_zstd=$(run "$tool" env 2>/dev/null | sed -n 's/.*zstd \([a-z]*\),.*/\1/p')
case $has_zstd in
  yes | no) ;;
  *) complain "ticktrue env: zstd: found \"$has_zstd\", expected yes or no" ;;
esac

# --- what the files need and give ------------------------------------------------------------------------------------
for file in ticktrue.exe ticktrue.dll; do
  x86_64-w64-mingw32-objdump -p "$stage/bin/$file" >parts
  others=$(sed -n 's/^[[:space:]]*DLL Name: //p' parts |
    grep -vixE 'kernel32\.dll|msvcrt\.dll|user32\.dll|advapi32\.dll|shell32\.dll|ws2_32\.dll' | tr '\n' ' ')
  [ -z "$others" ] || complain "$file: needs $others, expected libraries of Windows alone"
done
names=$(sed -n '/\[Ordinal\/Name Pointer\] Table/,/^$/s/^[[:space:]]*\[[ 0-9]*\] //p' parts)
count=$(printf '%s\n' "$names" | grep -c '^ticktrue_')
others=$(printf '%s\n' "$names" | grep -v '^ticktrue_' | tr '\n' ' ')
[ -z "$others" ] || complain "ticktrue.dll: exported names: found $others, expected ticktrue_* alone"
declared=$(grep -cE '^TICKTRUE_API ' "$stage/include/ticktrue.h")
[ "$count" = "$declared" ] || complain "ticktrue.dll: exported names: found $count, expected the $declared of ticktrue.h"

# --- examples against the staged folder ------------------------------------------------------------------------------
flags="-O2 -ffp-contract=off -I$stage/include"
examples=$source/examples
for example in lockstep rollback; do
  # shellcheck disable=SC2086 # flags are words
  expect 0 "" "$cc" -std=c99 $flags "$examples/$example.c" -o $example.exe -L"$stage/lib" -lticktrue
  # shellcheck disable=SC2086
  expect 0 "" cc -std=c99 $flags "$examples/$example.c" -o $example "$linux/libticktrue.so" -Wl,-rpath,"$linux"
done
# shellcheck disable=SC2086
expect 0 "" "$cxx" -std=c++20 $flags "$examples/units.cpp" -static -o units.exe "$stage/lib/libticktrue.dll.a"
# shellcheck disable=SC2086
expect 0 "" c++ -std=c++20 $flags "$examples/units.cpp" -o units "$linux/libticktrue.so" -Wl,-rpath,"$linux"
# shellcheck disable=SC2086
expect 0 "" "$cc" -std=c99 $flags -shared "$examples/plugin_pendulum.c" -o plugin_pendulum.dll

# --- sessions: green and red, here and there -------------------------------------------------------------------------
expect_run 0 "recorded  lockstep.ttr  600 ticks" ./lockstep.exe --record lockstep.ttr
expect_run 0 "match  lockstep.ttr  600 of 600 ticks compared" ./lockstep.exe --verify lockstep.ttr
red='diverged  lockstep.ttr  tick 
balls.velocity
expected 
got 
1 ulp'
expect_run 1 "$red" ./lockstep.exe --verify lockstep.ttr --bug order
grep -E '^ +(tick|column|columns|value|row|balls)' "$out" | tr -d '\r' >red_here
expect 0 "match  lockstep.ttr  600 of 600 ticks compared" ./lockstep --verify lockstep.ttr
expect 1 "$red" ./lockstep --verify lockstep.ttr --bug order
grep -E '^ +(tick|column|columns|value|row|balls)' "$out" >red_there
[ -s red_here ] && cmp -s red_here red_there || { complain "lockstep: the place of the divergence: wine and Linux differ"; diff red_here red_there; }
expect_run 2 "use --force to replace it" ./lockstep.exe --record lockstep.ttr
expect_run 0 "recorded  lockstep.ttr" ./lockstep.exe --record lockstep.ttr --force
[ ! -e lockstep.ttr.old ] || complain "lockstep --force: found lockstep.ttr.old, expected it to be removed"
expect 0 "recorded  from_linux.ttr" ./lockstep --record from_linux.ttr
packed "match  from_linux.ttr  600 of 600 ticks compared" ./lockstep.exe --verify from_linux.ttr
expect 0 "" "$linux/ticktrue" diff from_linux.ttr lockstep.ttr
packed "" "$tool" diff from_linux.ttr lockstep.ttr

expect_run 0 "recorded  units.ttr  300 ticks" ./units.exe --record units.ttr
expect_run 0 "match  units.ttr  300 of 300 ticks compared" ./units.exe --verify units.ttr
expect_run 1 "tick 150 of 300
units.hp          row 3 (id 4)" ./units.exe --verify units.ttr --fault
expect_run 0 "restore: 300 ticks ran twice" ./units.exe --verify units.ttr --mode restore
expect_run 0 "match" ./units.exe --verify units.ttr --from 200
expect 0 "match  units.ttr  300 of 300 ticks compared" ./units --verify units.ttr
expect 0 "recorded  units_linux.ttr" ./units --record units_linux.ttr
packed "match  units_linux.ttr  300 of 300 ticks compared" ./units.exe --verify units_linux.ttr
expect_run 0 "recorded  rollback.ttr  600 ticks" ./rollback.exe --record rollback.ttr
expect_run 0 "match  rollback.ttr  600 of 600 ticks compared" ./rollback.exe --verify rollback.ttr
expect 0 "match  rollback.ttr  600 of 600 ticks compared" ./rollback --verify rollback.ttr

# --- a program for the binary interface of MSVC, by clang and lld ----------------------------------------------------
if [ -f "$stage/lib/ticktrue.lib" ] && command -v clang-19 >/dev/null 2>&1 && command -v lld-link-19 >/dev/null 2>&1; then
  expect 0 "" clang-19 --target=x86_64-pc-windows-msvc -std=c11 -ffreestanding -Wall -Wextra -Werror -O2 -ffp-contract=off \
    -fno-builtin -I"$stage/include" -c "$source/tests/windows/msvc_session.c" -o msvc_session.obj
  expect 0 "" lld-link-19 /machine:x64 /subsystem:console /entry:start /nodefaultlib /out:msvc_session.exe msvc_session.obj \
    "$stage/lib/ticktrue.lib" "$(x86_64-w64-mingw32-gcc-posix -print-file-name=libkernel32.a)"
  expect_run 0 "recorded  msvc.ttr  100 ticks
match  msvc.ttr  100 of 100 ticks compared
diverged  msvc.ttr
ball.height" ./msvc_session.exe
  # Parses the compiler-specific code of libticktrue with clang for MSVC and for Apple, including lines for MSVC only.
  for target in x86_64-pc-windows-msvc aarch64-pc-windows-msvc arm64-apple-macos13; do
    expect 0 "" clang++-19 --target=$target -std=c++20 -ffreestanding -Wall -Wextra -Werror -Wno-pragma-once-outside-header \
      -fsyntax-only -x c++ "$source/base/compiler/compiler.h"
  done
  expect 0 "" clang++-19 --target=x86_64-pc-windows-msvc -U__clang__ -std=c++20 -ffreestanding -Wall -Wextra -Werror \
    -Wno-pragma-once-outside-header -fsyntax-only -x c++ "$source/base/compiler/compiler.h"
else
  echo "windows: no ticktrue.lib, clang-19 or lld-link-19: the program for MSVC's binary interface is left out"
fi

# --- the tool: traces of the engine, both ways -----------------------------------------------------------------------
expect_run 0 "300 ticks" "$tool" record 'mixed_pile?bodies=40' --ticks 300 --detail full:100..120 --checkpoint-interval 60 -o pile.ttr
expect_run 0 "match  pile.ttr  300 of 300 ticks compared" "$tool" verify pile.ttr
expect_run 0 "match  pile.ttr" "$tool" verify pile.ttr --mode restore
expect_run 0 "match  pile.ttr" "$tool" verify pile.ttr -j 2
expect 0 "match  pile.ttr  300 of 300 ticks compared" "$linux/ticktrue" verify pile.ttr
expect 0 "match  pile.ttr" "$linux/ticktrue" verify pile.ttr --mode restore
expect 0 "300 ticks" "$linux/ticktrue" record 'mixed_pile?bodies=40' --ticks 300 --detail full:100..120 --checkpoint-interval 60 --no-compress -o there.ttr
expect_run 0 "match  there.ttr  300 of 300 ticks compared" "$tool" verify there.ttr
expect_run 0 "match  there.ttr" "$tool" verify there.ttr --mode restore
expect_run 0 "" "$tool" diff pile.ttr there.ttr
expect_run 0 "\"passed\": 3" "$tool" inject pile.ttr --count 3 --seed 1 --json
cp "$source/traces/thesis_f32.ttr" golden.ttr 2>/dev/null || cp "$(find "$source/traces" -maxdepth 1 -name '*.ttr' | head -n 1)" golden.ttr
expect_run 0 "match" "$tool" verify golden.ttr
head -c 30000 pile.ttr >cut.ttr
expect_run 3 "incomplete" "$tool" verify cut.ttr
expect_run 0 "" "$tool" recover cut.ttr -o whole.ttr
expect 0 "match" "$linux/ticktrue" verify whole.ttr
expect_run 0 "" "$tool" report pile.ttr -o page.html
expect_run 0 "" "$tool" report pile.ttr -o page.html --force

# --- paths -----------------------------------------------------------------------------------------------------------
mkdir 'größe 日本 дом'
expect_run 0 "60 ticks" "$tool" record stack --ticks 60 -o 'größe 日本 дом\spiel 1.ttr'
[ -f 'größe 日本 дом/spiel 1.ttr' ] || complain "record: found no file of the name that was given"
expect_run 0 'größe 日本 дом\spiel 1.ttr  60 of 60 ticks compared' "$tool" verify 'größe 日本 дом\spiel 1.ttr'
expect_run 0 "match" "$tool" verify "Z:$(printf '%s' "$work" | tr / '\\')\\größe 日本 дом\\spiel 1.ttr"
expect_run 0 "60 ticks" "$tool" record stack --ticks 60 --force -o 'größe 日本 дом\spiel 1.ttr'
expect_run 2 "cannot create" "$tool" record stack --ticks 60 -o 'kein Ordner 日本\x.ttr'
expect_run 2 "check the spelling" "$tool" verify 'größe 日本 дом\fehlt.ttr'
expect_run 0 "" "$tool" scenes --random 7 --bodies-max 20 --ticks-max 60 -o 'größe 日本 дом\szene 日.json'
expect_run 0 '"ticks": 30' "$tool" record 'größe 日本 дом\szene 日.json' --ticks 30 --json -o 'größe 日本 дом\aus datei.ttr'
# The arguments of a C program are in the code page of the system (here 1252). Characters of this code page arrive
# intact.
expect_run 0 "600 ticks" ./lockstep.exe --record 'größe 1.ttr'
[ -f 'größe 1.ttr' ] || complain "lockstep --record größe 1.ttr: found no file of that name"
expect_run 0 "match" ./lockstep.exe --verify 'größe 1.ttr'
expect 0 "match" ./lockstep --verify 'größe 1.ttr'

# --- line ends -------------------------------------------------------------------------------------------------------
sed "s/\$/$carriage_return/" "$source/traces/thesis_mouse.jsonl" >crlf.jsonl
expect_run 0 "180 ticks" "$tool" record thesis --inputs crlf.jsonl --ticks 180 -o crlf.ttr
cp "$source/traces/thesis_mouse.jsonl" lf.jsonl
expect 0 "180 ticks" "$linux/ticktrue" record thesis --inputs lf.jsonl --ticks 180 --no-compress -o lf.ttr
expect_run 0 "" "$tool" diff crlf.ttr lf.ttr
run "$tool" scenes stack --print >here.json 2>/dev/null
"$linux/ticktrue" scenes stack --print >there.json
cmp -s here.json there.json || complain "scenes stack: standard output: expected the same bytes as on Linux"
sed "s/\$/$carriage_return/" there.json >crlf.json
expect_run 0 "30 ticks" "$tool" record crlf.json --ticks 30 -o crlf_scene.ttr
expect 0 "match" "$linux/ticktrue" verify crlf_scene.ttr
if grep -q "$carriage_return" page.html; then complain "report: found a carriage return in the page"; fi
run "$tool" show crlf.ttr --inputs >inputs_here 2>/dev/null
"$linux/ticktrue" show lf.ttr --inputs >inputs_there
cmp -s inputs_here inputs_there || complain "show --inputs: expected the same bytes as on Linux"
expect_run 0 "180 ticks" "$tool" record thesis --inputs - --ticks 180 -o from_pipe.ttr <crlf.jsonl
expect_run 0 "" "$tool" diff from_pipe.ttr lf.ttr

# --- plug-ins run inside of the tool, and it says so -----------------------------------------------------------------
plugin='.\plugin_pendulum.dll'
expect_run 0 "300 ticks
runs in the process of ticktrue" "$tool" record 8 --plugin "$plugin" --ticks 300 --detail full -o chain.ttr
for mode in replay restore twice; do
  expect_run 0 "match  chain.ttr  300 of 300 ticks compared" "$tool" verify chain.ttr --plugin "$plugin" --mode $mode
done
TICKTRUE_EXAMPLE_FAULT=drift
export TICKTRUE_EXAMPLE_FAULT
expect_run 1 "tick 100 of 300
links." "$tool" verify chain.ttr --plugin "$plugin"
unset TICKTRUE_EXAMPLE_FAULT
expect_run 2 "cannot be loaded" "$tool" verify chain.ttr --plugin no_such.dll
expect_run 2 "found no function ticktrue_plugin_entry" "$tool" verify chain.ttr --plugin ticktrue.dll
expect 0 "" cc -O2 -ffp-contract=off -I"$stage/include" -shared -fPIC "$examples/plugin_pendulum.c" -o plugin_pendulum.so
expect 0 "match  chain.ttr  300 of 300 ticks compared" "$linux/ticktrue" verify chain.ttr --plugin ./plugin_pendulum.so

# --- one recorder a file ---------------------------------------------------------------------------------------------
mkfifo held
run "$tool" record thesis --inputs - --force -o held.ttr <held >/dev/null 2>&1 &
holder=$!
exec 3>held
waited=0
while [ ! -e held.ttr ] && [ "$waited" -lt 100 ]; do sleep 0.1 && waited=$((waited + 1)); done
expect_run 2 "another process is recording to it" "$tool" record stack --ticks 30 --force -o held.ttr
exec 3>&-
wait "$holder"
holder=
rm -f held held.ttr

# --- black boxes -----------------------------------------------------------------------------------------------------
expect_run 0 "a black box: it holds ticks" ./units.exe --blackbox box.ttb
expect_run 0 "recovered  box.ttr" "$tool" recover box.ttb -o box.ttr
expect_run 0 "match  box.ttr" ./units.exe --verify box.ttr
expect 0 "recovered  box_there.ttr" "$linux/ticktrue" recover box.ttb -o box_there.ttr
expect 0 "match  box_there.ttr" ./units --verify box_there.ttr

# --- what needs Linux says so ----------------------------------------------------------------------------------------
for command in shake trail unsaved campaign bisect; do
  expect_run 2 "$command: runs on Linux: found a build for x86_64 windows" "$tool" $command lockstep.ttr -- ./lockstep.exe --verify '{trace}'
done
expect_run 2 "cannot start other programs" "$tool" verify lockstep.ttr --command './lockstep.exe --verify {}'

if [ "$failures" != 0 ]; then
  echo "windows: $failures failed"
  exit 1
fi
echo "windows: all passed"
