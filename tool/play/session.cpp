// Events, frames and clocks become ticks with inputs.
// SPDX-License-Identifier: MIT
#include "tool/play/session.h"

#include <algorithm>
#include <cmath>

#include "base/limits.h"

namespace ticktrue::play {
namespace {

using engine::Input;
using engine::InputKind;
using engine::Point;

constexpr double pan_begins_px = 4;  // a middle button that moved further pans
constexpr double pan_step = 0.1;     // of the picture, for an arrow key

double square_to_segment(const Point& p, const Point& a, const Point& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double square = dx * dx + dy * dy;
  const double share = square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  const double x = p.x - a.x - share * dx, y = p.y - a.y - share * dy;
  return x * x + y * y;
}

/// `point` in the body's frame.
bool contains(const tool::Outline& outline, const Point& point) {
  if (outline.is_line || outline.is_sensor || outline.points.empty()) return false;
  bool inside = outline.points.size() >= 3;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Point& a = outline.points[i];
    const Point& b = outline.points[(i + 1) % outline.points.size()];
    if ((b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x) < 0) inside = false;
    if (square_to_segment(point, a, b) <= outline.radius * outline.radius) return true;
  }
  return inside;
}

}  // namespace

std::size_t body_at(const tool::Drawing& drawing, const std::vector<tool::DrawnBody>& bodies, const Point& point) {
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const tool::DrawnBody& body = bodies[i];
    const tool::Figure& figure = drawing.figures()[body.figure];
    const double dx = point.x - body.center.x, dy = point.y - body.center.y;
    if (!body.is_finite || !(dx * dx + dy * dy <= figure.extent * figure.extent)) continue;
    const Point local{figure.center.x + body.cos * dx + body.sin * dy, figure.center.y - body.sin * dx + body.cos * dy};
    for (const tool::Outline& outline : figure.outlines)
      if (contains(outline, local)) return i;
  }
  return bodies.size();
}

Session::Session(engine::Engine& engine, const PlayScene& playable, const View& view, const LayerSet& layers,
                 NextFrame next_frame)
    : engine_(engine),
      playable_(playable),
      drawing_(playable.scene, *engine.state().schema),
      next_frame_(std::move(next_frame)),
      view_(view),
      clock_(playable.scene.settings.clock, playable.scene.settings.dt),
      layers_(layers) {
  if (playable.scene.settings.clock.kind == engine::ClockKind::adaptive) control_.emplace(engine);
}

Result<std::optional<double>> Session::next_dt() {
  double wanted_s = 0;
  if (control_ && clock_.due_s() >= limits::dt_min_s) {
    const Result<double> chosen = control_->choose(engine_, clock_.due_s(), clock_.report);
    if (!chosen) return chosen.error();
    wanted_s = *chosen;
  }
  return clock_.next_tick(wanted_s);
}

Result<std::optional<TickInput>> Session::next(std::uint64_t tick) {
  while (true) {
    const Result<std::optional<double>> dt = next_dt();
    if (!dt) return dt.error();
    if (*dt) {
      make_inputs(tick);
      return std::optional<TickInput>(TickInput{**dt, bytes_});
    }
    if (request_ != Request::none) return std::optional<TickInput>();
    const Result<HostFrame> frame = next_frame_(*this);
    if (!frame) return frame.error();
    take(*frame);
  }
}

void Session::pass(double seconds) {
  if (paused_ || request_ != Request::none) return;
  time_s_ += seconds;
  frame_s_ += seconds;
}

void Session::take(const HostFrame& frame) {
  frame_s_ = 0;
  double at = 0;
  for (const Event& event : frame.events) {
    const double until = std::clamp(event.at_s, at, std::max(at, frame.seconds));
    pass(until - at);
    at = until;
    handle(event);
  }
  pass(std::max(0.0, frame.seconds - at));
  if (frame_s_ > 0) clock_.add_frame(frame_s_);
}

void Session::handle(const Event& event) {
  switch (event.kind) {
    case EventKind::press:
      return handle_press(event);
    case EventKind::release:
      return handle_release(event);
    case EventKind::move:
      return handle_move(event);
    case EventKind::wheel:
      return view_.zoom({event.x, event.y}, std::pow(zoom_step, event.steps));
    case EventKind::key:
      return handle_key(event.key);
    case EventKind::resize:
      view_.width = static_cast<int>(event.x);
      view_.height = static_cast<int>(event.y);
      return;
    case EventKind::quit:
      request_ = Request::quit;
      return;
  }
}

void Session::add(Action action, Piece piece, const Event& event) {
  if (playable_.can_touch) pending_.push_back({time_s_, action, piece, event.ctrl, view_.to_world({event.x, event.y})});
}

void Session::handle_press(const Event& event) {
  pointer_ = {event.x, event.y};
  switch (event.button) {
    case Button::left:
      left_down_ = true;
      return add(event.ctrl ? Action::spawn : Action::press, Piece::circle, event);
    case Button::right:
      return add(Action::spawn, Piece::box, event);
    case Button::middle:
      middle_down_ = pointer_;
      panning_ = false;
      return;
  }
}

void Session::handle_release(const Event& event) {
  if (event.button == Button::left && left_down_) {
    left_down_ = false;
    add(Action::release, Piece::circle, event);
  }
  if (event.button == Button::middle && middle_down_) {
    if (!panning_) add(Action::spawn, Piece::polygon, event);
    middle_down_.reset();
  }
}

void Session::handle_move(const Event& event) {
  if (middle_down_ && std::hypot(event.x - middle_down_->x, event.y - middle_down_->y) > pan_begins_px) panning_ = true;
  if (middle_down_ && panning_) view_.pan(event.x - pointer_.x, event.y - pointer_.y);
  pointer_ = {event.x, event.y};
  if (left_down_) add(Action::drag, Piece::circle, event);
}

void Session::handle_key(const std::string& key) {
  if (layers_.toggle_key(key)) return;
  if (key == "space") paused_ = !paused_;
  if (key == "." && request_ == Request::none) {
    paused_ = true;
    time_s_ += playable_.scene.settings.dt;
    frame_s_ += playable_.scene.settings.dt;
  }
  if (key == "h") help_ = !help_;
  if (key == "r") request_ = Request::restart;
  if (key == "q" || key == "escape") request_ = Request::quit;
  if (key.size() == 1 && key[0] >= '1' && key[0] <= '9') {
    request_ = Request::scene;
    requested_scene_ = key[0] - '0';
  }
  if (key == "left") view_.pan(pan_step * view_.width, 0);
  if (key == "right") view_.pan(-pan_step * view_.width, 0);
  if (key == "up") view_.pan(0, pan_step * view_.height);
  if (key == "down") view_.pan(0, -pan_step * view_.height);
  const Pixel middle{view_.width / 2.0, view_.height / 2.0};
  if (key == "+" || key == "=") view_.zoom(middle, zoom_step);
  if (key == "-") view_.zoom(middle, 1 / zoom_step);
  if (key == "home") view_ = first_view(engine_, view_.width, view_.height);
}

void Session::make_inputs(std::uint64_t tick) {
  const bool is_fixed = playable_.scene.settings.clock.kind == engine::ClockKind::fixed;
  const double end_s = static_cast<double>(tick + 1) * playable_.scene.settings.dt;
  std::size_t count = 0;
  while (count < pending_.size() && (!is_fixed || pending_[count].time_s < end_s)) ++count;
  inputs_.clear();
  bytes_.clear();
  if (count == 0) return;
  drawing_.read(engine_.state(), bodies_);
  for (std::size_t i = 0; i < count; ++i) make_input(pending_[i]);
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(count));
  engine::encode_inputs(inputs_, bytes_);
  input_count_ += inputs_.size();
}

void Session::make_input(const Pending& pending) {
  const auto piece = static_cast<std::size_t>(pending.piece);
  if (!(std::abs(pending.at.x) <= limits::coordinate_max_m && std::abs(pending.at.y) <= limits::coordinate_max_m))
    return;
  if (pending.action == Action::drag && pull_) {
    pull_ = pending.at;
    add_input(InputKind::drag, 0, &pending.at);
  }
  if (pending.action == Action::release && pull_) {
    pull_.reset();
    add_input(InputKind::release, 0, nullptr);
  }
  if (pending.action != Action::press && pending.action != Action::spawn) return;
  const std::size_t hit = body_at(drawing_, bodies_, pending.at);
  if (hit == bodies_.size()) {
    add_input(InputKind::spawn, (pending.is_static ? playable_.fixed : playable_.moving)[piece], &pending.at);
  } else if (pending.action == Action::press &&
             drawing_.figures()[bodies_[hit].figure].type == engine::BodyType::dynamic_body) {
    pull_ = pending.at;
    add_input(InputKind::press, 0, &pending.at);
  }
}

void Session::add_input(InputKind kind, std::uint16_t prototype, const Point* at) {
  // Of several moves in one tick the last counts.
  const bool replaces = kind == InputKind::drag && !inputs_.empty() && inputs_.back().kind == InputKind::drag;
  if (!replaces) {
    if (inputs_.size() >= limits::inputs_per_tick_max) return;
    inputs_.emplace_back();
    inputs_.back().sequence = static_cast<std::uint32_t>(inputs_.size() - 1);
  }
  Input& input = inputs_.back();
  input.kind = kind;
  input.prototype = prototype;
  if (at != nullptr) {
    input.values[0] = at->x;
    input.values[1] = at->y;
  }
}

}  // namespace ticktrue::play
