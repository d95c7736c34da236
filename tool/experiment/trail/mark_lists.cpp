// Marks are matched by name and calling function first, because one extra draw of a generator changes all later values.
// SPDX-License-Identifier: MIT
#include "tool/experiment/trail/mark_lists.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <utility>

namespace ticktrue::trail {
namespace {

constexpr std::size_t resync_length = 4;     // consecutive marks that must match again
constexpr std::size_t resync_reach = 4'096;  // the largest number of missing or extra marks

using Stack = std::vector<shake::CallSite>;

/// The properties that identify a mark.
struct Shape {
  std::string_view name;
  std::uint32_t caller = 0;
  std::uint64_t value = 0;

  bool is_like(const Shape& other) const { return name == other.name && caller == other.caller; }
  bool operator==(const Shape&) const = default;
};

/// Distinguishes the callers of marks with one name, by function.
class Callers {
 public:
  /// Adds the stacks of one side.
  void add(const MarkSide& side) {
    for (std::size_t i = 0; i < side.of_marks.size(); ++i)
      stacks_[side.list.names[side.list.marks[i].name]].insert({names_in(side.stacks[side.of_marks[i]]), true});
  }

  /// "Shuffle"; empty if unknown.
  std::string text(const std::string& name, const Stack& stack) const {
    const auto depth = depth_of(name);
    std::string text;
    for (std::size_t i = 0; i <= depth && i < stack.size(); ++i) text += (i > 0 ? " < " : "") + stack[i].name();
    return text;
  }

 private:
  static std::vector<std::string> names_in(const Stack& stack) {
    std::vector<std::string> names;
    for (const shake::CallSite& site : stack) names.push_back(site.name());
    return names;
  }

  /// The innermost frame in which the stacks of a name differ. A function that makes all marks of a name distinguishes
  /// nothing. 0 if all stacks are equal.
  std::size_t depth_of(const std::string& name) const {
    const auto found = stacks_.find(name);
    if (found == stacks_.end()) return 0;
    const std::vector<std::string>& first = found->second.begin()->first;
    for (std::size_t depth = 0; depth < first.size(); ++depth)
      for (const auto& [other, is_there] : found->second)
        if (depth >= other.size() || other[depth] != first[depth]) return depth;
    return 0;
  }

  std::map<std::string, std::map<std::vector<std::string>, bool>> stacks_;
};

const Stack& stack_at(const MarkSide& side, std::size_t mark) {
  static const Stack none;
  return mark < side.of_marks.size() ? side.stacks[side.of_marks[mark]] : none;
}

std::vector<Shape> shapes_of(const MarkSide& side, const Callers* callers,
                             std::map<std::string, std::uint32_t>& numbers) {
  std::vector<Shape> shapes;
  // The text of a caller is made once for each pair of name and stack.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
  for (std::size_t i = 0; i < side.list.marks.size(); ++i) {
    const replay::Mark& mark = side.list.marks[i];
    Shape shape{side.list.names[mark.name], 0, mark.value};
    if (callers != nullptr) {
      const auto [at, is_new] = known.emplace(std::pair(mark.name, side.of_marks[i]), 0);
      if (is_new) {
        const std::string text = callers->text(side.list.names[mark.name], stack_at(side, i));
        at->second = numbers.emplace(text, static_cast<std::uint32_t>(numbers.size())).first->second;
      }
      shape.caller = at->second;
    }
    shapes.push_back(shape);
  }
  return shapes;
}

/// Whether the next marks match, regardless of their values.
bool goes_on(const std::vector<Shape>& a, std::size_t at_a, const std::vector<Shape>& b, std::size_t at_b) {
  if ((at_a >= a.size()) != (at_b >= b.size())) return false;
  for (std::size_t i = 0; i < resync_length; ++i) {
    if (at_a + i >= a.size() || at_b + i >= b.size()) return at_a + i >= a.size() && at_b + i >= b.size();
    if (!a[at_a + i].is_like(b[at_b + i])) return false;
  }
  return true;
}

FirstKind kind_at(const std::vector<Shape>& here, const std::vector<Shape>& there, std::size_t at) {
  if (at >= there.size()) return FirstKind::extra;
  if (at >= here.size()) return FirstKind::missing;
  if (here[at].is_like(there[at])) return FirstKind::value;
  for (std::size_t k = 1; k <= resync_reach; ++k) {
    if (goes_on(here, at + k, there, at)) return FirstKind::extra;
    if (goes_on(here, at, there, at + k)) return FirstKind::missing;
  }
  return FirstKind::other;
}

MarkPlace place_at(const MarkSide& side, std::size_t at) {
  const replay::Mark& mark = side.list.marks[at];
  return {side.list.names[mark.name], mark.value, stack_at(side, at)};
}

std::optional<FirstMark> first_difference(const MarkSide& here, const std::vector<Shape>& shapes_here,
                                          const MarkSide& there, const std::vector<Shape>& shapes_there) {
  std::size_t at = 0;
  const std::size_t both = std::min(shapes_here.size(), shapes_there.size());
  while (at < both && shapes_here[at] == shapes_there[at]) ++at;
  const bool ends_here = at == shapes_here.size(), ends_there = at == shapes_there.size();
  // Marks after a cut are unknown.
  if ((ends_here && ends_there) || (ends_here && here.list.is_cut) || (ends_there && there.list.is_cut))
    return std::nullopt;
  FirstMark first;
  first.index = at;
  first.kind = kind_at(shapes_here, shapes_there, at);
  if (at < shapes_here.size()) first.here = place_at(here, at);
  if (at < shapes_there.size()) first.there = place_at(there, at);
  return first;
}

using Counts = std::map<std::pair<std::string, std::string>, std::uint64_t>;  // name and caller

Counts count_calls(const MarkSide& side, const Callers& callers) {
  Counts counts;
  for (std::size_t i = 0; i < side.of_marks.size(); ++i) {
    const std::string& name = side.list.names[side.list.marks[i].name];
    ++counts[{name, callers.text(name, stack_at(side, i))}];
  }
  return counts;
}

std::uint64_t more_of(const CallerCount& count) {
  const std::uint64_t there = count.there.value_or(0);
  return count.here > there ? count.here - there : there - count.here;
}

}  // namespace

MarkSide side_of(const replay::LoggedList& logged) {
  const replay::MarkStacks& stacks = logged.stacks;
  std::vector<std::map<std::uint64_t, Stack>> functions(stacks.modules.size());  // [module] by offset
  for (const auto& stack : stacks.stacks)
    for (const replay::LogFrame& frame : stack) functions[frame.module][frame.offset];
  for (std::size_t m = 0; m < functions.size(); ++m) {
    std::vector<std::uint64_t> offsets;
    for (const auto& [offset, nothing] : functions[m]) offsets.push_back(offset);
    std::vector<Stack> frames = shake::call_frames(stacks.modules[m].path, stacks.modules[m].base, offsets);
    for (std::size_t i = 0; i < offsets.size(); ++i) functions[m][offsets[i]] = std::move(frames[i]);
  }
  MarkSide side;
  side.list = logged.list;
  side.of_marks = stacks.of_marks;
  for (const auto& stack : stacks.stacks) {
    Stack& names = side.stacks.emplace_back();
    for (const replay::LogFrame& frame : stack) {
      const Stack& found = functions[frame.module][frame.offset];
      names.insert(names.end(), found.begin(), found.end());
    }
  }
  return side;
}

const char* name_of(FirstKind kind) {
  constexpr std::array<const char*, 4> names{"extra", "missing", "value", "other"};
  return names[static_cast<std::size_t>(kind)];
}

ListDifference compare_lists(const MarkSide& here, const MarkSide* there, const std::vector<std::string>& names) {
  ListDifference difference;
  difference.compares_callers = there != nullptr && here.has_stacks() && there->has_stacks();
  Callers callers;
  if (here.has_stacks()) callers.add(here);
  if (difference.compares_callers) callers.add(*there);
  if (there != nullptr) {
    std::map<std::string, std::uint32_t> numbers;
    const Callers* compared = difference.compares_callers ? &callers : nullptr;
    const std::vector<Shape> shapes_here = shapes_of(here, compared, numbers);
    const std::vector<Shape> shapes_there = shapes_of(*there, compared, numbers);
    difference.first = first_difference(here, shapes_here, *there, shapes_there);
  }
  Counts counts_there;
  Counts counts_here;
  if (here.has_stacks()) counts_here = count_calls(here, callers);
  if (difference.compares_callers) {
    counts_there = count_calls(*there, callers);
    for (const auto& [key, count] : counts_there) counts_here.emplace(key, 0);
  }
  for (const auto& [key, count] : counts_here) {
    CallerCount of_caller{key.first, key.second, count, std::nullopt};
    if (difference.compares_callers) {
      const auto found = counts_there.find(key);
      of_caller.there = found == counts_there.end() ? 0 : found->second;
      if (*of_caller.there == count) continue;
    } else if (std::find(names.begin(), names.end(), key.first) == names.end()) {
      continue;
    }
    difference.callers.push_back(std::move(of_caller));
  }
  std::stable_sort(difference.callers.begin(), difference.callers.end(),
                   [](const CallerCount& a, const CallerCount& b) { return more_of(a) > more_of(b); });
  return difference;
}

}  // namespace ticktrue::trail
