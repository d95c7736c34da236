// Publishes and reads decisions.
// SPDX-License-Identifier: MIT
#include "verifier/store/agreement.h"

#include <utility>

#include "verifier/store/verdict_entry.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t agreement_size_max = 64u << 20;  // the plan of a corpus has a few bytes for each trace
constexpr int agree_attempts_max = 8;                  // between attempts, another process can move a damaged file

std::string name_of(const std::string& key) {
  return "agreed/" + spread_name(key);
}

}  // namespace

Result<std::optional<Bytes>> find_agreement(const StoreFolder& folder, const std::string& key) {
  Result<std::optional<Bytes>> bytes = folder.read(name_of(key), agreement_size_max);
  if (!bytes && bytes.error().code != ErrorCode::limit) return bytes.error();
  if (bytes && !*bytes) return std::optional<Bytes>();
  std::optional<VerdictEntry> entry = bytes ? decode_entry(**bytes) : std::nullopt;
  if (entry && entry->kind == VerdictEntry::Kind::agreement && entry->key == key)
    return std::optional<Bytes>(std::move(entry->content));
  const Result<std::string> aside = folder.set_aside(name_of(key));
  if (!aside) return aside.error();
  return std::optional<Bytes>();
}

Result<Bytes> agree_on(const StoreFolder& folder, const std::string& key, ByteView wanted) {
  VerdictEntry entry;
  entry.kind = VerdictEntry::Kind::agreement;
  entry.key = key;
  entry.by = folder.owner();
  entry.content.assign(wanted.begin(), wanted.end());
  const Bytes bytes = encode_entry(entry);
  for (int attempt = 0; attempt < agree_attempts_max; ++attempt) {
    if (const auto published = folder.publish(name_of(key), bytes); !published) return published.error();
    Result<std::optional<Bytes>> found = find_agreement(folder, key);
    if (!found) return found.error();
    if (*found) return std::move(**found);
  }
  return Error{ErrorCode::io,
               folder.path_of(name_of(key)) + ": damaged files come back as often as they are moved away",
               "look for a program that changes the store"};
}

}  // namespace ticktrue::verifier
