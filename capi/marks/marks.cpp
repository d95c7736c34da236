// Lists of marks, and marks without a name.
// SPDX-License-Identifier: MIT
#include "capi/marks/marks.h"

#include <utility>

#ifdef __linux__
#include <link.h>
#endif

#include "capi/marks/shake_page.h"

namespace ticktrue::capi {
namespace {

#ifdef __linux__

/// Whether the address is in a read-only mapping of a module, as string literals are.
bool is_constant(const char* name) {
  const auto address = reinterpret_cast<std::uintptr_t>(name);
  return ::dl_iterate_phdr(
             [](dl_phdr_info* module, std::size_t, void* wanted) {
               const std::uintptr_t at = *static_cast<const std::uintptr_t*>(wanted);
               for (std::size_t i = 0; i < module->dlpi_phnum; ++i) {
                 const auto& part = module->dlpi_phdr[i];
                 const std::uintptr_t begin = module->dlpi_addr + part.p_vaddr;
                 const bool is_written = part.p_type != PT_LOAD || (part.p_flags & PF_W) != 0;
                 if (!is_written && at >= begin && at - begin < part.p_memsz) return 1;
               }
               return 0;
             },
             const_cast<std::uintptr_t*>(&address)) != 0;
}

#else

bool is_constant(const char*) {
  return false;
}

#endif

}  // namespace

SessionMarks::SessionMarks() : tally_(is_constant) {}

void SessionMarks::add(const char* name, std::uint64_t value, const void* caller) {
  const InLibrary inside;
  const std::uint32_t entry = tally_.find(name);
  if (entry == replay::MarkTally::name_count_max) return tally_.leave_out();
  tally_.add(entry, value);
  // One more than the limit, so that the list is recognised as truncated.
  if (detail_ == MarkDetail::counts || list_.size() > replay::listed_mark_count_max) return;
  list_.push_back({entry, value});
  if (detail_ == MarkDetail::stacks) stacks_.add(caller);
}

BoundContents SessionMarks::take() {
  BoundContents contents;
  contents.marks = tally_.take();
  contents.stacks = stacks_.take();
  if (list_.empty()) return contents;
  replay::MarkList& list = contents.mark_list.emplace();
  list.is_cut = list_.size() > replay::listed_mark_count_max;
  if (list.is_cut) list_.pop_back();
  if (list.is_cut && !contents.stacks.of_marks.empty()) contents.stacks.of_marks.pop_back();
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
