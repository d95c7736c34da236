// Records a world, and verifies its trace in this process and in a fresh one.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/trace_checks.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "base/random.h"
#include "engine/scene/scene_binary.h"
#include "tool/session/session.h"
#include "verifier/runs/child.h"
#include "verifier/verify/verify.h"

namespace ticktrue::soak {
namespace {

/// The choices drawn from the number of a variant.
struct TraceDraw {
  tool::TraceChoices choices;
  verifier::VerifyMode mode = verifier::VerifyMode::replay;
  unsigned thread_count = 1;
  std::uint64_t from = 0;
  bool to_end = false;
};

TraceDraw draw_of(const Variant& variant, std::uint64_t tick_count) {
  Random random(variant.value);
  TraceDraw draw;
  draw.choices.detail = random.below(2) == 0 ? replay::Detail::root : replay::Detail::cells;
  const std::uint64_t interval_max = std::max<std::uint64_t>(2, std::min<std::uint64_t>(tick_count / 2, 40));
  draw.choices.checkpoint_interval = static_cast<std::uint32_t>(1 + random.below(interval_max));
  if (variant.check == CheckKind::process) {
    draw.mode = verifier::VerifyMode::restore;
    draw.thread_count = 1 + static_cast<unsigned>(random.below(2));
    return draw;
  }
  const std::uint64_t kind = random.below(8);
  if (kind == 7) draw.mode = verifier::VerifyMode::threads;
  if (kind == 6) draw.mode = verifier::VerifyMode::twice;
  if (kind >= 3 && kind < 6) draw.mode = verifier::VerifyMode::restore;
  if (kind < 6) draw.thread_count = 1 + static_cast<unsigned>(random.below(2));
  draw.to_end = kind == 3;
  if (kind == 0) draw.from = random.below(std::max<std::uint64_t>(1, tick_count));
  return draw;
}

const verifier::VerifyModeInfo& mode_info(verifier::VerifyMode mode) {
  return verifier::verify_modes[static_cast<std::size_t>(mode)];
}

std::string options_text(const TraceDraw& draw) {
  std::string text = "--mode " + std::string(mode_info(draw.mode).name) + " -j " + std::to_string(draw.thread_count);
  if (draw.from > 0) text += " --from " + std::to_string(draw.from);
  if (draw.to_end) text += " --to-end";
  return text;
}

class TraceRun {
 public:
  TraceRun(const RunContext& context, const BaseRun& base, const Variant& variant, const TraceFiles& files)
      : context_(context), base_(base), variant_(variant), files_(files), draw_(draw_of(variant, base.tick_count)) {}

  std::optional<Finding> run() {
    auto found = record();
    if (!found) found = variant_.check == CheckKind::process ? verify_elsewhere() : verify_here();
    std::error_code ignored;
    std::filesystem::remove(files_.path, ignored);
    return found;
  }

 private:
  Finding failure(std::uint64_t tick, const std::string& what) const {
    Finding finding;
    finding.variant = variant_;
    finding.tick = tick;
    finding.what = what;
    return finding;
  }

  std::optional<Finding> record() {
    const auto made = context_.make(context_.soak_case.scene, {});
    if (!made) return failure(0, made.error().message);
    CaseSource source(context_.inputs, base_.tick_count);
    replay::RecordOptions options;
    options.tick_count = base_.tick_count;
    options.writer.overwrite = true;
    options.writer.sync = false;
    const auto recorded = replay::record(**made, source, files_.path, make_trace_setup(**made, draw_.choices),
                                         tool::make_build_facts(), options);
    if (!recorded) return failure(0, "record: " + recorded.error().message);
    if (recorded->tick_count != base_.tick_count || recorded->root_hash != base_.hashes.back())
      return failure(recorded->tick_count, "record: another last state than the base run");
    return std::nullopt;
  }

  /// The simulation that the traces name. Its engines are made like those of every other run.
  SimulationInfo simulation_info() const {
    SimulationInfo info = engine::engine_info();
    info.make_on_threads = [this](ByteView setup, unsigned thread_count) -> Result<std::unique_ptr<Simulation>> {
      const auto scene = engine::decode_scene(setup);
      if (!scene) return scene.error();
      engine::EngineOptions options;
      options.thread_count = thread_count;
      auto engine = context_.make(*scene, options);
      if (!engine) return engine.error();
      return std::unique_ptr<Simulation>(*std::move(engine));
    };
    info.make = [make = info.make_on_threads](ByteView setup) { return make(setup, 1); };
    return info;
  }

  std::optional<Finding> verify_here() {
    auto reader = replay::TraceReader::open(files_.path);
    if (!reader) return failure(0, reader.error().message);
    const SimulationInfo info = simulation_info();
    verifier::VerifyOptions options;
    options.simulation = &info;
    options.mode = draw_.mode;
    options.from = draw_.from;
    options.to_end = draw_.to_end;
    options.row_count_max = 1;
    options.spread_ticks = 0;
    options.thread_count = draw_.thread_count;
    options.reopen = [this]() -> std::unique_ptr<verifier::TraceSource> {
      auto again = replay::TraceReader::open(files_.path);
      if (!again) return nullptr;
      return std::make_unique<verifier::OwnedReaderSource>(*std::move(again));
    };
    const verifier::Report report = verify(*reader, options);
    const bool is_whole = report.ticks_compared == base_.tick_count - draw_.from;
    if (report.verdict == verifier::Verdict::match && is_whole) return std::nullopt;
    std::string what = "verify " + options_text(draw_) + ", interval " +
                       std::to_string(draw_.choices.checkpoint_interval) + ": " +
                       std::string(verdict_info(report.verdict).name) + ", " + std::to_string(report.ticks_compared) +
                       " of " + std::to_string(base_.tick_count) + " ticks compared";
    if (!report.reason.empty()) what += ": " + report.reason;
    if (report.divergence && !report.divergence->rows.empty()) {
      const verifier::LaneReport& row = report.divergence->rows.front();
      what += "; table " + row.table + ", column " + row.column + ", row " + std::to_string(row.row);
    }
    return failure(report.divergence ? report.divergence->tick : 0, what);
  }

  std::optional<Finding> verify_elsewhere() {
    verifier::ChildCommand command;
    command.argv = {files_.tool, "verify", files_.path, "--mode", "restore", "-j", std::to_string(draw_.thread_count)};
    command.limits.time_s = 300;
    const verifier::ChildResult result = run_child(command);
    if (const std::string failed = child_failure(result, command.limits); !failed.empty())
      return failure(0, "verify in a fresh process " + failed);
    const int status = result.end.exit_status;
    if (status == 0) return std::nullopt;
    return failure(0, "verify " + options_text(draw_) + " in a fresh process: exit " + std::to_string(status) + ": " +
                          result.output.substr(0, result.output.find('\n')));
  }

  const RunContext& context_;
  const BaseRun& base_;
  Variant variant_;
  const TraceFiles& files_;
  TraceDraw draw_;
};

}  // namespace

std::optional<Finding> run_trace_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                         const TraceFiles& files) {
  if (base.tick_count == 0 || (variant.check == CheckKind::process && files.tool.empty())) return std::nullopt;
  return TraceRun(context, base, variant, files).run();
}

}  // namespace ticktrue::soak
