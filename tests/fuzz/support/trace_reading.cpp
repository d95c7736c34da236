// Reading, seeking, recovering and verifying of any bytes; right checks for them.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/trace_reading.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "replay/trace_reader.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/saving_toy.h"
#include "tests/support/toy_simulation.h"
#include "verifier/locate/locate.h"
#include "verifier/peers/bundle.h"
#include "verifier/report/content_text.h"
#include "verifier/verify/verify.h"

namespace ticktrue::fuzz {
namespace {

constexpr std::uint32_t toy_body_count_max = 100;
constexpr std::size_t located_count_max = 8;
constexpr std::size_t compared_size_max = std::size_t{1} << 20;  // of a state that is compared with the one before it

/// The toy whose saves can be loaded, for traces that have some.
const SimulationInfo saving_toy_info = [] {
  SimulationInfo info = test::toy_info;
  info.make = SavingToy::make;
  info.has_saves = true;
  return info;
}();

struct Reading {
  std::vector<std::uint64_t> roots;  // of the ticks, in order
  std::uint64_t checkpoint_count = 0;
};

/// Two states that a reader accepts can be compared; what differs has a place.
void compare_states(const StateSchema& schema, const Bytes& before, const Bytes& behind) {
  verifier::Divergence divergence;
  require(verifier::locate_lanes(schema, before, behind, {}, located_count_max, divergence).has_value(),
          "states of a trace can be compared");
  for (const verifier::LaneReport& row : divergence.rows) require(!row.column.empty(), "a lane has a column");
  for (const verifier::ContentReport& content : divergence.contents)
    require(!verifier::content_place(content).empty() && !verifier::content_values(content, "a", "b").empty(),
            "a text has a place and values");
  require((before == behind) || divergence.lane_count + divergence.content_count > 0, "a difference is found");
}

Reading read_on(replay::TraceReader& reader, std::uint64_t first_tick) {
  Reading reading;
  Bytes state;  // the last one that was stored
  const auto take_state = [&](Bytes next) {
    if (!state.empty() && std::max(state.size(), next.size()) <= compared_size_max)
      compare_states(reader.setup().schema, state, next);
    state = std::move(next);
  };
  for (;;) {
    const replay::TraceReader::Item& item = reader.next();
    require(reader.offset() <= reader.size(), "a place in the file");
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      require(tick->tick == first_tick + reading.roots.size(), "ticks rise by one");
      require(std::isfinite(tick->dt) && tick->dt >= 0, "dt is finite");
      require(tick->stage_hashes.empty() || tick->stage_hashes.size() == reader.setup().stages.size(), "stage hashes");
      reading.roots.push_back(tick->root_hash);
      if (tick->image) take_state(tick->image->joined());
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      require(checkpoint->tick == first_tick + reading.roots.size(), "a checkpoint stands at its tick");
      ++reading.checkpoint_count;
      take_state({checkpoint->image.begin(), checkpoint->image.end()});
    } else {
      break;
    }
  }
  const replay::TraceTail& tail = reader.tail();
  require(tail.condition == replay::TraceCondition::complete || !tail.message.empty(), "what is wrong is said");
  require(tail.offset <= reader.size(), "the place of damage is in the file");
  return reading;
}

void check_seek(replay::TraceReader& reader, const Reading& whole, bool is_whole, std::uint64_t tick) {
  if (!reader.seek(tick)) return;
  const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&reader.next());
  if (checkpoint == nullptr) return;
  const std::uint64_t start = checkpoint->tick;
  require(start <= tick, "a seek goes to a checkpoint at or before the tick");
  const Reading rest = read_on(reader, start);
  // The index is outside the chain: in a file that was forged and is damaged before it, it may lead to chunks that are
  // right in themselves and are never met in order.
  if (!is_whole) return;
  const std::uint64_t behind = start - reader.first_tick();
  for (std::size_t i = 0; i < rest.roots.size() && behind + i < whole.roots.size(); ++i)
    require(rest.roots[i] == whole.roots[behind + i], "a seek finds the same ticks");
}

void check_recovery(ByteView bytes, const Reading& whole) {
  const MemoryFile broken(bytes);
  const std::string output = "/dev/shm/ticktrue_fuzz_" + std::to_string(::getpid()) + ".ttr";
  const auto result = replay::recover_trace(broken.path(), output, true);
  if (result && (result->ticks_written > 0 || result->tail.condition == replay::TraceCondition::complete)) {
    require(result->ticks_written >= whole.roots.size(), "every tick that was read is recovered");
    auto saved = replay::TraceReader::open(output);
    require(saved.has_value(), "a recovered trace opens");
    const Reading again = read_on(*saved, saved->first_tick());
    require(saved->tail().condition == replay::TraceCondition::complete, "a recovered trace is complete");
    require(again.roots.size() == result->ticks_written, "a recovered trace has the ticks it is said to have");
    require(std::equal(whole.roots.begin(), whole.roots.end(), again.roots.begin()), "and they are the same");
  }
  ::unlink(output.c_str());
}

/// Goes through the chunks, and sets sequence, ticks, chain and checks as a writer would.
/// Kinds, sizes, records and payloads stay as they are; behind a chunk without sense all stays as it is.
class Forger {
 public:
  explicit Forger(ByteView bytes) : bytes_(bytes.begin(), bytes.end()) {}

  Bytes take() {
    if (bytes_.size() < replay::file_header_size) return std::move(bytes_);
    const std::uint16_t version = ByteReader(ByteView(bytes_).subspan(replay::magic.size())).u16();
    if (version > replay::format_version_first && version <= replay::format_version) version_ = version;
    seed_ = chain_ = replay::chain_start(version_);
    ByteWriter header;
    replay::encode_file_header(header, version_);
    put(0, header.view());
    offset_ = replay::file_header_size;
    while (forge_chunk()) {
    }
    return std::move(bytes_);
  }

 private:
  void put(std::size_t offset, ByteView part) {
    std::copy(part.begin(), part.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void put_u64(std::size_t offset, std::uint64_t value) {
    ByteWriter out;
    out.u64(value);
    put(offset, out.view());
  }

  bool forge_chunk() {
    if (bytes_.size() - offset_ < replay::chunk_header_size) return false;
    ByteReader in(ByteView(bytes_).subspan(offset_ + 4));
    replay::ChunkHeader header;
    header.kind = in.u8();
    in.bytes(7);
    header.size = in.u32();
    header.sequence = sequence_++;
    header.tick = tick_;
    header.chain = chain_;
    // Where a trace begins, only its first checkpoint says.
    if (const std::uint64_t tick = in.u64(); header.kind == static_cast<std::uint8_t>(replay::ChunkKind::checkpoint) &&
                                             !std::exchange(has_checkpoint_, true))
      header.tick = tick_ = tick;
    const bool is_ticks = header.kind == static_cast<std::uint8_t>(replay::ChunkKind::ticks);
    if (is_ticks) header.size = replay::streamed_size;
    ByteWriter out;
    header.check = replay::encode_chunk_header(header, seed_, out);
    put(offset_, out.view());
    offset_ += replay::chunk_header_size;
    return is_ticks ? forge_records(replay::begin_running(header, version_)) : forge_payload(header);
  }

  bool forge_records(replay::Running running) {
    std::uint64_t tick_count = 0;
    for (;;) {
      const replay::Record record = replay::parse_record(ByteView(bytes_).subspan(offset_), nullptr, version_);
      if (record.fault != replay::RecordFault::none) return false;
      const auto tag = static_cast<replay::RecordTag>(record.tag);
      if (tag == replay::RecordTag::root || tag == replay::RecordTag::root_image) ++tick_count;
      if (tag == replay::RecordTag::close) {
        ByteWriter count;
        count.u32(static_cast<std::uint32_t>(tick_count));
        put(offset_ + 1, count.view());
      }
      const bool is_close = tag == replay::RecordTag::close;
      const bool is_third = version_ >= replay::format_version_third;
      const std::size_t checks_size = !is_close ? 2 : is_third ? 16 : 8;
      const ByteView checked = ByteView(bytes_).subspan(offset_, record.size - checks_size);
      const bool is_bound = is_third && replay::is_bound_tag(record.tag);
      if (is_bound || (is_third && is_close)) running.outside = hash64(checked, running.outside);
      if (!is_bound) running.chained = hash64(checked, running.chained);
      offset_ += record.size;
      ByteWriter checks;
      if (is_bound || (is_third && is_close)) checks.u64(running.outside);
      if (!is_bound) checks.u64(running.chained);
      put(offset_ - checks_size, checks.view().first(checks_size));
      if (!is_close) continue;
      tick_ += tick_count;
      chain_ = running.chained;
      return true;
    }
  }

  bool forge_payload(const replay::ChunkHeader& header) {
    if (header.size > bytes_.size() - offset_ || bytes_.size() - offset_ - header.size < replay::chunk_trailer_size)
      return false;
    const ByteView payload = ByteView(bytes_).subspan(offset_, header.size);
    const std::uint64_t trailer = hash64(payload, header.check);
    using replay::ChunkKind;
    switch (static_cast<ChunkKind>(header.kind)) {
      case ChunkKind::checkpoint:
      case ChunkKind::image: {
        const auto part = replay::decode_image_part(payload, version_);
        Bytes raw;
        if (part && replay::unpack_image_part(*part, raw))
          chain_ = replay::extend_chain(header, payload.first(replay::image_fields_size(version_)), raw, version_);
        break;
      }
      case ChunkKind::facts:
      case ChunkKind::index:
      case ChunkKind::footer:
      case ChunkKind::shown:
      case ChunkKind::save:
      case ChunkKind::peer:
        break;
      default:
        chain_ = replay::extend_chain(header, {}, payload, version_);
        if (sequence_ == 1) seed_ = chain_;
        break;
    }
    offset_ += header.size;
    put_u64(offset_, trailer);
    offset_ += replay::chunk_trailer_size;
    return true;
  }

  Bytes bytes_;
  std::size_t offset_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint64_t tick_ = 0;
  bool has_checkpoint_ = false;
  std::uint16_t version_ = replay::format_version_first;
  std::uint64_t chain_ = 0;
  std::uint64_t seed_ = 0;
};

}  // namespace

Bytes with_right_checks(ByteView bytes) {
  return Forger(bytes).take();
}

void read_in_every_way(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "fuzz.ttr");
  if (!reader) {
    require_message(reader.error());
    return;
  }
  const std::uint64_t first_tick = reader->first_tick();
  const Reading whole = read_on(*reader, first_tick);
  require(reader->tail().ticks_intact == first_tick + whole.roots.size(), "ticks_intact counts the ticks");
  const bool is_whole = reader->tail().condition == replay::TraceCondition::complete;
  reader->rewind();
  require(read_on(*reader, first_tick).roots == whole.roots, "reading again gives the same");
  for (const std::uint64_t tick : {first_tick, first_tick + whole.roots.size() / 2, std::uint64_t{1} << 50})
    check_seek(*reader, whole, is_whole, tick);
  reader->tick_count_hint();
  check_recovery(bytes, whole);
  const auto bundle = verifier::Bundle::read(*reader);
  if (!bundle) require_message(bundle.error());
  if (bundle && *bundle) require(!(**bundle).text(reader->setup().schema).empty(), "a bundle says something");

  ByteReader setup(reader->setup().setup);
  if (setup.u32() > toy_body_count_max) return;
  // Each mode, and replay once more with ticks that run twice.
  for (std::size_t way = 0; way <= verifier::verify_modes.size(); ++way) {
    const bool is_sync = way == verifier::verify_modes.size();
    const verifier::VerifyModeInfo& mode = verifier::verify_modes[is_sync ? 0 : way];
    verifier::VerifyOptions options;
    options.sync_ticks = is_sync ? 3 : 0;
    options.simulation = reader->setup().has(replay::Feature::saves) ? &saving_toy_info : &test::toy_info;
    options.mode = mode.mode;
    reader->rewind();
    const verifier::Report report = verifier::verify(*reader, options);
    require(!verifier::report_text(report).empty(), "a report says something");
  }
}

}  // namespace ticktrue::fuzz
