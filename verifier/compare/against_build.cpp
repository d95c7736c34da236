// Runs another build of ticktrue, first for its verdict on the trace, then for one tick in full detail.
// SPDX-License-Identifier: MIT
#include "verifier/compare/against_build.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/hash.h"
#include "verifier/compare/pair_report.h"
#include "verifier/compare/stage_states.h"
#include "verifier/locate/locate.h"
#include "verifier/report/json_parts.h"
#include "verifier/runs/child.h"

namespace ticktrue::verifier {
namespace {

std::string first_line(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return line.size() > 200 ? line.substr(0, 200) + "..." : line;
}

template <typename T>
T json_at(const nlohmann::json& object, const char* key, T otherwise) {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  try {
    return found->get<T>();
  } catch (const nlohmann::json::exception&) {
    return otherwise;
  }
}

class BuildComparison {
 public:
  BuildComparison(replay::TraceReader& reader, Report here, const AgainstOptions& options)
      : reader_(reader), report_(std::move(here)), options_(options) {
    limits_.time_s = options.timeout_s;
  }

  Report run() {
    OtherVerdict other;
    other.build.binary = options_.binary;
    const std::string failure = ask_for_verdict(other);
    if (!failure.empty()) report_.against = other.build;
    Report pair = failure.empty()
                      ? pair_report(std::move(report_), other, [&](Report& parted) { locate_in(parted); })
                      : pair_failed(std::move(report_), options_.binary, failure,
                                    "--against-build needs another build of ticktrue that runs here, --against-plugin "
                                    "a library of the same simulation; --timeout gives it more time");
    pair.warnings.insert(pair.warnings.end(), warnings_.begin(), warnings_.end());
    return pair;
  }

 private:
  /// Fills `other` with the verdict of the other build. Returns why there is no verdict; empty: there is one.
  std::string ask_for_verdict(OtherVerdict& other) {
    std::vector<std::string> more{"verify", reader_.name(), "--json"};
    if (report_.verdict == Verdict::diverged && report_.divergence)  // later ticks are not compared
      more.insert(more.end(), {"--to", std::to_string(report_.divergence->tick)});
    const ChildResult result = run(more);
    if (std::string failure = child_failure(result, limits_); !failure.empty()) return failure;
    const auto json = nlohmann::json::parse(result.output, nullptr, false);
    if (!json.is_object() || !is_verify_schema(json_at<std::string>(json, "schema", "")) || !json.contains("verdict"))
      return "gave no report of schema ticktrue.verify/2: exit code " + std::to_string(result.end.exit_status) +
             (result.message.empty() ? "" : ", \"" + first_line(result.message) + "\"");
    other.build.verdict = first_line(json_at<std::string>(json, "verdict", ""));
    other.build.reason = first_line(json_at<std::string>(json, "reason", ""));
    other.build.ticks_compared = json_at<std::uint64_t>(json, "ticks_compared", 0);
    if (const auto divergence = json.find("divergence");
        other.build.verdict == "diverged" && divergence != json.end() && divergence->is_object()) {
      other.build.diverged_at = json_at<std::uint64_t>(*divergence, "tick", 0);
      other.got_hash = json_at<std::string>(*divergence, "got_hash", "");
    }
    if (const auto builds = json.find("builds"); builds != json.end() && builds->contains("here"))
      for (const auto& [name, value] : (*builds)["here"].items())
        if (value.is_string()) other.build.facts.emplace_back(name, value.get<std::string>());
    return "";
  }

  /// The words that call the other build.
  std::vector<std::string> words() const {
    return options_.words.empty() ? std::vector<std::string>{options_.binary} : options_.words;
  }

  ChildResult run(const std::vector<std::string>& more) {
    ChildCommand command;
    command.argv = words();
    command.argv.insert(command.argv.end(), more.begin(), more.end());
    command.limits = limits_;
    const ChildResult result = run_child(command);
    if (!result.end.escaped.empty())
      warnings_.push_back(options_.binary +
                          " left running, outside of its process group: " + escaped_text(result.end.escaped));
    return result;
  }

  std::string shell_words() const {
    std::string text;
    for (const std::string& word : words()) text += (text.empty() ? "" : " ") + shell_word(word);
    return text;
  }

  void locate_in(Report& pair) {
    Divergence& divergence = *pair.divergence;
    divergence.time_s = time_of(divergence.tick);
    locate(divergence, pair);
    pair.again = {shell_words() + " replay " + shell_word(reader_.name()) + " --format stages --ticks " +
                  std::to_string(divergence.tick) + ", and the same with this build, give every state of the tick"};
  }

  double time_of(std::uint64_t tick) {
    double time_s = 0;
    reader_.rewind();
    for (;;) {
      const auto& item = reader_.next();
      const auto* record = std::get_if<replay::TickRecord>(&item);
      if (std::holds_alternative<std::monostate>(item) || (record != nullptr && record->tick >= tick)) return time_s;
      if (record != nullptr) time_s += record->dt;
    }
  }

  /// Runs both builds again, with every state of the tick.
  void locate(Divergence& divergence, Report& pair) {
    divergence.stage.reset();
    ReaderSource source(reader_);
    const auto here = stage_states(source, *options_.simulation, divergence.tick);
    if (!here) {
      divergence.stage_note = "not known: " + here.error().message;
      return;
    }
    const ChildResult result =
        run({"replay", reader_.name(), "--format", "stages", "--ticks", std::to_string(divergence.tick)});
    std::string failure = child_failure(result, limits_);
    if (failure.empty() && result.end.exit_status == exit_usage)
      failure = "does not know `replay --format stages` (\"" + first_line(result.message) + "\"): an older version?";
    const auto there = parse_stage_states(result.output);
    if (failure.empty() && !there) failure = "replay --format stages: " + there.error().message;
    if (!failure.empty()) {
      divergence.stage_note = "not known: " + options_.binary + " " + failure;
      return;
    }
    compare_states(*there, *here, divergence, pair);
  }

  void compare_states(const StageStates& there, const StageStates& here, Divergence& divergence, Report& pair) {
    divergence.inputs = here.inputs;
    const std::size_t count = std::min(there.states.size(), here.states.size());
    std::size_t first = 0;
    while (first < count && there.states[first].stage == here.states[first].stage &&
           there.states[first].image == here.states[first].image)
      ++first;
    divergence.expected_root = there.states.back().root_hash;
    divergence.got_root = here.states.back().root_hash;
    if (first == count) {
      divergence.stage_note = count == there.states.size() && count == here.states.size()
                                  ? "run from the checkpoint of tick " + std::to_string(here.start_tick) +
                                        " both builds agree: the difference needs what came before it"
                                  : "the builds have other stages";
      return;
    }
    const StageState& a = there.states[first];
    const StageState& b = here.states[first];
    if (a.stage != b.stage) {
      divergence.stage_note = "the builds have other stages: there " + a.stage + ", here " + b.stage;
      return;
    }
    divergence.stage = first == 0 ? "before the tick" : b.stage;
    divergence.stage_note =
        first == 0 ? "run from the checkpoint of tick " + std::to_string(here.start_tick) + " the builds part earlier"
                   : "first stage whose output differs; values are those after it";
    const Status located =
        locate_lanes(reader_.setup().schema, a.image, b.image, names_in(b.image), options_.row_count_max, divergence);
    if (!located)
      pair.warnings.push_back("states of tick " + std::to_string(divergence.tick) +
                              " cannot be compared: " + located.error().message);
    Divergence at_end;
    if (first + 1 < count &&
        locate_lanes(reader_.setup().schema, there.states.back().image, here.states.back().image, {}, 0, at_end))
      pair.notes.push_back("at the end of the tick " + std::to_string(at_end.lane_count) + " lanes differ");
  }

  /// Names of rows, from a simulation with this state.
  RowNamer names_in(ByteView image) {
    auto made = options_.simulation->make(reader_.setup().setup);
    if (!made || !(*made)->load(image)) return {};
    std::shared_ptr<Simulation> simulation = std::move(*made);
    return [simulation](std::size_t table, std::size_t row) { return simulation->row_name(table, row); };
  }

  replay::TraceReader& reader_;
  Report report_;
  const AgainstOptions& options_;
  ChildLimits limits_;
  std::vector<std::string> warnings_;
};

}  // namespace

Report compare_builds(replay::TraceReader& reader, Report here, const AgainstOptions& options) {
  return BuildComparison(reader, std::move(here), options).run();
}

}  // namespace ticktrue::verifier
