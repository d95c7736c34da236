// Writes the slots of a black box. Recovery relies on the order of the stores.
// SPDX-License-Identifier: MIT
#include "replay/box/box_writer.h"

#include <fcntl.h>

#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/compiler/compiler.h"
#include "base/hash.h"
#include "replay/file/file.h"
#include "replay/file/file_calls.h"

namespace ticktrue::replay {
namespace {

namespace fs = std::filesystem;

std::string with_ending(const std::string& path, const char* ending) {
  return path + ending;
}

}  // namespace

/// Stores the value, least significant byte first, after all earlier stores.
void BoxWriter::store(std::size_t offset, std::uint64_t value, std::size_t size) {
  ByteWriter bytes;
  bytes.u64(value);
  std::uint8_t* at = slot() + offset;
  if (size == 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.view().data(), sizeof word);
    compiler::store_release(*reinterpret_cast<std::uint64_t*>(at), word);
  } else {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.view().data(), sizeof word);
    compiler::store_release(*reinterpret_cast<std::uint32_t*>(at), word);
  }
  compiler::full_fence();
}

/// Moves an older box away: a box that was closed is removed, a box that a crash left is renamed.
Status BoxWriter::make_place() {
  if (const Status status = check_output(path_); !status) return status;
  std::error_code failure;
  if (!fs::exists(system_path(path_), failure)) return {};
  Result<InputFile> old = InputFile::open(path_);
  if (!old) return old.error();
  Bytes head;
  old->read(0, box_header_size, head);
  if (head.size() < box_header_size || !is_box(head))
    return Error{ErrorCode::io, path_ + ": exists and is no black box: it is not overwritten", "give another name"};
  const bool is_closed = ByteReader(ByteView(head).subspan(box_state_offset)).u32() == 1;
  const std::string aside = with_ending(path_, ".crashed");
  if (is_closed)
    fs::remove(system_path(path_), failure);
  else
    fs::rename(system_path(path_), system_path(aside), failure);
  if (failure) return io_error(path_, "cannot be set aside", failure);
  if (!is_closed) note_ = "the box of a session that did not end is " + aside;
  return {};
}

Status BoxWriter::create(ByteView head) {
  if (head.size() > box_head_size_max)
    return Error{ErrorCode::limit,
                 path_ + ": setup and build facts: found " + std::to_string(head.size()) + " bytes, expected at most " +
                     std::to_string(box_head_size_max),
                 ""};
  if (const Status status = make_place(); !status) return status;
  layout_.head_size = static_cast<std::uint32_t>(head.size());
  seed_ = hash64(head);
  // The file has another name until it is complete.
  const std::string fresh = with_ending(path_, ".new");
  std::error_code failure;
  fs::remove(system_path(fresh), failure);
  Result<MappedFile> file = MappedFile::create(fresh, layout_.file_size());
  if (!file) return file.error();
  ByteWriter header;
  encode_box_header(layout_, header);
  std::memcpy(file->data(), header.view().data(), header.size());
  std::memcpy(file->data() + box_page_size, head.data(), head.size());
  fs::rename(system_path(fresh), system_path(path_), failure);
  if (failure) return io_error(path_, "cannot create", failure);
  file_.emplace(std::move(*file));
  return {};
}

/// Takes the first bytes of the writer. They are the same for every slot.
Status BoxWriter::take_head(ByteView bytes) {
  takes_head_ = false;
  if (!file_) {
    if (const Status status = create(bytes); !status) return status;
  } else if (hash64(bytes) != seed_) {
    return Error{ErrorCode::inconsistent, path_ + ": another setup than at the begin of the box", ""};
  }
  current_ = static_cast<std::size_t>(generation_ % layout_.slot_count);
  store(0, 0, 8);  // from here on the slot is empty
  store(box_committed_offset, 0, 4);
  ++generation_;
  ByteWriter header;
  header.u64(begins_at_);
  header.u64(box_slot_check(generation_, begins_at_, seed_));
  std::memcpy(slot() + 8, header.view().data(), header.size());
  committed_ = 0;
  is_full_ = false;
  if (first_ticks_.size() == layout_.slot_count) first_ticks_.erase(first_ticks_.begin());
  return {};
}

Status BoxWriter::append(ByteView bytes) {
  if (takes_head_) return take_head(bytes);
  wanted_size_ = committed_ + bytes.size();
  if (is_full_) return {};
  if (bytes.size() > room()) {
    is_full_ = true;
    return {};
  }
  std::memcpy(slot() + box_slot_header_size + committed_, bytes.data(), bytes.size());
  committed_ += bytes.size();
  written_size_ += bytes.size();
  store(box_committed_offset, committed_, 4);
  return {};
}

Result<TraceWriter> BoxWriter::begin_slot(const TraceSetup& setup, const BuildFacts& facts, std::uint64_t tick,
                                          double time_s) {
  takes_head_ = true;
  begins_at_ = tick;
  WriterOptions options;
  options.compress = false;  // copying costs a hundredth of compressing
  options.sync = false;
  options.allow_third = true;
  Result<TraceWriter> writer =
      TraceWriter::to(OutputFile::to(path_, [this](ByteView bytes) { return append(bytes); }), setup, facts, options);
  if (writer) writer->begin_at(tick, time_s);
  return writer;
}

void BoxWriter::publish() {
  store(0, generation_, 8);
  first_ticks_.push_back(begins_at_);
}

std::uint64_t BoxWriter::first_tick() const {
  return first_ticks_.empty() ? begins_at_ : first_ticks_.front();
}

void BoxWriter::close() {
  if (!file_) return;
  const std::uint32_t closed = 1;
  ByteWriter bytes;
  bytes.u32(closed);
  std::memcpy(file_->data() + box_state_offset, bytes.view().data(), bytes.size());
}

}  // namespace ticktrue::replay
