// Reads and writes rows of the history as files.
// SPDX-License-Identifier: MIT
#include "verifier/store/history.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <tuple>
#include <utility>

#include "verifier/store/verdict_entry.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t row_size_max = 64u << 10;
constexpr std::uint64_t row_version = 1;

std::string folder_of(const std::string& trace) {
  return "history/" + spread_name(trace);
}

Bytes encode_row(const HistoryRow& row) {
  ByteWriter out;
  out.u64(row_version);
  for (const Hash128& hash : {row.engine, row.libraries}) {
    out.u64(hash.high);
    out.u64(hash.low);
  }
  for (const std::string* text : {&row.options, &row.mode, &row.commit, &row.build, &row.verdict}) out.text(*text);
  out.u64(static_cast<std::uint64_t>(row.when_s));
  out.f64(row.seconds);
  out.u64(row.ticks_recorded);
  out.u64(row.ticks_compared);
  out.u64(row.root_hash);
  out.u8(row.diverged ? 1 : 0);
  out.u64(row.diverged.value_or(0));
  return out.take();
}

}  // namespace

std::optional<HistoryRow> decode_history_row(ByteView bytes) {
  ByteReader in(bytes);
  HistoryRow row;
  if (in.u64() != row_version) return std::nullopt;
  for (Hash128* hash : {&row.engine, &row.libraries}) {
    hash->high = in.u64();
    hash->low = in.u64();
  }
  for (std::string* text : {&row.options, &row.mode, &row.commit, &row.build, &row.verdict})
    *text = in.text(row_size_max);
  row.when_s = static_cast<std::int64_t>(in.u64());
  row.seconds = in.f64();
  row.ticks_recorded = in.u64();
  row.ticks_compared = in.u64();
  row.root_hash = in.u64();
  const bool has_diverged = in.u8() != 0;
  const std::uint64_t diverged = in.u64();
  if (has_diverged) row.diverged = diverged;
  if (!in.ok() || !in.at_end() || !std::isfinite(row.seconds) || row.seconds < 0) return std::nullopt;
  return row;
}

std::string history_name(const Hash128& trace, std::uint64_t size) {
  ByteWriter out;
  out.text("ticktrue.history/1");
  out.u64(trace.high);
  out.u64(trace.low);
  out.u64(size);
  return hex128(hash128(out.view()));
}

Status History::add(const std::string& trace, const HistoryRow& row) const {
  VerdictEntry entry;
  entry.kind = VerdictEntry::Kind::history;
  entry.key = row.key;
  entry.by = folder_.owner();
  entry.content = encode_row(row);
  const std::string name = folder_of(trace) + "/" + row.key;
  const auto published = folder_.publish(name, encode_entry(entry));
  if (published || folder_.exists(name)) return {};
  return published.error();
}

TraceHistory History::find(const std::string& trace) const {
  TraceHistory history;
  for (const std::string& name : folder_.list(folder_of(trace))) {
    const std::string file = folder_of(trace) + "/" + name;
    const Result<std::optional<Bytes>> bytes = folder_.read(file, row_size_max);
    if (bytes && !*bytes) continue;
    const std::optional<VerdictEntry> entry = bytes ? decode_entry(**bytes) : std::nullopt;
    std::optional<HistoryRow> row;
    if (entry && entry->kind == VerdictEntry::Kind::history && entry->key == name)
      row = decode_history_row(entry->content);
    if (!row) {
      history.warnings.push_back(folder_.path_of(file) + ": damaged: " +
                                 (bytes ? "its bytes are not what was written" : bytes.error().message));
      continue;
    }
    row->key = name;
    history.rows.push_back(std::move(*row));
  }
  std::sort(history.rows.begin(), history.rows.end(), [](const HistoryRow& a, const HistoryRow& b) {
    return std::tie(a.when_s, a.key) < std::tie(b.when_s, b.key);
  });
  return history;
}

}  // namespace ticktrue::verifier
