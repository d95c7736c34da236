// Makes an animation: reads the records once, runs one simulation throughout and reloads a second from stored states.
// SPDX-License-Identifier: MIT
#include "tool/report_page/animation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <variant>

#include "base/hash.h"
#include "engine/engine.h"
#include "engine/math/trig.h"
#include "tool/drawing/svg.h"
#include "tool/session/trace_summary.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::tool {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;

constexpr std::uint64_t exact_before = 90, exact_after = 180;  // ticks around the focus
constexpr std::size_t focus_lines_max = 200;                   // input lines of the focus that are always listed

/// Reads frames from the states of an engine.
class FrameReader {
 public:
  FrameReader(const engine::Engine& engine, Animation& animation)
      : drawing_(engine.scene(), *engine.state().schema), animation_(animation), pi_(engine::pi) {
    animation_.figures = drawing_.figures();
  }

  /// Called for every tick. `angles` are those of the previous tick, so that angles are continuous. The view is
  /// extended to all positions of moving bodies.
  Frame read(const engine::Engine& engine, std::vector<double>& angles, bool with_sums) {
    Frame frame;
    frame.ticks_done = engine.tick();
    frame.time_s = engine.time_s();
    drawing_.read(engine.state(), drawn_);
    frame.poses.reserve(drawn_.size());
    const engine::Point gravity = drawing_.gravity(engine.state());
    for (const DrawnBody& body : drawn_) {
      const Figure& figure = animation_.figures[body.figure];
      if (!body.is_finite) continue;
      const std::uint32_t index = index_of(body);
      if (angles.size() <= index) angles.resize(animation_.bodies.size(), 0);
      angles[index] = next_angle(angles[index], engine::arc_tangent(body.sin, body.cos));
      frame.poses.push_back({index, body.center.x, body.center.y, angles[index]});
      if (figure.type != engine::BodyType::static_body) {
        visited_.add(body.center.x - figure.extent, body.center.y - figure.extent);
        visited_.add(body.center.x + figure.extent, body.center.y + figure.extent);
      }
      add_sums(body, figure, gravity, frame.sums);
    }
    if (with_sums) add_contacts(engine, frame.sums);
    return frame;
  }

  const WorldBox& visited() const { return visited_; }
  std::optional<std::uint32_t> find(std::uint32_t id) const {
    const auto found = index_of_id_.find(id);
    return found == index_of_id_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::uint32_t index_of(const DrawnBody& body) {
    const auto [at, is_new] = index_of_id_.try_emplace(body.id, static_cast<std::uint32_t>(animation_.bodies.size()));
    if (is_new) animation_.bodies.push_back({body.id, body.figure, drawing_.name(body)});
    return at->second;
  }

  double next_angle(double before, double angle) const {
    const double turns = std::floor((before - angle) / (2 * pi_) + 0.5);
    return angle + turns * 2 * pi_;
  }

  static void add_sums(const DrawnBody& body, const Figure& figure, const engine::Point& gravity, FrameSums& sums) {
    const engine::Point& v = body.velocity;
    const double mass = figure.mass;
    sums.kinetic +=
        (mass * (v.x * v.x + v.y * v.y) + figure.inertia * body.angular_velocity * body.angular_velocity) / 2;
    sums.potential -= mass * figure.gravity_scale * (gravity.x * body.center.x + gravity.y * body.center.y);
    sums.momentum_x += mass * v.x;
    sums.momentum_y += mass * v.y;
  }

  static void add_contacts(const engine::Engine& engine, FrameSums& sums) {
    for (const engine::ContactReport& contact : engine.contacts()) {
      ++sums.contact_count;
      for (int i = 0; i < contact.point_count; ++i)
        if (-contact.separation[i] > sums.penetration) sums.penetration = -contact.separation[i];
    }
  }

  Drawing drawing_;
  Animation& animation_;
  double pi_;
  std::vector<DrawnBody> drawn_;
  std::map<std::uint32_t, std::uint32_t> index_of_id_;
  WorldBox visited_;
};

/// A simulation of the trace's setup; `engine` is set if the simulation is an Engine.
struct AnimatedRun {
  std::unique_ptr<Simulation> simulation;
  const engine::Engine* engine = nullptr;
  std::vector<double> angles;  // [body], of the previous state
};

std::uint32_t read_u32(const std::uint8_t* at) {
  std::uint32_t value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// Calls `each` with the ids of the owners of a row.
template <typename Each>
void for_each_reference(const StateView& state, std::size_t table, std::size_t row, Each each) {
  const TableSchema& schema = state.schema->tables[table];
  if (row >= state.tables[table].row_count) return;
  const std::uint8_t* data = state.tables[table].data + row * schema.row_size;
  for (const Column& column : schema.columns)
    if (column.target >= 0 && column.type == ScalarType::u32 && read_u32(data + column.offset) != no_reference)
      each(read_u32(data + column.offset));
}

class AnimationMaker {
 public:
  AnimationMaker(replay::TraceReader& reader, const AnimationOptions& options)
      : reader_(reader), options_(options), listing_(reader.setup()) {}

  Animation run() {
    begin();
    reader_.rewind();
    for (;;) {
      const replay::TraceReader::Item& item = reader_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item))
        process(*checkpoint);
      else
        process(std::get<TickRecord>(item));
    }
    end();
    return std::move(animation_);
  }

 private:
  void begin() {
    const std::uint64_t focus = options_.focus.value_or(0);
    if (options_.focus) {
      animation_.exact_first = focus > exact_before ? focus - exact_before : 0;
      animation_.exact_last = focus + exact_after;
    }
    here_ = make_run();
    if (here_.simulation == nullptr) return;
    if (here_.engine == nullptr) {
      animation_.no_poses = "This build simulates " + reader_.setup().simulation +
                            ", but does not know what its columns look like: there is nothing to draw.";
      return;
    }
    frame_reader_ = std::make_unique<FrameReader>(*here_.engine, animation_);
    Frame first = take_here();
    if (has_too_many(first)) return;
    add_frame(std::move(first));
    if (options_.focus == std::uint64_t{0}) answer_questions();
  }

  bool has_too_many(const Frame& frame) {
    if (frame.poses.size() <= options_.body_count_max) return false;
    animation_.no_poses = "There are " + std::to_string(frame.poses.size()) + " bodies; a page draws at most " +
                          std::to_string(options_.body_count_max) + ".";
    animation_.frames.clear();
    animation_.recorded.clear();
    return true;
  }

  AnimatedRun make_run() {
    AnimatedRun run;
    const SimulationInfo* info = options_.simulation;
    if (reader_.first_tick() > 0) {
      animation_.no_poses =
          "The trace begins at tick " + std::to_string(reader_.first_tick()) + ": it is not run again from its setup.";
      return run;
    }
    if (info == nullptr) {
      animation_.no_poses = "This build has no simulation " + reader_.setup().simulation + ": nothing was run again.";
      return run;
    }
    auto made = info->make(reader_.setup().setup);
    if (!made) {
      animation_.no_poses = "This build does not accept the setup of the trace: " + made.error().message + ".";
      return run;
    }
    run.simulation = std::move(*made);
    run.engine = dynamic_cast<const engine::Engine*>(run.simulation.get());
    return run;
  }

  Frame take_here() {
    const std::uint64_t done = here_.engine->tick();
    return frame_reader_->read(*here_.engine, here_.angles, includes_frame(animation_, done));
  }

  void process(const CheckpointRecord& checkpoint) {
    animation_.checkpoints.push_back(checkpoint.tick);
    if (differed_) begin_anew(checkpoint.image, checkpoint.root_hash);
  }

  /// Loads a stored state into the second run.
  void begin_anew(ByteView image, std::uint64_t root) {
    recorded_is_known_ = false;
    if (recorded_.simulation == nullptr) recorded_ = make_run();
    if (recorded_.simulation == nullptr || !recorded_.simulation->load(image)) return;
    if (root_hash(recorded_.simulation->state()) != root) return;
    recorded_is_known_ = true;
    // Angles continue those of the first run.
    if (recorded_.engine != nullptr) recorded_.angles = here_.angles;
  }

  void process(const TickRecord& record) {
    process_inputs(record);
    if (options_.progress) options_.progress(record.tick + 1);
    ++ticks_read_;
    time_s_ += record.dt;
    const TickInput input{record.dt, record.inputs};
    if (!runs() || !accepts(record.tick, input)) {
      add_match(record.tick, TickMatch::not_compared);
      return;
    }
    if (const Status did = here_.simulation->step(input, nullptr); !did) {
      animation_.stopped = did.error().message;
      add_match(record.tick, TickMatch::not_compared);
      return;
    }
    animation_.ticks_run = record.tick + 1;
    animation_.time_s = time_s_;
    const bool same = root_hash(here_.simulation->state()) == record.root_hash;
    const bool is_known = !same && follow_recorded(record, input);
    add_match(record.tick, same ? TickMatch::same : is_known ? TickMatch::differs_known : TickMatch::differs);
    if (record.tick + 1 == options_.focus) answer_questions();
    if (!animation_.no_poses.empty()) return;
    read_frame(is_known);
    if (const auto place = find_non_finite(here_.simulation->state()))
      animation_.stopped = "the state at the end of tick " + std::to_string(record.tick) + " is not finite";
  }

  bool runs() const { return here_.simulation != nullptr && animation_.stopped.empty(); }

  bool accepts(std::uint64_t tick, const TickInput& input) {
    const Status accepted = here_.simulation->accept(input);
    if (accepted) return true;
    animation_.stopped =
        "tick " + std::to_string(tick) + ": recorded inputs are refused here: " + accepted.error().message;
    return false;
  }

  /// Whether the recorded state at the end of this tick is known.
  bool follow_recorded(const TickRecord& record, const TickInput& input) {
    differed_ = true;
    if (recorded_is_known_) {
      recorded_is_known_ = recorded_.simulation->accept(input) && recorded_.simulation->step(input, nullptr);
      if (recorded_is_known_) recorded_is_known_ = root_hash(recorded_.simulation->state()) == record.root_hash;
    }
    if (!recorded_is_known_ && record.image) begin_anew(record.image->joined(), record.root_hash);
    return recorded_is_known_;
  }

  void read_frame(bool recorded_is_known) {
    Frame frame = take_here();
    const std::uint64_t done = frame.ticks_done;
    if (has_too_many(frame)) return;
    if (recorded_is_known && recorded_.engine != nullptr) {
      Frame other = frame_reader_->read(*recorded_.engine, recorded_.angles, includes_frame(animation_, done));
      if (includes_frame(animation_, done)) {
        pose_count_ += other.poses.size();
        animation_.recorded.push_back(std::move(other));
      }
    }
    if (includes_frame(animation_, done)) add_frame(std::move(frame));
  }

  void add_frame(Frame frame) {
    pose_count_ += frame.poses.size();
    animation_.frames.push_back(std::move(frame));
    while (pose_count_ > options_.pose_count_max && halve_frames(animation_)) {
      pose_count_ = 0;
      for (const auto* frames : {&animation_.frames, &animation_.recorded})
        for (const Frame& kept : *frames) pose_count_ += kept.poses.size();
    }
  }

  /// Finds the bodies of the requested rows in the current state.
  void answer_questions() {
    if (frame_reader_ == nullptr) return;
    const StateView& state = here_.simulation->state();
    const auto add = [&](std::uint32_t id) {
      const auto index = frame_reader_->find(id);
      if (index && std::find(animation_.named.begin(), animation_.named.end(), *index) == animation_.named.end())
        animation_.named.push_back(*index);
    };
    frame_reader_->read(*here_.engine, here_.angles, false);
    for (const RowQuestion& question : options_.questions) {
      const auto table = state.schema->find_table(question.table);
      if (!table) continue;
      if (question.table == "bodies" && question.id) add(static_cast<std::uint32_t>(*question.id));
      for_each_reference(state, *table, question.row, add);
      for (const AnimatedBody& body : animation_.bodies)
        if (!question.name.empty() && body.name == question.name) add(body.id);
    }
  }

  void process_inputs(const TickRecord& record) {
    if (record.inputs.empty()) return;
    const std::string text = here_.simulation != nullptr ? here_.simulation->inputs_text(record.tick, record.inputs)
                                                         : listing_.text(record.tick, record.inputs);
    const std::vector<std::string> lines =
        verifier::split_lines(text.empty() ? listing_.text(record.tick, record.inputs) : text);
    animation_.input_ticks.push_back({record.tick, static_cast<std::uint32_t>(lines.size())});
    animation_.input_count += lines.size();
    const bool is_focus = record.tick + 1 == options_.focus;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!(is_focus && i < focus_lines_max) && input_text_size_ + lines[i].size() > options_.input_text_size_max)
        break;
      input_text_size_ += lines[i].size();
      animation_.input_lines.emplace_back(record.tick, lines[i]);
    }
  }

  void add_match(std::uint64_t tick, TickMatch match) { add_match(tick, tick, match); }
  void add_match(std::uint64_t first, std::uint64_t last, TickMatch match) {
    if (!animation_.match_ranges.empty() && animation_.match_ranges.back().match == match &&
        animation_.match_ranges.back().last + 1 == first)
      animation_.match_ranges.back().last = last;
    else
      animation_.match_ranges.push_back({first, last, match});
    animation_.tick_count = last + 1;
  }

  void end() {
    const replay::TraceTail& tail = reader_.tail();
    for (const replay::IntactRange& range : tail.intact_after) {
      if (range.first_tick > animation_.tick_count)
        add_match(animation_.tick_count, range.first_tick - 1, TickMatch::unread);
      if (range.first_tick >= animation_.tick_count)
        add_match(range.first_tick, range.last_tick, TickMatch::unread_intact);
    }
    const std::uint64_t recorded = reader_.tick_count_hint().value_or(0);
    if (recorded > animation_.tick_count) add_match(animation_.tick_count, recorded - 1, TickMatch::unread);
    if (frame_reader_ == nullptr || !animation_.no_poses.empty() || animation_.frames.empty()) return;
    // The last state is always a frame.
    if (animation_.frames.back().ticks_done != here_.engine->tick())
      animation_.frames.push_back(frame_reader_->read(*here_.engine, here_.angles, true));
    choose();
  }

  void choose() {
    const AnimatedRun start = make_run();
    if (start.engine == nullptr) return;
    const WorldBox view = choose_view(*start.engine, frame_reader_->visited());
    animation_.view = {{view.lower_x, view.lower_y}, {view.upper_x, view.upper_y}};
  }

  verifier::ReaderSource reader_;
  const AnimationOptions& options_;
  InputListing listing_;
  Animation animation_;
  AnimatedRun here_;
  AnimatedRun recorded_;
  bool differed_ = false;
  bool recorded_is_known_ = false;
  std::unique_ptr<FrameReader> frame_reader_;
  std::uint64_t ticks_read_ = 0;
  double time_s_ = 0;
  std::size_t pose_count_ = 0;
  std::size_t input_text_size_ = 0;
};

}  // namespace

Animation make_animation(replay::TraceReader& reader, const AnimationOptions& options) {
  return AnimationMaker(reader, options).run();
}

void mark_differing(Animation& animation, std::uint64_t tick) {
  const auto part = std::find_if(
      animation.match_ranges.begin(), animation.match_ranges.end(),
      [&](const MatchRange& one) { return one.first <= tick && tick <= one.last && one.match == TickMatch::same; });
  if (part == animation.match_ranges.end()) return;
  const MatchRange whole = *part;
  std::vector<MatchRange> parts;
  if (whole.first < tick) parts.push_back({whole.first, tick - 1, whole.match});
  parts.push_back({tick, tick, TickMatch::differs});
  if (tick < whole.last) parts.push_back({tick + 1, whole.last, whole.match});
  animation.match_ranges.insert(animation.match_ranges.erase(part), parts.begin(), parts.end());
}

bool includes_frame(const Animation& animation, std::uint64_t ticks_done) {
  const bool is_exact =
      ticks_done >= animation.exact_first && ticks_done <= animation.exact_last && animation.exact_last > 0;
  return is_exact || ticks_done % animation.stride == 0;
}

bool halve_frames(Animation& animation) {
  if (animation.frames.size() < 3) return false;
  constexpr std::uint64_t stride_of_few_frames = 64;
  animation.stride *= 2;
  if (animation.stride > stride_of_few_frames && animation.exact_last > animation.exact_first) {
    const std::uint64_t quarter = (animation.exact_last - animation.exact_first) / 4;
    animation.exact_first += quarter;
    animation.exact_last -= quarter;
    if (quarter == 0) animation.exact_first = animation.exact_last = 0;
  }
  const std::uint64_t last = animation.frames.back().ticks_done;
  for (std::vector<Frame>* frames : {&animation.frames, &animation.recorded})
    frames->erase(std::remove_if(frames->begin(), frames->end(),
                                 [&](const Frame& frame) {
                                   return frame.ticks_done != last && !includes_frame(animation, frame.ticks_done);
                                 }),
                  frames->end());
  return true;
}

}  // namespace ticktrue::tool
