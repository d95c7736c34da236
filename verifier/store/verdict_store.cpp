// Finds, adds and sets aside verdicts.
// SPDX-License-Identifier: MIT
#include "verifier/store/verdict_store.h"

#include <utility>

#include "base/build_info.h"
#include "base/bytes.h"
#include "base/hash.h"
#include "verifier/report/report_transfer.h"
#include "verifier/store/verdict_entry.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t entry_size_max = 4u << 20;  // a report lists at most 64 lanes and the inputs of one tick
constexpr int add_attempts_max = 8;               // between attempts, another process can move a damaged file

/// Encodes a report. If its lists are too long for an entry, only the fields for is_same_verdict are kept.
Bytes encode_bounded(Report report) {
  Bytes bytes = encode_report(report);
  constexpr std::size_t room = 64u << 10;  // for the rest of an entry
  if (bytes.size() + room <= entry_size_max) return bytes;
  if (report.divergence) {
    report.divergence->inputs.clear();
    report.divergence->rows.clear();
    report.divergence->candidates.clear();
    report.divergence->spread.clear();
  }
  if (report.end) {
    report.end->pending_inputs.clear();
    report.end->tail.pending_inputs.clear();
  }
  report.recorded_build.clear();
  report.again.clear();
  report.notes = {"the store holds a shorter report than was found"};
  return encode_report(report);
}

std::string verdict_words(const Report& report) {
  return std::string(verdict_info(report.verdict).name) + " after " + std::to_string(report.ticks_compared) + " ticks";
}

std::string writer_words(const StoreFolder& folder) {
  return folder.owner() + ", " + build_line();
}

std::string conflict_name(const std::string& key, ByteView entry) {
  return "conflicts/" + key + "-" + hex64(hash64(entry));
}

Error damaged_error(const std::string& path) {
  return Error{ErrorCode::io, path + ": damaged files come back as often as they are moved away",
               "look for a program that changes the store"};
}

}  // namespace

std::string verdict_key(const VerdictSubject& subject) {
  ByteWriter out;
  out.text("ticktrue.verdict/1");
  for (const Hash128& hash : {subject.trace, subject.engine, subject.libraries}) {
    out.u64(hash.high);
    out.u64(hash.low);
  }
  out.u64(subject.size);
  out.text(subject.options);
  return hex128(hash128(out.view()));
}

bool is_same_verdict(const Report& a, const Report& b) {
  if (a.verdict != b.verdict || a.ticks_recorded != b.ticks_recorded || a.ticks_compared != b.ticks_compared ||
      a.first_tick != b.first_tick || a.root_hash != b.root_hash || a.checkpoint != b.checkpoint ||
      a.divergence.has_value() != b.divergence.has_value())
    return false;
  if (!a.divergence) return true;
  return a.divergence->tick == b.divergence->tick && a.divergence->stage == b.divergence->stage &&
         a.divergence->expected_root == b.divergence->expected_root && a.divergence->got_root == b.divergence->got_root;
}

Result<FoundVerdict> VerdictStore::find(const std::string& key) const {
  return read_entry(key, nullptr);
}

Result<FoundVerdict> VerdictStore::read_entry(const std::string& key, Bytes* read) const {
  const std::string name = spread_name(key);
  const Result<std::optional<Bytes>> bytes = folder_.read(name, entry_size_max);
  if (!bytes) {
    if (bytes.error().code != ErrorCode::limit) return bytes.error();
    return set_aside(key, bytes.error().message);
  }
  FoundVerdict found;
  if (!*bytes) return found;
  const std::optional<VerdictEntry> entry = decode_entry(**bytes);
  if (!entry) return set_aside(key, "its bytes are not what was written");
  if (entry->key != key) return set_aside(key, "it is the verdict of " + entry->key);
  found.file = folder_.path_of(name);
  if (entry->kind == VerdictEntry::Kind::conflict) {
    found.kind = FoundVerdict::Kind::conflict;
    found.what.assign(entry->content.begin(), entry->content.end());
    return found;
  }
  if (entry->kind != VerdictEntry::Kind::verdict) return set_aside(key, "it is no verdict");
  Result<Report> report = decode_report(entry->content);
  if (!report) return set_aside(key, report.error().message);
  found.kind = FoundVerdict::Kind::verdict;
  found.report = std::move(*report);
  if (read != nullptr) *read = **bytes;
  return found;
}

Result<FoundVerdict> VerdictStore::set_aside(const std::string& key, const std::string& why) const {
  const std::string name = spread_name(key);
  const Result<std::string> aside = folder_.set_aside(name);
  if (!aside) return aside.error();
  FoundVerdict found;
  if (aside->empty()) return found;
  // Between the reading and the move, another process may have replaced the file by an intact one.
  const Result<std::optional<Bytes>> moved = folder_.read(*aside, entry_size_max);
  if (moved && *moved) {
    const std::optional<VerdictEntry> entry = decode_entry(**moved);
    if (entry && entry->key == key && (entry->kind == VerdictEntry::Kind::conflict || decode_report(entry->content))) {
      folder_.put_back(*aside, name);
      return found;
    }
  }
  found.kind = FoundVerdict::Kind::damaged;
  found.file = folder_.path_of(*aside);
  found.what = folder_.path_of(name) + ": damaged: " + why + "; moved to " + found.file;
  return found;
}

Result<FoundVerdict> VerdictStore::add(const std::string& key, const Report& report) const {
  VerdictEntry entry;
  entry.key = key;
  entry.by = writer_words(folder_);
  entry.content = encode_bounded(report);
  const Bytes bytes = encode_entry(entry);
  for (int attempt = 0; attempt < add_attempts_max; ++attempt) {
    const Result<StoreFolder::Publish> published = folder_.publish(spread_name(key), bytes);
    Bytes there;
    Result<FoundVerdict> found = read_entry(key, &there);
    if (!found) return published ? found.error() : published.error();
    if (found->kind == FoundVerdict::Kind::conflict) {
      // Two sides are enough for people: a third side may be lost on a full disk.
      static_cast<void>(folder_.publish(conflict_name(key, bytes), bytes));
      return found;
    }
    if (found->kind == FoundVerdict::Kind::verdict) {
      // Also if this entry could not be written: the existing entry is the same, or is contradicted.
      found->is_new = published && *published == StoreFolder::Publish::created;
      if (is_same_verdict(*found->report, report)) return found;
      return add_conflict(key, {*found->report, there}, {report, bytes});
    }
    if (!published) return published.error();
  }
  return damaged_error(folder_.path_of(spread_name(key)));
}

Result<FoundVerdict> VerdictStore::add_conflict(const std::string& key, const Side& there, const Side& here) const {
  std::string what = "two verdicts for the same bytes, engine and options: ";
  for (const Side* side : {&there, &here}) {
    const std::string name = conflict_name(key, side->entry);
    const auto kept = folder_.publish(name, side->entry);
    what += kept ? folder_.path_of(name) : "one that could not be kept (" + kept.error().message + ")";
    what += " says " + verdict_words(side->report) + (side == &there ? ", " : "");
  }
  VerdictEntry entry;
  entry.kind = VerdictEntry::Kind::conflict;
  entry.key = key;
  entry.by = writer_words(folder_);
  entry.content.assign(what.begin(), what.end());
  const Bytes bytes = encode_entry(entry);
  Status written = folder_.replace(spread_name(key), bytes);
  if (!written) {
    // A contradicted verdict must not stay. Its disk space may be enough for the conflict.
    folder_.remove(spread_name(key));
    written = folder_.replace(spread_name(key), bytes);
  }
  if (!written) return Error{written.error().code, what + "; " + written.error().message, written.error().hint};
  FoundVerdict found;
  found.kind = FoundVerdict::Kind::conflict;
  found.file = folder_.path_of(spread_name(key));
  found.what = what;
  return found;
}

}  // namespace ticktrue::verifier
