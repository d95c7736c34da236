// Reads a bundle. The peers are at the end of a trace, and their tick is before the end: the trace is read twice.
// SPDX-License-Identifier: MIT
#include "verifier/peers/bundle.h"

#include <algorithm>
#include <deque>
#include <utility>
#include <variant>

#include "base/hash.h"
#include "base/plain_text.h"
#include "base/state/child_tables.h"
#include "replay/format/identity.h"
#include "replay/format/peer.h"
#include "replay/format/table_list.h"
#include "verifier/peers/peer_rows.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t kept_roots_max = 65'536;
constexpr std::size_t hashed_columns_max = 8;  // in a report

std::string player_name(std::uint32_t player) {
  return "player " + std::to_string(player);
}

/// Columns, texts and strings of bytes whose hashes in the cells of the player are not those of this state.
std::vector<std::string> columns_by_hash(const StateSchema& schema, std::span<const ImageTable> tables, ByteView list) {
  const replay::CellLayout layout(schema);
  replay::ComposedCells there;
  if (list.empty() || tables.empty() || !there.apply(layout, list)) return {};
  StateView view;
  view.schema = &schema;
  std::vector<Bytes> rows(tables.size());
  for (std::size_t t = 0; t < tables.size(); ++t) {
    rows[t].resize(tables[t].rows.size());
    decode_rows(schema.tables[t], tables[t], rows[t].data());
    view.tables.push_back({rows[t].data(), tables[t].row_count});
  }
  StateCells here;
  CellHasher(schema).hash(view, there.cells().partition_cells, here);
  std::vector<std::string> names;
  for (std::size_t t = 0; t < layout.table_count(); ++t)
    for (std::size_t c = 0; c < layout.column_count(t); ++c) {
      const std::size_t at = layout.first_column(t) + c;
      if (names.size() >= hashed_columns_max || here.columns[at] == there.cells().columns[at]) continue;
      if (!has_pieces(schema.tables[t]))
        names.push_back(schema.tables[t].name + "." + schema.tables[t].columns[c].name);
      else if (names.empty() || names.back() != schema.tables[t].name)
        names.push_back(schema.tables[t].name);  // the columns of pieces say nothing to people
    }
  return names;
}

}  // namespace

/// The recorder's data in the trace, up to the differing tick.
struct Bundle::RecordedTicks {
  std::deque<std::pair<std::uint64_t, std::uint64_t>> roots;  // tick, root; ascending
  std::optional<replay::TickInputs> inputs;                   // of the differing tick
  std::optional<Bytes> image;                                 // of the state after it

  void read(replay::TraceReader& reader, std::uint64_t tick) {
    reader.rewind();
    for (;;) {
      const replay::TraceReader::Item& item = reader.next();
      if (std::holds_alternative<std::monostate>(item)) return;
      if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
        if (checkpoint->tick == tick + 1) image.emplace(checkpoint->image.begin(), checkpoint->image.end());
        if (checkpoint->tick > tick) return;
        continue;
      }
      const auto& record = std::get<replay::TickRecord>(item);
      if (record.tick > tick) return;
      roots.emplace_back(record.tick, record.root_hash);
      if (roots.size() > kept_roots_max) roots.pop_front();
      if (record.tick < tick) continue;
      inputs = replay::inputs_of(record.dt, record.inputs);
      if (record.image) image = record.image->joined();
    }
  }
};

DesyncPlayer Bundle::recorder_at(const replay::TraceReader& reader, const RecordedTicks& ticks) {
  DesyncPlayer player;
  player.player = recorder_;
  player.facts = reader.facts();
  player.inputs = ticks.inputs;
  if (!ticks.roots.empty() && ticks.roots.back().first == finding_.tick) player.root = ticks.roots.back().second;
  if (!ticks.image) {
    player.lost_state = true;
    return player;
  }
  image_ = *ticks.image;
  const StateSchema& schema = reader.setup().schema;
  Result<std::vector<ImageTable>> tables = split_image(schema, image_);
  if (!tables) {
    warnings_.push_back(player_name(recorder_) + ": its state cannot be read: " + tables.error().message);
    player.lost_state = true;
    return player;
  }
  tables_ = std::move(*tables);
  if (const std::uint64_t root = root_of_tables(schema, tables_); player.root && root != *player.root)
    warnings_.push_back(player_name(recorder_) + ": its stored state has the hash " + hex64(root) + ", its tick " +
                        hex64(*player.root));
  player.tables = tables_;
  return player;
}

Result<DesyncPlayer> Bundle::other_at(const StateSchema& schema, const replay::PeerRecord& peer) {
  DesyncPlayer player;
  player.player = peer.player;
  player.facts = peer.facts;
  player.inputs = peer.inputs;
  player.lost_state = peer.lost_state;
  player.root = peer.root_at(finding_.tick);
  if (!peer.has_state || tables_.empty()) {
    if (!peer.has_state) player.hashed = columns_by_hash(schema, tables_, peer.cells);
    return player;
  }
  Result<std::vector<Bytes>> rows = rows_of_peer(schema, tables_, peer);
  if (!rows) return rows.error();
  rows_.push_back(std::move(*rows));
  player.tables = tables_of(schema, rows_.back());
  finding_.is_cut = finding_.is_cut || peer.is_cut;
  const std::uint64_t root = root_of_tables(schema, *player.tables);
  if (!peer.is_cut && player.root && root != *player.root) {
    finding_.is_cut = true;
    warnings_.push_back(player_name(peer.player) + ": its rows have the hash " + hex64(root) + ", its tick " +
                        hex64(*player.root) + ": more differs than they say");
  }
  return player;
}

void Bundle::find_agreed(const RecordedTicks& ticks, std::span<const replay::PeerRecord> peers) {
  const auto is_same = [&](std::uint64_t tick, std::uint64_t root) {
    return std::all_of(peers.begin(), peers.end(), [&](const replay::PeerRecord& peer) {
      const auto there = peer.root_at(finding_.tick);
      // A player with the recorder's root at this tick has no known earlier difference.
      const bool is_with_recorder = there && !ticks.roots.empty() && ticks.roots.back().first == finding_.tick &&
                                    there == ticks.roots.back().second;
      return !there || is_with_recorder || peer.root_at(tick) == root;
    });
  };
  for (auto at = ticks.roots.rbegin(); at != ticks.roots.rend() && !finding_.agreed; ++at)
    if (at->first < finding_.tick && is_same(at->first, at->second)) finding_.agreed = at->first;
}

Result<std::optional<Bundle>> Bundle::read(replay::TraceReader& reader) {
  if (!reader.setup().has(replay::Feature::peers)) return std::optional<Bundle>();
  reader.rewind();
  while (!std::holds_alternative<std::monostate>(reader.next())) {
  }
  const std::vector<replay::PeerRecord> peers = reader.tail().peers;
  if (peers.empty()) return std::optional<Bundle>();
  Bundle bundle;
  bundle.recorder_ = peers[0].recorder;
  bundle.finding_.simulation = reader.setup().simulation;
  bundle.finding_.tick = peers[0].tick;
  RecordedTicks ticks;
  ticks.read(reader, peers[0].tick);
  const StateSchema& schema = reader.setup().schema;
  std::vector<DesyncPlayer>& players = bundle.finding_.players;
  players.push_back(bundle.recorder_at(reader, ticks));
  for (const replay::PeerRecord& peer : peers) {
    Result<DesyncPlayer> player = bundle.other_at(schema, peer);
    if (!player) return Error{player.error().code, reader.name() + ": " + player.error().message, ""};
    const auto place = std::find_if(players.begin(), players.end(),
                                    [&](const DesyncPlayer& other) { return other.player > player->player; });
    players.insert(place, std::move(*player));
    if (peer.session_identity != replay::session_identity(reader.setup()))
      bundle.warnings_.push_back(player_name(peer.player) + " plays another game: session identity " +
                                 hex64(peer.session_identity) + ", that of the recorder is " +
                                 hex64(replay::session_identity(reader.setup())));
  }
  bundle.finding_.is_whole = std::all_of(players.begin(), players.end(), [](const DesyncPlayer& player) {
    return player.root.has_value() && player.tables.has_value();
  });
  compare_players(schema, {}, bundle.finding_);
  bundle.find_agreed(ticks, peers);
  return std::optional<Bundle>(std::move(bundle));
}

std::string Bundle::players_text() const {
  std::string text = "players";
  for (std::size_t i = 0; i < finding_.players.size(); ++i)
    text += (i > 0 ? ", " : " ") + std::to_string(finding_.players[i].player);
  return text + "; recorded by " + player_name(recorder_);
}

std::string Bundle::text(const StateSchema& schema) const {
  std::string text = desync_text(schema, finding_);
  for (const std::string& warning : warnings_) text += "  warning " + plain_line(warning) + "\n";
  return text;
}

std::string bundle_note(const replay::TraceSetup& setup, const std::string& file) {
  if (!setup.has(replay::Feature::peers)) return "";
  return "a bundle of several players: `ticktrue show " + shell_word(file) + "` says who differs";
}

std::string players_text(std::span<const replay::PeerRecord> peers) {
  if (peers.empty()) return "";
  std::vector<std::uint32_t> players{peers[0].recorder};
  for (const replay::PeerRecord& peer : peers) players.push_back(peer.player);
  std::sort(players.begin(), players.end());
  std::string text = "players";
  for (std::size_t i = 0; i < players.size(); ++i) text += (i > 0 ? ", " : " ") + std::to_string(players[i]);
  return text + "; recorded by " + player_name(peers[0].recorder);
}

}  // namespace ticktrue::verifier
