// Lists traces and divides the list into shards.
// SPDX-License-Identifier: MIT
#include "verifier/corpus/trace_list.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>

namespace ticktrue::verifier {
namespace {

constexpr std::uint64_t shard_count_max = 1'000'000;

bool read_count(std::string_view text, std::uint64_t& value) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && end == text.data() + text.size() && value >= 1 && value <= shard_count_max;
}

}  // namespace

Result<std::vector<std::string>> list_traces(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const std::string& word : words) {
    std::error_code failure;
    if (!std::filesystem::is_directory(word, failure)) {
      files.push_back(word);
      continue;
    }
    std::vector<std::string> found;
    std::filesystem::directory_iterator entry(word, failure);
    for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure))
      if (entry->path().extension() == ".ttr") found.push_back(entry->path().string());
    if (failure) return Error{ErrorCode::io, word + ": cannot be listed: " + failure.message(), ""};
    if (found.empty()) return Error{ErrorCode::io, word + ": no trace in this directory: found no *.ttr", ""};
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

Result<Shard> parse_shard(const std::string& text) {
  Shard shard;
  const std::size_t slash = text.find('/');
  const bool is_read = slash != std::string::npos && read_count(std::string_view(text).substr(0, slash), shard.index) &&
                       read_count(std::string_view(text).substr(slash + 1), shard.count);
  if (is_read && shard.index <= shard.count) return shard;
  return Error{ErrorCode::usage, "--shard: found \"" + text + "\", expected I/N with 1 <= I <= N, such as 2/8", ""};
}

std::vector<std::string> take_shard(std::vector<std::string> files, const Shard& shard) {
  std::sort(files.begin(), files.end());
  std::vector<std::string> part;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (i % shard.count + 1 == shard.index) part.push_back(files[i]);
  return part;
}

}  // namespace ticktrue::verifier
