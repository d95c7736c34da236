// Playing a trace from any tick to any other.
// SPDX-License-Identifier: MIT
#include "tool/play/player.h"

#include <algorithm>
#include <chrono>
#include <variant>

#include "base/float_behaviour.h"
#include "base/parallel/jobs.h"
#include "tool/session/playback.h"
#include "verifier/locate/schema_difference.h"
#include "verifier/verify/trace_source.h"
#include "verifier/verify/verify.h"

namespace ticktrue::play {
namespace {

constexpr std::size_t tick_count_max = 4u << 20;     // 19 hours at 60 Hz; 24 B each
constexpr std::size_t inputs_size_max = 256u << 20;  // bytes
constexpr std::size_t saved_size_max = 256u << 20;   // bytes
constexpr std::uint64_t saved_interval = 32;         // ticks between cached states, for playing backwards
constexpr std::uint64_t run_rather_than_seek = 64;   // ticks forward

}  // namespace

Result<std::unique_ptr<Player>> Player::open(const std::string& path) {
  if (const Status floats = check_float_behaviour(); !floats) return floats.error();
  auto reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole.error();
  const Result<engine::Scene> scene = tool::scene_of(reader->setup());
  if (!scene) return Error{scene.error().code, path + ": " + scene.error().message, scene.error().hint};
  auto engine = engine::make_engine(*scene);
  if (!engine) return Error{engine.error().code, path + ": " + engine.error().message, engine.error().hint};
  std::unique_ptr<Player> player(new Player());
  player->path_ = path;
  player->reader_.emplace(std::move(*reader));
  player->engine_ = std::move(*engine);
  encode_image(player->engine_->state(), player->first_state_);
  if (const Status status = player->read_all(); !status) return status.error();
  return player;
}

Status Player::read_all() {
  verifier::ReaderSource source(*reader_);
  while (true) {
    const replay::TraceReader::Item& item = source.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) checkpoints_.push_back(checkpoint->tick);
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (dt_.size() >= tick_count_max || inputs_.size() + record->inputs.size() > inputs_size_max)
      return Error{ErrorCode::limit, path_ + ": too long for play: found over " + std::to_string(dt_.size()) + " ticks",
                   "ticktrue replay and verify read it in bounded memory"};
    dt_.push_back(record->dt);
    hashes_.push_back(record->root_hash);
    input_begin_.push_back(inputs_.size());
    inputs_.insert(inputs_.end(), record->inputs.begin(), record->inputs.end());
  }
  tail_ = source.tail();
  match_.assign(dt_.size(), Match::unknown);
  if (dt_.empty())
    return Error{
        ErrorCode::truncated,
        path_ + ": " + (tail_.message.empty() ? "ends early" : tail_.message) + ": found no tick that is intact", ""};
  return {};
}

bool Player::load_checkpoint(std::uint64_t tick) {
  if (verifier::first_schema_difference(reader_->setup().schema, *engine_->state().schema, verifier::Ranges::inside) ||
      !reader_->seek(tick))
    return false;
  const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&reader_->next());
  if (checkpoint == nullptr || checkpoint->tick != tick || !engine_->load(checkpoint->image)) return false;
  position_ = tick;
  return true;
}

void Player::start_at_nearest(std::uint64_t target) {
  const bool is_ahead = target >= position_;
  if (is_ahead && target - position_ <= run_rather_than_seek) return;
  // The last cached state before the target, or a recorded checkpoint. Checkpoints after a difference belong to another
  // run.
  auto saved = saved_.upper_bound(target);
  const std::uint64_t saved_tick = saved == saved_.begin() ? 0 : std::prev(saved)->first;
  auto recorded = std::upper_bound(checkpoints_.begin(), checkpoints_.end(), target);
  std::uint64_t recorded_tick = 0;
  while (recorded != checkpoints_.begin() && recorded_tick == 0) {
    --recorded;
    if (!difference_ || *recorded <= *difference_) recorded_tick = *recorded;
  }
  if (is_ahead && position_ >= std::max(saved_tick, recorded_tick)) return;
  if (recorded_tick > saved_tick && load_checkpoint(recorded_tick)) return;
  const Bytes& image = saved_tick > 0 ? saved_.at(saved_tick) : first_state_;
  const Status loaded = engine_->load(image);
  TICKTRUE_ASSERT(loaded.has_value());  // it is an image of this engine's own state
  position_ = saved_tick;
}

void Player::save_state() {
  if (position_ % saved_interval != 0 || saved_.count(position_) != 0 || saved_size_ > saved_size_max) return;
  Bytes& image = saved_[position_];
  encode_image(engine_->state(), image);
  saved_size_ += image.size();
}

void Player::run_tick() {
  const TickInput input{dt_[position_], inputs(position_)};
  if (const Status accepted = engine_->accept(input); !accepted) {
    refused_ = "tick " + std::to_string(position_) + ": " + accepted.error().message;
    return;
  }
  const auto before = std::chrono::steady_clock::now();
  if (const Status did = engine_->step(input, nullptr); !did) {
    refused_ = did.error().message;
    return;
  }
  const double ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
  ms_per_tick_ = ms_per_tick_ == 0 ? ms : 0.9 * ms_per_tick_ + 0.1 * ms;
  const bool same = root_hash(engine_->state()) == hashes_[position_];
  match_[position_] = same ? Match::same : Match::different;
  if (!same && (!difference_ || position_ < *difference_)) {
    difference_ = position_;
    report_.reset();
    recorded_image_.reset();
  }
  ++position_;
  save_state();
}

void Player::go_to(std::uint64_t target, bool stop_at_difference, const std::function<bool()>& is_late) {
  target = std::min<std::uint64_t>(target, tick_count());
  if (target < position_) refused_.reset();
  start_at_nearest(target);
  while (position_ < target && !refused_) {
    const bool knew = difference_.has_value();
    run_tick();
    if (stop_at_difference && !knew && difference_) return;
    if (is_late()) return;
  }
}

bool Player::search(const std::function<bool()>& is_late) {
  while (!difference_ && !refused_) {
    while (known_ < tick_count() && match_[known_] != Match::unknown) ++known_;
    if (known_ == tick_count()) break;
    if (position_ > known_ || known_ - position_ > run_rather_than_seek) start_at_nearest(known_);
    run_tick();
    if (is_late()) return false;
  }
  return true;
}

const verifier::Report* Player::report() {
  if (!difference_) return nullptr;
  if (report_) return &*report_;
  auto reader = replay::TraceReader::open(path_);
  if (!reader) return nullptr;
  verifier::VerifyOptions options;
  options.simulation = &engine::engine_info();
  options.from = *difference_;
  options.to = *difference_;
  options.spread_ticks = 0;
  options.search_single_bit = true;
  options.thread_count = core_count();
  report_ = verifier::verify(*reader, options);
  reader->seek(*difference_);
  while (true) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr || record->tick < *difference_) continue;
    if (record->tick == *difference_ && record->image) recorded_image_ = record->image->joined();
    break;
  }
  return &*report_;
}

const Bytes* Player::recorded_image() {
  return report() != nullptr && recorded_image_ ? &*recorded_image_ : nullptr;
}

std::vector<std::uint32_t> Player::named_bodies() {
  std::vector<std::uint32_t> ids;
  const verifier::Report* found = report();
  if (found == nullptr || !found->divergence) return ids;
  const auto add = [&ids](const std::string& table, const std::optional<std::uint64_t>& id) {
    if (table == "bodies" && id) ids.push_back(static_cast<std::uint32_t>(*id));
  };
  for (const verifier::LaneReport& row : found->divergence->rows) add(row.table, row.id);
  for (const verifier::Candidate& row : found->divergence->candidates) add(row.table, row.id);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace ticktrue::play
