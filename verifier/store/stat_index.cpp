// Reads and writes the file of a stat index: rows and a checksum.
// SPDX-License-Identifier: MIT
#include "verifier/store/stat_index.h"

#include <chrono>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/bytes.h"
#include "base/hash.h"

namespace ticktrue::verifier {
namespace {

constexpr std::string_view index_head = "ticktrue stat index 1\n";
constexpr std::size_t index_size_max = 256u << 20;  // a million files with long names
constexpr std::size_t file_name_size_max = 4096;
constexpr std::size_t index_checksum_size = 8;
constexpr auto settling_time = std::chrono::minutes(10);

/// "HOST" of "HOST-PROCESS-NUMBER". The inodes of another machine identify other files.
std::string host_of(const std::string& owner) {
  return owner.substr(0, owner.rfind('-', owner.rfind('-') - 1));
}

std::int64_t now_ns() {
  using std::chrono::duration_cast;
  return duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

bool is_unchanged(const replay::FileFacts& before, const replay::FileFacts& after) {
  return before.device == after.device && before.inode == after.inode && before.size == after.size &&
         before.modified_ns == after.modified_ns && before.changed_ns == after.changed_ns;
}

StatIndex::StatIndex(const StoreFolder& folder, const std::string& traces) : folder_(folder.unsynced()) {
  std::error_code failure;
  const std::string place = std::filesystem::weakly_canonical(traces, failure).string();
  ByteWriter words;
  words.text(host_of(folder.owner()));
  words.text(failure ? traces : place);
  name_ = "index/" + hex128(hash128(words.view()));
  const Result<std::optional<Bytes>> bytes = folder_.read(name_, index_size_max);
  if (bytes && *bytes) read(**bytes);
}

void StatIndex::read(ByteView bytes) {
  if (bytes.size() < index_head.size() + index_checksum_size) return;
  const ByteView covered = bytes.first(bytes.size() - index_checksum_size);
  ByteReader checksum(bytes.last(index_checksum_size));
  if (checksum.u64() != hash64(covered) || std::memcmp(covered.data(), index_head.data(), index_head.size()) != 0)
    return;
  ByteReader in(covered.subspan(index_head.size()));
  std::map<std::string, Row> rows;
  while (in.ok() && !in.at_end()) {
    std::string file = in.text(file_name_size_max);
    Row row;
    row.facts.device = in.u64();
    row.facts.inode = in.u64();
    row.facts.size = in.u64();
    row.facts.modified_ns = static_cast<std::int64_t>(in.u64());
    row.facts.changed_ns = static_cast<std::int64_t>(in.u64());
    row.hash.high = in.u64();
    row.hash.low = in.u64();
    rows.emplace_hint(rows.end(), std::move(file), row);
  }
  if (in.ok()) rows_ = std::move(rows);
}

std::optional<Hash128> StatIndex::find(const std::string& file, const replay::FileFacts& facts) const {
  const std::lock_guard<std::mutex> guard(lock_);
  const auto found = rows_.find(file);
  if (found == rows_.end() || !is_unchanged(found->second.facts, facts)) return std::nullopt;
  return found->second.hash;
}

void StatIndex::note(const std::string& file, const replay::FileFacts& facts, const Hash128& hash) {
  const std::int64_t settled_ns =
      now_ns() - std::chrono::duration_cast<std::chrono::nanoseconds>(settling_time).count();
  const bool is_settled = facts.changed_ns < settled_ns && facts.modified_ns < settled_ns;
  if (!is_settled || facts.inode == 0 || file.size() > file_name_size_max) return;
  const std::lock_guard<std::mutex> guard(lock_);
  rows_[file] = Row{facts, hash};
  has_changed_ = true;
}

Status StatIndex::save() {
  const std::lock_guard<std::mutex> guard(lock_);
  if (!has_changed_) return {};
  ByteWriter out;
  for (const char c : index_head) out.u8(static_cast<std::uint8_t>(c));
  for (const auto& [file, row] : rows_) {
    out.text(file);
    for (const std::uint64_t value :
         {row.facts.device, row.facts.inode, row.facts.size, static_cast<std::uint64_t>(row.facts.modified_ns),
          static_cast<std::uint64_t>(row.facts.changed_ns), row.hash.high, row.hash.low})
      out.u64(value);
  }
  out.u64(hash64(out.view()));
  if (out.size() > index_size_max) return {};
  if (const Status status = folder_.replace(name_, out.view()); !status) return status;
  has_changed_ = false;
  return {};
}

}  // namespace ticktrue::verifier
