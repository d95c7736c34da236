// Writes a reduced session.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/result_folder.h"

#include <filesystem>
#include <system_error>

#include "engine/scene/scene_json.h"
#include "replay/recorder.h"
#include "tool/experiment/reduce/program_judge.h"
#include "tool/experiment/reduce/session_file.h"
#include "tool/output/cli.h"
#include "tool/session/session.h"
#include "verifier/report/report.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::reduce {
namespace {

namespace fs = std::filesystem;
using verifier::shell_word;

constexpr std::size_t scene_size_max = std::size_t{64} << 20;

std::string shell_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + shell_word(word);
  return text;
}

class ResultWriter {
 public:
  ResultWriter(const ReduceResult& result, Predicate& predicate, const ReduceOptions& options, const std::string& path)
      : result_(result), predicate_(predicate), options_(options) {
    folder_.path = path;
  }

  Result<ResultFolder> write() {
    std::error_code failed;
    fs::create_directories(folder_.path, failed);
    if (failed) return Error{ErrorCode::io, folder_.path + ": cannot be made: " + failed.message(), ""};
    folder_.command = command_in(folder_.path + "/", "ticktrue");
    const std::pair<const char*, std::string> files[] = {{"scene.json", engine::print_scene(result_.smallest.scene)},
                                                         {"inputs.jsonl", inputs_text(result_.smallest)},
                                                         {"command", folder_.command + "\n"},
                                                         {"test.sh", test_text()}};
    for (const auto& [name, text] : files)
      if (const Status written = verifier::write_data_file(folder_.path + "/" + name, text); !written)
        return written.error();
    fs::permissions(folder_.path + "/test.sh", fs::perms::owner_exec, fs::perm_options::add, failed);
    if (const Status recorded = record_trace(); !recorded) return recorded.error();
    if (const Status same = read_again(); !same) return same.error();
    for (const char* name : {"scene.json", "inputs.jsonl", "command", "test.sh", "trace.ttr"}) {
      const std::uintmax_t size = fs::file_size(folder_.path + "/" + name, failed);
      if (!failed) folder_.size += size;
    }
    return std::move(folder_);
  }

 private:
  std::string command_in(const std::string& place, const std::string& tool) const {
    if (const std::string line = predicate_.show_line(); !line.empty())
      return words_with_trace({line}, shell_word(place + "trace.ttr")).front();
    return tool + " reduce " + shell_word(place + "scene.json") + " --inputs " + shell_word(place + "inputs.jsonl") +
           " --ticks " + std::to_string(result_.smallest.tick_count) + " " + shell_words(predicate_.words()) +
           (options_.is_loose ? " --loose" : "") + " --once";
  }

  std::string test_text() const {
    std::string what = result_.last.what;
    for (char& c : what)
      if (c == '\n') c = ' ';
    const std::string line = predicate_.test_line();
    const bool has_tool = line.empty() || line.find("${TICKTRUE:-") != std::string::npos;
    std::string text = "#!/bin/sh\n# Exit code 0: mended. Another: still fails, tick " +
                       std::to_string(result_.last.tick) + ": " + what + ".\n";
    // A command names its program relative to the folder in which `reduce` was started.
    text += has_tool ? "# TICKTRUE: the program to test.\n"
                     : "# It runs in the folder in which its command finds the program.\n";
    text += "# CMake: add_test(NAME reduced COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/test.sh)\n";
    if (line.empty())
      return text + "cd \"$(dirname \"$0\")\" && exec " + command_in("", "\"${TICKTRUE:-ticktrue}\"") + "\n";
    return text + "trace=$(dirname \"$0\")/trace.ttr\n" + words_with_trace({line}, "\"$trace\"").front() + "\n";
  }

  /// Records the trace, with the whole state of the failing tick.
  Status record_trace() {
    const std::string trace = folder_.path + "/trace.ttr";
    const auto made = options_.make(result_.smallest.scene, {});
    if (!made) return made.error();
    tool::TraceChoices choices;
    choices.detail = replay::Detail::full;
    choices.full_first = choices.full_last = result_.last.tick;
    const soak::CaseInputs inputs(result_.smallest);
    soak::CaseSource source(inputs, result_.smallest.tick_count);
    replay::RecordOptions options;
    options.writer.overwrite = true;
    const auto recorded = replay::record(**made, source, trace, tool::make_trace_setup(**made, choices),
                                         tool::make_build_facts(), options);
    folder_.has_trace = recorded.has_value();
    std::error_code ignored;
    if (!recorded) fs::remove(trace, ignored);  // the first tick fails or is not finite
    return {};
  }

  Status read_again() const {
    const std::string file = folder_.path + "/scene.json";
    const Result<std::string> text = cli::read_text_file(file, scene_size_max);
    if (!text) return text.error();
    const Result<engine::Scene> scene = engine::parse_scene(*text, file);
    if (!scene) return scene.error();
    const auto session = read_session(*scene, folder_.path + "/inputs.jsonl", result_.smallest.tick_count);
    if (!session) return session.error();
    const auto found = predicate_.examine(*session);
    if (!found) return found.error();
    if (*found && is_same(result_.last, **found, options_.is_loose)) return {};
    return Error{ErrorCode::inconsistent,
                 folder_.path + ": read again, the session does not fail in the same way: found " +
                     (*found ? (*found)->kind + " " + place_text(**found) : std::string("nothing")) + ", expected " +
                     result_.last.kind + " " + place_text(result_.last),
                 ""};
  }

  const ReduceResult& result_;
  Predicate& predicate_;
  const ReduceOptions& options_;
  ResultFolder folder_;
};

}  // namespace

std::string inputs_text(const SoakCase& session) {
  std::string text;
  for (const engine::Input& input : session.inputs)
    if (input.kind != engine::InputKind::end) text += print_input(session.scene, input) + "\n";
  return text;
}

Result<ResultFolder> write_result(const ReduceResult& result, Predicate& predicate, const ReduceOptions& options,
                                  const std::string& path) {
  return ResultWriter(result, predicate, options, path).write();
}

}  // namespace ticktrue::reduce
