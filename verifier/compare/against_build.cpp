// Runs another build of ticktrue: first for its verdict on the trace, then for one tick in full detail.
// SPDX-License-Identifier: MIT
#include "verifier/compare/against_build.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/hash.h"
#include "verifier/compare/stage_states.h"
#include "verifier/locate/locate.h"
#include "verifier/runs/child.h"

namespace ticktrue::verifier {
namespace {

/// The verdict of the other build on the trace.
struct OtherVerdict {
  std::string failure;  // why there is no verdict; empty: there is one
  OtherBuild build;
  std::string got_hash;  // of the tick at which it diverged
};

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
    const std::optional<std::uint64_t> here_at = diverged_at();
    const OtherVerdict other = ask_for_verdict(here_at);
    report_.against = other.build;
    if (!other.failure.empty()) return failed(other.failure);
    const std::optional<std::uint64_t> there_at = other.build.diverged_at;
    const bool here_judges = report_.verdict == Verdict::match || here_at;
    const bool there_judges = other.build.verdict == "match" || there_at;
    if (!here_judges) return std::move(report_);  // its verdict says why
    if (!there_judges) return not_judged_there(other.build);
    if (!here_at && !there_at) {
      report_.notes.push_back(options_.binary + " gives the recorded bits too, in all " +
                              std::to_string(other.build.ticks_compared) + " ticks");
      return std::move(report_);
    }
    const std::uint64_t tick = std::min(here_at.value_or(*there_at), there_at.value_or(*here_at));
    const bool same_there = here_at && there_at && *here_at == *there_at && report_.divergence &&
                            other.got_hash == hex64(report_.divergence->got_root);
    return same_there ? both_differ_alike(tick) : builds_differ(tick, here_at, there_at);
  }

 private:
  std::optional<std::uint64_t> diverged_at() const {
    if (report_.verdict != Verdict::diverged || !report_.divergence) return std::nullopt;
    return report_.divergence->tick;
  }

  OtherVerdict ask_for_verdict(std::optional<std::uint64_t> to) {
    OtherVerdict other;
    other.build.binary = options_.binary;
    std::vector<std::string> words{options_.binary, "verify", reader_.name(), "--json"};
    if (to)
      words.insert(words.end(), {"--to", std::to_string(*to)});  // ticks after our first difference are not compared
    const ChildResult result = run(words);
    other.failure = child_failure(result, limits_);
    if (!other.failure.empty()) return other;
    const auto json = nlohmann::json::parse(result.output, nullptr, false);
    if (!json.is_object() || json_at<std::string>(json, "schema", "") != "ticktrue.verify/1" ||
        !json.contains("verdict")) {
      other.failure = "gave no report of schema ticktrue.verify/1: exit code " +
                      std::to_string(result.end.exit_status) +
                      (result.message.empty() ? "" : ", \"" + first_line(result.message) + "\"");
      return other;
    }
    other.build.verdict = json_at<std::string>(json, "verdict", "");
    other.build.reason = json_at<std::string>(json, "reason", "");
    other.build.ticks_compared = json_at<std::uint64_t>(json, "ticks_compared", 0);
    if (const auto divergence = json.find("divergence");
        other.build.verdict == "diverged" && divergence != json.end() && divergence->is_object()) {
      other.build.diverged_at = json_at<std::uint64_t>(*divergence, "tick", 0);
      other.got_hash = json_at<std::string>(*divergence, "got_hash", "");
    }
    if (const auto builds = json.find("builds"); builds != json.end() && builds->contains("here"))
      for (const auto& [name, value] : (*builds)["here"].items())
        if (value.is_string()) other.build.facts.emplace_back(name, value.get<std::string>());
    return other;
  }

  ChildResult run(std::vector<std::string> argv) {
    ChildCommand command;
    command.argv = std::move(argv);
    command.limits = limits_;
    const ChildResult result = run_child(command);
    if (!result.end.escaped.empty())
      report_.warnings.push_back(options_.binary +
                                 " left running, outside of its process group: " + escaped_text(result.end.escaped));
    return result;
  }

  Report failed(const std::string& what) {
    report_.verdict = Verdict::error;
    report_.reason = options_.binary + " " + what;
    report_.hint = "--against-build needs another build of ticktrue that runs here; --timeout gives it more time";
    return std::move(report_);
  }

  Report not_judged_there(const OtherBuild& other) {
    const auto found = std::find_if(verdicts.begin(), verdicts.end(),
                                    [&](const VerdictInfo& info) { return info.name == other.verdict; });
    if (found == verdicts.end()) return failed("gave an unknown verdict: \"" + first_line(other.verdict) + "\"");
    report_.verdict = found->verdict;
    report_.reason = options_.binary + " says " + other.verdict + ": " + first_line(other.reason);
    report_.hint.clear();
    return std::move(report_);
  }

  Report both_differ_alike(std::uint64_t tick) {
    report_.notes.push_back("both builds give the same other bits at tick " + std::to_string(tick) +
                            ": the recording is of a third build, or was changed");
    return std::move(report_);
  }

  Report builds_differ(std::uint64_t tick, std::optional<std::uint64_t> here_at,
                       std::optional<std::uint64_t> there_at) {
    report_.verdict = Verdict::diverged;
    report_.reason.clear();
    report_.hint.clear();
    report_.again.clear();
    report_.against->is_expected = true;
    const auto words = [](std::optional<std::uint64_t> at) {
      return at ? "leaves the recording at tick " + std::to_string(*at) : std::string("gives the recorded bits");
    };
    report_.notes.push_back("this build " + words(here_at) + ", " + options_.binary + " " + words(there_at));
    if (!report_.divergence || report_.divergence->tick != tick) report_.divergence = Divergence{};
    Divergence& divergence = *report_.divergence;
    divergence.tick = tick;
    divergence.time_s = time_of(tick);
    locate(divergence);
    report_.again = {shell_word(options_.binary) + " replay " + shell_word(reader_.name()) +
                     " --format stages --ticks " + std::to_string(tick) +
                     ", and the same with this build, give every state of the tick"};
    return std::move(report_);
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

  /// Both builds again, with every state of the tick.
  void locate(Divergence& divergence) {
    divergence.stage.reset();
    ReaderSource source(reader_);
    const auto here = stage_states(source, *options_.simulation, divergence.tick);
    if (!here) {
      divergence.stage_note = "not known: " + here.error().message;
      return;
    }
    const ChildResult result = run(
        {options_.binary, "replay", reader_.name(), "--format", "stages", "--ticks", std::to_string(divergence.tick)});
    std::string failure = child_failure(result, limits_);
    if (failure.empty() && result.end.exit_status == exit_usage)
      failure = "does not know `replay --format stages` (\"" + first_line(result.message) + "\"): an older version?";
    const auto there = parse_stage_states(result.output);
    if (failure.empty() && !there) failure = "replay --format stages: " + there.error().message;
    if (!failure.empty()) {
      divergence.stage_note = "not known: " + options_.binary + " " + failure;
      return;
    }
    compare_states(*there, *here, divergence);
  }

  void compare_states(const StageStates& there, const StageStates& here, Divergence& divergence) {
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
      report_.warnings.push_back("states of tick " + std::to_string(divergence.tick) +
                                 " cannot be compared: " + located.error().message);
    Divergence at_end;
    if (first + 1 < count &&
        locate_lanes(reader_.setup().schema, there.states.back().image, here.states.back().image, {}, 0, at_end))
      report_.notes.push_back("at the end of the tick " + std::to_string(at_end.lane_count) + " lanes differ");
  }

  /// Names of rows, from a simulation in that state.
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
};

}  // namespace

Report compare_builds(replay::TraceReader& reader, Report here, const AgainstOptions& options) {
  return BuildComparison(reader, std::move(here), options).run();
}

}  // namespace ticktrue::verifier
