// Fuzzes files of a store: an entry, the same under a right checksum, a report, a row of the history, a plan of shards.
// SPDX-License-Identifier: MIT
#include "base/hash.h"
#include "tests/fuzz/support/fuzz.h"
#include "tool/corpus/run/shard_plan.h"
#include "verifier/report/report_ci.h"
#include "verifier/report/report_transfer.h"
#include "verifier/store/history.h"
#include "verifier/store/verdict_entry.h"

namespace {

void show(const ticktrue::verifier::VerdictEntry& entry) {
  using namespace ticktrue;
  if (entry.kind != verifier::VerdictEntry::Kind::verdict) return;
  const Result<verifier::Report> report = verifier::decode_report(entry.content);
  if (!report) {
    fuzz::require_message(report.error());
    return;
  }
  const std::span<const verifier::Report> one(&*report, 1);
  fuzz::require(!verifier::report_text(*report).empty(), "a report has a text");
  fuzz::require(!verifier::report_json(one, false).empty(), "a report has a JSON object");
  fuzz::require(!verifier::report_junit(one, false).empty(), "a report has a test case");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const Bytes bytes(data, data + size);
  if (const auto entry = verifier::decode_entry(bytes)) show(*entry);
  verifier::VerdictEntry report;
  report.content = bytes;
  show(report);
  if (const auto row = verifier::decode_history_row(bytes)) fuzz::require(row->seconds >= 0, "work takes time");
  constexpr std::uint32_t shard_count = 3;
  constexpr std::size_t trace_count = 4;
  if (const auto plan = tool::decode_plan(bytes, trace_count, shard_count))
    fuzz::require(tool::encode_plan(*plan) == bytes, "a plan is written as it was read");
  // The last eight bytes of a seed are its checksum.
  constexpr std::size_t checksum_size = 8;
  if (size < checksum_size) return 0;
  ByteWriter forged;
  forged.bytes(ByteView(bytes).first(size - checksum_size));
  forged.u64(hash64(forged.view()));
  if (const auto entry = verifier::decode_entry(forged.view())) show(*entry);
  return 0;
}
