// Runs the program. The result is in the file of TICKTRUE_RESULT. If there is none, the page has the last tick.
// SPDX-License-Identifier: MIT
#include "verifier/programs/program_run.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "base/plain_text.h"
#include "shim/page.h"

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t printed_size_max = std::uint64_t{1} << 30;
constexpr std::size_t output_size_max = 64u << 10;  // of standard output, which is not used
constexpr std::uintmax_t result_size_max = 16u << 20;
constexpr std::uintmax_t mapped_size_max = 4u << 20;
constexpr std::size_t line_size_max = 160;

bool write_page(const std::string& path) {
  shim::SessionPart part{};
  part.magic = shim::page_magic;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(&part), sizeof part);
  return static_cast<bool>(out.flush());
}

void read_page(const std::string& path, ProgramRun& run) {
  shim::SessionPart part{};
  std::ifstream in(path, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(&part), sizeof part) || part.magic != shim::page_magic) return;
  run.has_session = part.session_process != 0;
  run.position = part.position;
}

/// Removes the files of a run.
class RunFiles {
 public:
  explicit RunFiles(const std::string& stem) : page(stem), result(stem + ".json"), mapped(stem + ".mapped") {}
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;
  ~RunFiles() {
    std::error_code ignored;
    for (const std::string& path : {page, result, mapped}) fs::remove(path, ignored);
  }
  const std::string page;
  const std::string result;
  const std::string mapped;
};

std::string read_text(const std::string& path, std::uintmax_t size) {
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(size));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

Result<std::string> read_result(const std::string& path) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(path, none);
  if (none) return std::string();
  if (size > result_size_max)
    return Error{ErrorCode::limit,
                 "result of the program: found " + std::to_string(size) + " bytes, expected at most " +
                     std::to_string(result_size_max),
                 "sessions write it to the file that TICKTRUE_RESULT names, and nobody else"};
  return read_text(path, size);
}

/// `result_count`: number of sessions that reported. Each of them must have listed the mappings of its process.
std::optional<std::vector<std::string>> read_mapped(const std::string& path, std::ptrdiff_t result_count) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(path, none);
  if (none || size == 0 || size > mapped_size_max) return std::nullopt;
  const std::string text = read_text(path, size);
  if (text.size() != size || text.back() != '\n') return std::nullopt;
  std::vector<std::string> lines;
  std::istringstream in(text);
  std::ptrdiff_t told_count = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty())
      ++told_count;
    else
      lines.push_back(line);
  }
  if (told_count < result_count) return std::nullopt;
  return lines;
}

}  // namespace

Result<ProgramRun> run_program(const std::vector<std::string>& words, const std::string& folder,
                               const std::string& name, double time_s) {
  const RunFiles files(folder + "/" + name);
  if (!write_page(files.page))
    return Error{ErrorCode::io, files.page + ": cannot be written", "the variable TMPDIR names another folder"};
  ChildCommand command;
  command.argv = words;
  command.environment = {
      {shim::page_variable, files.page}, {"TICKTRUE_RESULT", files.result}, {shim::mapped_variable, files.mapped}};
  command.limits.time_s = time_s;
  command.limits.output_size_max = output_size_max;
  command.limits.printed_size_max = printed_size_max;
  ProgramRun run;
  run.child = run_child(command);
  if (run.child.end.how != ChildEnd::How::exited) run.failure = child_failure(run.child, command.limits);
  read_page(files.page, run);
  Result<std::string> results = read_result(files.result);
  if (!results) return results.error();
  run.results = *std::move(results);
  run.mapped = read_mapped(files.mapped, std::count(run.results.begin(), run.results.end(), '\n'));
  return run;
}

std::string position_text(const ProgramRun& run) {
  if (!run.has_session) return "";
  if (run.position == 0) return ", before its first tick";
  const std::string tick = std::to_string((run.position - 1) / 2);
  return run.position % 2 == 1 ? ", in tick " + tick : ", behind tick " + tick;
}

std::string last_line(const ProgramRun& run) {
  std::string text = run.child.message;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t line = text.rfind('\n');
  text = plain_line(line == std::string::npos ? text : text.substr(line + 1));
  return text.size() > line_size_max ? text.substr(0, line_size_max) + "..." : text;
}

}  // namespace ticktrue::verifier
