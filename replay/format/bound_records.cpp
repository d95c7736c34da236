// Checks names, marks and notes. Format: docs/trace_format.md, section 20.
// SPDX-License-Identifier: MIT
#include "replay/format/bound_records.h"

#include <array>

namespace ticktrue::replay {
namespace {

struct BoundTagInfo {
  RecordTag tag;
  Feature feature;
  std::string_view feature_name;
};
constexpr std::array<BoundTagInfo, 4> bound_tags{{
    {RecordTag::name, Feature::marks, "marks"},
    {RecordTag::marks, Feature::marks, "marks"},
    {RecordTag::mark_list, Feature::marks, "marks"},
    {RecordTag::note, Feature::notes, "notes"},
}};

std::string check_note(ByteView body) {
  ByteReader in(body);
  const std::string topic = in.text(topic_size_max);
  if (!in.ok() || topic.empty()) return "note: topic: expected 1.." + std::to_string(topic_size_max) + " bytes";
  if (in.remaining() > note_body_size_max)
    return "note: found " + std::to_string(in.remaining()) + " bytes, expected at most " +
           std::to_string(note_body_size_max);
  return "";
}

}  // namespace

std::string BoundRules::check(const Record& record, const TraceSetup& setup, std::uint64_t tick) {
  const auto tag = static_cast<RecordTag>(record.tag);
  for (const BoundTagInfo& info : bound_tags)
    if (info.tag == tag && !setup.has(info.feature))
      return "record tag: found " + std::to_string(record.tag) + ", whose feature (" + std::string(info.feature_name) +
             ") is off in the setup";
  size_ += record.size;
  if (size_ > bound_size_max)
    return "records outside of the chain: found more than " + std::to_string(bound_size_max) + " bytes";
  switch (tag) {
    case RecordTag::name:
      return check_name(record.body);
    case RecordTag::marks:
      return check_marks(record.body);
    case RecordTag::mark_list:
      if (!setup.is_full(tick)) return "mark list: found one of a tick not stored in full";
      return check_mark_list(record.body);
    default:
      return check_note(record.body);
  }
}

std::string BoundRules::check_name(ByteView body) {
  if (names_.size() == mark_name_count_max)
    return "names of marks: found more than " + std::to_string(mark_name_count_max) + " in a chunk";
  return names_.emplace(body.begin(), body.end()).second ? "" : "names of marks: found the same one twice in a chunk";
}

std::string BoundRules::check_marks(ByteView body) {
  if (has_marks_) return "marks: found a second record in one tick";
  has_marks_ = true;
  ByteReader in(body);
  in.u64();
  const std::uint64_t count = in.varint();
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < count && in.ok(); ++i) {
    const std::uint64_t skip = in.varint();
    if (!in.ok() || skip >= names_.size() - next) return "marks: found a name that does not stand before";
    next += skip + 1;
    if (in.varint() == 0) return "marks: found a name without marks";
    in.u32();
  }
  return in.ok() && in.at_end() ? "" : "marks: sizes do not add up";
}

std::string BoundRules::check_mark_list(ByteView body) {
  list_size_ += body.size();
  if (list_size_ > mark_list_size_max)
    return "mark list: found more than " + std::to_string(mark_list_size_max) + " bytes in one tick";
  ByteReader in(body);
  if (in.u8() > 1) return "mark list: flags: found others than bit 0";
  while (in.ok() && !in.at_end()) {
    if (in.varint() >= names_.size()) return "mark list: found a name that does not stand before";
    in.u64();
  }
  return in.ok() ? "" : "mark list: sizes do not add up";
}

}  // namespace ticktrue::replay
