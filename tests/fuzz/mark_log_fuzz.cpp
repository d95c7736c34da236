// Fuzzes the log of marks that a program writes for `ticktrue trail`: what is read is within the limits, and is written
// as it was read.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "replay/format/mark_log.h"
#include "replay/format/mark_tally.h"
#include "tests/fuzz/support/fuzz.h"

namespace {

using namespace ticktrue;

/// Every index is valid, and no list is longer than a session writes it.
void require_bounded(const replay::LoggedList& list) {
  const auto& [modules, stacks, of_marks] = list.stacks;
  fuzz::require(list.list.names.size() <= replay::MarkTally::name_count_max, "names are bounded");
  fuzz::require(list.list.marks.size() <= replay::listed_mark_count_max, "marks are bounded");
  fuzz::require(modules.size() <= replay::listed_module_count_max, "modules are bounded");
  fuzz::require(stacks.size() <= replay::listed_stack_count_max, "stacks are bounded");
  for (const replay::Mark& mark : list.list.marks)
    fuzz::require(mark.name < list.list.names.size(), "a mark has a name");
  fuzz::require(of_marks.size() == (stacks.empty() ? 0 : list.list.marks.size()), "each mark has a stack, or none has");
  for (const std::uint32_t stack : of_marks) fuzz::require(stack < stacks.size(), "a mark has a stack that is there");
  for (const auto& stack : stacks) {
    fuzz::require(stack.size() <= replay::listed_stack_depth_max, "the depth of a stack is bounded");
    for (const replay::LogFrame& frame : stack) fuzz::require(frame.module < modules.size(), "a frame has a module");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const replay::MarkLog log = replay::decode_mark_log({data, size});
  ByteWriter out;
  for (std::size_t i = 0; i < log.ticks.size(); ++i) {
    fuzz::require(i == 0 || log.ticks[i - 1].tick < log.ticks[i].tick, "ticks ascend");
    replay::encode_logged_tick(log.ticks[i], out);
  }
  if (log.list) {
    require_bounded(*log.list);
    replay::encode_logged_list(*log.list, out);
  }
  const replay::MarkLog again = replay::decode_mark_log(out.view());
  fuzz::require(std::equal(log.ticks.begin(), log.ticks.end(), again.ticks.begin(), again.ticks.end(),
                           [](const replay::LoggedTick& a, const replay::LoggedTick& b) {
                             return a.tick == b.tick && a.marks == b.marks;
                           }),
                "ticks are written as they were read");
  fuzz::require(log.list.has_value() == again.list.has_value(), "a list is written as it was read");
  if (log.list)
    fuzz::require(log.list->tick == again.list->tick && log.list->list == again.list->list &&
                      log.list->stacks == again.list->stacks,
                  "a list is written as it was read");
  return 0;
}
