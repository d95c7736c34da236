// Searches for the differences that move a column: halves of the set are written into copies of the process.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <numeric>

#include "capi/unsaved/probe.h"
#include "capi/unsaved/window.h"

namespace ticktrue::capi {

#ifdef __linux__
namespace {

constexpr std::uint64_t trials_of_window_max = 400;
constexpr std::uint64_t time_of_window_max_ms = 20'000;
constexpr std::size_t holders_max = 16;  // units of a finding whose holders are searched
constexpr std::uint64_t examined_windows_max = 40;

/// The key of a variable, or of a place in the blocks of one allocation site. It is equal in every window.
std::string key_of(const Unit& unit) {
  std::string key = std::to_string(static_cast<int>(unit.owner)) + " " + unit.name;
  if (unit.owner == PieceOwner::variable || unit.owner == PieceOwner::generator) return key;
  if (unit.owner == PieceOwner::block) {
    for (const void* address : unit.stack) key += " " + std::to_string(reinterpret_cast<std::uint64_t>(address));
    return key + " " + std::to_string(unit.pieces.front().address - unit.begin);
  }
  return key + " " + std::to_string(unit.pieces.front().address);
}

}  // namespace

bool Probe::examine() {
  ++moved_count_;
  Finding plain;
  plain.tick = shared_->tick;
  plain.window = begin_;
  plain.columns = moved_columns();
  if (moved_count_ > examined_windows_max) {
    ++unexamined_count_;
    return false;
  }
  compare_with_copy();
  trials_here_ = 0;
  trials_ms_ = 0;
  Groups rest;
  for (std::size_t group = 0; group < differences_.groups.size(); ++group) {
    const Groups& units = differences_.groups[group];
    const bool is_known = std::all_of(units.begin(), units.end(), [&](std::size_t unit) {
      return known_.count(key_of(differences_.units[unit])) > 0;
    });
    if (!is_known) rest.push_back(group);
  }
  const Trial control = try_groups({});
  if (is_copy()) return true;
  if (control.has_moved) {
    if (refusal_.empty())
      refusal_ = "the same ticks from the same memory end otherwise at tick " + std::to_string(control.tick);
    hint_.clear();  // `ticktrue unsaved` knows the command that finds the cause
    return false;
  }
  const std::size_t before = findings_.size();
  const bool has_found = search(rest, nullptr);
  if (is_copy()) return true;
  if (is_spent()) ++unexamined_count_;
  if (!has_found && before == 0 && unexplained_.empty()) unexplained_.push_back(std::move(plain));
  for (const Unit& unit : differences_.units)
    if (known_.count(key_of(unit)) == 0 && seen_.insert(key_of(unit)).second) harmless_.push_back(unit);
  return false;
}

bool Probe::search(const Groups& groups, const Trial* known) {
  if (groups.empty() || is_spent()) return false;
  const Trial trial = known != nullptr ? *known : try_groups(groups);
  if (is_copy() || !trial.has_moved) return false;
  if (groups.size() == 1) {
    // A crashed copy had memory that does not fit together: a crash alone is no proof.
    if (trial.has_crashed) return false;
    add_finding(groups, trial, false);
    return true;
  }
  const auto middle = groups.begin() + static_cast<std::ptrdiff_t>(groups.size() / 2);
  const bool has_first = search(Groups(groups.begin(), middle), nullptr);
  if (is_copy()) return false;
  const bool has_second = search(Groups(middle, groups.end()), nullptr);
  if (is_copy()) return false;
  if (!has_first && !has_second && !trial.has_crashed && !is_spent()) {
    add_finding(groups, trial, true);
    return true;
  }
  return has_first || has_second;
}

bool Probe::is_spent() const {
  return trials_here_ >= trials_of_window_max || trials_ms_ >= time_of_window_max_ms;
}

Probe::Trial Probe::try_groups(const Groups& groups) {
  ++trial_count_;
  ++trials_here_;
  if (fork_copy(Role::trial, groups.empty() ? copy_time_ms : trial_limit_ms_)) {
    write_groups(groups);
    return {};
  }
  trials_ms_ += copy_ms_;
  Trial trial;
  trial.has_crashed = shared_->end != CopyEnd::same && shared_->end != CopyEnd::moved;
  trial.has_moved = trial.has_crashed || shared_->end == CopyEnd::moved;
  if (shared_->end != CopyEnd::moved) return trial;
  trial.tick = shared_->tick;
  trial.columns = moved_columns();
  return trial;
}

void Probe::write_groups(const Groups& groups) {
  // Reserves the blocks that load allocated: the differences contain pointers to them.
  keep_heap_blocks(shared_->heap);
  const char* first = heap_.begin != nullptr ? heap_.top : shared_->heap.begin;
  const auto size = static_cast<std::uint64_t>(shared_->heap.top - first);
  if (size > 0 && heap_.begin != nullptr)
    if (const std::uint8_t* bytes = other_.at(reinterpret_cast<std::uint64_t>(first), size))
      std::memcpy(heap_.top, bytes, size);
  const ParkedGenerator parked;
  for (const std::size_t group : groups) {
    for (const std::size_t unit : differences_.groups[group])
      for (const Piece& piece : differences_.units[unit].pieces)
        std::memcpy(reinterpret_cast<void*>(piece.address), piece.other, piece.size);
    for (std::size_t i = 0; i < moved_group_.size(); ++i)
      if (moved_group_[i] == static_cast<std::ptrdiff_t>(group))
        apply_({shared_->moved_columns[i].table, shared_->moved_columns[i].column, shared_->moved_columns[i].source});
  }
}

void Probe::add_finding(const Groups& groups, const Trial& trial, bool is_joint) {
  Finding finding;
  finding.tick = trial.tick;
  finding.window = begin_;
  finding.columns = trial.columns;
  finding.is_joint = is_joint;
  for (const std::size_t group : groups)
    for (const std::size_t unit : differences_.groups[group]) {
      known_.insert(key_of(differences_.units[unit]));
      finding.units.push_back(differences_.units[unit]);
      if (finding.units.size() <= holders_max && finding.units.back().owner == PieceOwner::block)
        find_holder(memory_, finding.units.back());
    }
  findings_.push_back(std::move(finding));
}

#endif

}  // namespace ticktrue::capi
