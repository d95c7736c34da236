// Reading, seeking, recovering and verifying of any bytes.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/trace_reading.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "replay/trace_reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/toy_simulation.h"
#include "verifier/verify/verify.h"

namespace ticktrue::fuzz {
namespace {

constexpr std::uint32_t toy_body_count_max = 100;

struct Reading {
  std::vector<std::uint64_t> roots;  // of the ticks, in order
  std::uint64_t checkpoint_count = 0;
};

Reading read_on(replay::TraceReader& reader, std::uint64_t first_tick) {
  Reading reading;
  for (;;) {
    const replay::TraceReader::Item& item = reader.next();
    require(reader.offset() <= reader.size(), "a place in the file");
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) {
      require(tick->tick == first_tick + reading.roots.size(), "ticks rise by one");
      require(std::isfinite(tick->dt) && tick->dt >= 0, "dt is finite");
      require(tick->stage_hashes.empty() || tick->stage_hashes.size() == reader.setup().stages.size(), "stage hashes");
      reading.roots.push_back(tick->root_hash);
    } else if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      require(checkpoint->tick == first_tick + reading.roots.size(), "a checkpoint stands at its tick");
      ++reading.checkpoint_count;
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

}  // namespace

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

  ByteReader setup(reader->setup().setup);
  if (setup.u32() > toy_body_count_max) return;
  for (const verifier::VerifyModeInfo& mode : verifier::verify_modes) {
    verifier::VerifyOptions options;
    options.simulation = &test::toy_info;
    options.mode = mode.mode;
    reader->rewind();
    const verifier::Report report = verifier::verify(*reader, options);
    require(!verifier::report_text(report).empty(), "a report says something");
  }
}

}  // namespace ticktrue::fuzz
