#!/bin/sh
# run.sh BUILD: installs that build into a folder of its own, builds examples/ from there alone, and runs each green and red.
# SPDX-License-Identifier: MIT
set -u
build=$(cd "$1" && pwd) || exit 2
source=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix
out=$work/out
failures=0

complain() {
  printf 'examples: error: %s\n' "$1"
  failures=$((failures + 1))
}

# expect EXIT TEXT COMMAND...: the command ends with EXIT and prints TEXT.
expect() {
  wanted=$1
  text=$2
  shift 2
  "$@" >"$out" 2>&1
  code=$?
  [ "$code" = "$wanted" ] || { complain "$*: exit code: found $code, expected $wanted"; cat "$out"; }
  [ -z "$text" ] || grep -qF -- "$text" "$out" || { complain "$*: output: expected \"$text\", found:"; cat "$out"; }
}

# --- install, and build what is outside of this tree -----------------------------------------------------------------
cmake --install "$build" --prefix "$prefix" >"$out" 2>&1 || { cat "$out"; complain "cmake --install"; exit 1; }
cp -r "$source/examples" "$work/examples"
cd "$work" || exit 2
configure() {
  cmake -S examples -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
}
configure >"$out" 2>&1 || { cat "$out"; complain "examples: configuration"; exit 1; }
cmake --build build -j 2 >"$out" 2>&1 || { cat "$out"; complain "examples: build"; exit 1; }
tool=$(find "$prefix" -name ticktrue -type f -perm -u+x)
library=$(find "$prefix" -name 'libticktrue.so' | head -n 1)
cd build || exit 2

if command -v nm >/dev/null 2>&1; then
  others=$(nm -D --defined-only "$library" | awk '$3 !~ /^ticktrue_/ { print $3 }' | head -n 3)
  [ -z "$others" ] || complain "libticktrue.so: exported names: found $others, expected ticktrue_* alone"
fi

# The header is C99 and C++98, and asks nothing of who includes it.
printf '#include <ticktrue.h>\nint main(void) { return ticktrue_api_version() == TICKTRUE_API_VERSION ? 0 : 1; }\n' >header.c
expect 0 "" cc -std=c99 -pedantic -Wall -Wextra -Wstrict-prototypes -Werror -I"$prefix/include" -c header.c -o header.o
expect 0 "" c++ -std=c++98 -pedantic -Wall -Wextra -Werror -I"$prefix/include" -x c++ -fsyntax-only header.c
for example in lockstep rollback udp_lockstep plugin_pendulum; do
  expect 0 "" cc -std=c99 -pedantic -Wall -Wextra -Werror -fsyntax-only -I"$prefix/include" "../examples/$example.c"
done
grep -q 'ffp-contract=off.*lockstep\.c' compile_commands.json || complain "ticktrue::determinism: its flags did not arrive"
grep -q 'ffp-contract=off.*consumer\.cpp' compile_commands.json && complain "consumer: flags it did not ask for arrived"
if command -v pkg-config >/dev/null 2>&1; then
  flags=$(PKG_CONFIG_PATH=$(dirname "$library")/pkgconfig pkg-config --cflags --libs ticktrue) || complain "pkg-config: no ticktrue"
  # shellcheck disable=SC2086 # flags are words
  expect 0 "" cc -std=c99 header.c $flags -Wl,-rpath,"$(dirname "$library")" -o header
  expect 0 "" ./header
fi

# --- a swarm with ticktrue/math.h: recorded by one build, verified by others ------------------------------------------
printf '#include <ticktrue/math.h>\nint main() { return ticktrue::math::sin(0.0f) < 0; }\n' >math.cpp
expect 0 "" c++ -std=c++14 -pedantic -Wall -Wextra -Wshadow -Wconversion -Werror -I"$prefix/include" math.cpp -o math
expect 0 "recorded  swarm.ttr  600 ticks" ./swarm --record swarm.ttr
expect 0 "match  swarm.ttr  600 of 600 ticks compared" ./swarm --verify swarm.ttr
compile_swarm() {
  cc -std=c11 "$@" -I"$prefix/include" ../examples/swarm.c "$library" -Wl,-rpath,"$(dirname "$library")" -o swarm_other
}
for flags in -O0 '-O3 -march=native -ffp-contract=fast' '-O2 -flto'; do
  # shellcheck disable=SC2086 # flags are words
  cc $flags -fsyntax-only header.c -I"$prefix/include" 2>/dev/null || continue # flags that this compiler does not know
  # shellcheck disable=SC2086
  compile_swarm $flags 2>"$out" || { cat "$out"; complain "swarm: $flags: build"; continue; }
  expect 0 "match  swarm.ttr  600 of 600 ticks compared" ./swarm_other --verify swarm.ttr
done

# --- the loop of docs/any_simulation.md ------------------------------------------------------------------------------
block() { awk -v want="$1" '/^```c$/ { n++; on = n == want; next } /^```/ { on = 0 } on' "$source/docs/any_simulation.md"; }
{
  echo '#include <ticktrue.h>'
  block 1 | sed '/^int main(void)/,$d'
  block 2
} >game.c
compile_game() { cc -O2 "$@" -I"$prefix/include" "$library" -Wl,-rpath,"$(dirname "$library")" -o game; }
expect 0 "" compile_game game.c
expect 0 "recorded  game.ttr  600 ticks" ./game --record game.ttr
expect 0 "match  game.ttr  600 of 600 ticks compared" ./game --verify game.ttr
sed 's/-9.8f/-9.81f/' game.c >other.c
expect 0 "" compile_game other.c
expect 1 "balls.vy          row 0" ./game --verify game.ttr
if grep -qw fma /proc/cpuinfo 2>/dev/null && compile_game -mfma game.c 2>/dev/null; then
  expect 1 "expected 3e4cccce (0.20000002).  got 3e4ccccd (0.2).  1 ulp" ./game --verify game.ttr
  expect 0 "" compile_game -mfma -ffp-contract=off game.c
  expect 0 "match  game.ttr" ./game --verify game.ttr
fi

# Each build verifies what it recorded, found by its build id.
mkdir -p builds/9.8 builds/9.81
for gravity in 9.8 9.81; do
  sed "s/-9.8f/-${gravity}f/" game.c >other.c
  expect 0 "" compile_game -Wl,--build-id other.c
  mv game builds/$gravity/game
  expect 0 "recorded" builds/$gravity/game --record "game_$gravity.ttr"
done
expect 1 "1 match, 1 diverged" "$tool" verify game_9.8.ttr game_9.81.ttr --command 'builds/9.8/game --verify {}'
expect 0 "2 traces: 2 match" "$tool" verify game_9.8.ttr game_9.81.ttr --builds builds
expect 0 "recorded by the build builds/9.81/game" "$tool" verify game_9.81.ttr --builds builds --command '{build} --verify {}'
# The build that recorded a trace beside another one: the first agrees with the trace, the other does not.
"$tool" verify game_9.8.ttr --builds builds --command 'builds/9.81/game --verify {}' --against-command '{build} --verify {}' >by_both
[ $? = 1 ] || complain "verify --builds --against-command: expected exit code 1"
grep -q "balls.vy" by_both || { complain "verify --builds --against-command: found no column"; cat by_both; }
rm -r builds/9.8
expect 5 "found none such in builds (1 builds)" "$tool" verify game_9.8.ttr --builds builds
expect 2 "found no program with a build id" "$tool" verify game_9.8.ttr --builds ../examples

# The commands that the document prints, in their order, from an install in ~/ticktrue.
home=$work/home
mkdir -p "$home" "$work/doc"
ln -s "$prefix" "$home/ticktrue"
cp game.c "$work/doc/game.c"
# The first program behind the heading, and what the document says that it prints.
sed -n '/^## C++: five lines$/,$p' "$source/docs/any_simulation.md" >five_lines
awk '/^```cpp$/ { n++; next } /^```/ { if (n) exit } n' five_lines >"$work/doc/units.cpp"
cp lockstep rollback udp_lockstep inventory "$work/doc"
[ ! -f libplugin_pendulum.so ] || cp libplugin_pendulum.so "$work/doc"
library_folder=$(dirname "$library")
sed -n 's/^\$ //p' "$source/docs/any_simulation.md" |
  sed "s|~/ticktrue/lib/pkgconfig|$library_folder/pkgconfig|; s|LD_LIBRARY_PATH=~/ticktrue/lib|LD_LIBRARY_PATH=$library_folder|" >printed
[ "$(wc -l <printed)" -ge 10 ] || complain "any_simulation.md: commands: found $(wc -l <printed), expected 10 or more"
environment=:
is_red=1 # the first run of the game built with -mfma alone
while IFS= read -r command; do
  wanted=0
  case $command in
    export\ *) environment=${command%%  #*}; continue ;; # without what it is for
    *pkg-config*) command -v pkg-config >/dev/null 2>&1 || command=$(printf '%s' "$command" |
      sed "s|\$(pkg-config --cflags ticktrue)|-I$prefix/include|; s|\$(pkg-config[^)]*)|-I$prefix/include -L$library_folder -lticktrue|") ;;
  esac
  case $command in
    *columns*) ! "$tool" columns "$tool" x 2>&1 | grep -q 'without libdw' || continue ;;
    *_fma*) grep -qw fma /proc/cpuinfo 2>/dev/null || continue ;;
  esac
  case $command in
    ./game_fma*) wanted=$is_red is_red=0 ;;
    ./units_fma*) wanted=1 ;;
    "./lockstep --record"*) ;;
    *--bug* | *--fault* | TICKTRUE_EXAMPLE_FAULT=* | "ticktrue diff "* | "ticktrue verify b1.ttr"*) wanted=1 ;;
  esac
  case $command in *' & '*) command="{ $command; code=\$?; wait; exit \$code; }" ;; esac
  expect "$wanted" "" env HOME="$home" PATH="$(dirname "$tool"):$PATH" sh -c "cd '$work/doc' && $environment && $command"
done <printed
if [ "$(uname -m)" = x86_64 ]; then # other machines fuse by themselves
  LD_LIBRARY_PATH=$library_folder "$work/doc/units" --record "$work/doc/v.ttr" >"$out" 2>&1
  is_told() { grep -qF "$1" five_lines && grep -qF "$1" "$out" || { cat "$out"; complain "any_simulation.md: five lines: expected $1"; }; }
  is_told "600 ticks (10.000 s)"
  is_told "hash    8191fa7a62d5f9f9"
  LD_LIBRARY_PATH=$library_folder "$work/doc/inventory" --record "$work/doc/w.ttr" >"$out" 2>&1
  is_told "hash    69aca91c4cc9c0a3"
  LD_LIBRARY_PATH=$library_folder "$work/doc/inventory" --verify "$work/doc/w.ttr" --fault >"$out" 2>&1
  is_told 'expected "Cleo the Rich".  got "Cldo the Rich".  differs at character 2'
  if [ -x "$work/doc/units_fma" ]; then
    LD_LIBRARY_PATH=$library_folder "$work/doc/units_fma" --verify "$work/doc/v.ttr" >"$out" 2>&1
    is_told "tick 33 of 600"
    is_told "columns units.pos"
    is_told "fused: recorded no, here yes (changes bits)"
  fi
fi

# --- the commands in the first lines of the examples -----------------------------------------------------------------
mkdir -p "$work/headers"
for file in lockstep rollback udp_lockstep swarm consumer units inventory libplugin_pendulum.so libplugin_box2d.so ../examples/bouncers.py; do
  [ ! -e "$file" ] || cp "$file" "$work/headers"
done
for example in lockstep.c rollback.c udp_lockstep.c swarm.c consumer.cpp units.cpp inventory.cpp plugin_pendulum.c plugin_box2d.cpp bouncers.py; do
  # Of "//   COMMAND   what it does" the command.
  sed -n '1,/^[^/#]/s%^\(//\|#\)   \([^ ].*\)$%\2%p' "../examples/$example" | sed 's/  .*//' >printed
  [ -s printed ] || complain "$example: found no command in its first lines, expected some"
  while IFS= read -r command; do
    case $command in
      *libplugin_box2d*) [ -f libplugin_box2d.so ] || continue ;;
      *python3*) command -v python3 >/dev/null 2>&1 || continue ;;
    esac
    wanted=0
    case $command in *--bug* | *--fault*) wanted=1 ;; esac
    command=$(printf '%s' "$command" | sed "s|PREFIX/lib/libticktrue.so|$library|")
    case $command in *' & '*) command="{ $command; code=\$?; wait; exit \$code; }" ;; esac
    expect "$wanted" "" env PYTHONHASHSEED=1 PATH="$(dirname "$tool"):$PATH" sh -c "cd '$work/headers' && $command"
  done <printed
  rm -f "$work"/headers/*.ttr
done

# --- a lockstep game in C --------------------------------------------------------------------------------------------
lines=$(wc -l <../examples/lockstep.c)
[ "$lines" -lt 150 ] || complain "lockstep.c: lines: found $lines, expected fewer than 150"
expect 0 "score" ./lockstep
expect 0 "recorded  lockstep.ttr  600 ticks" ./lockstep --record lockstep.ttr
expect 2 "use --force to replace it" ./lockstep --record lockstep.ttr
grep -q '^  .*use --force to replace it' "$out" || complain "lockstep --record: the next step: expected on a line of its own"
expect 0 "match  lockstep.ttr  600 of 600 ticks compared" ./lockstep --verify lockstep.ttr
expect 0 "match  lockstep.ttr  600 of 600 ticks compared" ./lockstep_static --verify lockstep.ttr
expect 1 "balls.velocity    row 3, lane 0" ./lockstep --verify lockstep.ttr --bug clock
head -c 100000 lockstep.ttr >cut.ttr
expect 3 "\`ticktrue recover\` makes a complete trace of it" ./lockstep --verify cut.ttr
expect 0 "recovered" "$tool" recover cut.ttr -o saved.ttr
expect 0 "match  saved.ttr" ./lockstep --verify saved.ttr
expect 1 "1 ulp" ./lockstep --verify lockstep.ttr --bug order
expect 1 "  program recorded " ./lockstep --verify lockstep.ttr --bug order
expect 0 "fused no" "$tool" show lockstep.ttr
expect 2 "--bug: found odrer, expected order, clock" ./lockstep --verify lockstep.ttr --bug odrer
expect 5 "schema: balls.padding" ./lockstep --verify lockstep.ttr --bug padding
expect 0 "recorded" ./lockstep --record pointer.ttr --bug pointer
expect 0 "recorded" ./lockstep --record padding.ttr --bug padding
expect 5 "simulation lockstep-example is not available" "$tool" verify lockstep.ttr
expect 5 "--command './PROGRAM --verify {}'" "$tool" verify lockstep.ttr
expect 0 "condition   complete" "$tool" show lockstep.ttr
expect 5 "recorded with lockstep-example, this program is rollback-example" ./rollback --verify lockstep.ttr
# Addresses differ from run to run; where the system does not move them, there is nothing to see.
if ./lockstep --verify pointer.ttr --bug pointer >"$out" 2>&1; then echo "examples: note: addresses are the same in every run here"
else
  expect 1 "look like addresses" ./lockstep --verify pointer.ttr --bug pointer
  expect 1 "balls.padding" ./lockstep --verify padding.ttr --bug padding
fi

# --- a live match: each player writes a bundle, and the tool opens it -------------------------------------------------
udp_port=$((20000 + $$ % 20000))
./udp_lockstep 0 --port $udp_port --record p0.ttr --bundle b0.ttr >/dev/null 2>&1 &
expect 1 "note    bundle b1.ttr: ticks 50..299" ./udp_lockstep 1 --port $udp_port --record p1.ttr --bundle b1.ttr --bug order
wait
expect 0 "match  b0.ttr  250 of 250 ticks compared" "$tool" verify b0.ttr --command './udp_lockstep 0 --verify {}'
expect 1 "diverged  b1.ttr  tick 100 of 250" "$tool" verify b1.ttr --command './udp_lockstep 1 --verify {}'
expect 0 "match  b1.ttr" "$tool" verify b1.ttr --command './udp_lockstep 1 --verify {} --bug order'
for side in 0 1; do
  expect 0 "  players     0, 1; recorded by player $side" "$tool" show "b$side.ttr"
  grep -q '^desync  udp-lockstep  tick 100$' "$out" || complain "show b$side.ttr: expected the desync"
  grep -q '^  column  boats.speed       row 3, lane 1$' "$out" || complain "show b$side.ttr: expected its row"
  grep -q '^  value   player 0: 3f763dd8 .*player 1: 3f763dd9 ' "$out" || complain "show b$side.ttr: expected both values"
  expect 0 '"recorded_by": '$side "$tool" show "b$side.ttr" --json
  "$tool" report "b$side.ttr" -o "b$side.html" >"$out" 2>&1
  grep -q 'player 0: 3f763dd8' "b$side.html" || complain "report b$side.ttr: expected the values of both players"
done
expect 1 "b is a bundle of several players: players 0, 1; recorded by player 1" "$tool" diff b0.ttr b1.ttr
head -c 36000 b0.ttr >cut_bundle.ttr
expect 3 "the file ends" "$tool" show cut_bundle.ttr

# --- rollback --------------------------------------------------------------------------------------------------------
expect 0 "recorded  rollback.ttr  600 ticks" ./rollback --record rollback.ttr
expect 0 "match  rollback.ttr  600 of 600 ticks compared" ./rollback --verify rollback.ttr
expect 1 "fighters.cooldown" ./rollback --verify rollback.ttr --bug unsaved
expect 0 "recorded  unsaved.ttr" ./rollback --record unsaved.ttr --bug unsaved
expect 1 "fighters.cooldown" ./rollback --verify unsaved.ttr
expect 0 "ticks ran twice with the same state" ./rollback --record sync.ttr --sync-test 1
cmp -s sync.ttr rollback.ttr || complain "rollback: a sync test records other bytes"
expect 1 "fighters.cooldown" ./rollback --record forgets.ttr --sync-test 1 --bug unsaved
expect 0 "sync test: " ./rollback --verify rollback.ttr --sync-test 7
expect 0 "ticks ran twice with the same state" ./rollback --verify rollback.ttr --mode restore
expect 0 "match  rollback.ttr  100 of 600 ticks compared" ./rollback --verify rollback.ttr --from 500
expect 0 "match  rollback.ttr  30 of 600 ticks compared" ./rollback --verify rollback.ttr --from 310 --to 339
expect 1 "fighters.cooldown" ./rollback --verify rollback.ttr --mode restore --bug unsaved
expect 2 "--mode: found fast behind it" ./rollback --verify rollback.ttr --mode fast
expect 0 "saves       13" "$tool" show rollback.ttr

# --- the tool runs the program ---------------------------------------------------------------------------------------
expect 0 "2 traces: 2 match" "$tool" verify lockstep.ttr saved.ttr --command './lockstep --verify {}' -j 2
expect 0 "match  rollback.ttr  600 of 600 ticks compared" "$tool" verify rollback.ttr --command ./rollback
expect 0 "30 of 600 ticks compared" "$tool" verify rollback.ttr --command './rollback --verify {} --from 310 --to 339'
expect 3 "\`ticktrue recover\` makes a complete trace of it" "$tool" verify cut.ttr --command ./lockstep
expect 0 "accepted: every tick up to the cut matches" "$tool" verify cut.ttr --command ./lockstep --allow-truncated
# Two runs read the same clock in one of a hundred cases.
"$tool" verify lockstep.ttr --command './lockstep --verify {} --bug clock' >by_clock
case $? in 1 | 6) ;; *) complain "verify --command: a program that reads a clock: found another exit code, expected 6" ;; esac
grep -q "balls.velocity    row 3, lane 0" by_clock || complain "verify --command: a program that reads a clock: found no column"
expect 1 "1 ulp" "$tool" verify lockstep.ttr --command './lockstep --verify {} --bug order'
expect 1 "the program ran twice, with the same result" "$tool" verify lockstep.ttr --command './lockstep --verify {} --bug order'
expect 1 "state_incomplete" "$tool" verify rollback.ttr --command './rollback --verify {} --sync-test 1 --bug unsaved'
expect 5 "recorded with lockstep-example, this program is rollback-example" "$tool" verify lockstep.ttr --command ./rollback
expect 1 '"column": "velocity"' "$tool" verify lockstep.ttr --command './lockstep --verify {} --bug order' --json --report failure.html
[ -s failure.html ] || complain "verify --command --report: found no page"
if ! ./lockstep --verify pointer.ttr --bug pointer >"$out" 2>&1; then
  expect 6 "two runs of the program differ" "$tool" verify pointer.ttr --command './lockstep --verify {} --bug pointer'
fi
# What the tool says of a run is what the program says, line by line.
./lockstep --verify lockstep.ttr --bug order | grep '^diverged\|^  \(column\|value\|hash\|input\|stage\)' >own
"$tool" verify lockstep.ttr --command './lockstep --verify {} --bug order' | grep '^diverged\|^  \(column\|value\|hash\|input\|stage\)' >by_tool
cmp own by_tool || complain "verify --command: found another report than the program prints"

# --- black boxes -----------------------------------------------------------------------------------------------------
expect 0 "a black box: it holds ticks" ./rollback --blackbox r.ttb --box-kib 256
expect 5 "a black box, expected a trace" "$tool" verify r.ttb
expect 0 "recovered  tail.ttr" "$tool" recover r.ttb -o tail.ttr
expect 0 "match  tail.ttr" ./rollback --verify tail.ttr
expect 0 "match  tail.ttr" "$tool" verify tail.ttr --command ./rollback
expect 0 "a black box: it holds ticks" ./units --blackbox u.ttb
expect 0 "recovered  u.ttr" "$tool" recover u.ttb -o u.ttr
expect 0 "match  u.ttr" ./units --verify u.ttr
expect 2 "--box-kib: found nothing behind it" ./rollback --blackbox r2.ttb --box-kib
printf 'xxxxxxxxxx' | dd of=r.ttb bs=1 seek=10 conv=notrunc 2>/dev/null
expect 4 "black box: header: its check does not match" "$tool" recover r.ttb -o none.ttr

# --- programs and plug-ins built with the header of interface version 1 ----------------------------------------------
old=$source/tests/capi/header_1
compile_old() { cc -std=c99 -O2 -ffp-contract=off -I"$old" "$@" -Wl,-rpath,"$(dirname "$library")"; }
expect 0 "" compile_old "$old/rollback.c" "$library" -o rollback_old
expect 0 "match  rollback.ttr  600 of 600 ticks compared" ./rollback_old --verify rollback.ttr
expect 0 "recorded  rollback_old.ttr  600 ticks" ./rollback_old --record rollback_old.ttr
expect 0 "match  rollback_old.ttr" ./rollback --verify rollback_old.ttr
expect 0 "" compile_old "$old/plugin_pendulum.c" -shared -fPIC -o old_pendulum.so
expect 0 "100 ticks" "$tool" record 8 --plugin ./old_pendulum.so --ticks 100 -o old_pendulum.ttr
for mode in replay restore twice; do
  expect 0 "match  old_pendulum.ttr" "$tool" verify old_pendulum.ttr --plugin ./old_pendulum.so --mode "$mode"
  expect 0 "match  old_pendulum.ttr" "$tool" verify old_pendulum.ttr --plugin ./libplugin_pendulum.so --mode "$mode"
done

# --- C++ by find_package ---------------------------------------------------------------------------------------------
expect 0 "recorded  consumer.ttr  120 ticks" ./consumer --record consumer.ttr
expect 0 "match  consumer.ttr" ./consumer --verify consumer.ttr
expect 1 "tick 77 of 120" ./consumer --verify consumer.ttr --fault
expect 1 "tick 77 of 120" ./consumer --verify consumer.ttr --from 60 --fault
expect 0 "sync test: 120 ticks ran twice" ./consumer --record consumer_sync.ttr --sync-test 1
expect 0 "restore: 120 ticks ran twice" ./consumer --verify consumer.ttr --mode restore
expect 0 "20 of 120 ticks compared" ./consumer --verify consumer.ttr --from 100

# --- C++20: a struct named once --------------------------------------------------------------------------------------
expect 0 "" c++ -std=c++20 -pedantic -Wall -Wextra -Wshadow -Wconversion -Werror -fsyntax-only -I"$prefix/include" ../examples/units.cpp
expect 0 "" ./units
expect 0 "recorded  units.ttr  300 ticks" ./units --record units.ttr
expect 0 "match  units.ttr  300 of 300 ticks compared" ./units --verify units.ttr
expect 0 "match  units.ttr  300 of 300 ticks compared" "$tool" verify units.ttr --command './units --verify {}'
expect 1 "units.hp          row 3 (id 4)" "$tool" verify units.ttr --command './units --verify {} --fault'
expect 1 "units.hp          row 3 (id 4)" ./units --verify units.ttr --fault
expect 1 "tick 150 of 300" ./units --verify units.ttr --fault
expect 0 "sync test: 300 ticks ran twice" ./units --record units_sync.ttr --sync-test 5
expect 0 "restore: 300 ticks ran twice" ./units --verify units.ttr --mode restore
expect 0 "100 of 300 ticks compared" ./units --verify units.ttr --from 200

# --- C++20: texts and lists ------------------------------------------------------------------------------------------
expect 0 "" c++ -std=c++20 -pedantic -Wall -Wextra -Wshadow -Wconversion -Werror -fsyntax-only -I"$prefix/include" ../examples/inventory.cpp
expect 0 "recorded  inventory.ttr  200 ticks" ./inventory --record inventory.ttr
expect 0 "match  inventory.ttr  200 of 200 ticks compared" "$tool" verify inventory.ttr --command './inventory --verify {}'
expect 1 "heroes[1].name  (id 2)" ./inventory --verify inventory.ttr --fault
expect 1 "differs at character 2" ./inventory --verify inventory.ttr --fault
expect 1 "heroes[1].name  (id 2)" "$tool" verify inventory.ttr --command './inventory --verify {} --fault'
expect 1 "differs at character 2" "$tool" verify inventory.ttr --command './inventory --verify {} --fault'

# --- Python ----------------------------------------------------------------------------------------------------------
if command -v python3 >/dev/null 2>&1; then
  TICKTRUE_LIBRARY=$library
  export TICKTRUE_LIBRARY
  expect 0 "recorded  bouncers.ttr  300 ticks" python3 ../examples/bouncers.py --record bouncers.ttr
  expect 0 "match  bouncers.ttr" env PYTHONHASHSEED=1 python3 ../examples/bouncers.py --verify bouncers.ttr
  expect 1 "bouncers.velocity" env PYTHONHASHSEED=1 python3 ../examples/bouncers.py --verify bouncers.ttr --bug hash
fi

# --- plug-ins --------------------------------------------------------------------------------------------------------
pendulum=./libplugin_pendulum.so
printf '{"tick": 3, "bytes": "10f0"}\n{"tick": 150, "bytes": "7f"}\n' >inputs.jsonl
expect 0 "300 ticks" "$tool" record 8 --plugin "$pendulum" --ticks 300 --inputs inputs.jsonl --detail full --checkpoint-interval 50 -o pendulum.ttr
expect 0 "ms/tick (mean, without writing)" "$tool" record 8 --plugin "$pendulum" --ticks 9 -o timed.ttr
expect 0 "ms/tick (median)" "$tool" run 8 --plugin "$pendulum" --ticks 300 --inputs inputs.jsonl
for mode in replay restore twice; do
  expect 0 "match  pendulum.ttr" "$tool" verify pendulum.ttr --plugin "$pendulum" --mode "$mode"
done
expect 0 "match  pendulum.ttr" "$tool" --plugin "$pendulum" verify pendulum.ttr --from 120
expect 0 "saves       7, 1400 bytes" "$tool" show pendulum.ttr
expect 0 "plug-in     path ./libplugin_pendulum.so, build " "$tool" show pendulum.ttr
expect 0 "begin with its save, which pendulum-example loads" "$tool" verify pendulum.ttr --plugin "$pendulum" --mode restore
expect 0 "match  pendulum.ttr  300 of 300 ticks compared" "$tool" verify pendulum.ttr --plugin "$pendulum" -j 2
expect 1 "state_incomplete  pendulum.ttr" env TICKTRUE_EXAMPLE_FAULT=unsaved "$tool" verify pendulum.ttr --plugin "$pendulum" --mode restore
expect 1 "links.velocity" env TICKTRUE_EXAMPLE_FAULT=unsaved "$tool" verify pendulum.ttr --plugin "$pendulum" --from 120
expect 0 "match  pendulum.ttr" env TICKTRUE_EXAMPLE_FAULT=unsaved "$tool" verify pendulum.ttr --plugin "$pendulum" -j 1
sed 's/-9\.8125/-9.75/' ../examples/plugin_pendulum.c >other_pendulum.c
expect 0 "" cc -O2 -ffp-contract=off -I"$prefix/include" other_pendulum.c -shared -fPIC -o other_pendulum.so
expect 0 "gives the recorded bits too, in all 300 ticks" "$tool" verify pendulum.ttr --plugin "$pendulum" --against-plugin "$pendulum"
expect 1 "this build gives the recorded bits, ./other_pendulum.so leaves the recording at tick 0" \
  "$tool" verify pendulum.ttr --plugin "$pendulum" --against-plugin ./other_pendulum.so
expect 1 "columns links.angle, links.velocity" "$tool" verify pendulum.ttr --plugin "$pendulum" --against-plugin ./other_pendulum.so
expect 0 "links 4 (pendulum 4)  id 4  angle " "$tool" replay pendulum.ttr --plugin "$pendulum" --ticks 299
expect 0 "\"name\":\"pendulum 7\"" "$tool" replay pendulum.ttr --plugin "$pendulum" --format jsonl --ticks 10..12
expect 0 "" "$tool" diff pendulum.ttr pendulum.ttr --plugin "$pendulum"
expect 0 "20 of 20 flips found" "$tool" inject pendulum.ttr --plugin "$pendulum" --count 20
expect 1 "name \"pendulum 4\"" env TICKTRUE_EXAMPLE_FAULT=drift "$tool" verify pendulum.ttr --plugin "$pendulum"
expect 1 "first stage whose output differs" env TICKTRUE_EXAMPLE_FAULT=drift "$tool" verify pendulum.ttr --plugin "$pendulum"
expect 1 "crashed with SIGSEGV in step of tick 100" env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum"
expect 1 "hangs in step of tick 100: found no end after 1 s" env TICKTRUE_EXAMPLE_FAULT=hang "$tool" verify pendulum.ttr --plugin "$pendulum" --plugin-timeout 1
# How many ticks were compared is told also of a plug-in that ended in the middle.
expect 1 "diverged  pendulum.ttr  100 of 300 ticks compared (1.667 s)" env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum"
expect 1 '"ticks_compared": 100' env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum" --json
expect 1 "80 of 300 ticks compared" env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum" --from 20
expect 1 "100 of 300 ticks compared" env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum" --mode twice
# The scene is the word behind the library, and the commands of reports bring the plug-in along.
expect 0 "300 ticks" "$tool" record --plugin "$pendulum" 8 --ticks 300 -o first.ttr
expect 0 "match  first.ttr" "$tool" verify --plugin "$pendulum" first.ttr
env TICKTRUE_EXAMPLE_FAULT=drift "$tool" verify first.ttr --plugin "$pendulum" >"$out" 2>&1
sed -n 's/^  again   ticktrue //p' "$out" | sed 's/, with the build.*//' >again
[ "$(wc -l <again)" = 2 ] || { complain "again: lines: found $(wc -l <again), expected 2"; cat "$out"; }
while IFS= read -r command; do expect 0 "" sh -c "'$tool' $command"; done <again
expect 0 "match  full.ttr  101 of 101" "$tool" --plugin "$pendulum" verify full.ttr
expect 0 "ran  pendulum-example  300 ticks" "$tool" run first.ttr --plugin "$pendulum"
head -c 20000 first.ttr >first_cut.ttr
expect 2 "ticktrue recover makes a trace that does" "$tool" run first_cut.ttr --plugin "$pendulum"
expect 0 "recovered" "$tool" recover first_cut.ttr -o first_saved.ttr
expect 0 "ran  pendulum-example" "$tool" run first_saved.ttr --plugin "$pendulum"
expect 2 "--inputs: found a trace" "$tool" run first.ttr --plugin "$pendulum" --inputs inputs.jsonl
expect 2 "found simulation lockstep-example, expected pendulum-example" "$tool" run lockstep.ttr --plugin "$pendulum"
# A crash or a hang is one file's finding: those before and behind it are verified.
expect 0 "50 ticks" "$tool" record 8 --plugin "$pendulum" --ticks 50 -o short.ttr
for text in "match  short.ttr" "crashed with SIGSEGV in step of tick 100" "3 traces: 2 match, 1 diverged"; do
  expect 1 "$text" env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify short.ttr pendulum.ttr short.ttr --plugin "$pendulum"
done
expect 1 "2 traces: 1 match, 1 diverged" env TICKTRUE_EXAMPLE_FAULT=hang "$tool" verify pendulum.ttr short.ttr --plugin "$pendulum" --plugin-timeout 1
expect 1 '"reason": "plug-in ./libplugin_pendulum.so: crashed with SIGSEGV in step of tick 100"' env TICKTRUE_EXAMPLE_FAULT=crash "$tool" verify pendulum.ttr --plugin "$pendulum" --json
expect 5 "simulation pendulum-example is not available" "$tool" verify pendulum.ttr
expect 2 "create: refused the setup: number of pendulums" "$tool" run 0 --plugin "$pendulum" --ticks 3
expect 2 "cannot be loaded" "$tool" verify pendulum.ttr --plugin ./missing.so
expect 2 "found no function ticktrue_plugin_entry" "$tool" verify pendulum.ttr --plugin "$library"
if [ -f libplugin_box2d.so ]; then
  box2d=./libplugin_box2d.so
  expect 0 "120 ticks" "$tool" record 6 --plugin "$box2d" --ticks 120 --inputs inputs.jsonl --detail full -o box2d.ttr
  expect 0 "match  box2d.ttr" "$tool" verify box2d.ttr --plugin "$box2d"
  expect 5 "can only be observed" "$tool" verify box2d.ttr --plugin "$box2d" --mode restore
  expect 5 "" "$tool" verify box2d.ttr --plugin "$pendulum"
fi

# --- plug-ins that are wrong -----------------------------------------------------------------------------------------
expect 0 "" cc -std=c99 -pedantic -Wall -Wextra -Werror -shared -fPIC -I"$prefix/include" "$source/tests/examples/bad_plugin.c" -o bad.so
while read -r exit_code fault text; do
  rm -f bad.ttr
  expect "$exit_code" "$text" env TICKTRUE_BAD_PLUGIN="$fault" "$tool" record x --plugin ./bad.so --ticks 5 -o bad.ttr
done <<FAULTS
0 none 5 ticks
2 size struct_size: found 12
2 version interface version: found 99, expected 1..5
2 old it does not work with interface version 5
2 name name: found 0 bytes
2 engine found another one of this name
2 many stages: found 100000
2 missing found a null function
2 loud create: refused the setup: xxx
2 nothing create: found success and no simulation
2 empty state: found no column
2 columns columns: failed
2 stride stride: found 4 bytes, expected at least 8
2 rows column z has 3, column x has 4
2 null pointer: found null
1 late found a new column after the first tick
1 type found another type or lane count than before
1 step step of tick 2: failed: out of fuel
1 stages stages said to be done: found 1, expected 2
1 order stages said to be done
1 beyond stages said to be done
1 infinite column x, lane 0: found a value that is not finite
1 entry crashed with SIGABRT while it was loaded
1 destroy crashed with SIGABRT in destroy
FAULTS

# --- traces as CTest tests -------------------------------------------------------------------------------------------
cd .. || exit 2
configure >"$out" 2>&1 || { cat "$out"; complain "examples: configuration with traces"; }
expect 0 "100% tests passed, 0 tests failed out of 7" ctest --test-dir build
expect 8 "0% tests passed" env TICKTRUE_EXAMPLE_FAULT=drift ctest --test-dir build -R pendulum

[ "$failures" = 0 ] || exit 1
echo "examples: built from the install tree alone, each green and red"
