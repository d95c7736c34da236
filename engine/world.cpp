// The engine of one precision: model, state, tick lists and pipeline put together as a Simulation.
// SPDX-License-Identifier: MIT
#include "engine/world.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/limits.h"
#include "engine/broad_phase/broad_phase.h"
#include "engine/contacts/choose_kernels.h"
#include "engine/math/trig.h"
#include "engine/model/motion_bounds.h"
#include "engine/model/poison.h"
#include "engine/model/tick_lists.h"
#include "engine/narrow_phase/narrow_phase.h"
#include "engine/pipeline.h"
#include "engine/scene/scene_json.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Point to_point(Vec2 v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y)};
}

Error input_error(const std::string& what, const std::string& hint = "") {
  return {ErrorCode::invalid_input, what, hint};
}

/// The inputs of the next tick. step() takes the inputs that accept() has decoded.
class DecodedInputs {
 public:
  Status decode(const Scene& scene, ByteView bytes) {
    if (is_valid_ && std::equal(bytes.begin(), bytes.end(), bytes_.begin(), bytes_.end())) return {};
    const Status status = decode_inputs(scene, bytes, inputs_);
    is_valid_ = status.has_value();
    bytes_.assign(bytes.begin(), bytes.end());
    return status;
  }
  /// Requires: decode succeeded.
  const std::vector<Input>& inputs() const { return inputs_; }
  /// Moves the inputs to `to`. Requires: decode succeeded.
  void take(std::vector<Input>& to) {
    is_valid_ = false;
    to.swap(inputs_);
  }

 private:
  std::vector<Input> inputs_;
  Bytes bytes_;  // of inputs_
  bool is_valid_ = false;
};

class World final : public Engine {
 public:
  World(const Scene& scene, const EngineOptions& options, std::unique_ptr<ChunkRunner> workers)
      : workers_(std::move(workers)),
        model_(make_model(scene)),
        broad_phase_(options.broad_phase.value_or(scene.settings.broad_phase)),
        is_full_(options.full_pipeline),
        pipeline_(compose(model_, broad_phase_, is_full_)),
        schema_(make_schema(model_, pipeline_.tables)),
        state_(initial_state(model_)) {
    model_.is_composed = !options.full_pipeline;
    const unsigned features = model_.contact_features | (options.full_pipeline ? contact_feature::general : 0u);
    set_kernels(model_, options.instruction_set.value_or(instruction_set_in_use()), features);
    for (const PipelineStage& stage : pipeline_.stages) {
      stage_names_.push_back(stage.name);
      stage.stage->list_caches(caches_);
    }
    tick_.parallel = options.parallel;
    if (options.parallel.runner == nullptr) tick_.parallel.runner = workers_.get();
    pair_count_max_ = options.pair_count_max;
    if (options.check_caches) check_ = std::make_unique<ColdTick>();
    view_.schema = &schema_;
    update_view(state_, pipeline_.tables, view_);
  }

  Status accept(const TickInput& input) const override {
    if (!last_step_) return last_step_;
    if (!(input.dt >= limits::dt_min_s && input.dt <= limits::dt_max_s))
      return input_error("dt: found " + lane_text(ScalarType::f64, bits_of(input.dt)) + " s, expected 1e-09..1");
    if (state_.world.tick >= limits::tick_count_max) return input_error("tick: no more ticks are possible");
    if (const Status status = decoded_.decode(model_.scene, input.inputs); !status) return status;
    // Bodies that this tick's inputs may still create count as issued; each press creates at most one.
    std::uint64_t issued = state_.world.next_id;
    for (const Input& event : decoded_.inputs()) {
      const InputInfo& info = info_of(input_kinds, event.kind);
      if (info.may_make_body) ++issued;
      if (issued >= no_reference) return input_error("id: no more bodies can be made");
      if (state_.bodies.size() + (issued - state_.world.next_id) > limits::body_count_max)
        return {{ErrorCode::limit, "bodies: more than " + std::to_string(limits::body_count_max),
                 "set spawned_max in the scene"}};
      if (!info.has_body) continue;
      if (event.body >= issued)
        return input_error(std::string(info.name) + ": body: id " + std::to_string(event.body) +
                           " was never issued: found " + std::to_string(event.body) + ", expected less than " +
                           std::to_string(issued));
      if (event.kind != InputKind::set_velocity) continue;
      const std::size_t row = state_.find_body(event.body);
      if (row < state_.bodies.size() && model_.bodies[state_.bodies[row].source].type == BodyType::static_body)
        return input_error("set_velocity: body: id " + std::to_string(event.body) + " is static",
                           "use a kinematic body for what moves but is not pushed");
    }
    return {};
  }

  Status step(const TickInput& input, StageObserver* observer) override {
    if (!last_step_) return last_step_;
#ifdef TICKTRUE_POISON
    poison_all_but_caches();
#endif
    const Status decoded = decoded_.decode(model_.scene, input.inputs);
    TICKTRUE_ASSERT(decoded.has_value());
    decoded_.take(tick_.inputs);
    tick_.injected = std::exchange(injected_, std::nullopt);
    if (check_ != nullptr) begin_check(input);
    begin_tick(tick_);
    begin_state(state_, input);
    const Real dt = static_cast<Real>(input.dt);
    for (std::size_t i = 0; i < pipeline_.stages.size(); ++i) {
      tick_.pair_count_max = pair_count_max();  // inputs create bodies
      pipeline_.stages[i].stage->run(model_, state_, tick_, dt);
      if (tick_.has_too_many_pairs) {
        forget_caches(all_caches);
        last_step_ = too_many_pairs();
        break;
      }
      if (check_ != nullptr && last_step_) last_step_ = check_stage(i, dt);
      if (observer == nullptr) continue;
      update_view(state_, pipeline_.tables, view_);
      observer->after_stage(i, view_);
    }
    update_view(state_, pipeline_.tables, view_);
    return last_step_;
  }

  const StateView& state() const override {
    return view_;
  }

  Status load(ByteView image) override {
    const Status status = load_state(model_, schema_, pipeline_.tables, image, state_);
    if (status) {
      forget_caches(all_caches);
      last_step_ = {};
    }
    update_view(state_, pipeline_.tables, view_);
    return status;
  }

  Status inject(const InnerFault& fault) override {
    struct Field {
      std::string_view column;
      BodyField field;
    };
    constexpr Field fields[] = {{"position", BodyField::position},
                                {"rotation", BodyField::rotation},
                                {"velocity", BodyField::velocity},
                                {"angular_velocity", BodyField::angular_velocity}};
    const TableSchema& table = schema_.tables[fault.place.table];
    const bool has_substeps = model_.scene.settings.solver == SolverKind::tgs_soft;
    const bool has_row = table.name == "bodies" && fault.place.row < state_.bodies.size() &&
                         model_.bodies[state_.bodies[fault.place.row].source].type != BodyType::static_body;
    for (const Field& field : fields)
      if (has_substeps && has_row && field.column == table.columns[fault.place.column].name) {
        injected_ = {fault.place.row, field.field, fault.place.lane, fault.bit, static_cast<int>(fault.substep)};
        return {};
      }
    return Error{ErrorCode::unsupported, "the solver works on what moves, in substeps, with tgs_soft alone", ""};
  }

  std::span<const std::string> stage_names() const override {
    return stage_names_;
  }

  std::string row_name(std::size_t table, std::size_t row) const override {
    std::string name;
    std::size_t index = 0;
    for_each_table(state_, pipeline_.tables, [&](const char*, const auto& rows) {
      if constexpr (requires { rows[row]; })
        if (index == table && row < rows.size()) name = name_of(rows[row], row);
      ++index;
    });
    return name;
  }

  std::string inputs_text(std::uint64_t tick, ByteView bytes) const override {
    std::vector<Input> inputs;
    if (!decode_inputs(model_.scene, bytes, inputs)) return "";
    std::string text;
    for (Input& input : inputs) {
      input.tick = tick;
      text += print_input(model_.scene, input) + "\n";
    }
    return text;
  }

  std::vector<StageDescription> describe() const override {
    return pipeline_.description;
  }
  const Scene& scene() const override {
    return model_.scene;
  }
  std::uint64_t tick() const override {
    return state_.world.tick;
  }
  double time_s() const override {
    return state_.world.time;
  }
  std::uint64_t ignored_inputs() const override {
    return state_.world.ignored_inputs;
  }
  std::optional<BudgetReport> budget_report() const override {
    if (!pipeline_.tables.budget) return std::nullopt;
    return BudgetReport{state_.budget.cut_ticks, state_.budget.limited_ticks};
  }

  void forget_caches(CacheSet caches) override {
    for (TickCache* cache : caches_)
      if ((caches & cache_bit(cache->kind())) != 0) cache->invalidate();
  }
  CacheReport cache_report() const override {
    CacheReport report{};
    for (const TickCache* cache : caches_) report[static_cast<std::size_t>(cache->kind())] = cache->counts();
    return report;
  }

  std::vector<BodyReport> bodies() const override {
    std::vector<BodyReport> reports;
    for (const BodyRow& row : state_.bodies) {
      const BodyModel& constants = model_.bodies[row.source];
      const Body& description = description_of(row);
      BodyReport report;
      report.id = row.id;
      report.name = body_name(row);
      report.type = constants.type;
      report.center = to_point(row.position);
      report.origin = to_point(row.position - rotate(row.rotation, constants.center));
      report.angle = arc_tangent(static_cast<double>(row.rotation.s), static_cast<double>(row.rotation.c));
      report.velocity = to_point(row.velocity);
      report.angular_velocity = static_cast<double>(row.angular_velocity);
      report.mass = static_cast<double>(constants.mass);
      report.inertia = static_cast<double>(constants.inertia);
      report.shapes = &description.shapes;
      reports.push_back(std::move(report));
    }
    return reports;
  }

  std::vector<ContactReport> contacts() const override {
    TickLists found;
    found.pair_count_max = pair_count_max();
    State poses = state_;
    const std::unique_ptr<Stage> broad_phase = make_broad_phase(BroadPhaseKind::sweep_and_prune);
    NarrowPhase narrow_phase;
    broad_phase->run(model_, poses, found, Real(0));
    narrow_phase.run(model_, poses, found, Real(0));
    std::vector<ContactReport> reports;
    for (std::size_t i = 0; i < found.contact_pairs.size(); ++i) {
      const ContactPair& pair = found.contact_pairs[i];
      const ContactRow& row = poses.contacts[i];
      ContactReport report;
      report.body_a = row.body_a;
      report.body_b = row.body_b;
      report.normal = to_point(pair.manifold.normal);
      report.point_count = pair.manifold.point_count;
      for (int p = 0; p < report.point_count; ++p) {
        report.point[p] = to_point(poses.bodies[pair.body_a].position + pair.manifold.points[p].anchor_a);
        report.separation[p] = static_cast<double>(pair.manifold.points[p].separation);
        report.normal_force[p] = static_cast<double>(row.normal_force[p]);
      }
      reports.push_back(report);
    }
    return reports;
  }

  BroadPhaseReport broad_phase() const override {
    const Real dt = static_cast<Real>(model_.scene.settings.dt);
    TickLists found;
    found.pair_count_max = pair_count_max();
    State poses = state_;
    const std::unique_ptr<Stage> stage = make_broad_phase(model_.scene.settings.broad_phase);
    stage->run(model_, poses, found, dt);
    const Real gravity_displacement = gravity_displacement_of_tick(model_, state_);
    const MotionBounds bounds = motion_bounds_of_tick(model_, state_, dt);
    BroadPhaseReport report;
    for (const Proxy& proxy : found.proxies) {
      const BodyRow& body = state_.bodies[proxy.body];
      const Box box = box_around(model_, body, model_.shapes[proxy.shape], gravity_displacement,
                                 swept_displacement_of(bounds, model_.bodies[body.source], body));
      report.boxes.push_back({body.id, to_point(box.lower), to_point(box.upper)});
    }
    for (const Pair& pair : found.pairs) report.pairs.push_back({pair.first, pair.second});
    return report;
  }

 private:
  std::size_t pair_count_max() const {
    return pair_count_max_.value_or(limits::pair_count_max(state_.bodies.size()));
  }

  /// A tick without any cached structure, in addition to the real tick.
  struct ColdTick {
    State state;
    std::optional<TickLists> tick;
    Pipeline pipeline;
  };

  /// Poisons the memory of stages and lists, so that only caches can carry data from one tick to the next.
  void poison_all_but_caches() {
    list_fields(tick_, Poison{});
    for (const PipelineStage& stage : pipeline_.stages) stage.stage->poison();
  }

  static void begin_state(State& state, const TickInput& input) {
    ++state.world.tick;
    state.world.time += input.dt;
  }

  /// Begins the same tick in `check_`.
  void begin_check(const TickInput& input) {
    check_->state = state_;
    check_->pipeline = compose(model_, broad_phase_, is_full_);
    TickLists& cold = check_->tick.emplace();
    cold.parallel = tick_.parallel;
    cold.inputs = tick_.inputs;
    cold.injected = tick_.injected;
    begin_state(check_->state, input);
  }

  /// Runs a stage in `check_`, too. Errors: inconsistent.
  Status check_stage(std::size_t stage, Real dt) {
    check_->tick->pair_count_max = tick_.pair_count_max;
    check_->pipeline.stages[stage].stage->run(model_, check_->state, *check_->tick, dt);
    StateView cold;
    cold.schema = &schema_;
    update_view(check_->state, pipeline_.tables, cold);
    update_view(state_, pipeline_.tables, view_);
    Bytes expected;
    Bytes got;
    encode_image(cold, expected);
    encode_image(view_, got);
    if (expected == got) return {};
    return cached_otherwise(stage, expected, got);
  }

  Error cached_otherwise(std::size_t stage, const Bytes& expected, const Bytes& got) const {
    const auto tables_expected = split_image(schema_, expected);
    const auto tables_got = split_image(schema_, got);
    TICKTRUE_ASSERT(tables_expected.has_value() && tables_got.has_value());
    const std::vector<LaneDifference> found = diff_images(schema_, *tables_expected, *tables_got, 1);
    TICKTRUE_ASSERT(!found.empty());
    const LaneDifference& first = found[0];
    const TableSchema& table = schema_.tables[first.place.table];
    const Column& column = table.columns[first.place.column];
    const auto text = [&](const std::optional<std::uint64_t>& bits) {
      return bits ? lane_hex(column.type, *bits) + " (" + lane_text(column.type, *bits) + ")" : std::string("no row");
    };
    return {ErrorCode::inconsistent,
            "tick " + std::to_string(state_.world.tick - 1) + ": stage " + stage_names_[stage] + ": " + table.name +
                "." + column.name + " row " + std::to_string(first.place.row) + ": found " + text(first.got) +
                " with cached structures, expected " + text(first.expected) + " without",
            "this is a fault of the engine: report it with the scene, its inputs and this line"};
  }

  Error too_many_pairs() const {
    const std::string most = std::to_string(tick_.pair_count_max);
    return {ErrorCode::limit,
            "tick " + std::to_string(state_.world.tick - 1) + ": pairs of shapes near each other: found more than " +
                most + ", expected at most " + most,
            "thousands of shapes are in one place: move them apart, or give them filters that keep them from meeting"};
  }

  const Body& description_of(const BodyRow& row) const {
    return row.source < model_.first_prototype ? model_.scene.bodies[row.source]
                                               : model_.scene.prototypes[row.source - model_.first_prototype];
  }
  std::string body_name(const BodyRow& row) const {
    const std::string& name = description_of(row).name;
    if (row.source >= model_.first_prototype) return name + "#" + std::to_string(row.id);
    return name.empty() ? "body#" + std::to_string(row.id) : name;
  }
  std::string body_name(std::uint32_t id) const {
    const std::size_t row = state_.find_body(id);
    return row < state_.bodies.size() ? body_name(state_.bodies[row]) : "body#" + std::to_string(id);
  }

  std::string joint_name(std::uint32_t joint) const {
    const std::string& name = model_.scene.joints[joint].name;
    return name.empty() ? "joint#" + std::to_string(joint) : name;
  }

  // The name of a row of a table.
  std::string name_of(const BodyRow& row, std::size_t) const {
    return body_name(row);
  }
  std::string name_of(const AccelerationRow&, std::size_t row) const {
    return body_name(state_.bodies[row]);
  }
  std::string name_of(const JointRow& row, std::size_t) const {
    return joint_name(row.joint);
  }
  std::string name_of(const GearRow&, std::size_t row) const {
    for (const JointRow& joint : state_.joints)
      if (model_.joints[joint.joint].gear != no_gear && row-- == 0) return joint_name(joint.joint);
    return "";
  }
  std::string name_of(const PointerRow& row, std::size_t) const {
    return "player " + std::to_string(row.player) + " / " + body_name(row.body);
  }
  std::string name_of(const EventRow& row, std::size_t index) const {
    return name_of(row.touch, index);
  }
  template <typename Row>
  std::string name_of(const Row& row, std::size_t) const {
    if constexpr (requires { row.child_a; }) return body_name(row.body_a) + " / " + body_name(row.body_b);
    return "";
  }

  std::unique_ptr<ChunkRunner> workers_;
  Model model_;
  BroadPhaseKind broad_phase_;
  bool is_full_;
  Pipeline pipeline_;
  StateSchema schema_;
  State state_;
  TickLists tick_;
  std::vector<TickCache*> caches_;  // of the stages and the solver
  std::optional<std::size_t> pair_count_max_;
  std::unique_ptr<ColdTick> check_;        // if every tick also runs without cached structures
  std::optional<InjectedFault> injected_;  // for the next tick
  mutable DecodedInputs decoded_;
  Status last_step_;  // after an error, the state belongs to no tick
  StateView view_;
  std::vector<std::string> stage_names_;
};

}  // namespace

std::unique_ptr<Engine> make_world(const Scene& scene, const EngineOptions& options,
                                   std::unique_ptr<ChunkRunner> workers) {
  return std::make_unique<World>(scene, options, std::move(workers));
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
