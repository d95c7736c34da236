// Selection of the stages that a scene needs, with reasons.
// SPDX-License-Identifier: MIT
#include "engine/pipeline.h"

#include "engine/broad_phase/broad_phase.h"
#include "engine/contacts/choose_kernels.h"
#include "engine/impacts/find_impacts.h"
#include "engine/islands/islands.h"
#include "engine/narrow_phase/narrow_phase.h"
#include "engine/narrow_phase/shape_pairs.h"
#include "engine/solvers/restitution.h"
#include "engine/solvers/solver.h"
#include "engine/stages/events.h"
#include "engine/stages/stages.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

template <typename Kind>
std::unique_ptr<Stage> make() {
  return std::make_unique<Kind>();
}

/// A stage without a workspace.
template <void (*act)(const Model& model, State& state, TickLists& tick, Real dt)>
class PlainStage final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override { act(model, state, tick, dt); }
};
template <void (*act)(const Model& model, State& state, TickLists& tick, Real dt)>
std::unique_ptr<Stage> plain() {
  return make<PlainStage<act>>();
}

}  // namespace

Pipeline compose(const Model& model, BroadPhaseKind broad_phase, bool full) {
  Pipeline pipeline;
  const auto solver_work = std::make_shared<SolverWork>();
  const auto consider = [&](std::string_view name, auto make, bool needed, std::string_view why_needed,
                            std::string_view why_not) {
    const bool included = needed || full;
    const std::string why(needed ? why_needed : (full ? "forced: " : ""));
    const std::string reason = needed ? why : why + std::string(why_not);
    if (included) pipeline.stages.push_back({std::string(name), make()});
    pipeline.description.push_back({std::string(name), included, reason});
  };

  const SolverInfo& solver = info_of(solvers, model.scene.settings.solver);
  const bool finds_pairs_itself = model.scene.settings.solver == SolverKind::impulse;
  const bool finds_contacts = (model.can_collide || model.has_sensors) && !finds_pairs_itself;
  const bool tells_contacts = model.scene.settings.events;
  const std::string_view no_pairs =
      finds_pairs_itself ? "the solver tests every pair itself" : "no two shapes can meet";

  consider("inputs", plain<apply_inputs>, model.takes_inputs, "the scene declares inputs",
           "the scene declares no inputs");
  consider("cull", plain<cull>, model.has_bounds, "the scene has bounds", "the scene has no bounds");
  // Contacts cannot be added to a solver that does not read them: their rows would change the state instead of
  // extending it.
  const bool contacts_possible = solver.solves_constraints && !finds_pairs_itself;
  if (finds_contacts || (full && contacts_possible)) {
    consider(
        info_of(broad_phases, broad_phase).name, [broad_phase] { return make_broad_phase(broad_phase); },
        finds_contacts, "two shapes can meet", no_pairs);
    consider("narrow_phase", make<NarrowPhase>, finds_contacts, meeting_pairs(model), no_pairs);
    pipeline.tables.contacts = true;
    consider("events", make<EventFinder>, tells_contacts || model.has_sensors,
             tells_contacts ? "the scene asks for events" : "a shape is a sensor", "no events asked for, no sensor");
    pipeline.tables.touching = tells_contacts || full;
    pipeline.tables.sensors = model.has_sensors || full;
    pipeline.tables.events = tells_contacts || model.has_sensors || full;
  } else {
    pipeline.description.push_back(
        {std::string(info_of(broad_phases, broad_phase).name), false, std::string(no_pairs)});
    pipeline.description.push_back({"narrow_phase", false, std::string(no_pairs)});
    pipeline.description.push_back({"events", false, std::string(no_pairs)});
  }
  const Settings& settings = model.scene.settings;
  const bool can_pass = finds_contacts && (settings.continuous || settings.locate_impacts);
  if (can_pass)
    consider("impacts", make<ImpactFinder>, true,
             settings.locate_impacts ? "the scene asks for bounces at their moment" : "fast bodies must not pass walls",
             "");
  else
    pipeline.description.push_back(
        {"impacts", false, finds_contacts ? "the scene forgoes continuous collision" : std::string(no_pairs)});
  // Islands own columns, so only the settings of the scene add them.
  if (model.finds_islands)
    consider("islands", make<IslandFinder>, true, "bodies may sleep, or get substeps of their own", "");
  else
    pipeline.description.push_back({"islands", false, "nothing sleeps, every body gets the same substeps"});
  const std::string left = left_out(full ? contact_feature::general : model.contact_features);
  const bool has_kernels = finds_contacts && model.can_collide && !left.empty();
  consider(
      solver.name, [&] { return make_solver(solver.kind, solver_work); }, true,
      has_kernels ? "every scene moves; its contacts have " + left : "every scene moves", "");
  if (can_pass && settings.locate_impacts)
    pipeline.description.push_back({"restitution", false, "impacts are located in time"});
  else if (finds_contacts || (full && contacts_possible))
    consider(
        "restitution", [&] { return std::make_unique<Restitution>(solver_work); }, finds_contacts && model.bounces,
        "a material bounces", "no pair of materials bounces");
  else
    pipeline.description.push_back(
        {"restitution", false, finds_pairs_itself ? "part of the solver" : "no two shapes can meet"});
  if (settings.sleep)
    consider("sleep", plain<measure_idle_time>, true, "the scene lets bodies sleep", "");
  else
    pipeline.description.push_back({"sleep", false, "the scene lets nothing sleep"});
  pipeline.tables.sleep = settings.sleep.has_value();
  pipeline.tables.substeps = settings.auto_substeps.has_value();
  pipeline.tables.loads = settings.substep_loads == SubstepLoads::measured;
  pipeline.tables.budget = settings.substep_budget > 0;
  pipeline.tables.pointers = model.has_pointer;
  pipeline.tables.joints = !model.joints.empty();
  pipeline.tables.gears = !model.gears.empty();
  pipeline.tables.accelerations = keeps_accelerations(model);
  pipeline.tables.integrator = model.scene.settings.integrator == IntegratorKind::implicit_midpoint;
  return pipeline;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
