// Lists of marks, and marks that have no name.
// SPDX-License-Identifier: MIT
#include "capi/marks.h"

#include <utility>

#include "capi/shake_page.h"

namespace ticktrue::capi {
namespace {

constexpr std::size_t list_count_max = std::size_t{1} << 20;

}  // namespace

void SessionMarks::add_slowly(const char* name, std::uint64_t value) {
  const InLibrary inside;
  const std::uint32_t entry = name == nullptr ? replay::MarkTally::name_count_max : tally_.find(name);
  if (entry == replay::MarkTally::name_count_max) return tally_.leave_out();
  tally_.add(entry, value);
  // One more than there is room for: so the list is known to be cut.
  if (lists_ && list_.size() <= list_count_max) list_.push_back({entry, value});
}

BoundContents SessionMarks::take() {
  BoundContents contents;
  contents.marks = tally_.take();
  if (!lists_ || list_.empty()) return contents;
  replay::MarkList& list = contents.mark_list.emplace();
  list.is_cut = list_.size() > list_count_max;
  if (list.is_cut) list_.pop_back();
  std::vector<std::uint32_t> numbers(replay::MarkTally::name_count_max, replay::MarkTally::name_count_max);
  for (replay::Mark& mark : list_) {
    std::uint32_t& number = numbers[mark.name];
    if (number == replay::MarkTally::name_count_max) {
      number = static_cast<std::uint32_t>(list.names.size());
      list.names.push_back(tally_.name(mark.name));
    }
    mark.name = number;
  }
  list.marks = std::exchange(list_, {});
  return contents;
}

}  // namespace ticktrue::capi
