#!/bin/sh
# columns.sh TOOL SOURCE LIBRARY: runs `ticktrue columns` on programs of each available compiler. The printed line
# compiles with ticktrue.hpp, and the program records and verifies. Damaged files give a message.
# SPDX-License-Identifier: MIT
set -u
full_path() { printf '%s/%s' "$(cd "$(dirname "$1")" && pwd)" "$(basename "$1")"; }
tool=$(full_path "$1")
source=$(cd "$2" && pwd) || exit 2
library=$(full_path "$3")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
failures=0
count=0

complain() {
  printf 'columns: error: %s\n' "$1"
  failures=$((failures + 1))
}
# expect EXIT TEXT COMMAND...: the command ends with EXIT and prints TEXT.
expect() {
  wanted=$1
  text=$2
  shift 2
  count=$((count + 1))
  "$@" >out 2>&1
  code=$?
  [ "$code" = "$wanted" ] || { cat out; complain "$*: exit code: found $code, expected $wanted"; }
  grep -qF -- "$text" out || { cat out; complain "$*: expected \"$text\""; }
}

cat >structs.h <<'UNIT'
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>
namespace game {
struct Vec2 { float x, y; };
struct Vec3 { union { double x, r; }; union { double y, g; }; union { double z, b; }; };
enum class Team : std::uint8_t { red, blue };
struct Slot { std::uint16_t item; bool is_used; std::int32_t count; };
struct Odd { float x; double y; };
struct Item { std::uint16_t kind; std::string label; };
struct Base { std::uint32_t id; };
struct Unit : Base {
  Vec2 pos; Vec3 far; Team team; bool is_alive; std::int16_t hp; double wear[3]; std::array<std::int64_t, 2> score;
  Slot hand; std::array<Slot, 2> bag; Odd odd; Vec2 corners[2]; Unit* target; std::string name; std::vector<int> list;
  std::vector<Item> items; std::vector<int*> pointers; std::vector<bool> flags; std::vector<Unit> crowd;
  std::unique_ptr<int> owner; std::map<int, int> tree; long double wide; unsigned bits : 3;
  union { int as_int; float as_float; }; struct { int inner; }; char label[8]; float many[256];
  struct Nested { std::uint8_t a; std::uint64_t b; } nested;
  std::uint8_t last; static int made;
};
inline int Unit::made = 0;
class Counter {
 public:
  int step() { return ++ticks_; }
 private:
  int ticks_ = 0;
  friend struct Columns;
};
template <class A, class B> struct Pair { A first; B second; };
}
namespace ui { struct Unit { int width; std::uint8_t depth; }; }
UNIT
cat >program.cpp <<'UNIT'
#include "structs.h"
#include <cstdio>
int main() {
  game::Unit unit{};
  ui::Unit widget{1, 2};
  game::Counter counter;
  game::Pair<int, double> pair{1, 2};
  std::printf("%u %d %d %d\n", unit.id, widget.width, counter.step(), pair.first);
}
UNIT
cat >expected <<'LINES'
namespace game {
TICKTRUE_COLUMNS(Slot, item, is_used, count)
//   padding   bytes 3 of 8, in no trace
TICKTRUE_COLUMNS(Odd, x, y)
//   padding   bytes 4..7 of 16, in no trace
TICKTRUE_COLUMNS(Item, kind, label)
//   padding   bytes 2..7 of 40, in no trace
TICKTRUE_COLUMNS(Unit::Nested, a, b)
//   padding   bytes 1..7 of 16, in no trace
TICKTRUE_COLUMNS(Unit, id, pos, far, team, is_alive, hp, wear, score, hand, bag, odd, corners, name, list, items, inner,
    label, nested, last)
//   left out  target    is a pointer or a reference: another address in every run. Use an index or an id
//   left out  pointers  is a list of pointers: other addresses in every run. Use indices or ids
//   left out  flags     is a list of bits, which have no addresses. Use std::vector<std::uint8_t>
//   left out  crowd     is a list of the struct that it is in. Keep indices or ids in it
//   left out  owner     is a pointer or a reference: another address in every run. Use an index or an id
//   left out  tree      is a container whose elements do not lie side by side. Use a std::vector, sorted where the order is not fixed
//   left out  wide      is long double: other bytes on other machines. Use double
//   left out  bits      is a bit-field, which has no address. Use a whole integer
//   left out  as_int    is one of a union: nothing says which member is valid. Keep a value of each beside it
//   left out  as_float  is one of a union: nothing says which member is valid. Keep a value of each beside it
//   left out  many      has more than 255 numbers. Make them rows of a table of their own
LINES
cat >second.cpp <<'UNIT'
#include "structs.h"
#include <ticktrue.hpp>
#include "columns.inc"
int main(int argc, char** argv) {
  std::vector<game::Unit> units(3);
  std::vector<ui::Unit> widgets(2);
  ticktrue::Session session(argc, argv, "columns-test");
  session.table("units", units);
  session.table("widgets", widgets);
  for (int tick = 0; tick < 20; ++tick) {
    if (!session.begin_tick()) break;
    for (game::Unit& unit : units) { unit.pos.x += 1; unit.bag[1].count += tick; unit.nested.b ^= 5; unit.far.z -= 0.5;
      unit.name += "x"; unit.list.push_back(tick); unit.items.push_back({7, unit.name}); }
    if (argc > 3 && tick == 7) units[1].bag[1].count += 1;
    widgets[0].depth = static_cast<std::uint8_t>(tick);
    session.end_tick();
  }
  return session.close();
}
UNIT

if ! "$tool" columns "$tool" x 2>&1 | grep -qF 'build of ticktrue without libdw'; then has_libdw=yes; else has_libdw=no; fi
if [ "$has_libdw" = no ]; then
  expect 2 "install libdw-dev and build anew" "$tool" columns "$tool" x
  [ "$failures" = 0 ] || exit 1
  echo "columns: skipped: no libdw"
  exit 77
fi

for compiler in g++ clang++-14 clang++-19; do
  command -v "$compiler" >/dev/null 2>&1 || continue
  for flags in -gdwarf-4 '-gdwarf-5 -O2' '-gdwarf-5 -fdebug-types-section -gz'; do
    # shellcheck disable=SC2086 # flags are words
    "$compiler" -std=c++20 $flags program.cpp -o program 2>log || { cat log; complain "$compiler $flags: build"; continue; }
    "$tool" columns program game::Unit >lines 2>&1 || { cat lines; complain "$compiler $flags: columns"; }
    count=$((count + 1))
    head -n "$(wc -l <expected)" lines >head
    cmp -s head expected || { diff expected head; complain "$compiler $flags: other lines"; }
  done
  "$tool" columns program ui::Unit >>lines
  cp lines columns.inc
  "$compiler" -std=c++20 -Wall -Wextra -I"$source/include" second.cpp "$library" -Wl,-rpath,"$(dirname "$library")" -o second 2>log ||
    { cat log; complain "$compiler: the printed lines do not compile"; }
  rm -f x.ttr
  expect 0 "recorded  x.ttr  20 ticks" ./second --record x.ttr
  expect 0 "match  x.ttr" ./second --verify x.ttr
  expect 1 "units.bag[1].count" ./second --verify x.ttr --fault
  expect 1 "tick 7 of 20" ./second --verify x.ttr --fault
done

c++ -std=c++20 -g program.cpp -o program && c++ -std=c++20 -g -c program.cpp -o program.o &&
  c++ -std=c++20 -g -fPIC -shared program.cpp -o program.so || complain "build"
for file in program.o program.so; do
  expect 0 "TICKTRUE_COLUMNS(Unit, width, depth)" "$tool" columns "$file" ui::Unit
  expect 0 "game::Counter" "$tool" columns "$file" --list
done
cp program stripped && strip stripped
expect 2 "compile with -g, and do not strip the file" "$tool" columns stripped Unit
expect 2 "struct Unit: found 2: game::Unit (" "$tool" columns program Unit
expect 2 "name it with its namespace" "$tool" columns program Unit
expect 2 "struct Untie: found none of this name" "$tool" columns program Untie
expect 2 "did you mean game::Unit?" "$tool" columns program game::Unti
expect 0 "// friend TICKTRUE_COLUMNS(Counter, ticks_)" "$tool" columns program Counter
expect 0 "using TicktrueRow16 = Pair<int, double>;" "$tool" columns program Pair
expect 0 "TICKTRUE_COLUMNS(TicktrueRow16, first, second)" "$tool" columns program Pair
expect 0 "  offset  size  member" "$tool" columns program ui::Unit --table
expect 0 "       5     3  -       padding" "$tool" columns program ui::Unit --table
expect 0 '"schema": "ticktrue.columns/1"' "$tool" columns program ui::Unit --json
expect 0 '"name": "ui::Unit"' "$tool" columns program --list --json
expect 2 "found no struct, expected its name or --list" "$tool" columns program
expect 2 "found no ELF file that can be read" "$tool" columns program.cpp Unit
expect 2 "No such file" "$tool" columns missing Unit
expect 2 "found no regular file" "$tool" columns . Unit

# Damaged files: truncated, or with bytes overwritten. The random generator has a fixed seed.
size=$(wc -c <program.o)
random() { seed=$(((seed * 1103515245 + 12345) % 2147483648)); value=$((seed / 8 % $1)); }
seed=1
number=0
signals=0
while [ "$number" -lt 40 ]; do
  number=$((number + 1))
  cp program.o damaged
  random "$size"
  if [ $((number % 4)) = 0 ]; then
    head -c "$value" program.o >damaged
  else
    changes=$((number * number % 37 + 1))
    while [ "$changes" -gt 0 ]; do
      changes=$((changes - 1))
      random "$size"
      offset=$value
      random 256
      printf "\\$(printf %o "$value")" | dd of=damaged bs=1 seek="$offset" conv=notrunc 2>/dev/null
    done
  fi
  "$tool" columns damaged game::Unit >out 2>&1
  code=$?
  count=$((count + 1))
  case $code in
    0 | 1) ;;
    2) grep -q '^ticktrue: error: damaged: ' out || { cat out; complain "damaged file $number: no message"; } ;;
    *) cat out; complain "damaged file $number: exit code: found $code, expected 0, 1 or 2" ;;
  esac
  grep -q 'ended with signal' out && signals=$((signals + 1))
done
[ "$failures" = 0 ] || exit 1
echo "columns: $count checks; of 40 damaged files, the reader of $signals ended with a signal"
