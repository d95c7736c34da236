// Compares ways to simulate one scene: runs them, samples them at equal simulated times, compares them with twins.
// SPDX-License-Identifier: MIT
#include "tool/study/compare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "base/random.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/input.h"
#include "engine/scene/scene_binary.h"
#include "replay/trace_reader.h"
#include "tool/session/clocked_inputs.h"
#include "tool/study/table.h"

namespace ticktrue::tool {

using engine::BodyReport;
using engine::BodyType;
using engine::Engine;
using engine::Scene;

Result<CompareSession> session_of_trace(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole.error();
  if (reader->setup().simulation != engine::simulation_name)
    return Error{ErrorCode::incompatible,
                 path + ": simulation: found " + reader->setup().simulation + ", expected " +
                     std::string(engine::simulation_name),
                 "compare needs the scene, which only traces of the engine hold"};
  auto scene = engine::decode_scene(reader->setup().setup);
  if (!scene) return scene.error();
  CompareSession session;
  session.scene = std::move(*scene);
  session.seconds = 0;
  std::vector<engine::Input> inputs;
  for (;;) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (!record) continue;
    if (record->inputs.size() > 0) {
      if (Status decoded = engine::decode_inputs(session.scene, record->inputs, inputs); !decoded)
        return decoded.error();
      for (const engine::Input& input : inputs) session.inputs.push_back({session.seconds, input});
    }
    session.dts.push_back(record->dt);
    session.seconds += record->dt;
  }
  if (session.dts.empty())
    return Error{ErrorCode::truncated, path + ": found no whole tick, expected at least one", {}};
  return session;
}

std::vector<Variant> product_of(const CompareAxes& axes) {
  std::vector<Variant> variants{Variant{}};
  const auto multiply = [&](const auto& values, auto set) {
    if (values.empty()) return;
    std::vector<Variant> more;
    for (const Variant& variant : variants)
      for (const auto& value : values) {
        Variant next = variant;
        const std::string name = set(next, value);
        next.name += (next.name.empty() || name.empty() ? "" : ", ") + name;
        more.push_back(std::move(next));
      }
    variants = std::move(more);
  };
  multiply(axes.integrators, [](Variant& v, engine::IntegratorKind kind) {
    v.integrator = kind;
    return std::string(engine::info_of(engine::integrators, kind).name);
  });
  multiply(axes.solvers, [](Variant& v, engine::SolverKind kind) {
    v.solver = kind;
    for (const auto& info : engine::solvers)
      if (info.kind == kind) return std::string(info.name);
    return std::string();
  });
  multiply(axes.substeps, [](Variant& v, int count) {
    v.substeps = count;
    return count == 0 ? std::string("auto sub") : std::to_string(count) + " sub";
  });
  multiply(axes.precisions, [](Variant& v, engine::Precision kind) {
    v.precision = kind;
    return std::string(engine::info_of(engine::precisions, kind).name);
  });
  multiply(axes.dts, [](Variant& v, double dt) {
    v.dt = dt;
    char text[32];
    std::snprintf(text, sizeof text, "dt %.4g", dt);
    return std::string(text);
  });
  multiply(axes.clocks, [](Variant& v, engine::ClockKind kind) {
    v.clock = kind;
    return std::string(engine::info_of(engine::clock_kinds, kind).name);
  });
  if (!axes.clocks.empty())
    multiply(axes.hosts, [&](Variant& v, const std::string& host) {
      v.host = host;
      return axes.hosts.size() > 1 ? host : std::string();
    });
  multiply(axes.broad_phases, [](Variant& v, engine::BroadPhaseKind kind) {
    v.broad_phase = kind;
    return std::string(engine::info_of(engine::broad_phases, kind).name);
  });
  multiply(axes.threads, [](Variant& v, unsigned count) {
    v.threads = count;
    return count_text(count, "thread");
  });
  if (variants.size() == 1 && variants[0].name.empty()) variants.clear();
  return variants;
}

Result<std::vector<Variant>> with_varied(const std::vector<Variant>& variants, const Scene& scene,
                                         const VariedKey& varied, const std::string& place) {
  std::vector<Variant> out;
  const std::string name = varied.label.empty() ? varied.key.substr(varied.key.rfind('.') + 1) : varied.label;
  for (const Variant& variant : variants.empty() ? std::vector<Variant>{{}} : variants)
    for (const std::string& value : varied.values) {
      Result<Scene> changed = scene_with(variant.scene ? *variant.scene : scene, varied.key, value, place);
      if (!changed) return changed.error();
      Variant next = variant;
      const auto number = engine::parse_number(value);
      next.name += (next.name.empty() ? "" : ", ") + name + " " + (number ? short_number(*number) : value);
      next.scene = std::make_shared<const Scene>(*std::move(changed));
      next.varied_values.push_back(number ? full_number(*number) : value);
      out.push_back(std::move(next));
    }
  return out;
}

std::string base_text(const engine::Settings& settings) {
  std::string text = std::string(engine::info_of(engine::solvers, settings.solver).name) + ", " +
                     std::string(engine::info_of(engine::integrators, settings.integrator).name) + ", ";
  text += settings.auto_substeps ? "auto sub" : std::to_string(settings.substeps) + " sub";
  text += ", " + std::string(engine::info_of(engine::precisions, settings.precision).name);
  return text + ", dt " + short_number(settings.dt) + " s";
}

Scene twin_of(const Scene& scene, std::uint64_t seed) {
  Scene twin = scene;
  std::uint64_t bits = seed * 0x9e3779b97f4a7c15ull + 1;
  for (engine::Body& body : twin.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    bits = bits * 6364136223846793005ull + 1442695040888963407ull;
    const double sign = (bits >> 63) != 0 ? 1 : -1;
    double size = std::fabs(body.position.x);
    for (const engine::Shape& shape : body.shapes) size = std::max({size, shape.radius, shape.half_size.x});
    const int mantissa = scene.settings.precision == engine::Precision::f32 ? 23 : 52;
    if (size > 0) body.position.x += sign * std::ldexp(1.0, std::ilogb(size) - mantissa);
  }
  return twin;
}

std::optional<double> growth_rate(const std::vector<CompareSample>& samples) {
  double most = 0;
  for (const CompareSample& sample : samples) most = std::max(most, sample.position_rms);
  double n = 0, st = 0, sy = 0, stt = 0, sty = 0;
  for (const CompareSample& sample : samples) {
    if (sample.position_rms <= 0) continue;
    const double y = std::log(sample.position_rms);
    n += 1;
    st += sample.time_s;
    sy += y;
    stt += sample.time_s * sample.time_s;
    sty += sample.time_s * y;
    if (sample.position_rms >= 0.1 * most) break;
  }
  const double spread = n * stt - st * st;
  if (n < 3 || spread <= 0) return {};
  return (n * sty - st * sy) / spread;
}

std::optional<double> first_beyond(const std::vector<CompareSample>& samples) {
  for (const CompareSample& sample : samples)
    if (sample.position_rms > beyond_factor * sample.twin_rms) return sample.time_s;
  return {};
}

namespace {

// One run, with all values that need no other run.
struct Trajectory {
  std::string why_not;  // why the run was refused; empty: the run was accepted
  bool is_finite = true;
  bool has_clock = false;
  std::vector<double> dts;              // s, of each tick
  std::vector<std::uint64_t> bits;      // hash of the bodies after each tick
  std::vector<std::uint64_t> root;      // hash of the whole state after each tick
  std::vector<Bodies> samples;          // the bodies at the common times
  std::vector<CompareSample> measures;  // of each sample: values that do not depend on the base
  CompareRow row;                       // values that do not depend on the base
  CrosscheckRun outcome;
};

Scene scene_of(const CompareSession& session, const Variant& variant) {
  Scene scene = variant.scene ? *variant.scene : session.scene;
  engine::Settings& settings = scene.settings;
  if (variant.solver) scene = scene_with_solver(scene, *variant.solver);
  if (variant.integrator) settings.integrator = *variant.integrator;
  if (variant.substeps && *variant.substeps > 0) engine::use_fixed_substeps(settings, *variant.substeps);
  if (variant.substeps && *variant.substeps == 0 && !settings.auto_substeps) engine::choose_substeps(settings);
  if (variant.precision) settings.precision = *variant.precision;
  if (variant.dt) settings.dt = *variant.dt;
  if (variant.clock) settings.clock.kind = *variant.clock;
  if (variant.broad_phase) settings.broad_phase = *variant.broad_phase;
  return scene;
}

/// Whether the variant must give the same bits as the base in every column.
bool preserves_state(const Variant& v) {
  return !v.integrator && !v.clock && !v.solver && !v.substeps && !v.precision && !v.dt && !v.scene;
}

std::uint64_t bits_of(const StateView& view) {
  const auto table = view.schema->find_table("bodies");
  if (!table) return 0;
  return hash64(
      ByteView(view.tables[*table].data, view.tables[*table].row_count * view.schema->tables[*table].row_size));
}

// Gives each tick of a run its length and inputs. The length is the recorded one, the clock's or the scene's.
class TickMaker {
 public:
  TickMaker(const CompareSession& session, const Variant& variant, const CompareOptions& options, Engine& engine)
      : session_(session),
        engine_(engine),
        host_(variant.host),
        uses_record_(!variant.dt && !variant.clock && !session.dts.empty()) {
    if (!variant.clock) return;
    auto frames = open_host(variant.host, options.host_seed);
    if (!frames) {
      error_ = frames.error().message;
      return;
    }
    clock_.emplace(engine, std::make_unique<replay::NoInputs>(engine.scene().settings.dt), std::move(*frames));
  }

  /// Errors: those of the clock.
  Result<TickInput> next(std::uint64_t tick) {
    if (!error_.empty()) return Error{ErrorCode::io, error_, {}};
    double dt = engine_.scene().settings.dt;
    if (uses_record_ && tick < session_.dts.size()) dt = session_.dts[tick];
    if (clock_) {
      const auto input = clock_->next(tick);
      if (!input) return input.error();
      if (!*input)
        return Error{ErrorCode::usage,
                     "found no more frames of " + host_ + " after " + short_number(engine_.time_s()) + " s, expected " +
                         short_number(session_.seconds) + " s of them",
                     {}};
      dt = (*input)->dt;
    }
    collect(engine_.time_s());
    return TickInput{dt, bytes_};
  }

 private:
  // Collects the inputs up to this time. Renumbers them, because inputs of several recorded ticks may fall into one
  // tick.
  void collect(double time_s) {
    bytes_.clear();
    std::vector<engine::Input> due;
    while (next_ < session_.inputs.size() && session_.inputs[next_].time_s <= time_s + 1e-9)
      due.push_back(session_.inputs[next_++].input);
    if (due.empty()) return;
    std::stable_sort(due.begin(), due.end(), [](const auto& a, const auto& b) { return a.player < b.player; });
    for (std::size_t i = 0; i < due.size(); ++i)
      due[i].sequence = i > 0 && due[i].player == due[i - 1].player ? due[i - 1].sequence + 1 : 0;
    engine::encode_inputs(due, bytes_);
  }

  const CompareSession& session_;
  Engine& engine_;
  std::string host_;
  bool uses_record_;
  std::string error_;
  std::optional<ClockedInputs> clock_;
  std::size_t next_ = 0;
  Bytes bytes_;
};

// Interpolates the bodies at `time_s`, between two ticks: the position by a cubic through both positions and
// velocities, the angle linearly.
Bodies between(const Bodies& before, double before_s, const Bodies& after, double after_s, double time_s) {
  const double length = after_s - before_s;
  if (length <= 0 || std::fabs(after_s - time_s) < 1e-9) return after;
  const double s = (time_s - before_s) / length;
  const double a = (1 + 2 * s) * (1 - s) * (1 - s), b = s * (1 - s) * (1 - s), c = s * s * (3 - 2 * s),
               d = s * s * (s - 1);
  Bodies out;
  std::size_t k = 0;
  for (const BodyReport& body : after) {
    while (k < before.size() && before[k].id < body.id) ++k;
    BodyReport mixed = body;
    if (k < before.size() && before[k].id == body.id) {
      const BodyReport& old = before[k];
      mixed.center.x =
          a * old.center.x + b * length * old.velocity.x + c * body.center.x + d * length * body.velocity.x;
      mixed.center.y =
          a * old.center.y + b * length * old.velocity.y + c * body.center.y + d * length * body.velocity.y;
      mixed.angle = old.angle + s * std::remainder(body.angle - old.angle, 2 * engine::pi);
    }
    out.push_back(std::move(mixed));
  }
  return out;
}

/// The values of a sample at the end of a tick that do not depend on the base.
CompareSample measured(const Scene& scene, const Bodies& bodies, const std::vector<engine::ContactReport>& contacts) {
  CompareSample sample;
  sample.energy = energy_of(scene, bodies);
  const engine::Point momentum = momentum_of(bodies);
  sample.momentum = std::hypot(momentum.x, momentum.y);
  sample.overlap = deepest_overlap(contacts);
  sample.joint_gap = largest(joint_gaps(scene, bodies));
  return sample;
}

Trajectory run_trajectory(const CompareSession& session, const Variant& variant, const Scene& scene,
                          const CrosscheckLayout& layout, const CompareOptions& options) {
  Trajectory trajectory;
  trajectory.has_clock = variant.clock.has_value();
  trajectory.row.variant = variant;
  engine::EngineOptions choices;
  choices.thread_count = variant.threads.value_or(1);
  Result<Run> made = Run::make(scene, choices);
  if (!made) {
    trajectory.why_not = made.error().message;
    return trajectory;
  }
  Run& run = *made;
  Engine& engine = run.engine();
  TickMaker ticks(session, variant, options, engine);
  CrosscheckMeasure measure(layout, 0, 0);
  Bodies now = run.bodies();
  const Bodies start = now;
  double step_time_s = 0;
  for (int sample = 1; sample <= options.sample_count; ++sample) {
    const double time_s = session.seconds * sample / options.sample_count;
    Bodies before = now;
    double before_s = engine.time_s();
    while (engine.time_s() < time_s - 1e-9) {
      const auto input = ticks.next(engine.tick());
      if (!input) {
        trajectory.why_not = input.error().message;
        return trajectory;
      }
      if (Status accepted = engine.accept(*input); !accepted) {
        trajectory.why_not = accepted.error().message;
        return trajectory;
      }
      before_s = engine.time_s();
      if (before_s + input->dt >= time_s - 1e-9) before = run.bodies();
      const auto wall = std::chrono::steady_clock::now();
      const Result<double> computed_s = run.step(*input);
      if (!computed_s) {
        trajectory.why_not = computed_s.error().message;
        return trajectory;
      }
      step_time_s += options.wall_clock ? std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count()
                                        : *computed_s;
      trajectory.dts.push_back(input->dt);
      trajectory.bits.push_back(bits_of(engine.state()));
      trajectory.root.push_back(root_hash(engine.state()));
    }
    now = run.bodies();
    if (!all_finite(now)) {
      trajectory.is_finite = false;
      break;
    }
    trajectory.samples.push_back(between(before, before_s, now, engine.time_s(), time_s));
    const auto contacts = engine.contacts();
    trajectory.measures.push_back(measured(scene, now, contacts));
    if (options.measure) trajectory.measures.back().values = options.measure(engine);
    trajectory.measures.back().values_time_s = engine.time_s();
    const CompareSample& measured_now = trajectory.measures.back();
    trajectory.row.overlap_max = std::max(trajectory.row.overlap_max, measured_now.overlap);
    trajectory.row.joint_gap_max = std::max(trajectory.row.joint_gap_max, measured_now.joint_gap);
    measure.add(time_s, now, time_s > session.seconds - 1 ? &contacts : nullptr);
  }
  trajectory.row.tick_count = engine.tick();
  trajectory.row.root_hash = root_hash(engine.state());
  trajectory.row.energy = energy_of(scene, now) - energy_of(scene, start);
  const engine::Point momentum = momentum_of(now);
  trajectory.row.momentum = std::hypot(momentum.x, momentum.y);
  trajectory.row.ms_per_s = step_time_s * 1e3 / session.seconds;
  if (!trajectory.is_finite) return trajectory;
  trajectory.outcome = measure.finish();
  trajectory.row.placed_count = layout.placed_count;
  trajectory.row.standing_count = trajectory.outcome.standing_count;
  trajectory.row.order = trajectory.outcome.order;
  for (const CrosscheckPlace& place : trajectory.outcome.places) trajectory.row.resting_count += place.rests ? 1 : 0;
  return trajectory;
}

/// Adds the distance between `a` and `b` to `sample`.
CompareSample apart(const Bodies& a, const Bodies& b, double time_s, CompareSample sample) {
  sample.time_s = time_s;
  double squares = 0;
  std::size_t count = 0, k = 0;
  for (const BodyReport& body : a) {
    while (k < b.size() && b[k].id < body.id) ++k;
    if (k >= b.size() || b[k].id != body.id || body.type != BodyType::dynamic_body) continue;
    const double distance = std::hypot(body.center.x - b[k].center.x, body.center.y - b[k].center.y);
    sample.position_max = std::max(sample.position_max, distance);
    sample.angle_max = std::max(sample.angle_max, std::fabs(std::remainder(body.angle - b[k].angle, 2 * engine::pi)));
    squares += distance * distance;
    ++count;
  }
  if (count > 0) sample.position_rms = std::sqrt(squares / static_cast<double>(count));
  return sample;
}

std::size_t elsewhere(const CrosscheckRun& a, const CrosscheckRun& b, double size) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < std::min(a.places.size(), b.places.size()); ++i) {
    if (!a.places[i].rests || !b.places[i].rests) continue;
    const double distance = std::hypot(a.places[i].across - b.places[i].across, a.places[i].up - b.places[i].up);
    if (distance > size / 2) ++count;
  }
  return count;
}

// Fills the values that depend on the base. `twin_rms[i]`: the largest RMS of the twins up to sample i.
CompareRow against(const Trajectory& base, const Trajectory& trajectory, const std::vector<double>& twin_rms,
                   const CompareSession& session, int sample_count, double size) {
  CompareRow row = trajectory.row;
  if (!trajectory.why_not.empty()) {
    row.reason = trajectory.why_not;
    return row;
  }
  row.same_ticks = trajectory.dts == base.dts;
  const bool same_rows =
      row.same_ticks && session.scene.settings.precision == scene_of(session, row.variant).settings.precision;
  row.whole_state = same_rows && preserves_state(row.variant);
  const std::vector<std::uint64_t>& bits = row.whole_state ? trajectory.root : trajectory.bits;
  const std::vector<std::uint64_t>& base_bits = row.whole_state ? base.root : base.bits;
  if (same_rows)
    for (std::size_t i = 0; i < std::min(bits.size(), base_bits.size()); ++i)
      if (bits[i] != base_bits[i]) {
        row.first_different = i;
        break;
      }
  const std::size_t count = std::min(base.samples.size(), trajectory.samples.size());
  const double interval = session.seconds / sample_count;
  for (std::size_t i = 0; i < count; ++i) {
    CompareSample sample =
        apart(base.samples[i], trajectory.samples[i], interval * static_cast<double>(i + 1), trajectory.measures[i]);
    if (i < twin_rms.size()) sample.twin_rms = twin_rms[i];
    row.position_max = std::max(row.position_max, sample.position_max);
    row.angle_max = std::max(row.angle_max, sample.angle_max);
    row.position_rms = sample.position_rms;
    row.samples.push_back(sample);
  }
  row.growth = growth_rate(row.samples);
  row.elsewhere_count = elsewhere(base.outcome, trajectory.outcome, size);
  if (!trajectory.is_finite) {
    row.verdict = CompareVerdict::not_finite;
    row.reason =
        "a value is not finite after tick " + std::to_string(trajectory.bits.empty() ? 0 : trajectory.bits.size() - 1);
    return row;
  }
  if (same_rows && !row.first_different && trajectory.bits.size() == base.bits.size()) {
    row.verdict = CompareVerdict::same_bits;
    return row;
  }
  row.beyond_s = first_beyond(row.samples);
  row.verdict = row.beyond_s ? CompareVerdict::drift : CompareVerdict::within_twins;
  return row;
}

// Whether the outcome differs visibly: the number of standing bodies, their order, or their places of rest.
bool differs_in_outcome(const CompareRow& base, const CompareRow& row) {
  const double placed = static_cast<double>(std::max<std::size_t>(1, base.placed_count));
  const double standing = std::fabs(static_cast<double>(base.standing_count) - static_cast<double>(row.standing_count));
  return standing > 0.02 * placed || (base.placed_count > 0 && std::fabs(base.order - row.order) > 0.02) ||
         row.elsewhere_count > 0;
}

}  // namespace

Result<CompareReport> compare_variants(const CompareSession& session, const std::vector<Variant>& variants,
                                       const CompareOptions& options) {
  const CrosscheckLayout layout = make_layout(session.scene);
  const std::size_t twin_count = static_cast<std::size_t>(options.twin_count);
  std::vector<Trajectory> trajectories(1 + twin_count + variants.size());
  std::mutex mutex;
  std::uint64_t done_count = 0;
  const Status ran = run_jobs(trajectories.size(), options.thread_count, [&](std::size_t i) {
    Variant variant;
    variant.name = i == 0 ? "base" : "twin " + std::to_string(i);
    if (i > twin_count) variant = variants[i - 1 - twin_count];
    Scene scene = i == 0 ? session.scene : i <= twin_count ? twin_of(session.scene, i) : scene_of(session, variant);
    trajectories[i] = run_trajectory(session, variant, scene, layout, options);
    const std::lock_guard<std::mutex> lock(mutex);
    if (options.progress) options.progress(++done_count, trajectories.size());
  });
  if (!ran) return ran.error();
  const Trajectory& base = trajectories[0];
  if (!base.why_not.empty()) return Error{ErrorCode::invalid_scene, "compare: the base: " + base.why_not, {}};

  CompareReport report;
  report.size = layout.size;
  report.base = against(base, base, {}, session, options.sample_count, layout.size);
  report.base.verdict = base.is_finite ? CompareVerdict::same_bits : CompareVerdict::not_finite;
  std::vector<double> twin_rms(base.samples.size(), 0);
  std::size_t twins_with_other_outcome = 0;
  for (std::size_t i = 1; i <= twin_count; ++i) {
    report.twins.push_back(against(base, trajectories[i], {}, session, options.sample_count, layout.size));
    CompareRow& twin = report.twins.back();
    for (std::size_t k = 0; k < twin.samples.size() && k < twin_rms.size(); ++k)
      twin_rms[k] = std::max(twin_rms[k], twin.samples[k].position_rms);
    if (twin.verdict == CompareVerdict::drift) twin.verdict = CompareVerdict::within_twins;
    twin.beyond_s.reset();
    if (differs_in_outcome(report.base, twin)) ++twins_with_other_outcome;
  }
  for (std::size_t k = 1; k < twin_rms.size(); ++k) twin_rms[k] = std::max(twin_rms[k], twin_rms[k - 1]);
  for (std::size_t i = 1 + twin_count; i < trajectories.size(); ++i) {
    CompareRow row = against(base, trajectories[i], twin_rms, session, options.sample_count, layout.size);
    const bool is_judged = row.verdict == CompareVerdict::drift || row.verdict == CompareVerdict::within_twins;
    if (is_judged && differs_in_outcome(report.base, row)) {
      if (twins_with_other_outcome == 0) row.verdict = CompareVerdict::other_outcome;
      row.reason = twins_with_other_outcome == 0 ? "the twins all end as the base does"
                                                 : "the outcome is another one, but so is that of " +
                                                       std::to_string(twins_with_other_outcome) + " of the twins";
    }
    report.rows.push_back(std::move(row));
  }
  return report;
}

}  // namespace ticktrue::tool
