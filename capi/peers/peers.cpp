// Combines roots, states and messages of the players.
// SPDX-License-Identifier: MIT
#include "capi/peers/peers.h"

#include <algorithm>
#include <utility>

#include "base/count_text.h"
#include "base/hash.h"
#include "replay/format/table_list.h"
#include "verifier/peers/peer_rows.h"

namespace ticktrue::capi {
namespace {

constexpr std::uint64_t root_window = 64;  // roots are sent of this number of ticks before the differing tick

Error other_game(const std::string& what) {
  return {ErrorCode::incompatible, "desync message: " + what, ""};
}

}  // namespace

void Peers::set_game(const replay::TraceSetup& setup, const replay::BuildFacts& facts) {
  game_ = std::make_unique<Hello>(make_hello(setup, facts));
  schema_ = setup.schema;
  hasher_ = std::make_unique<CellHasher>(*schema_);
}

void Peers::add(std::uint64_t tick, std::uint64_t root, double dt, ByteView inputs, const StateView& state) {
  // After a difference all ticks differ: the stored states stay.
  if (keeps_states_ && !has_desync()) kept_.add(tick, dt, inputs, state, time_s_);
  time_s_ += dt;
  roots_.add(tick, root);
  if (has_desync()) update();
}

Result<HelloDifferences> Peers::take_hello(std::uint32_t peer, ByteView bytes) {
  Result<Hello> there = decode_hello(bytes);
  if (!there) return there.error();
  roots_.know(peer);
  HelloDifferences found = hello_differences(*game_, *there);
  hellos_[peer] = std::move(*there);
  return found;
}

void Peers::add_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root) {
  roots_.add_peer(peer, tick, root);
  if (has_desync()) update();
}

/// Sets the tick of the exchange: the first differing tick that is known, or an earlier tick that another player named.
void Peers::update() {
  const std::optional<std::uint64_t> differing = roots_.differing();
  if (!differing) return;
  const bool is_known = location_ && location_->tick == *differing;
  bool is_named = false;
  if (location_ && location_->named_by && location_->tick < *differing) {
    const auto there = roots_.at(*location_->named_by, location_->tick);
    is_named = !there || there != roots_.at(location_->tick);
  }
  if (!is_known && !is_named) locate(*differing, std::nullopt);
  const std::optional<std::uint64_t> here = roots_.at(location_->tick);
  for (const auto& [peer, count] : roots_.peers()) {
    const auto there = roots_.at(peer, location_->tick);
    if (!there || there != here) other(peer);
  }
}

void Peers::locate(std::uint64_t tick, std::optional<std::uint32_t> named_by) {
  Location& location = location_.emplace();
  location.tick = tick;
  location.named_by = named_by;
  CellsDocument document;
  const std::uint64_t first = std::max(roots_.first_kept(), tick > root_window ? tick - root_window : 0);
  document.first_tick = first;
  for (std::uint64_t t = first; t <= tick; ++t) document.roots.push_back(roots_.at(t).value_or(0));
  if (const KeptTick* kept = kept_.find(tick)) {
    location.inputs = kept->inputs;
    location.state.emplace(kept->state.view());
    document.inputs = kept->inputs;
    document.has_state = true;
    hasher_->hash(location.state->view(), 0, document.cells);
  }
  ByteWriter out;
  encode_cells_document(document, schema(), out);
  location.cells_document = out.take();
}

Peers::Other& Peers::other(std::uint32_t peer) {
  Other& found = location_->others[peer];
  if (!found.exchange.is_offered(Document::cells)) found.exchange.offer(Document::cells, location_->cells_document);
  return found;
}

Bytes Peers::next_message(std::uint32_t peer, std::size_t size) {
  if (!location_) return {};
  const auto found = location_->others.find(peer);
  if (found == location_->others.end() || !found->second.exchange.has_message()) return {};
  Message message;
  message.identity = game_->identity;
  message.from = player_;
  message.to = peer;
  message.tick = location_->tick;
  found->second.exchange.next(size - message_fields_size, message);
  return encode_message(message);
}

Status Peers::receive(std::uint32_t peer, ByteView bytes) {
  const Result<Message> message = decode_message(bytes);
  if (!message) return message.error();
  if (message->identity != game_->identity)
    return other_game("session identity: found " + hex64(message->identity) + ", expected " + hex64(game_->identity));
  if (message->from != peer || message->to != player_)
    return other_game("found one from player " + std::to_string(message->from) + " to player " +
                      std::to_string(message->to) + ", expected from " + std::to_string(peer) + " to " +
                      std::to_string(player_));
  const std::optional<std::uint64_t> here = roots_.at(message->tick);
  if (!here) return {};  // not confirmed yet, or forgotten: the message comes again
  const bool is_here = location_ && location_->tick == message->tick;
  if (location_ && message->tick > location_->tick) {
    other(peer).exchange.owe_answer();  // the answer names the earlier tick
    return {};
  }
  if (!is_here) {
    const auto there = roots_.at(peer, message->tick);
    if (there && there == here) return {};  // a difference between other players shows in their roots
    roots_.know(peer);
    locate(message->tick, peer);
  }
  Other& from = other(peer);
  if (const Status status = from.exchange.take(*message); !status) return status;
  const Status status = read_documents(peer, from);
  update();
  return status;
}

bool Peers::rows_are_due(const Other& other, std::uint32_t peer) const {
  return other.cells && other.cells->has_state && location_->state &&
         roots_.at(peer, location_->tick) != roots_.at(location_->tick);
}

Status Peers::read_cells(std::uint32_t peer, Other& from, ByteView bytes) {
  Result<CellsDocument> cells = decode_cells_document(schema(), bytes);
  if (!cells) return cells.error();
  for (std::size_t i = 0; i < cells->roots.size(); ++i) roots_.add_peer(peer, cells->first_tick + i, cells->roots[i]);
  from.cells = std::move(*cells);
  if (!rows_are_due(from, peer)) return {};
  from.sent = rows_to_send(location_->state->view(), from.cells->cells, *hasher_);
  ByteWriter out;
  encode_rows_document(*from.sent, out);
  from.exchange.offer(Document::rows, out.take());
  return {};
}

Status Peers::read_documents(std::uint32_t peer, Other& from) {
  if (const Bytes* bytes = from.exchange.arrived(Document::cells); bytes != nullptr && !from.cells)
    if (const Status status = read_cells(peer, from, *bytes); !status) return status;
  const Bytes* bytes = from.exchange.arrived(Document::rows);
  if (bytes == nullptr || from.state || !from.sent) return {};
  const Result<RowsDocument> rows = decode_rows_document(schema(), *bytes);
  if (!rows) return rows.error();
  from.state.emplace(location_->state->view(), *from.sent, *rows);
  from.is_cut = rows->is_cut || from.sent->is_cut;
  return {};
}

DesyncFinding Peers::finding(const RowNamer& row_name) {
  DesyncFinding found;
  found.simulation = game_->simulation;
  found.tick = location_->tick;
  found.is_whole = true;
  const std::optional<std::uint64_t> here = roots_.at(found.tick);
  std::optional<std::vector<ImageTable>> own;
  if (location_->state) own = canonical_tables(location_->state->view(), location_->buffer);
  DesyncPlayer me;
  me.player = player_;
  me.root = here;
  if (location_->state) me.inputs = location_->inputs;
  me.tables = own;
  me.lost_state = !location_->state;
  me.facts = game_->facts;
  found.players.push_back(std::move(me));
  for (const auto& [peer, count] : roots_.peers()) {
    DesyncPlayer player;
    player.player = peer;
    player.root = roots_.at(peer, found.tick);
    if (const auto hello = hellos_.find(peer); hello != hellos_.end()) player.facts = hello->second.facts;
    const auto other = location_->others.find(peer);
    const bool is_known = other != location_->others.end();
    if (is_known && other->second.cells) {
      if (other->second.cells->has_state) player.inputs = other->second.cells->inputs;
      player.lost_state = !other->second.cells->has_state;
    }
    if (player.root && player.root == here) {
      player.tables = own;
      if (!player.inputs) player.inputs = found.players[0].inputs;
    } else if (is_known && other->second.state) {
      const auto tables = other->second.state->tables();
      player.tables.emplace(tables.begin(), tables.end());
      found.is_cut = found.is_cut || other->second.is_cut;
    }
    found.is_whole = found.is_whole && player.root && player.tables;
    found.players.push_back(std::move(player));
  }
  std::sort(found.players.begin(), found.players.end(),
            [](const DesyncPlayer& a, const DesyncPlayer& b) { return a.player < b.player; });
  verifier::compare_players(schema(), row_name, found);
  for (std::uint64_t t = found.tick; t-- > roots_.first_kept() && !found.agreed;) {
    const auto all = roots_.at(t);
    // A player with the same root as this player has no known earlier difference.
    const bool is_same = all && std::all_of(found.players.begin(), found.players.end(), [&](const DesyncPlayer& p) {
                           return !p.root || p.root == here || roots_.at(p.player, t) == all;
                         });
    if (is_same) found.agreed = t;
  }
  return found;
}

std::vector<replay::PeerRecord> Peers::records(const DesyncFinding& finding) const {
  const auto own = std::find_if(finding.players.begin(), finding.players.end(),
                                [this](const DesyncPlayer& player) { return player.player == player_; });
  std::vector<replay::PeerRecord> records;
  for (const DesyncPlayer& player : finding.players) {
    if (player.player == player_) continue;
    replay::PeerRecord record;
    record.player = player.player;
    record.recorder = player_;
    const auto hello = hellos_.find(player.player);
    record.session_identity = hello != hellos_.end() ? hello->second.identity : game_->identity;
    record.facts = player.facts;
    record.tick = finding.tick;
    for (std::uint64_t tick = roots_.first_kept(); tick < roots_.end(); ++tick)
      if (const auto root = roots_.at(player.player, tick)) record.roots.push_back({tick, *root});
    record.inputs = player.inputs;
    const auto other = location_->others.find(player.player);
    const bool is_known = other != location_->others.end();
    if (is_known && other->second.cells && other->second.cells->has_state) {
      ByteWriter cells;
      replay::encode_cell_list(replay::CellLayout(schema()), other->second.cells->cells, nullptr, cells);
      record.cells = cells.take();
    }
    if (player.tables && own->tables) {
      verifier::set_peer_rows(schema(), *own->tables, *player.tables, record);
      record.is_cut = record.is_cut || (is_known && other->second.is_cut);
    }
    record.lost_state = player.lost_state && !record.has_state;
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<std::string> Peers::lines() const {
  std::vector<std::string> lines;
  for (const auto& [peer, count] : roots_.peers()) {
    std::string line = "player " + std::to_string(peer) + ": " + count_text(count.compared, "tick") + " compared";
    if (count.differing)
      line += ", other from tick " + std::to_string(*count.differing) + " on";
    else if (count.agreed)
      line += ", the same up to tick " + std::to_string(*count.agreed);
    if (count.changed > 0) line += ", " + count_text(count.changed, "root") + " came again with another value";
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace ticktrue::capi
