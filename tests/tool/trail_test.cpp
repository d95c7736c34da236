// Two lists of marks: the first difference, and the number of marks from each function.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/catch.h"
#include "tool/experiment/trail/mark_lists.h"

namespace ticktrue::test {
namespace {

using trail::FirstKind;
using trail::MarkSide;

/// A mark: name, value, and functions from the innermost outwards.
struct MadeMark {
  std::string name;
  std::uint64_t value = 0;
  std::vector<std::string> functions = {};
};

MarkSide side_with(const std::vector<MadeMark>& marks, bool has_stacks = true) {
  MarkSide side;
  for (const MadeMark& mark : marks) {
    auto& names = side.list.names;
    auto found = std::find(names.begin(), names.end(), mark.name);
    if (found == names.end()) found = names.insert(found, mark.name);
    side.list.marks.push_back({static_cast<std::uint32_t>(found - names.begin()), mark.value});
    if (!has_stacks) continue;
    std::vector<shake::CallSite> stack;
    for (const std::string& function : mark.functions) {
      shake::CallSite site;
      site.function = function + "(int)";
      stack.push_back(site);
    }
    side.of_marks.push_back(static_cast<std::uint32_t>(side.stacks.size()));
    side.stacks.push_back(stack);
  }
  return side;
}

}  // namespace

TEST_CASE("one more draw is the first difference, though all values behind it are others", "[tool][trail][injection]") {
  // The generator gives 10, 11, 12, ... to any caller.
  const MarkSide there = side_with({{"rand", 10, {"Scatter", "update"}},
                                    {"rand", 11, {"Shuffle", "update"}},
                                    {"rand", 12, {"Drop", "update"}},
                                    {"rand", 13, {"Drop", "update"}}});
  const MarkSide here = side_with({{"rand", 10, {"Scatter", "update"}},
                                   {"rand", 11, {"Shuffle", "update"}},
                                   {"rand", 12, {"Shuffle", "update"}},
                                   {"rand", 13, {"Drop", "update"}},
                                   {"rand", 14, {"Drop", "update"}}});
  const trail::ListDifference more = compare_lists(here, &there, {"rand"});
  REQUIRE(more.first);
  CHECK(more.first->kind == FirstKind::extra);
  CHECK(more.first->index == 2);
  CHECK(more.first->here->stack[0].name() == "Shuffle");
  REQUIRE(more.callers.size() == 1);
  CHECK(more.callers[0].caller == "Shuffle");
  CHECK(more.callers[0].here == 2);
  CHECK(more.callers[0].there == 1);
  const trail::ListDifference fewer = compare_lists(there, &here, {"rand"});
  REQUIRE(fewer.first);
  CHECK(fewer.first->kind == FirstKind::missing);
  CHECK(fewer.first->there->value == 12);
  CHECK(fewer.callers[0].here == 1);

  // If the other side has no stacks, the order is compared in the same way, and the callers of this side are named.
  const trail::ListDifference alone = compare_lists(here, nullptr, {"rand"});
  CHECK_FALSE(alone.first);
  CHECK_FALSE(alone.compares_callers);
  REQUIRE(alone.callers.size() == 3);
  for (const trail::CallerCount& caller : alone.callers) CHECK_FALSE(caller.there);
  MarkSide no_stacks = there;
  no_stacks.stacks.clear();
  no_stacks.of_marks.clear();
  const trail::ListDifference by_value = compare_lists(here, &no_stacks, {"rand"});
  REQUIRE(by_value.first);
  CHECK(by_value.first->index == 4);
  CHECK(by_value.first->kind == FirstKind::extra);
}

TEST_CASE("a function that makes all marks of a name is passed by", "[tool][trail][injection]") {
  const MarkSide there =
      side_with({{"rand", 1, {"draw", "Scatter", "main"}}, {"rand", 2, {"draw", "Shuffle", "main"}}});
  const MarkSide here = side_with({{"rand", 1, {"draw", "Scatter", "main"}},
                                   {"rand", 2, {"draw", "Shuffle", "main"}},
                                   {"rand", 3, {"draw", "Shuffle", "main"}}});
  const trail::ListDifference found = compare_lists(here, &there, {"rand"});
  REQUIRE(found.callers.size() == 1);
  CHECK(found.callers[0].caller == "draw < Shuffle");
  // If all stacks are the same, the innermost function is named.
  const MarkSide one = side_with({{"rand", 1, {"draw", "Shuffle", "main"}}});
  const MarkSide two = side_with({{"rand", 1, {"draw", "Shuffle", "main"}}, {"rand", 2, {"draw", "Shuffle", "main"}}});
  CHECK(compare_lists(two, &one, {"rand"}).callers[0].caller == "draw");
}

TEST_CASE("marks that are the same by chance do not hide which side lacks some", "[tool][trail][injection]") {
  const MarkSide there = side_with({{"x"}, {"m"}, {"n"}, {"a"}, {"m"}, {"c"}, {"d"}, {"e"}, {"f"}}, false);
  const MarkSide here = side_with({{"x"}, {"a"}, {"m"}, {"c"}, {"d"}, {"e"}, {"f"}}, false);
  const trail::ListDifference fewer = compare_lists(here, &there, {"m", "n"});
  REQUIRE(fewer.first);
  CHECK(fewer.first->kind == FirstKind::missing);
  CHECK(fewer.first->there->name == "m");
  const trail::ListDifference more = compare_lists(there, &here, {"m", "n"});
  REQUIRE(more.first);
  CHECK(more.first->kind == FirstKind::extra);
}

TEST_CASE("other values, other marks and cut lists are told as such", "[tool][trail][injection]") {
  const MarkSide there = side_with({{"a", 1, {"f"}}, {"b", 2, {"g"}}, {"a", 3, {"f"}}});
  const MarkSide value = side_with({{"a", 1, {"f"}}, {"b", 9, {"g"}}, {"a", 3, {"f"}}});
  trail::ListDifference found = compare_lists(value, &there, {"b"});
  REQUIRE(found.first);
  CHECK(found.first->kind == FirstKind::value);
  CHECK(found.first->index == 1);
  CHECK(found.callers.empty());
  const MarkSide other = side_with({{"a", 1, {"f"}}, {"c", 2, {"g"}}, {"a", 3, {"f"}}});
  found = compare_lists(other, &there, {"b", "c"});
  REQUIRE(found.first);
  CHECK(found.first->kind == FirstKind::other);
  CHECK(found.callers.size() == 2);
  MarkSide cut = side_with({{"a", 1, {"f"}}, {"b", 2, {"g"}}});
  cut.list.is_cut = true;
  CHECK_FALSE(compare_lists(cut, &there, {}).first);
  cut.list.is_cut = false;
  CHECK(compare_lists(cut, &there, {}).first);
  CHECK_FALSE(compare_lists(there, &there, {}).first);
}

}  // namespace ticktrue::test
