// Runs programs on traces and reads their reports.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/program_judge.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "tool/output/cli.h"
#include "verifier/report/json_parts.h"
#include "verifier/runs/child.h"

namespace ticktrue::reduce {
namespace {

using nlohmann::json;
using Answer = Result<std::optional<Failure>>;

constexpr std::size_t report_size_max = std::size_t{64} << 20;
constexpr std::size_t body_count_max = 8;  // taken from the state rows in a report

template <typename T>
T value_of(const json& object, const char* key, const T& otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  try {
    return found->get<T>();
  } catch (const json::exception&) {
    return otherwise;  // null or of another type
  }
}

void add_once(std::uint32_t body, std::vector<std::uint32_t>& bodies) {
  if (bodies.size() < body_count_max && std::find(bodies.begin(), bodies.end(), body) == bodies.end())
    bodies.push_back(body);
}

std::string value_at(const json& row, const char* key) {
  const auto found = row.find(key);
  const std::string text = found == row.end() ? "" : verifier::value_text(*found);
  return text.empty() ? "no row" : text;
}

void read_rows(const json& divergence, Failure& failure) {
  const auto rows = divergence.find("rows");
  if (rows == divergence.end() || !rows->is_array()) return;
  for (const json& row : *rows) {
    if (!row.is_object()) continue;
    const auto table = value_of<std::string>(row, "table", "");
    if (!failure.row) {
      failure.table = table;
      failure.column = value_of<std::string>(row, "column", "");
      failure.row = value_of<std::uint64_t>(row, "row", 0);
      failure.what = failure.table + "." + failure.column + " row " + std::to_string(*failure.row) + " " +
                     value_of<std::string>(row, "name", "") + ": expected " + value_at(row, "expected_value") +
                     ", got " + value_at(row, "got_value");
    }
    const auto id = value_of<std::int64_t>(row, "id", -1);
    // The key of a state row in a table of pairs contains the id of the first body.
    if (id >= 0 && table != "joints") add_once(static_cast<std::uint32_t>(id), failure.bodies);
  }
}

Failure failure_of_divergence(const std::string& verdict, const json& report) {
  Failure failure;
  failure.kind = verdict;
  failure.what = value_of<std::string>(report, "reason", "");
  const auto divergence = report.find("divergence");
  if (divergence == report.end() || !divergence->is_object()) return failure;
  failure.tick = value_of<std::uint64_t>(*divergence, "tick", 0);
  failure.stage = value_of<std::string>(*divergence, "stage", "");
  failure.table = value_of<std::string>(*divergence, "table", "");
  const auto columns = value_of<std::vector<std::string>>(*divergence, "columns", {});
  if (!columns.empty()) failure.column = columns.front();
  read_rows(*divergence, failure);
  return failure;
}

std::string first_line(const std::string& text) {
  constexpr std::size_t size_max = 200;
  const std::string line = text.substr(0, text.find('\n'));
  return line.size() > size_max ? line.substr(0, size_max) + "..." : line;
}

class ProgramJudge {
 public:
  ProgramJudge(std::vector<std::string> words, const std::string& folder, double time_s)
      : words_(std::move(words)), result_file_(folder + "/result.json"), time_s_(time_s) {}

  Answer operator()(const std::string& trace) const {
    std::error_code ignored;
    std::filesystem::remove(result_file_, ignored);
    verifier::ChildCommand command;
    command.argv = words_with_trace(words_, trace);
    command.environment = {{"TICKTRUE_RESULT", result_file_}};
    command.limits.time_s = time_s_;
    const verifier::ChildResult result = verifier::run_child(command);
    if (const std::string failed = child_failure(result, command.limits); !failed.empty())
      return crashed(result, failed);
    std::string report = result.output;
    if (std::filesystem::exists(result_file_, ignored)) {
      Result<std::string> written = cli::read_text_file(result_file_, report_size_max);
      if (!written) return written.error();
      report = *std::move(written);
    }
    Answer answer = failure_of_report(report);
    if (answer || answer.error().code != ErrorCode::unsupported) return answer;
    return by_exit_code(result);
  }

 private:
  Answer crashed(const verifier::ChildResult& result, const std::string& failed) const {
    if (result.end.signal == 0)
      return Error{ErrorCode::unsupported, words_.front() + ": " + failed, "--timeout gives it more time"};
    Failure failure;
    failure.kind = "crashed";
    failure.what = words_.front() + " " + failed;
    return std::optional(failure);
  }

  Answer by_exit_code(const verifier::ChildResult& result) const {
    if (result.end.exit_status == 0) return std::optional<Failure>();
    if (result.end.exit_status != 1)
      return Error{ErrorCode::unsupported,
                   words_.front() + ": exit code " + std::to_string(result.end.exit_status) + ": found \"" +
                       first_line(result.message) + "\", expected a report of schema ticktrue.verify/2, or 0 or 1",
                   ""};
    Failure failure;
    failure.kind = "exit_code_1";
    const std::string said = first_line(result.message);
    failure.what = "the program ended with exit code 1" + (said.empty() ? "" : ": " + said);
    return std::optional(failure);
  }

  std::vector<std::string> words_;
  std::string result_file_;
  double time_s_;
};

}  // namespace

std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace) {
  std::vector<std::string> with = words;
  bool has_mark = false;
  for (std::string& word : with)
    for (std::size_t at = word.find(trace_mark); at != std::string::npos;
         at = word.find(trace_mark, at + trace.size())) {
      word.replace(at, std::string(trace_mark).size(), trace);
      has_mark = true;
    }
  if (!has_mark) with.push_back(trace);
  return with;
}

Answer failure_of_report(const std::string& text) {
  const json report = json::parse(text, nullptr, false);
  if (!report.is_object() || !verifier::is_verify_schema(value_of<std::string>(report, "schema", "")))
    return Error{ErrorCode::unsupported, "found no report of schema ticktrue.verify/2", ""};
  const auto verdict = value_of<std::string>(report, "verdict", "");
  if (verdict == "match") return std::optional<Failure>();
  if (verdict == "diverged" || verdict == "state_incomplete" || verdict == "not_reproducible")
    return std::optional(failure_of_divergence(verdict, report));
  return Error{ErrorCode::incompatible, "verdict " + verdict + ": " + value_of<std::string>(report, "reason", ""), ""};
}

TraceJudge program_judge(const std::vector<std::string>& words, const std::string& folder, double time_s) {
  return ProgramJudge(words, folder, time_s);
}

}  // namespace ticktrue::reduce
