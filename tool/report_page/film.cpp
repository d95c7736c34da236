// Filming: one walk over the records, one simulation that goes on, one that begins anew where states are stored.
// SPDX-License-Identifier: MIT
#include "tool/report_page/film.h"

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

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TickRecord;

constexpr std::uint64_t exact_before = 90, exact_after = 180;  // ticks around the focus
constexpr std::size_t focus_lines_max = 200;                   // input lines of the focus that are always listed

/// Reads the bodies of an engine's states and keeps what does not change from frame to frame.
class Camera {
 public:
  Camera(const engine::Engine& engine, Film& film)
      : drawing_(engine.scene(), *engine.state().schema), film_(film), pi_(engine::pi) {
    film_.figures = drawing_.figures();
  }

  /// Looks at the state of every tick: angles (of the tick before) go on without jumps, and the view covers where
  /// bodies went.
  FilmFrame take(const engine::Engine& engine, std::vector<double>& angles, bool with_sums) {
    FilmFrame frame;
    frame.ticks_done = engine.tick();
    frame.time_s = engine.time_s();
    drawing_.read(engine.state(), drawn_);
    frame.poses.reserve(drawn_.size());
    const engine::Point gravity = drawing_.gravity(engine.state());
    for (const DrawnBody& body : drawn_) {
      const Figure& figure = film_.figures[body.figure];
      if (!body.is_finite) continue;
      const std::uint32_t index = index_of(body);
      if (angles.size() <= index) angles.resize(film_.bodies.size(), 0);
      angles[index] = next_angle(angles[index], engine::arc_tangent(body.sin, body.cos));
      frame.poses.push_back({index, body.center.x, body.center.y, angles[index]});
      if (figure.type != engine::BodyType::static_body) {
        visited_.add(body.center.x - figure.reach, body.center.y - figure.reach);
        visited_.add(body.center.x + figure.reach, body.center.y + figure.reach);
      }
      add_sums(body, figure, gravity, frame.sums);
    }
    if (with_sums) look_at_contacts(engine, frame.sums);
    return frame;
  }

  const WorldBox& visited() const { return visited_; }
  std::optional<std::uint32_t> find(std::uint32_t id) const {
    const auto found = index_of_id_.find(id);
    return found == index_of_id_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::uint32_t index_of(const DrawnBody& body) {
    const auto [at, is_new] = index_of_id_.try_emplace(body.id, static_cast<std::uint32_t>(film_.bodies.size()));
    if (is_new) film_.bodies.push_back({body.id, body.figure, drawing_.name(body)});
    return at->second;
  }

  double next_angle(double before, double angle) const {
    const double turns = std::floor((before - angle) / (2 * pi_) + 0.5);
    return angle + turns * 2 * pi_;
  }

  static void add_sums(const DrawnBody& body, const Figure& figure, const engine::Point& gravity, FilmSums& sums) {
    const engine::Point& v = body.velocity;
    const double mass = figure.mass;
    sums.kinetic +=
        (mass * (v.x * v.x + v.y * v.y) + figure.inertia * body.angular_velocity * body.angular_velocity) / 2;
    sums.potential -= mass * figure.gravity_scale * (gravity.x * body.center.x + gravity.y * body.center.y);
    sums.momentum_x += mass * v.x;
    sums.momentum_y += mass * v.y;
  }

  static void look_at_contacts(const engine::Engine& engine, FilmSums& sums) {
    for (const engine::ContactReport& contact : engine.contacts()) {
      ++sums.contact_count;
      for (int i = 0; i < contact.point_count; ++i)
        if (-contact.separation[i] > sums.penetration) sums.penetration = -contact.separation[i];
    }
  }

  Drawing drawing_;
  Film& film_;
  double pi_;
  std::vector<DrawnBody> drawn_;
  std::map<std::uint32_t, std::uint32_t> index_of_id_;
  WorldBox visited_;
};

/// A simulation of the trace's setup; `engine` where it is one of ours.
struct FilmedRun {
  std::unique_ptr<Simulation> simulation;
  const engine::Engine* engine = nullptr;
  std::vector<double> angles;  // [body], of the state before
};

std::uint32_t read_u32(const std::uint8_t* at) {
  std::uint32_t value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// Calls `each` with the ids of the owners a row belongs to.
template <typename Each>
void for_each_reference(const StateView& state, std::size_t table, std::size_t row, Each each) {
  const TableSchema& schema = state.schema->tables[table];
  if (row >= state.tables[table].row_count) return;
  const std::uint8_t* data = state.tables[table].data + row * schema.row_size;
  for (const Column& column : schema.columns)
    if (column.target >= 0 && column.type == ScalarType::u32 && read_u32(data + column.offset) != no_reference)
      each(read_u32(data + column.offset));
}

class Filming {
 public:
  Filming(replay::TraceReader& reader, const FilmOptions& options)
      : reader_(reader), options_(options), listing_(reader.setup()) {}

  Film run() {
    begin();
    reader_.rewind();
    for (;;) {
      const replay::TraceReader::Item& item = reader_.next();
      if (std::holds_alternative<std::monostate>(item)) break;
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item))
        see(*checkpoint);
      else
        see(std::get<TickRecord>(item));
    }
    end();
    return std::move(film_);
  }

 private:
  void begin() {
    const std::uint64_t focus = options_.focus.value_or(0);
    if (options_.focus) {
      film_.exact_first = focus > exact_before ? focus - exact_before : 0;
      film_.exact_last = focus + exact_after;
    }
    here_ = make_run();
    if (here_.simulation == nullptr) return;
    if (here_.engine == nullptr) {
      film_.no_poses = "This build simulates " + reader_.setup().simulation +
                       ", but does not know what its columns look like: there is nothing to draw.";
      return;
    }
    camera_ = std::make_unique<Camera>(*here_.engine, film_);
    FilmFrame first = take_here();
    if (has_too_many(first)) return;
    keep_frame(std::move(first));
    if (options_.focus == std::uint64_t{0}) answer();
  }

  bool has_too_many(const FilmFrame& frame) {
    if (frame.poses.size() <= options_.body_count_max) return false;
    film_.no_poses = "There are " + std::to_string(frame.poses.size()) + " bodies; a page draws at most " +
                     std::to_string(options_.body_count_max) + ".";
    film_.frames.clear();
    film_.recorded.clear();
    return true;
  }

  FilmedRun make_run() {
    FilmedRun run;
    const SimulationInfo* info = options_.simulation;
    if (info == nullptr) {
      film_.no_poses = "This build has no simulation " + reader_.setup().simulation + ": nothing was run again.";
      return run;
    }
    auto made = info->make(reader_.setup().setup);
    if (!made) {
      film_.no_poses = "This build does not accept the setup of the trace: " + made.error().message + ".";
      return run;
    }
    run.simulation = std::move(*made);
    run.engine = dynamic_cast<const engine::Engine*>(run.simulation.get());
    return run;
  }

  FilmFrame take_here() {
    const std::uint64_t done = here_.engine->tick();
    return camera_->take(*here_.engine, here_.angles, keeps_frame(film_, done));
  }

  void see(const CheckpointRecord& checkpoint) {
    film_.checkpoints.push_back(checkpoint.tick);
    if (differed_) begin_anew(checkpoint.image, checkpoint.root_hash);
  }

  /// The recorded run goes on from a state that is stored.
  void begin_anew(ByteView image, std::uint64_t root) {
    recorded_is_known_ = false;
    if (recorded_.simulation == nullptr) recorded_ = make_run();
    if (recorded_.simulation == nullptr || !recorded_.simulation->load(image)) return;
    if (root_hash(recorded_.simulation->state()) != root) return;
    recorded_is_known_ = true;
    // Angles go on from where this build's run has them.
    if (recorded_.engine != nullptr) recorded_.angles = here_.angles;
  }

  void see(const TickRecord& record) {
    see_inputs(record);
    if (options_.progress) options_.progress(record.tick + 1);
    ++ticks_read_;
    time_s_ += record.dt;
    const TickInput input{record.dt, record.inputs};
    if (!runs() || !accepts(record.tick, input)) {
      add_to_strip(record.tick, TickMatch::not_compared);
      return;
    }
    if (const Status did = here_.simulation->step(input, nullptr); !did) {
      film_.stopped = did.error().message;
      add_to_strip(record.tick, TickMatch::not_compared);
      return;
    }
    film_.ticks_run = record.tick + 1;
    film_.time_s = time_s_;
    const bool same = root_hash(here_.simulation->state()) == record.root_hash;
    const bool is_known = !same && follow_recorded(record, input);
    add_to_strip(record.tick, same ? TickMatch::same : is_known ? TickMatch::differs_known : TickMatch::differs);
    if (record.tick + 1 == options_.focus) answer();
    if (!film_.no_poses.empty()) return;
    look(is_known);
    if (const auto place = find_non_finite(here_.simulation->state()))
      film_.stopped = "the state at the end of tick " + std::to_string(record.tick) + " is not finite";
  }

  bool runs() const { return here_.simulation != nullptr && film_.stopped.empty(); }

  bool accepts(std::uint64_t tick, const TickInput& input) {
    const Status accepted = here_.simulation->accept(input);
    if (accepted) return true;
    film_.stopped = "tick " + std::to_string(tick) + ": recorded inputs are refused here: " + accepted.error().message;
    return false;
  }

  /// Whether the recorded state at the end of this tick is known.
  bool follow_recorded(const TickRecord& record, const TickInput& input) {
    differed_ = true;
    if (recorded_is_known_) {
      recorded_is_known_ = recorded_.simulation->accept(input) && recorded_.simulation->step(input, nullptr);
      if (recorded_is_known_) recorded_is_known_ = root_hash(recorded_.simulation->state()) == record.root_hash;
    }
    if (!recorded_is_known_ && record.image) begin_anew(*record.image, record.root_hash);
    return recorded_is_known_;
  }

  void look(bool recorded_is_known) {
    FilmFrame frame = take_here();
    const std::uint64_t done = frame.ticks_done;
    if (has_too_many(frame)) return;
    if (recorded_is_known && recorded_.engine != nullptr) {
      FilmFrame other = camera_->take(*recorded_.engine, recorded_.angles, keeps_frame(film_, done));
      if (keeps_frame(film_, done)) {
        pose_count_ += other.poses.size();
        film_.recorded.push_back(std::move(other));
      }
    }
    if (keeps_frame(film_, done)) keep_frame(std::move(frame));
  }

  void keep_frame(FilmFrame frame) {
    pose_count_ += frame.poses.size();
    film_.frames.push_back(std::move(frame));
    while (pose_count_ > options_.pose_count_max && thin_out(film_)) {
      pose_count_ = 0;
      for (const auto* frames : {&film_.frames, &film_.recorded})
        for (const FilmFrame& kept : *frames) pose_count_ += kept.poses.size();
    }
  }

  /// Finds the bodies that rows of the present state belong to.
  void answer() {
    if (camera_ == nullptr) return;
    const StateView& state = here_.simulation->state();
    const auto add = [&](std::uint32_t id) {
      const auto index = camera_->find(id);
      if (index && std::find(film_.named.begin(), film_.named.end(), *index) == film_.named.end())
        film_.named.push_back(*index);
    };
    camera_->take(*here_.engine, here_.angles, false);
    for (const RowQuestion& question : options_.questions) {
      const auto table = state.schema->find_table(question.table);
      if (!table) continue;
      if (question.table == "bodies" && question.id) add(static_cast<std::uint32_t>(*question.id));
      for_each_reference(state, *table, question.row, add);
      for (const FilmBody& body : film_.bodies)
        if (!question.name.empty() && body.name == question.name) add(body.id);
    }
  }

  void see_inputs(const TickRecord& record) {
    if (record.inputs.empty()) return;
    const std::string text = here_.simulation != nullptr ? here_.simulation->inputs_text(record.tick, record.inputs)
                                                         : listing_.text(record.tick, record.inputs);
    const std::vector<std::string> lines = split_lines(text.empty() ? listing_.text(record.tick, record.inputs) : text);
    film_.input_ticks.push_back({record.tick, static_cast<std::uint32_t>(lines.size())});
    film_.input_count += lines.size();
    const bool is_focus = record.tick + 1 == options_.focus;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!(is_focus && i < focus_lines_max) && input_text_size_ + lines[i].size() > options_.input_text_size_max)
        break;
      input_text_size_ += lines[i].size();
      film_.input_lines.emplace_back(record.tick, lines[i]);
    }
  }

  void add_to_strip(std::uint64_t tick, TickMatch match) { add_to_strip(tick, tick, match); }
  void add_to_strip(std::uint64_t first, std::uint64_t last, TickMatch match) {
    if (!film_.strip.empty() && film_.strip.back().match == match && film_.strip.back().last + 1 == first)
      film_.strip.back().last = last;
    else
      film_.strip.push_back({first, last, match});
    film_.tick_count = last + 1;
  }

  void end() {
    const replay::TraceTail& tail = reader_.tail();
    for (const replay::IntactRange& range : tail.intact_after) {
      if (range.first_tick > film_.tick_count) add_to_strip(film_.tick_count, range.first_tick - 1, TickMatch::unread);
      if (range.first_tick >= film_.tick_count)
        add_to_strip(range.first_tick, range.last_tick, TickMatch::unread_intact);
    }
    const std::uint64_t recorded = reader_.tick_count_hint().value_or(0);
    if (recorded > film_.tick_count) add_to_strip(film_.tick_count, recorded - 1, TickMatch::unread);
    if (camera_ == nullptr || !film_.no_poses.empty() || film_.frames.empty()) return;
    // The last state is always there.
    if (film_.frames.back().ticks_done != here_.engine->tick())
      film_.frames.push_back(camera_->take(*here_.engine, here_.angles, true));
    choose();
  }

  void choose() {
    const FilmedRun start = make_run();
    if (start.engine == nullptr) return;
    const WorldBox view = choose_view(*start.engine, camera_->visited());
    film_.view = {{view.lower_x, view.lower_y}, {view.upper_x, view.upper_y}};
  }

  replay::TraceReader& reader_;
  const FilmOptions& options_;
  InputListing listing_;
  Film film_;
  FilmedRun here_;
  FilmedRun recorded_;
  bool differed_ = false;
  bool recorded_is_known_ = false;
  std::unique_ptr<Camera> camera_;
  std::uint64_t ticks_read_ = 0;
  double time_s_ = 0;
  std::size_t pose_count_ = 0;
  std::size_t input_text_size_ = 0;
};

}  // namespace

Film make_film(replay::TraceReader& reader, const FilmOptions& options) {
  return Filming(reader, options).run();
}

void mark_differing(Film& film, std::uint64_t tick) {
  const auto part = std::find_if(film.strip.begin(), film.strip.end(), [&](const StripPart& one) {
    return one.first <= tick && tick <= one.last && one.match == TickMatch::same;
  });
  if (part == film.strip.end()) return;
  const StripPart whole = *part;
  std::vector<StripPart> parts;
  if (whole.first < tick) parts.push_back({whole.first, tick - 1, whole.match});
  parts.push_back({tick, tick, TickMatch::differs});
  if (tick < whole.last) parts.push_back({tick + 1, whole.last, whole.match});
  film.strip.insert(film.strip.erase(part), parts.begin(), parts.end());
}

bool keeps_frame(const Film& film, std::uint64_t ticks_done) {
  const bool is_exact = ticks_done >= film.exact_first && ticks_done <= film.exact_last && film.exact_last > 0;
  return is_exact || ticks_done % film.stride == 0;
}

bool thin_out(Film& film) {
  if (film.frames.size() < 3) return false;
  constexpr std::uint64_t stride_of_few_frames = 64;
  film.stride *= 2;
  if (film.stride > stride_of_few_frames && film.exact_last > film.exact_first) {
    const std::uint64_t quarter = (film.exact_last - film.exact_first) / 4;
    film.exact_first += quarter;
    film.exact_last -= quarter;
    if (quarter == 0) film.exact_first = film.exact_last = 0;
  }
  const std::uint64_t last = film.frames.back().ticks_done;
  for (std::vector<FilmFrame>* frames : {&film.frames, &film.recorded})
    frames->erase(std::remove_if(frames->begin(), frames->end(),
                                 [&](const FilmFrame& frame) {
                                   return frame.ticks_done != last && !keeps_frame(film, frame.ticks_done);
                                 }),
                  frames->end());
  return true;
}

}  // namespace ticktrue::verifier
