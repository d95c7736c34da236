// Choice of the simulation, its threads and its segments; plug-ins in processes of their own.
// SPDX-License-Identifier: MIT
#include "tool/corpus/verify_trace.h"

#include <memory>
#include <utility>

#include "tool/session/session.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/report/report_transfer.h"
#include "verifier/runs/plugin_isolation.h"
#include "verifier/verify/parts.h"

namespace ticktrue::tool {
namespace {

/// What verifies, where a library brought the simulation; else it is this tool alone. A match does not depend on where
/// the library lies.
void set_here(verifier::Report& report) {
  if (report.verdict != verifier::Verdict::match && !verifier::plugin_path(report.simulation).empty())
    report.here_build = make_build_facts(report.simulation);
}

verifier::Report plugin_report(const std::string& file, std::string_view mode, const std::string& what,
                               const verifier::SharedCount& compared) {
  verifier::Report report;
  report.file = file;
  report.mode = mode;
  report.verdict = verifier::Verdict::diverged;
  report.reason = what;
  report.ticks_compared = compared.ticks();
  report.time_s = compared.time_s();
  if (const auto reader = replay::TraceReader::open(file)) {
    report.title = reader->setup().title;
    report.simulation = reader->setup().simulation;
    report.ticks_recorded = reader->tick_count_hint();
    report.recorded_build = reader->facts();
    set_here(report);
  }
  return report;
}

}  // namespace

const SimulationInfo* simulation_of(const replay::TraceReader& reader) {
  return find_simulation(reader.setup().simulation);
}

SimulationInfo on_engine_threads(const SimulationInfo& info, unsigned thread_count) {
  SimulationInfo changed = info;
  if (thread_count > 1 && info.make_on_threads)
    changed.make = [make = info.make_on_threads, thread_count](ByteView setup) { return make(setup, thread_count); };
  return changed;
}

verifier::Report verify_trace(replay::TraceReader& reader, const std::string& file, const TraceVerification& how) {
  verifier::VerifyOptions options;
  options.mode = how.mode;
  options.from = how.from;
  options.to = how.to;
  options.to_end = how.to_end;
  options.sync_ticks = how.sync_ticks;
  options.part = how.part;
  options.simulation = simulation_of(reader);
  if (options.simulation != nullptr) options.tool = tool_command(options.simulation->name);
  const bool on_threads = options.simulation == nullptr || runs_on_threads(*options.simulation);
  options.thread_count = on_threads ? how.thread_count : 1;
  options.in_segments = on_threads && how.in_segments;
  SimulationInfo simulation;
  if (options.simulation != nullptr) {
    simulation = on_engine_threads(*options.simulation, how.engine_threads);
    options.simulation = &simulation;
  }
  options.search_single_bit = true;
  options.reopen = [&file]() -> std::unique_ptr<verifier::TraceSource> {
    auto again = replay::TraceReader::open(file);
    if (!again) return nullptr;
    return std::make_unique<verifier::OwnedReaderSource>(std::move(*again));
  };
  const std::uint64_t tick_count = reader.tick_count_hint().value_or(0);
  if (how.progress) options.progress = [&](std::uint64_t ticks_done) { how.progress(ticks_done, tick_count); };
  if (how.compared != nullptr) options.on_compared = [&how](double time_s) { how.compared->add_tick(time_s); };
  verifier::Report report = verify(reader, options);
  set_here(report);
  if (options.simulation == nullptr && report.hint.empty()) report.hint = other_simulation_hint(file, reader.facts());
  return report;
}

std::size_t count_trace_parts(replay::TraceReader& reader, std::size_t count_max) {
  verifier::VerifyOptions options;
  options.simulation = simulation_of(reader);
  options.in_segments = options.simulation != nullptr && runs_on_threads(*options.simulation);
  return count_parts(reader, options, count_max);
}

bool needs_plugin(const std::string& file) {
  if (verifier::plugin_simulations().empty()) return false;
  const Result<replay::TraceReader> reader = replay::TraceReader::open(file);
  const SimulationInfo* info = reader ? simulation_of(*reader) : nullptr;
  return info != nullptr && !runs_on_threads(*info);
}

PluginVerification verify_by_plugin(const std::string& file, std::string_view mode,
                                    const std::function<verifier::Report(verifier::SharedCount& compared)>& work,
                                    const std::function<void()>& meanwhile) {
  verifier::SharedCount compared;
  const auto part = [&] {
    try {
      return encode_report(work(compared));
    } catch (const verifier::PluginFailure& failure) {
      return encode_report(plugin_report(file, mode, failure.what(), compared));
    }
  };
  const verifier::IsolatedPart done = verifier::run_part(part, meanwhile);
  if (!done.message.empty()) {
    verifier::Report report = plugin_report(file, mode, done.message, compared);
    report.hint =
        "run the same under a debugger: the file is verified in a child process (gdb: set follow-fork-mode child)";
    return {std::move(report), false};
  }
  Result<verifier::Report> report = verifier::decode_report(done.result);
  if (!report) return {plugin_report(file, mode, report.error().message, compared), false};
  return {std::move(*report), true};
}

}  // namespace ticktrue::tool
