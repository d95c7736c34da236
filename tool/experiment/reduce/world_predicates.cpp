// Predicates that only need this build.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/state/non_finite.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/experiment/reduce/predicate.h"

namespace ticktrue::reduce {
namespace {

using engine::Engine;
using soak::CaseInputs;

using Answer = Result<std::optional<Failure>>;

Error at_tick(std::uint64_t tick, const Error& error) {
  const std::string place = "tick " + std::to_string(tick) + ": ";
  if (error.message.compare(0, place.size(), place) == 0) return error;
  return Error{error.code, place + error.message, error.hint};
}

/// Runs one tick. Errors: a refused or failed tick.
Status step_once(Engine& engine, const TickInput& input, std::uint64_t tick, StageObserver* observer) {
  if (const Status accepted = engine.accept(input); !accepted) return at_tick(tick, accepted.error());
  if (const Status did = engine.step(input, observer); !did) return at_tick(tick, did.error());
  return {};
}

/// Runs the session until `look`, called after each tick, finds a failure.
template <typename Look>
Answer run_until(Engine& engine, const SoakCase& session, const Look& look) {
  const CaseInputs inputs(session);
  for (std::uint64_t tick = 0; tick < session.tick_count; ++tick) {
    if (const Status did = step_once(engine, inputs.at(tick), tick, nullptr); !did) return did.error();
    if (std::optional<Failure> found = look(tick)) return found;
  }
  return std::optional<Failure>();
}

/// Stores the first stage after which a value is not finite.
class FirstNonFinite : public StageObserver {
 public:
  void after_stage(std::size_t stage, const StateView& state) override {
    if (!stage_ && find_non_finite(state)) stage_ = stage;
  }
  std::optional<std::size_t> stage() const { return stage_; }

 private:
  std::optional<std::size_t> stage_;
};

class NotFinite : public Predicate {
 public:
  explicit NotFinite(const EngineMaker& make) : make_(make) {}
  std::vector<std::string> words() const override { return {"--not-finite"}; }

  Answer examine(const SoakCase& session) override {
    const auto made = make_(session.scene, {});
    if (!made) return made.error();
    Engine& engine = **made;
    Answer answer = run_until(engine, session, [&](std::uint64_t tick) -> std::optional<Failure> {
      const auto place = find_non_finite(engine.state());
      if (!place) return std::nullopt;
      const auto found = find_non_finite_of(engine, tick);
      Failure failure;
      failure.kind = "not_finite";
      failure.tick = tick;
      failure.table = found->table;
      failure.column = found->column;
      failure.row = found->row;
      failure.bodies = bodies_of_row(engine.state(), place->table, place->row);
      failure.what = non_finite_text(*found);
      return failure;
    });
    if (answer && *answer) (*answer)->stage = stage_of(session, (*answer)->tick);
    return answer;
  }

 private:
  /// Runs the session again, and examines the state after each stage of the last tick.
  std::string stage_of(const SoakCase& session, std::uint64_t last) const {
    const auto made = make_(session.scene, {});
    if (!made) return "";
    const CaseInputs inputs(session);
    FirstNonFinite observer;
    for (std::uint64_t tick = 0; tick <= last; ++tick)
      if (!step_once(**made, inputs.at(tick), tick, tick == last ? &observer : nullptr)) return "";
    return observer.stage() ? (*made)->stage_names()[*observer.stage()] : "";
  }

  EngineMaker make_;
};

class BrokenExpectation : public Predicate {
 public:
  BrokenExpectation(tool::Expression expression, const EngineMaker& make)
      : expression_(std::move(expression)), make_(make) {}
  std::vector<std::string> words() const override { return {"--expect", expression_.text()}; }

  Answer examine(const SoakCase& session) override {
    const auto made = make_(session.scene, {});
    if (!made) return made.error();
    Engine& engine = **made;
    expression_.begin(engine);
    // If the expression is false before the first tick, the session shows nothing.
    if (!holds(engine))
      return Error{
          ErrorCode::usage,
          "--expect: \"" + expression_.text() + "\" is broken before the first tick: " + expression_.values_text(),
          "expect something that holds at first; NAME_start is the value before the first tick"};
    return run_until(engine, session, [&](std::uint64_t tick) -> std::optional<Failure> {
      if (holds(engine)) return std::nullopt;
      Failure failure;
      failure.kind = find_non_finite(engine.state()) ? "expectation_not_finite" : "expectation";
      failure.tick = tick;
      failure.what = "\"" + expression_.text() + "\" is broken: " + expression_.values_text();
      failure.bodies = culprits(engine);
      return failure;
    });
  }

 private:
  bool holds(const Engine& engine) {
    const double value = expression_.evaluate(engine);
    return value != 0 && !std::isnan(value);
  }
  std::vector<std::uint32_t> culprits(const Engine& engine) const {
    tool::WorldMeasures measures(engine);
    for (const tool::WorldValue value : expression_.values())
      if (std::vector<std::uint32_t> bodies = measures.bodies_of(value); !bodies.empty()) return bodies;
    return {};
  }

  tool::Expression expression_;
  EngineMaker make_;
};

class StaleCache : public Predicate {
 public:
  explicit StaleCache(const EngineMaker& make) : make_(make) {}
  std::vector<std::string> words() const override { return {"--check-caches"}; }

  Answer examine(const SoakCase& session) override {
    engine::EngineOptions options;
    options.check_caches = true;
    const auto made = make_(session.scene, options);
    if (!made) return made.error();
    const CaseInputs inputs(session);
    for (std::uint64_t tick = 0; tick < session.tick_count; ++tick) {
      const Status did = step_once(**made, inputs.at(tick), tick, nullptr);
      if (did) continue;
      if (did.error().code != ErrorCode::inconsistent) return did.error();
      Failure failure;
      failure.kind = "stale_cache";
      failure.tick = tick;
      failure.what = did.error().message;
      read_place(failure.what, failure);
      return std::optional(failure);
    }
    return std::optional<Failure>();
  }

 private:
  EngineMaker make_;
};

class OracleCheck : public Predicate {
 public:
  OracleCheck(std::string word, soak::OracleOptions options) : word_(std::move(word)), options_(std::move(options)) {}
  std::vector<std::string> words() const override { return {"--check", word_}; }

  Answer examine(const SoakCase& session) override {
    constexpr std::uint64_t seed = 1;
    std::optional<soak::Finding> found;
    if (!options_.checks.only.empty()) {
      found = examine_variant(session, options_.checks.only.front(), options_);
    } else {
      const soak::WorldResult result = soak::examine(session, seed, options_);
      if (!result.findings.empty()) found = result.findings.front();
    }
    if (!found) return std::optional<Failure>();
    if (found->is_refused) return Error{ErrorCode::invalid_scene, found->what, ""};
    Failure failure;
    failure.kind = std::string(soak::check_table[static_cast<std::size_t>(found->variant.check)].name);
    failure.tick = found->tick;
    failure.what = variant_text(found->variant) + ": " + found->what;
    read_place(found->what, failure);
    return std::optional(failure);
  }

 private:
  std::string word_;
  soak::OracleOptions options_;
};

class CrosscheckDiffers : public Predicate {
 public:
  std::vector<std::string> words() const override { return {"--crosscheck"}; }
  bool is_of_outcome() const override { return true; }

  Answer examine(const SoakCase& session) override {
    tool::CrosscheckOptions options;
    options.seconds = static_cast<double>(session.tick_count) * session.scene.settings.dt;
    const auto report = tool::crosscheck(session.scene, options);
    if (!report) return report.error();
    for (const tool::CriterionResult& row : report->rows) {
      if (row.verdict != tool::Agreement::differ) continue;
      Failure failure;
      failure.kind = "crosscheck";
      failure.tick = session.tick_count - 1;
      failure.table = row.criterion;
      failure.what = row.criterion + (row.reason.empty() ? " differs from Box2D" : ": " + row.reason);
      return std::optional(failure);
    }
    return std::optional<Failure>();
  }
};

}  // namespace

std::unique_ptr<Predicate> not_finite(const EngineMaker& make) {
  return std::make_unique<NotFinite>(make);
}
std::unique_ptr<Predicate> broken_expectation(tool::Expression expression, const EngineMaker& make) {
  return std::make_unique<BrokenExpectation>(std::move(expression), make);
}
std::unique_ptr<Predicate> stale_cache(const EngineMaker& make) {
  return std::make_unique<StaleCache>(make);
}
std::unique_ptr<Predicate> crosscheck_differs() {
  return std::make_unique<CrosscheckDiffers>();
}

Result<std::unique_ptr<Predicate>> oracle_check(const std::string& word, const soak::OracleOptions& options) {
  const auto checks = soak::parse_checks({word});
  if (!checks) return checks.error();
  soak::OracleOptions with = options;
  with.checks = *checks;
  return std::unique_ptr<Predicate>(std::make_unique<OracleCheck>(word, std::move(with)));
}

}  // namespace ticktrue::reduce
