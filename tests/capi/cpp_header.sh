#!/bin/sh
# cpp_header.sh SOURCE LIBRARY: include/ticktrue.hpp alone, by each compiler there is: no warning, also without exceptions
# and type information; what it refuses, with the message; and two builds of a program, whose facts a report tells.
# SPDX-License-Identifier: MIT
set -u
source=$(cd "$1" && pwd) || exit 2
library=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2
failures=0
count=0

complain() {
  printf 'cpp_header: error: %s\n' "$1"
  failures=$((failures + 1))
}

cat >good.cpp <<'UNIT'
#include <ticktrue.hpp>
namespace game {
struct Vec2 { float x, y; };
struct Slot { std::uint16_t item; bool is_used; };
TICKTRUE_COLUMNS(Slot, item, is_used)
enum class Team : std::uint8_t { red, blue };
struct Base { std::uint32_t id; };
struct Item { int index; std::string label; std::vector<Slot> slots; };
TICKTRUE_COLUMNS(Item, index, label, slots)
struct Unit : Base {
  Vec2 pos; Team team; long wear[3]; std::array<Slot, 2> bag; std::uint32_t target; float glow; int* owner;
  std::string name; std::string_view rank; char label[8]; std::array<char, 4> tag; std::string words[2];
  std::vector<unsigned char> blob; std::vector<Vec2> path; std::vector<Item> items; std::vector<std::string> lines;
  std::vector<std::vector<int>> grid; std::span<const float> view;
};
TICKTRUE_COLUMNS(Unit, key(id), pos.x, pos.y, team, wear, bag, reference(target, "units"), shown(glow), name, rank,
                 text(label), text(tag), words, blob, path, items, lines, grid, view);
template <class T> struct Pair { T first, second; };
template <class T> TICKTRUE_COLUMNS(Pair<T>, first, second)
class Counter {
 public:
  void step() { ++ticks_; }
  friend TICKTRUE_COLUMNS(Counter, ticks_)
 private:
  unsigned ticks_ = 0;
};
}  // namespace game
namespace { struct Local { int a; }; TICKTRUE_COLUMNS(Local, a) }
int main(int argc, char** argv) {
  const bool has_fault = argc > 3;
  std::vector<game::Unit> units(1);
  std::vector<Local> orders(2);
  game::Pair<double> pair{1, 2};
  game::Counter counter;
  Local local{3};
  ticktrue::Options options("cpp-header");
  options.saves(local).set_setup(local);
  ticktrue::Session session(argc, argv, options);
  if (!session.setup(local)) return 3;
  session.table("units", units);
  session.table("pair", pair);
  session.table("counter", counter);
  session.table("local", local);
  for (int tick = 0; tick < 9; ++tick) {
    float dt = 0.5f;
    if (!session.input(orders) || !session.input(local) || !session.begin_tick(dt)) break;
    counter.step();
    pair.second += static_cast<double>(dt);
    if (has_fault && tick == 5) pair.second += 1;
    units[0].bag[1].item++;
    units[0].items.push_back({tick, "item", std::vector<game::Slot>(2)});
    units[0].words[1] += "word";
    session.end_tick();
  }
  return session.close();
}
UNIT

# One bad member a struct: each is refused by its name.
cat >members.cpp <<'UNIT'
#include <ticktrue.hpp>
#include <deque>
#include <map>
#include <optional>
struct Padded { float x; double y; };
struct Unit {
  int id; bool flag; int* pointer; std::unique_ptr<int> owner; int& reference_; std::wstring name; std::deque<int> list;
  std::vector<int*> addresses; std::vector<Padded> pads; std::vector<bool> bits; std::string text_; std::vector<int> ints;
  std::map<int, int> tree; long double wide; float many[256]; Padded padded; std::optional<int> maybe; const char* labels[2];
};
#define BAD(row, member) struct row : Unit {}; TICKTRUE_COLUMNS(row, id, member) TABLE_OF(row)
// Newer compilers refuse where the columns are used.
#define TABLE_OF(row) inline void use(const row&) { ticktrue_columns_of(ticktrue::detail::Of<row>{}, ticktrue::detail::Ignore{}); }
BAD(A, pointer) BAD(B, owner) BAD(C, reference_) BAD(D, name) BAD(E, list) BAD(F, tree) BAD(G, wide) BAD(H, many)
BAD(I, padded) BAD(J, maybe) BAD(K, labels) BAD(L, key(flag)) BAD(M, reference(id, "x"))
BAD(N, addresses) BAD(O, pads) BAD(P, bits) BAD(Q, text(id)) BAD(R, shown(text_)) BAD(S, key(ints))
UNIT
cat >members.txt <<'MESSAGES'
ticktrue: pointer is a pointer or a reference: another address in every run. Use an index or an id
ticktrue: owner is a pointer or a reference: another address in every run. Use an index or an id
ticktrue: reference_ is a pointer or a reference: another address in every run. Use an index or an id
ticktrue: name is text of wide characters: other bytes on other machines. Use UTF-8 in a std::string
ticktrue: list is a container whose elements do not lie side by side. Use a std::vector, sorted where the order is not fixed
ticktrue: tree is a container whose elements do not lie side by side. Use a std::vector, sorted where the order is not fixed
ticktrue: addresses is a list of pointers: other addresses in every run. Use indices or ids
ticktrue: pads is a list whose elements have no columns. Write TICKTRUE_COLUMNS for the element before this line
ticktrue: bits is a container whose elements do not lie side by side
ticktrue: text(id): is no array of char; a std::string needs no word around it
ticktrue: shown(text_): is a text or a list, which is always compared: leave it out
ticktrue: key(ints): is no unsigned integer
ticktrue: wide is long double: other bytes on other machines. Use double
ticktrue: many has more than 255 numbers. Make them rows of a table of their own
ticktrue: padded is a struct without columns, or has padding. Write TICKTRUE_COLUMNS for it before this line
ticktrue: maybe is a struct without columns, or has padding. Write TICKTRUE_COLUMNS for it before this line
ticktrue: labels is a pointer or a reference: another address in every run. Use an index or an id
ticktrue: key(flag): is no unsigned integer
ticktrue: reference(id, ...): is no std::uint32_t
MESSAGES
cat >calls.cpp <<'UNIT'
#include <ticktrue.hpp>
#include <deque>
struct None { int a; };
struct Padded { float x; double y; };
struct Late { unsigned a, b; };
TICKTRUE_COLUMNS(Late, a, key(b))
struct Wide { Late many[200]; };
TICKTRUE_COLUMNS(Wide, many)
struct Base { unsigned a; };
TICKTRUE_COLUMNS(Base, a)
struct Derived : Base { unsigned b; };  // not the columns of its base
struct Mat { float at[4]; int more; };
template <> struct ticktrue::lanes<Mat> : ticktrue::lanes_of<float, 4> {};
struct HasMat { Mat mat; };
TICKTRUE_COLUMNS(HasMat, mat)
struct Named { std::string name; };
TICKTRUE_COLUMNS(Named, name)
struct Node { int id; std::vector<Node> nodes; };
TICKTRUE_COLUMNS(Node, id, nodes)
struct Glow { int id; float glow; };
TICKTRUE_COLUMNS(Glow, id, shown(glow))
struct HasGlow { int id; std::vector<Glow> glows; };
TICKTRUE_COLUMNS(HasGlow, id, glows)
void calls(ticktrue::Session& session, std::vector<None>& none, std::vector<None*>& pointers, std::deque<int>& deque,
           std::vector<Late>& late, std::vector<Wide>& wide, std::vector<Derived>& derived, Padded& padded,
           std::vector<Named>& named, std::vector<Node>& nodes, std::vector<HasGlow>& glows) {
  session.table("a", none);
  session.table("b", pointers);
  session.table("c", deque);
  session.table("d", late);
  session.table("e", wide);
  session.table("f", derived);
  session.table("g", std::vector<int>{1});
  session.table("h", named);
  session.table("i", nodes);
  session.table("j", glows);
  session.input(named[0]);
  session.input(padded);
  const int fixed = 1;
  session.input(fixed);
  int captured = 0;
  ticktrue::Options("x").saves(captured, [&](const int&) { return std::string(1, char(captured)); },
                               [](int&, std::span<const std::byte>) { return true; });
  ticktrue::Options("x").saves(none);
}
UNIT
cat >calls.txt <<'MESSAGES'
ticktrue: table: the rows have no columns: write TICKTRUE_COLUMNS(Row, members...) beside the struct; `ticktrue columns PROGRAM Row` prints that line
ticktrue: table: the rows are pointers: copy what they point to into a std::vector before end_tick
ticktrue: table: the rows do not lie side by side: copy them into a std::vector before end_tick
ticktrue: TICKTRUE_COLUMNS: key(...) members come first
ticktrue: table: more than 256 columns: make two tables of them
ticktrue: table: the session keeps the address of the container: give it a name
ticktrue: table: the rows have texts and lists alone: add a number to TICKTRUE_COLUMNS, as an id
ticktrue: a list holds itself, or lists that are nested more than 8 times
ticktrue: the elements of a list have a shown(...) member: leave it out
ticktrue: input: has padding, pointers or no fixed size: write TICKTRUE_COLUMNS for the struct
ticktrue: input: a verification replaces the value: it is not const
ticktrue: saves: the lambdas capture nothing: they are given the state
ticktrue: saves: the state is more than one block of memory: give the lambdas save and load
ticktrue: lanes: the type has other bytes beside these numbers: padding, or further members
MESSAGES

# refuses FILE COMPILER: it does not compile, and each of the messages is there.
refuses() {
  "$2" -std=c++20 -I"$source/include" -fsyntax-only "$1.cpp" >log 2>&1 && complain "$2: $1.cpp: compiles"
  while IFS= read -r message; do
    count=$((count + 1))
    grep -qF -- "$message" log || { complain "$2: $1.cpp: found no \"$message\" in:"; grep error: log; }
  done <"$1.txt"
}

warnings='-Wall -Wextra -Wconversion -Wsign-conversion -Wshadow -Wpedantic -Wdouble-promotion -Wold-style-cast -Werror'
for compiler in g++ clang++-14 clang++-19; do
  command -v "$compiler" >/dev/null 2>&1 || continue
  for flags in '' '-fno-exceptions -fno-rtti -O2'; do
    # shellcheck disable=SC2086 # flags are words
    "$compiler" -std=c++20 $warnings $flags -I"$source/include" -fsyntax-only good.cpp >log 2>&1 ||
      { cat log; complain "$compiler $flags: expected no warning"; }
    count=$((count + 1))
  done
  refuses members "$compiler"
  refuses calls "$compiler"
  [ "$(grep -c 'the rows have no columns' log)" -ge 2 ] || complain "$compiler: a derived struct took the columns of its base"
done
[ "$count" -gt 0 ] || { echo "cpp_header: skipped: no compiler"; exit 77; }

# Two builds of one program.
compile() {
  program=$1
  shift
  c++ -std=c++20 "$@" -I"$source/include" good.cpp "$library" -Wl,-rpath,"$(dirname "$library")" -o "$program" 2>log || { cat log; complain "$*"; }
}
compile plain -O2 -fno-exceptions -fno-rtti
compile fast -O2 -ffast-math '-DTICKTRUE_UNIT_FLAGS="-O2 -ffast-math"'
./plain --record x.ttr >log 2>&1 || { cat log; complain "plain: record"; }
./fast --verify x.ttr >log 2>&1 || { cat log; complain "fast: verify"; }
./fast --verify x.ttr --fault >log 2>&1
for text in 'tick 5 of 9' 'fast_math: recorded no, here yes (changes bits)' 'columns pair.second'; do
  grep -qF -- "$text" log || { cat log; complain "fast: expected \"$text\""; }
  count=$((count + 1))
done
[ "$failures" = 0 ] || exit 1
echo "cpp_header: $count checks"
