// The part of a session about other players: roots, hello, location of a desync, and their lines in the report.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "base/hash.h"
#include "base/plain_text.h"
#include "capi/call_values.h"
#include "capi/peers/bundle.h"
#include "capi/session.h"
#include "replay/box/recover_box.h"
#include "replay/file/file_calls.h"
#include "verifier/report/exit_codes.h"

namespace ticktrue::capi {
namespace {

std::string joined_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + plain_line(line);
  return text;
}

ByteView view_of(const void* bytes, std::size_t size) {
  return {static_cast<const std::uint8_t*>(bytes), bytes == nullptr ? 0 : size};
}

/// Writes the part of the text that fits, with the final zero.
void put_text(const std::string& from, char* text, std::size_t text_size) {
  if (text == nullptr || text_size == 0) return;
  const std::size_t size = std::min(from.size(), text_size - 1);
  std::memcpy(text, from.data(), size);
  text[size] = 0;
}

}  // namespace

void Session::take_live_tick(const DoneTick& done) {
  live_root_ = done.root_hash;
  live_time_s_ += done.dt;
  if (!comparing_) changes_.add(*done.state, table_hashes_);
  peers_->add(done.tick, done.root_hash, done.dt, done.inputs, *done.state);
}

/// Fixes the columns: other players receive them from now on.
bool Session::know_game() {
  if (peers_->has_game()) return true;
  if (!state_.is_frozen())
    if (const Status status = state_.freeze(); !status) return fail(status.error()), false;
  peers_->set_game(game_setup(), facts_.all());
  peers_->keep_states();
  return true;
}

replay::TraceSetup Session::game_setup() const {
  replay::TraceSetup game;
  game.simulation = identity_.name;
  game.physics_version = identity_.version;
  game.dt = default_dt_;
  game.schema = state_.schema();
  game.setup.assign(setup().begin(), setup().end());
  return game;
}

int Session::refuse(const Error& error) {
  refusal_ = plain_line(error.message);
  if (!error.hint.empty()) refusal_ += "\n  " + plain_line(error.hint);
  return TICKTRUE_REFUSED;
}

bool Session::can_call_peers(const char* what, std::uint32_t peer) {
  if (!can_call(what) || refuse_in_callback(what)) return false;
  if (peer > player_max || peer == peers_->player()) {
    wrong_order(std::string(what) + ": player: found " + std::to_string(peer) +
                    ", expected another one than this, which is " + std::to_string(peers_->player()) +
                    ", and at most " + std::to_string(player_max),
                "`player` of the options is this player's own number");
    return false;
  }
  return know_game();
}

int Session::root(std::uint64_t tick, std::uint64_t* root) {
  if (status_ == TICKTRUE_FAILED || refuse_in_callback("root")) return status_;
  if (root == nullptr) return wrong_order("root: found null, expected where to write it", "");
  const auto found = peers_->roots().at(tick);
  if (!found) return TICKTRUE_END;
  *root = *found;
  return TICKTRUE_OK;
}

std::size_t Session::hello(void* buffer, std::size_t size) {
  if (!can_call("hello") || refuse_in_callback("hello") || !know_game()) return 0;
  const Bytes bytes = peers_->hello();
  if (buffer != nullptr && bytes.size() <= size) std::memcpy(buffer, bytes.data(), bytes.size());
  return bytes.size();
}

int Session::hello_check(std::uint32_t peer, const void* bytes, std::size_t size, char* text, std::size_t text_size) {
  put_text("", text, text_size);
  if (!can_call_peers("hello_check", peer)) return status_;
  const Result<HelloDifferences> found = peers_->take_hello(peer, view_of(bytes, size));
  if (!found) {
    put_text(plain_line(found.error().message), text, text_size);
    return TICKTRUE_REFUSED;
  }
  std::vector<std::string> lines = found->refusals;
  lines.insert(lines.end(), found->warnings.begin(), found->warnings.end());
  put_text(joined_lines(lines), text, text_size);
  return found->refusals.empty() ? TICKTRUE_OK : TICKTRUE_DIVERGED;
}

int Session::peer_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root) {
  if (!can_call_peers("peer_root", peer)) return status_;
  peers_->add_root(peer, tick, root);
  return peers_status();
}

std::size_t Session::desync_message(std::uint32_t peer, void* buffer, std::size_t size) {
  if (!can_call_peers("desync_message", peer)) return 0;
  if (buffer == nullptr || size < message_size_min) {
    wrong_order("desync_message: size: found " + std::to_string(buffer == nullptr ? 0 : size) +
                    " bytes, expected at least " + std::to_string(message_size_min),
                "as many as a packet may have, 1200 for UDP");
    return 0;
  }
  const Bytes bytes = peers_->next_message(peer, size);
  std::copy(bytes.begin(), bytes.end(), static_cast<std::uint8_t*>(buffer));
  return bytes.size();
}

int Session::desync_receive(std::uint32_t peer, const void* bytes, std::size_t size) {
  if (!can_call_peers("desync_receive", peer)) return status_;
  if (const Status status = peers_->receive(peer, view_of(bytes, size)); !status) return TICKTRUE_REFUSED;
  return peers_status();
}

int Session::bundle(const char* path) {
  if (status_ == TICKTRUE_FAILED || refuse_in_callback("bundle")) return status_;
  refusal_.clear();
  if (path == nullptr || path[0] == 0) return refuse(usage("bundle: path: found none, expected a file name"));
  if (comparing_) return refuse(usage("bundle: found a verification", "a live session or a recording writes one"));
  if (!peers_->has_desync() || !peers_->has_game())
    return refuse(usage("bundle: found no desync: no tick is known that differs",
                        "ticktrue_peer_root and ticktrue_desync_receive return TICKTRUE_DIVERGED once there is one"));
  BundleSource source;
  if (is_recording() && recording_->is_started()) source.recording = path_;
  source.is_box = recording_ && recording_->is_box();
  source.game = game_setup();
  source.game.title = identity_.name;
  source.game.detail = replay::Detail::cells;
  source.game.stages = stages_;
  source.facts = facts_.all();
  const std::string name = replay::utf8_path(path);
  const bool overwrite = (flags_ & TICKTRUE_OVERWRITE) != 0;
  const Result<WrittenBundle> written = write_bundle(name, overwrite, source, *peers_, namer());
  if (!written) return refuse(written.error());
  file_notes_.push_back(plain_line(bundle_text(name, *written)));
  return TICKTRUE_OK;
}

int Session::box_save(const char* path) {
  if (status_ == TICKTRUE_FAILED || refuse_in_callback("box_save")) return status_;
  refusal_.clear();
  if (path == nullptr || path[0] == 0) return refuse(usage("box_save: path: found none, expected a file name"));
  if (!recording_ || !recording_->is_box())
    return refuse(usage("box_save: found no black box", "set box_kib in the options, or use --blackbox FILE"));
  if (!recording_->is_started()) return refuse(usage("box_save: found a session before its first tick"));
  const std::string name = replay::utf8_path(path);
  const auto saved = replay::save_box(path_, name, (flags_ & TICKTRUE_OVERWRITE) != 0);
  if (!saved) return refuse(saved.error());
  file_notes_.push_back(plain_line("the black box up to tick " +
                                   std::to_string(saved->first_tick + saved->result.ticks_written - 1) + " is in " +
                                   name));
  return TICKTRUE_OK;
}

std::string Session::desync_report(bool& is_complete) {
  is_complete = false;
  if (!peers_ || !peers_->has_desync() || !peers_->has_game()) return "";
  const DesyncFinding finding = peers_->finding(namer());
  is_complete = finding.is_whole;
  return desync_text(state_.schema(), finding);
}

void Session::report_peers() {
  std::vector<std::string>& notes = is_recording() ? recording_->notes : live_notes_;
  for (const std::string& line : file_notes_) notes.push_back(line);
  for (std::string& line : changes_.lines()) notes.push_back(plain_line(line));
  for (std::string& line : peers_->lines()) notes.push_back(std::move(line));
  if (!peers_->has_desync() || !peers_->has_game()) return;
  const DesyncFinding finding = peers_->finding(namer());
  desync_text_ = desync_text(state_.schema(), finding);
  desync_json_ = desync_json(state_.schema(), finding);
  if (status_ != TICKTRUE_FAILED && exit_code_ == verifier::exit_ok) exit_code_ = verifier::exit_finding;
}

std::string Session::live_text() const {
  if (status_ == TICKTRUE_FAILED) return "";
  char numbers[64];
  std::snprintf(numbers, sizeof numbers, "%llu ticks (%.3f s)", static_cast<unsigned long long>(peers_->roots().end()),
                live_time_s_);
  std::string text = "live  " + plain_line(identity_.name) + "  " + numbers + "\n  hash    " + hex64(live_root_) + "\n";
  for (const std::string& note : live_notes_) text += "  note    " + note + "\n";
  return text + desync_text_;
}

std::string Session::live_json() const {
  if (status_ == TICKTRUE_FAILED) return "";
  nlohmann::ordered_json object{{"schema", "ticktrue.live/1"},
                                {"simulation", plain_line(identity_.name)},
                                {"ticks", peers_->roots().end()},
                                {"hash", hex64(live_root_)},
                                {"notes", live_notes_}};
  if (!desync_json_.empty()) object["desync"] = nlohmann::ordered_json::parse(desync_json_);
  return object.dump() + "\n";
}

}  // namespace ticktrue::capi
