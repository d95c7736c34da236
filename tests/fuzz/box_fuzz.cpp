// Fuzzes black boxes as `ticktrue recover` reads them: checks are made right, so that what stands behind is reached.
// SPDX-License-Identifier: MIT
//
// Input: a packed box, without the space between its parts. Header (44 bytes), a u32, head, then slots: header (64
// bytes) and committed bytes. The u32 cuts the file there (0: nowhere). In byte 28 of a slot's header, bit 0 leaves the
// checks of its chunks as they are, and bit 1 that of the header.
#include <unistd.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/hash.h"
#include "replay/box/box_layout.h"
#include "replay/box/recover_box.h"
#include "replay/trace_reader.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/trace_reading.h"

namespace {

using namespace ticktrue;
using replay::BoxLayout;

constexpr std::size_t state_end = replay::box_header_size;
constexpr std::size_t flags_offset = 28;
constexpr std::uint8_t keeps_chunk_checks = 1;
constexpr std::uint8_t keeps_own_check = 2;

void put(Bytes& file, std::uint64_t offset, ByteView part) {
  if (offset + part.size() > file.size()) file.resize(offset + part.size());
  std::copy(part.begin(), part.end(), file.begin() + static_cast<std::ptrdiff_t>(offset));
}

/// The roots that a slot must have in a recovered trace.
struct SlotTicks {
  std::uint64_t generation = 0;
  std::uint64_t first_tick = 0;
  std::vector<std::uint64_t> roots;
};

std::vector<std::uint64_t> roots_of(replay::TraceReader& reader, std::optional<std::uint64_t>& first_tick) {
  std::vector<std::uint64_t> roots;
  for (;;) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) return roots;
    if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      if (!first_tick) first_tick = checkpoint->tick;
    } else {
      roots.push_back(std::get<replay::TickRecord>(item).root_hash);
    }
  }
}

class ForgedBox {
 public:
  explicit ForgedBox(ByteView packed) : in_(packed) {
    lay_out_header();
    head_ = take(layout_.head_size);
    if (!head_.empty()) head_ = fuzz::with_right_checks(head_);
    layout_.head_size = static_cast<std::uint32_t>(head_.size());
    seed_ = hash64(head_);
    write_header();
    put(file_, replay::box_page_size, head_);
    if (is_right_) {
      file_.resize(layout_.file_size());
      for (std::size_t i = 0; i < layout_.slot_count && !in_.at_end(); ++i) add_slot(i);
    }
    if (cut_ > 0 && cut_ < file_.size()) file_.resize(cut_);
  }

  const Bytes& file() const { return file_; }
  /// The slots that recovery must be able to read. None if the file was cut.
  const std::vector<SlotTicks>& slots() const { return slots_; }
  bool is_cut() const { return cut_ > 0; }

 private:
  Bytes take(std::uint64_t size) {
    const ByteView part = in_.bytes(static_cast<std::size_t>(std::min<std::uint64_t>(size, in_.remaining())));
    return {part.begin(), part.end()};
  }

  /// Sizes that a box may have become the smallest, so that a file is small.
  void lay_out_header() {
    header_ = take(state_end);
    header_.resize(state_end);
    cut_ = in_.u32();
    std::copy(replay::box_magic.begin(), replay::box_magic.end(), header_.begin());
    ByteReader fields(ByteView(header_).subspan(replay::box_magic.size()));
    version_ = fields.u16();
    layout_.slot_count = fields.u16();
    layout_.head_size = fields.u32();
    layout_.slot_size = fields.u64();
    size_ = fields.u64();
    is_right_ = version_ == replay::box_version && layout_.slot_count >= replay::box_slot_count_min &&
                layout_.slot_count <= replay::box_slot_count_max && layout_.slot_size >= replay::box_slot_size_min &&
                layout_.slot_size <= replay::box_slot_size_max && layout_.slot_size % replay::box_page_size == 0;
    if (is_right_) layout_.slot_size = replay::box_slot_size_min;
  }

  void write_header() {
    ByteWriter out;
    replay::encode_box_header(layout_, out);
    Bytes bytes(out.view().begin(), out.view().end());
    if (!is_right_) {  // a wrong field with a right check
      ByteWriter version;
      version.u16(version_);
      put(bytes, replay::box_magic.size(), version.view());
      ByteWriter size;
      size.u64(size_);
      put(bytes, replay::box_magic.size() + 16, size.view());
      ByteWriter check;
      check.u64(hash64(ByteView(bytes).first(replay::box_magic.size() + 24)));
      put(bytes, replay::box_magic.size() + 24, check.view());
    }
    put(bytes, replay::box_state_offset, ByteView(header_).subspan(replay::box_state_offset));
    put(file_, 0, bytes);
    file_.resize(replay::box_page_size);
  }

  void add_slot(std::size_t slot) {
    Bytes header = take(replay::box_slot_header_size);
    header.resize(replay::box_slot_header_size);
    ByteReader fields(header);
    SlotTicks ticks;
    ticks.generation = fields.u64();
    ticks.first_tick = fields.u64();
    fields.u64();
    const std::uint32_t committed = fields.u32();
    const std::uint8_t flags = header[flags_offset];
    const std::uint64_t room = layout_.slot_size - replay::box_slot_header_size;
    Bytes trace = head_;
    const Bytes body = take(std::min<std::uint64_t>(committed, room));
    trace.insert(trace.end(), body.begin(), body.end());
    if ((flags & keeps_chunk_checks) == 0) trace = fuzz::with_right_checks(trace);
    if ((flags & keeps_own_check) == 0) {
      ByteWriter check;
      check.u64(replay::box_slot_check(ticks.generation, ticks.first_tick, seed_));
      put(header, 16, check.view());
    }
    const std::uint64_t offset = layout_.slot_offset(slot);
    put(file_, offset, header);
    put(file_, offset + replay::box_slot_header_size, ByteView(trace).subspan(head_.size()));
    // A part that is committed and was never written is zeros.
    if (committed > room || ticks.generation == 0 || !replay::decode_box_slot_header(header, seed_).is_right) return;
    trace.resize(head_.size() + committed);
    put(trace, 0, head_);  // a chunk that the head begins and the slot ends stays wrong
    auto reader = replay::TraceReader::open_bytes(trace, "slot");
    if (!reader) return;
    std::optional<std::uint64_t> first_tick;
    ticks.roots = roots_of(*reader, first_tick);
    if (first_tick == ticks.first_tick) slots_.push_back(std::move(ticks));
  }

  ByteReader in_;
  Bytes header_;
  std::uint16_t version_ = 0;
  std::uint64_t size_ = 0;
  std::uint32_t cut_ = 0;
  bool is_right_ = false;
  BoxLayout layout_;
  Bytes head_;
  std::uint64_t seed_ = 0;
  Bytes file_;
  std::vector<SlotTicks> slots_;
};

/// The ticks of the newest slot are the end of the trace, and every tick was recorded by a slot.
void check_ticks(const std::vector<SlotTicks>& slots, std::uint64_t first_tick,
                 const std::vector<std::uint64_t>& roots) {
  std::map<std::uint64_t, std::set<std::uint64_t>> recorded;
  std::uint64_t newest = 0;
  for (const SlotTicks& slot : slots) {
    newest = std::max(newest, slot.generation);
    for (std::size_t i = 0; i < slot.roots.size(); ++i) recorded[slot.first_tick + i].insert(slot.roots[i]);
  }
  for (std::size_t i = 0; i < roots.size(); ++i)
    fuzz::require(recorded[first_tick + i].count(roots[i]) == 1, "a recovered tick was recorded");
  bool has_newest = false;
  for (const SlotTicks& slot : slots)
    has_newest = has_newest || (slot.generation == newest && slot.roots.size() <= roots.size() &&
                                slot.first_tick + slot.roots.size() == first_tick + roots.size() &&
                                std::equal(slot.roots.rbegin(), slot.roots.rend(), roots.rbegin()));
  fuzz::require(has_newest, "the newest slot is recovered");
}

void check_recovered(const ForgedBox& box, const replay::RecoveredBox& recovered, const std::string& output) {
  for (const std::string& text : recovered.left_out) fuzz::require(text.size() > 5, "what is left out is named");
  const bool has_file = ::access(output.c_str(), F_OK) == 0;
  fuzz::require(has_file == (recovered.result.ticks_written > 0), "a file is written where a tick is intact");
  if (!has_file) return;
  auto reader = replay::TraceReader::open(output);
  fuzz::require(reader.has_value(), "a recovered trace opens");
  std::optional<std::uint64_t> first_tick;
  const std::vector<std::uint64_t> roots = roots_of(*reader, first_tick);
  fuzz::require(reader->tail().condition == replay::TraceCondition::complete, "a recovered trace is complete");
  fuzz::require(roots.size() == recovered.result.ticks_written, "it has the ticks it is said to have");
  fuzz::require(first_tick == recovered.first_tick, "it begins where it is said to begin");
  if (!box.is_cut()) check_ticks(box.slots(), *first_tick, roots);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ForgedBox box({data, size});
  const fuzz::MemoryFile file(box.file());
  fuzz::require(replay::is_box_file(file.path()) == (box.file().size() >= replay::box_magic.size()), "it is a box");
  const std::string output = "/dev/shm/ticktrue_fuzz_box_" + std::to_string(::getpid()) + ".ttr";
  ::unlink(output.c_str());
  const auto recovered = replay::recover_box(file.path(), output, true);
  if (recovered) {
    check_recovered(box, *recovered, output);
  } else {
    fuzz::require_message(recovered.error());
    fuzz::require(::access(output.c_str(), F_OK) != 0, "a refusal leaves no file");
    fuzz::require(box.is_cut() || box.slots().empty() || recovered.error().code != ErrorCode::corrupt,
                  "a box with a readable slot is no damaged one");
  }
  ::unlink(output.c_str());
  return 0;
}
