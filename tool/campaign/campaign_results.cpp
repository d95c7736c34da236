// Rows of results as text, and the file that holds them.
// SPDX-License-Identifier: MIT
#include "tool/campaign/campaign_results.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <utility>

#include "base/plain_text.h"
#include "replay/file/file_calls.h"

namespace ticktrue::campaign {
namespace {

constexpr std::size_t column_count = 10;
constexpr std::uint64_t file_size_max = std::uint64_t{1} << 30;
constexpr std::size_t block_size = 1u << 20;

std::string cell(const std::string& text) {
  return text.empty() ? "-" : plain_line(text);
}

std::string uncell(std::string_view text) {
  return text == "-" ? std::string() : std::string(text);
}

bool read_number(std::string_view text, std::uint64_t& number) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failure == std::errc() && end == text.data() + text.size();
}

/// A file in the folder, or none.
bool is_name(std::string_view name) {
  return name != ".." && name.find('/') == std::string_view::npos;
}

std::optional<SeedResult> parse_line(std::string_view line) {
  std::array<std::string_view, column_count> cells;
  for (std::size_t i = 0; i < column_count; ++i) {
    const std::size_t end = line.find('\t');
    if ((end == std::string_view::npos) != (i + 1 == column_count)) return std::nullopt;
    cells[i] = line.substr(0, end);
    line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
  }
  SeedResult result;
  const auto info = std::find_if(verifier::verdicts.begin(), verifier::verdicts.end(),
                                 [&](const verifier::VerdictInfo& one) { return one.name == cells[2]; });
  std::uint64_t tick = 0;
  const bool has_tick = cells[4] != "-";
  // A seed of which the machine could not say a thing is run again, and has no row.
  if (info == verifier::verdicts.end() || info->verdict == verifier::Verdict::error ||
      !read_number(cells[0], result.seed) || !read_number(cells[3], result.ticks) ||
      (has_tick && !read_number(cells[4], tick)))
    return std::nullopt;
  result.program = uncell(cells[1]);
  result.verdict = info->verdict;
  if (has_tick) result.tick = tick;
  result.table = uncell(cells[5]);
  result.column = uncell(cells[6]);
  result.trace = uncell(cells[7]);
  result.second = uncell(cells[8]);
  result.reason = uncell(cells[9]);
  if (!is_name(result.trace) || !is_name(result.second)) return std::nullopt;
  return result;
}

}  // namespace

std::string results_head() {
  return "# seed\tprogram\tverdict\tticks\ttick\ttable\tcolumn\ttrace\tsecond\treason\n";
}

std::string result_line(const SeedResult& result) {
  return std::to_string(result.seed) + "\t" + cell(result.program) + "\t" +
         std::string(verifier::verdict_info(result.verdict).name) + "\t" + std::to_string(result.ticks) + "\t" +
         (result.tick ? std::to_string(*result.tick) : "-") + "\t" + cell(result.table) + "\t" + cell(result.column) +
         "\t" + cell(result.trace) + "\t" + cell(result.second) + "\t" + cell(result.reason) + "\n";
}

std::map<std::uint64_t, SeedResult> parse_results(std::string_view text, SeedRange seeds) {
  std::map<std::uint64_t, SeedResult> results;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    std::optional<SeedResult> result = parse_line(text.substr(0, end));
    if (result && result->seed >= seeds.first && result->seed <= seeds.last) {
      const std::uint64_t seed = result->seed;
      results.insert_or_assign(seed, *std::move(result));
    }
    text.remove_prefix(end + 1);
  }
  return results;
}

Result<ResultsFile> ResultsFile::open(const std::string& folder, SeedRange seeds) {
  const std::string path = folder + "/" + results_name;
  const int descriptor = replay::open_file(path, O_RDWR | O_CREAT | O_APPEND);
  if (descriptor < 0) return replay::io_error(path, "open", errno);
  ResultsFile file(path, descriptor);
  if (!replay::lock_file(descriptor))
    return Error{ErrorCode::io,
                 path + ": in use by " + replay::lock_holder(descriptor) + ", expected no other campaign",
                 "--out names another folder"};
  std::string text;
  if (const Status read = file.read_all(text); !read) return read.error();
  file.before_ = parse_results(text, seeds);
  // A line that was cut short ends here, so that the next one is whole.
  const std::string_view begin = text.empty() || text.back() == '\n' ? "" : "\n";
  if (const Status written = file.write_all(text.empty() ? results_head() : std::string(begin)); !written)
    return written.error();
  return file;
}

ResultsFile::ResultsFile(ResultsFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      before_(std::move(other.before_)) {}

ResultsFile::~ResultsFile() {
  if (descriptor_ >= 0) replay::close_file(descriptor_);
}

Status ResultsFile::append(const SeedResult& result) {
  return write_all(result_line(result));
}

Status ResultsFile::read_all(std::string& text) const {
  std::vector<std::uint8_t> block(block_size);
  for (;;) {
    const std::int64_t size = replay::read_some(descriptor_, block.data(), block.size(), text.size());
    if (size < 0) return replay::io_error(path_, "read", errno);
    if (size == 0) return {};
    text.append(reinterpret_cast<const char*>(block.data()), static_cast<std::size_t>(size));
    if (text.size() > file_size_max)
      return Error{ErrorCode::limit,
                   path_ + ": size: found more than " + std::to_string(file_size_max) + " bytes, expected at most that",
                   "it is no file of a campaign, or one to begin anew"};
  }
}

Status ResultsFile::write_all(std::string_view text) const {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  for (std::size_t done = 0; done < text.size();) {
    const std::int64_t size = replay::write_some(descriptor_, bytes + done, text.size() - done);
    if (size < 0) return replay::io_error(path_, "write", errno);
    done += static_cast<std::size_t>(size);
  }
  return {};
}

}  // namespace ticktrue::campaign
