// Recovers a black box. The reader of traces reads each slot, because head and slot are a truncated trace.
// SPDX-License-Identifier: MIT
#include "replay/box/recover_box.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "base/hash.h"
#include "replay/box/box_layout.h"
#include "replay/file/file.h"
#include "replay/trace_copy.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {
namespace {

/// The content of a slot, as far as its bytes prove it.
struct Slot {
  std::size_t number = 0;
  std::uint64_t generation = 0;
  std::uint32_t committed = 0;
  std::uint64_t first_tick = 0;
  std::uint64_t first_root = 0;  // of its first checkpoint
  std::uint64_t last_root = 0;   // of its last tick; if it has no tick, of the checkpoint
  std::uint64_t end = 0;         // first tick + ticks
  bool is_damaged = false;
  std::string message;
};

class Box {
 public:
  static Result<Box> open(const std::string& path) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    Box box(path, std::move(*file));
    Bytes header;
    box.file_.read(0, box_header_size, header);
    if (header.size() < box_header_size || !is_box(header))
      return Error{ErrorCode::corrupt, path + ": black box: the file ends inside its header", ""};
    Result<BoxLayout> layout = decode_box_header(header, path);
    if (!layout) return layout.error();
    box.layout_ = *layout;
    box.is_closed = ByteReader(ByteView(header).subspan(box_state_offset)).u32() == 1;
    box.file_.read(box_page_size, layout->head_size, box.head_);
    if (box.head_.size() < layout->head_size)
      return Error{ErrorCode::truncated, path + ": black box: the file ends inside its head", ""};
    return box;
  }

  /// Returns head and slot as one trace.
  const Bytes& trace_of(const Slot& slot) {
    Bytes body;
    file_.read(layout_.slot_offset(slot.number) + box_slot_header_size, slot.committed, body);
    bytes_ = head_;
    bytes_.insert(bytes_.end(), body.begin(), body.end());
    return bytes_;
  }

  /// Returns the non-empty slots, by generation.
  std::vector<Slot> slots(std::vector<std::string>& left_out) {
    const std::uint64_t seed = hash64(head_);
    std::vector<Slot> found;
    for (std::size_t i = 0; i < layout_.slot_count; ++i) {
      Bytes bytes;
      file_.read(layout_.slot_offset(i), box_slot_header_size, bytes);
      const BoxSlotHeader header = decode_box_slot_header(bytes, seed);
      if (bytes.size() == box_slot_header_size && header.generation == 0) continue;
      Slot slot;
      slot.number = i;
      slot.generation = header.generation;
      slot.committed = header.committed;
      if (!header.is_right || header.committed > layout_.slot_size - box_slot_header_size)
        left_out.push_back("slot " + std::to_string(i) + ": its header is damaged");
      else if (const std::string wrong = examine(slot, header.first_tick); !wrong.empty())
        left_out.push_back("slot " + std::to_string(i) + ": " + wrong);
      else
        found.push_back(std::move(slot));
    }
    std::sort(found.begin(), found.end(), [](const Slot& a, const Slot& b) { return a.generation < b.generation; });
    return found;
  }

  const std::string& path() const { return path_; }
  Status check_unchanged() const { return file_.check_unchanged(path_); }
  bool is_closed = false;

 private:
  Box(std::string path, InputFile file) : path_(std::move(path)), file_(std::move(file)) {}

  /// Reads the slot. Returns why the slot is useless; empty: it begins with a checkpoint.
  std::string examine(Slot& slot, std::uint64_t first_tick) {
    Result<TraceReader> reader = TraceReader::open_bytes(trace_of(slot), path_);
    if (!reader) return reader.error().message;
    bool has_checkpoint = false;
    for (;;) {
      const TraceReader::Item& item = reader->next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item)) {
        if (!std::exchange(has_checkpoint, true)) {
          slot.first_tick = slot.end = checkpoint->tick;
          slot.first_root = slot.last_root = checkpoint->root_hash;
        }
        continue;
      }
      const auto& tick = std::get<TickRecord>(item);
      slot.last_root = tick.root_hash;
      slot.end = tick.tick + 1;
    }
    if (!has_checkpoint) return "its first checkpoint cannot be read: " + reader->tail().message;
    if (slot.first_tick != first_tick) return "its first tick is not that of its header";
    slot.is_damaged = reader->tail().condition == TraceCondition::damaged;
    slot.message = reader->tail().message;
    return "";
  }

  std::string path_;
  InputFile file_;
  BoxLayout layout_;
  Bytes head_;
  Bytes bytes_;
};

bool is_joint(const Slot& before, const Slot& after) {
  return !before.is_damaged && before.generation + 1 == after.generation && before.end == after.first_tick &&
         before.last_root == after.first_root;
}

/// The longest run of contiguous slots that ends with the last slot.
std::vector<Slot> last_run(std::vector<Slot> slots, std::vector<std::string>& left_out) {
  std::size_t first = slots.size() - 1;
  while (first > 0 && is_joint(slots[first - 1], slots[first])) --first;
  for (std::size_t i = 0; i < first; ++i)
    left_out.push_back("slot " + std::to_string(slots[i].number) + ": ticks " + std::to_string(slots[i].first_tick) +
                       ".." + std::to_string(slots[i].end) + " do not go on to those behind" +
                       (slots[i].is_damaged ? ": " + slots[i].message : ""));
  return {slots.begin() + static_cast<std::ptrdiff_t>(first), slots.end()};
}

/// Copies a slot, without a checkpoint that the slot before ended with.
Status copy_slot(TraceReader& reader, std::optional<std::uint64_t>& last_checkpoint, TraceWriter& writer,
                 RecoveredBox& recovered) {
  for (;;) {
    const TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) return {};
    const auto* checkpoint = std::get_if<CheckpointRecord>(&item);
    if (checkpoint != nullptr) {
      if (last_checkpoint == checkpoint->tick) continue;
      if (!last_checkpoint) {
        recovered.first_tick = checkpoint->tick;
        recovered.has_save = checkpoint->save.has_value();
      }
      last_checkpoint = checkpoint->tick;
    }
    if (const Status status = copy_item(item, writer); !status) return status;
  }
}

Status copy_run(Box& box, const std::vector<Slot>& run, bool goes_on, TraceWriter& writer, RecoveredBox& recovered) {
  std::optional<std::uint64_t> last_checkpoint;
  for (const Slot& slot : run) {
    Result<TraceReader> reader = TraceReader::open_bytes(box.trace_of(slot), box.path());
    if (!reader) return reader.error();
    if (const Status status = copy_slot(*reader, last_checkpoint, writer, recovered); !status) return status;
    if (&slot == &run.back()) recovered.result.tail = reader->tail();
  }
  if (const Status status = box.check_unchanged(); !status) return status;
  recovered.result.ticks_written = writer.tick_count() - recovered.first_tick;
  if (recovered.result.ticks_written == 0) return {};
  if (goes_on && recovered.result.tail.condition != TraceCondition::damaged)
    return writer.finish(EndReason::complete, "");
  return finish_copy(recovered.result.tail, writer);
}

}  // namespace

bool is_box_file(const std::string& path) {
  Result<InputFile> file = InputFile::open(path);
  if (!file) return false;
  Bytes bytes;
  file->read(0, box_magic.size(), bytes);
  return is_box(bytes);
}

namespace {

using MakeWriter = std::function<Result<TraceWriter>(const TraceSetup&, const BuildFacts&)>;

Result<RecoveredBox> recover_to(const std::string& input, bool goes_on, const MakeWriter& make_writer) {
  Result<Box> box = Box::open(input);
  if (!box) return box.error();
  RecoveredBox recovered;
  recovered.was_closed = box->is_closed;
  std::vector<Slot> slots = box->slots(recovered.left_out);
  if (slots.empty())
    return Error{ErrorCode::corrupt,
                 input + ": black box: found no slot that can be read" +
                     (recovered.left_out.empty() ? "" : ": " + recovered.left_out.front()),
                 "the session ended before its first tick, or the file is damaged"};
  const std::vector<Slot> run = last_run(std::move(slots), recovered.left_out);
  Result<TraceReader> reader = TraceReader::open_bytes(box->trace_of(run.front()), input);
  if (!reader) return reader.error();
  Result<TraceWriter> writer = make_writer(reader->setup(), reader->facts());
  if (!writer) return writer.error();
  const Status status = copy_run(*box, run, goes_on, *writer, recovered);
  if (!status || recovered.result.ticks_written == 0) writer->discard();
  if (!status) return status.error();
  return recovered;
}

Result<RecoveredBox> recover_to_file(const std::string& input, bool goes_on, const std::string& output,
                                     bool overwrite) {
  std::error_code ignored;
  if (std::filesystem::equivalent(input, output, ignored))
    return Error{ErrorCode::usage, output + ": is the black box: it is never changed", "name another output"};
  return recover_to(input, goes_on, [&](const TraceSetup& setup, const BuildFacts& facts) {
    WriterOptions options;
    options.overwrite = overwrite;
    options.allow_third = true;
    return TraceWriter::create(output, setup, facts, options);
  });
}

}  // namespace

Result<RecoveredBox> recover_box(const std::string& input, const std::string& output, bool overwrite) {
  return recover_to_file(input, false, output, overwrite);
}

Result<RecoveredBox> save_box(const std::string& input, const std::string& output, bool overwrite) {
  Result<RecoveredBox> saved = recover_to_file(input, true, output, overwrite);
  if (saved && saved->result.ticks_written == 0)
    return Error{ErrorCode::usage, input + ": black box: no tick has ended yet", ""};
  return saved;
}

Result<Bytes> save_box(const std::string& input) {
  Bytes bytes;
  const Result<RecoveredBox> saved = recover_to(input, true, [&](const TraceSetup& setup, const BuildFacts& facts) {
    WriterOptions options;
    options.compress = false;
    options.sync = false;
    options.allow_third = true;
    const auto append = [&bytes](ByteView more) {
      bytes.insert(bytes.end(), more.begin(), more.end());
      return Status();
    };
    return TraceWriter::to(OutputFile::to(input, append), setup, facts, options);
  });
  if (!saved) return saved.error();
  if (saved->result.ticks_written == 0)
    return Error{ErrorCode::usage, input + ": black box: no tick has ended yet", ""};
  return bytes;
}

}  // namespace ticktrue::replay
