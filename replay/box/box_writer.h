// Writes a black box: a file of fixed size with the last ticks of a session. A killed process leaves it readable.
// SPDX-License-Identifier: MIT
//
// Each slot is the body of a trace that begins at a checkpoint. Bytes are copied into the mapped file first, and
// counted as committed afterwards. A process that is killed between two stores leaves the committed bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/box/box_layout.h"
#include "replay/file/mapped_file.h"
#include "replay/format/trace.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {

class BoxWriter {
 public:
  /// Creates no file yet.
  BoxWriter(std::string path, BoxLayout layout) : path_(std::move(path)), layout_(layout) {}
  BoxWriter(const BoxWriter&) = delete;
  BoxWriter& operator=(const BoxWriter&) = delete;

  /// Begins the next slot and erases its content. The returned writer writes into the slot until the next slot begins.
  /// Its first call is checkpoint(). The first slot creates the file. Errors: io (the path, the disk), limit (the
  /// setup), usage.
  Result<TraceWriter> begin_slot(const TraceSetup& setup, const BuildFacts& facts, std::uint64_t tick, double time_s);
  /// Marks the slot as valid. Requires: the first checkpoint of the slot is complete.
  void publish();

  /// Whether a write did not fit into the slot. Then nothing more is written to the slot.
  bool is_full() const { return is_full_; }
  std::uint64_t room() const { return layout_.slot_size - box_slot_header_size - committed_; }
  /// Bytes written to slots since the box was created.
  std::uint64_t written_size() const { return written_size_; }
  /// Bytes of the slot that the last write needed, also if it did not fit.
  std::uint64_t wanted_size() const { return wanted_size_; }
  std::uint64_t file_size() const { return layout_.file_size(); }
  std::uint64_t slot_size() const { return layout_.slot_size; }
  /// The first tick in the box.
  std::uint64_t first_tick() const;
  /// What happened to an older box at the path; empty: nothing.
  const std::string& note() const { return note_; }

  /// Marks the box as closed by its session.
  void close();

 private:
  Status create(ByteView head);
  Status make_place();
  Status take_head(ByteView bytes);
  Status append(ByteView bytes);
  std::uint8_t* slot() { return file_->data() + layout_.slot_offset(current_); }
  void store(std::size_t offset, std::uint64_t value, std::size_t size);

  std::string path_;
  BoxLayout layout_;
  std::optional<MappedFile> file_;
  std::uint64_t seed_ = 0;
  std::uint64_t generation_ = 0;  // of the current slot
  std::size_t current_ = 0;
  std::uint64_t committed_ = 0;
  std::uint64_t written_size_ = 0;
  std::uint64_t wanted_size_ = 0;
  std::vector<std::uint64_t> first_ticks_;  // of the valid slots, the oldest first
  std::uint64_t begins_at_ = 0;
  bool takes_head_ = false;
  bool is_full_ = false;
  std::string note_;
};

}  // namespace ticktrue::replay
