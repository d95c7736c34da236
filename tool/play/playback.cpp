// Keys, timeline and time of a trace that plays.
// SPDX-License-Identifier: MIT
#include "tool/play/playback.h"

#include <algorithm>
#include <cmath>

namespace ticktrue::play {
namespace {

constexpr double speed_max = 16;
constexpr double jump_s = 1;  // of an arrow key, simulated

}  // namespace

Timeline Timeline::of(const View& view) {
  return {24, std::max(40.0, view.width - 24.0), view.height - 44.0, view.height - 26.0};
}

bool Timeline::contains(const Pixel& pixel) const {
  return pixel.x >= left - 8 && pixel.x <= right + 8 && pixel.y >= top - 12 && pixel.y <= bottom + 12;
}

double Timeline::x_of(std::uint64_t position, std::uint64_t tick_count) const {
  return left + (right - left) * static_cast<double>(position) / static_cast<double>(tick_count);
}

std::uint64_t Timeline::position_at(double x, std::uint64_t tick_count) const {
  const double share = std::clamp((x - left) / (right - left), 0.0, 1.0);
  return static_cast<std::uint64_t>(share * static_cast<double>(tick_count) + 0.5);
}

Playback::Playback(Player& player, Player* other, const View& view, const LayerSet& layers)
    : player_(player), other_(other), view_(view), layers_(layers), target_(player.position()) {}

void Playback::seek(std::uint64_t position) {
  target_ = std::min(position, player_.tick_count());
  due_s_ = 0;
  searching_ = false;
}

void Playback::let_time_pass(double seconds) {
  if (!playing_) return;
  due_s_ += seconds * speed_;
  while (target_ < player_.tick_count() && due_s_ >= player_.dt(target_)) due_s_ -= player_.dt(target_++);
  if (target_ == player_.tick_count()) playing_ = false;
}

void Playback::take(const HostFrame& frame, const std::function<bool()>& is_late) {
  for (const Event& event : frame.events) handle(event);
  if (!is_seeking()) let_time_pass(frame.seconds);
  const bool knew = player_.difference().has_value();
  if (searching_) {
    searching_ = !player_.search(is_late);
    target_ = player_.position();
  } else if (is_seeking())
    player_.go_to(target_, true, is_late);
  if (player_.refused() || (!knew && player_.difference())) {
    target_ = player_.position();
    playing_ = false;
  }
  if (other_ != nullptr) other_->go_to(player_.position(), false, is_late);
}

std::uint64_t Playback::checkpoint_beside(bool later) const {
  const std::vector<std::uint64_t>& list = player_.checkpoints();
  if (later) {
    const auto found = std::upper_bound(list.begin(), list.end(), target_);
    return found == list.end() ? player_.tick_count() : *found;
  }
  const auto found = std::lower_bound(list.begin(), list.end(), target_);
  return found == list.begin() ? 0 : *std::prev(found);
}

void Playback::handle(const Event& event) {
  const Pixel at{event.x, event.y};
  const Timeline timeline = Timeline::of(view_);
  switch (event.kind) {
    case EventKind::press:
      on_timeline_ = timeline.contains(at);
      if (on_timeline_) {
        playing_ = false;
        seek(timeline.position_at(at.x, player_.tick_count()));
      } else {
        pan_ = at;
      }
      return;
    case EventKind::release:
      on_timeline_ = false;
      pan_.reset();
      return;
    case EventKind::move:
      if (on_timeline_) seek(timeline.position_at(at.x, player_.tick_count()));
      if (pan_) {
        view_.pan(at.x - pan_->x, at.y - pan_->y);
        pan_ = at;
      }
      return;
    case EventKind::wheel:
      return view_.zoom(at, std::pow(zoom_step, event.steps));
    case EventKind::key:
      return handle_key(event.key);
    case EventKind::resize:
      view_.width = static_cast<int>(event.x);
      view_.height = static_cast<int>(event.y);
      return;
    case EventKind::quit:
      quit_ = true;
      return;
  }
}

void Playback::handle_key(const std::string& key) {
  if (layers_.toggle_key(key)) return;
  const auto jump = static_cast<std::uint64_t>(std::max(1.0, std::round(jump_s / player_.setup().dt)));
  const auto step_to = [this](std::uint64_t position) {
    playing_ = false;
    seek(position);
  };
  if (key == "space") {
    if (!playing_ && target_ == player_.tick_count()) seek(0);
    playing_ = !playing_;
  }
  if (key == ".") step_to(target_ + 1);
  if (key == ",") step_to(target_ > 0 ? target_ - 1 : 0);
  if (key == "right") step_to(target_ + jump);
  if (key == "left") step_to(target_ > jump ? target_ - jump : 0);
  if (key == "page down") step_to(checkpoint_beside(true));
  if (key == "page up") step_to(checkpoint_beside(false));
  if (key == "home" || key == "r") step_to(0);
  if (key == "end") step_to(player_.tick_count());
  if (key == "d") {
    playing_ = false;
    searching_ = !player_.difference();
    if (player_.difference()) seek(*player_.difference() + 1);
  }
  if (key == "g") ghosts_ = !ghosts_;
  if (key == "]") speed_ = std::min(speed_ * 2, speed_max);
  if (key == "[") speed_ = std::max(speed_ / 2, 1 / speed_max);
  if (key == "h") help_ = !help_;
  if (key == "q" || key == "escape") quit_ = true;
  const Pixel middle{view_.width / 2.0, view_.height / 2.0};
  if (key == "+" || key == "=") view_.zoom(middle, zoom_step);
  if (key == "-") view_.zoom(middle, 1 / zoom_step);
  if (key == "f") view_ = first_view(player_.engine(), view_.width, view_.height);
}

}  // namespace ticktrue::play
