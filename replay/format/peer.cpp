// Encodes and decodes peer records. Each count is compared with the remaining bytes before memory is allocated.
// SPDX-License-Identifier: MIT
#include "replay/format/peer.h"

#include <algorithm>
#include <utility>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/format/chunk.h"
#include "replay/format/payload.h"
#include "replay/format/table_list.h"

namespace ticktrue::replay {
namespace {

constexpr std::uint8_t flag_inputs = 1;
constexpr std::uint8_t flag_state = 2;
constexpr std::uint8_t flag_cut = 4;
constexpr std::uint8_t flag_lost = 8;
constexpr std::uint8_t flag_mask = 15;

Error wrong(const std::string& what) {
  return {ErrorCode::corrupt, "peer: " + what, ""};
}

Error wrong_number(const std::string& what, std::uint64_t found, std::uint64_t max) {
  return wrong(what + ": found " + std::to_string(found) + ", expected at most " + std::to_string(max));
}

std::uint8_t flags_of(const PeerRecord& peer) {
  return static_cast<std::uint8_t>((peer.inputs ? flag_inputs : 0) | (peer.has_state ? flag_state : 0) |
                                   (peer.is_cut ? flag_cut : 0) | (peer.lost_state ? flag_lost : 0));
}

/// Reads ascending row numbers and their rows. False: not ascending, or the payload ends early.
bool read_rows(ByteReader& in, std::size_t row_size, std::vector<std::uint32_t>& rows, Bytes& bytes) {
  const std::uint32_t count = in.u32();
  if (count > in.remaining() / (sizeof(std::uint32_t) + row_size)) return false;
  rows.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t row = in.u32();
    if (row >= limits::row_count_max || (!rows.empty() && row <= rows.back())) return false;
    rows.push_back(row);
    const ByteView row_bytes = in.bytes(row_size);
    bytes.insert(bytes.end(), row_bytes.begin(), row_bytes.end());
  }
  return in.ok();
}

Status read_tables(const StateSchema& schema, ByteReader& in, PeerRecord& peer) {
  const std::uint16_t count = in.u16();
  std::uint64_t next = 0;
  std::size_t row_count = 0, size = 0;
  for (std::uint16_t i = 0; i < count; ++i) {
    const std::uint64_t skip = in.varint();
    if (!in.ok() || skip >= schema.tables.size() - next) return wrong("rows: end early, or are of no table");
    PeerTable table;
    table.table = static_cast<std::uint32_t>(next + skip);
    next = table.table + 1;
    const TableSchema& columns = schema.tables[table.table];
    Bytes none;
    if (!read_rows(in, 0, table.removed, none) || !read_rows(in, columns.row_size, table.rows, table.bytes))
      return wrong("table " + columns.name + ": rows: end early, or their numbers do not ascend");
    if (table.removed.empty() && table.rows.empty()) return wrong("table " + columns.name + ": found no row");
    row_count += table.removed.size() + table.rows.size();
    size += table.bytes.size();
    if (row_count > peer_row_count_max) return wrong_number("rows", row_count, peer_row_count_max);
    if (size > peer_rows_size_max) return wrong_number("bytes of rows", size, peer_rows_size_max);
    peer.tables.push_back(std::move(table));
  }
  return {};
}

Status read_roots(ByteReader& in, PeerRecord& peer) {
  std::uint64_t tick = in.u64();
  const std::uint32_t count = in.u32();
  if (count > peer_root_count_max) return wrong_number("roots", count, peer_root_count_max);
  if (count > in.remaining() / 9) return wrong("roots: end early");
  if (count == 0 && tick != 0) return wrong("first tick of the roots: found one without roots");
  peer.roots.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t skip = in.varint();
    const std::uint64_t root = in.u64();
    if (!in.ok()) return wrong("roots: end early");
    if (i == 0 && skip != 0) return wrong("roots: the first one stands at another tick than the first");
    if (tick > limits::tick_count_max || skip > limits::tick_count_max - tick)
      return wrong("roots: found a tick behind the last that there can be");
    tick += skip;
    peer.roots.push_back({tick++, root});
  }
  return {};
}

Status read_inputs(ByteReader& in, PeerRecord& peer) {
  TickInputs& inputs = peer.inputs.emplace();
  inputs.dt = in.f64();
  inputs.size = in.u64();
  inputs.hash = in.u64();
  const std::uint8_t size = in.u8();
  if (size > input_begin_max || size > inputs.size) return wrong("inputs: found more bytes than there can be");
  const ByteView begin = in.bytes(size);
  inputs.begin.assign(begin.begin(), begin.end());
  return in.ok() ? Status() : wrong("inputs: end early");
}

}  // namespace

TickInputs inputs_of(double dt, ByteView inputs) {
  TickInputs found;
  found.dt = dt;
  found.size = inputs.size();
  found.hash = hash64(inputs);
  const ByteView begin = inputs.first(std::min(inputs.size(), input_begin_max));
  found.begin.assign(begin.begin(), begin.end());
  return found;
}

std::optional<std::uint64_t> PeerRecord::root_at(std::uint64_t at) const {
  const auto found = std::lower_bound(roots.begin(), roots.end(), at,
                                      [](const PeerRoot& root, std::uint64_t wanted) { return root.tick < wanted; });
  return found == roots.end() || found->tick != at ? std::nullopt : std::optional(found->root);
}

Status check_peer(const PeerRecord& peer, const std::string& place) {
  std::size_t row_count = 0, size = 0;
  for (const PeerTable& table : peer.tables) {
    row_count += table.removed.size() + table.rows.size();
    size += table.bytes.size();
  }
  const struct {
    const char* what;
    std::size_t found;
    std::size_t max;
  } bounds[] = {{"roots", peer.roots.size(), peer_root_count_max},
                {"rows", row_count, peer_row_count_max},
                {"bytes of rows", size, peer_rows_size_max},
                {"bytes of cells", peer.cells.size(), cell_list_size_max}};
  for (const auto& bound : bounds)
    if (bound.found > bound.max)
      return Error{ErrorCode::limit,
                   place + ": peer: " + bound.what + ": found " + std::to_string(bound.found) + ", expected at most " +
                       std::to_string(bound.max),
                   ""};
  return check_facts(peer.facts, place + ": peer");
}

void encode_peer(const PeerRecord& peer, ByteWriter& out) {
  out.u32(peer.player);
  out.u32(peer.recorder);
  out.u64(peer.session_identity);
  out.u16(static_cast<std::uint16_t>(peer.facts.size()));
  for (const auto& [name, value] : peer.facts) {
    out.text(name);
    out.text(value);
  }
  out.u64(peer.tick);
  out.u64(peer.roots.empty() ? 0 : peer.roots.front().tick);
  out.u32(static_cast<std::uint32_t>(peer.roots.size()));
  std::uint64_t next = peer.roots.empty() ? 0 : peer.roots.front().tick;
  for (const PeerRoot& root : peer.roots) {
    out.varint(root.tick - next);
    out.u64(root.root);
    next = root.tick + 1;
  }
  out.u8(flags_of(peer));
  if (peer.inputs) {
    out.f64(peer.inputs->dt);
    out.u64(peer.inputs->size);
    out.u64(peer.inputs->hash);
    out.u8(static_cast<std::uint8_t>(peer.inputs->begin.size()));
    out.bytes(peer.inputs->begin);
  }
  out.u32(static_cast<std::uint32_t>(peer.cells.size()));
  out.bytes(peer.cells);
  out.u16(static_cast<std::uint16_t>(peer.tables.size()));
  std::uint32_t next_table = 0;
  for (const PeerTable& table : peer.tables) {
    out.varint(table.table - next_table);
    next_table = table.table + 1;
    out.u32(static_cast<std::uint32_t>(table.removed.size()));
    for (const std::uint32_t row : table.removed) out.u32(row);
    out.u32(static_cast<std::uint32_t>(table.rows.size()));
    const std::size_t row_size = table.rows.empty() ? 0 : table.bytes.size() / table.rows.size();
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      out.u32(table.rows[i]);
      out.bytes(ByteView(table.bytes).subspan(i * row_size, row_size));
    }
  }
}

Result<PeerRecord> decode_peer(const StateSchema& schema, ByteView payload) {
  ByteReader in(payload);
  PeerRecord peer;
  peer.player = in.u32();
  peer.recorder = in.u32();
  peer.session_identity = in.u64();
  if (!in.ok()) return wrong("ends early");
  for (const std::uint32_t player : {peer.player, peer.recorder})
    if (player > player_max) return wrong_number("player", player, player_max);
  if (peer.player == peer.recorder) return wrong("player: found " + std::to_string(peer.player) + ", who recorded");
  const std::uint16_t fact_count = in.u16();
  if (fact_count > fact_count_max) return wrong_number("facts", fact_count, fact_count_max);
  for (std::size_t i = 0; i < fact_count && in.ok(); ++i) {
    std::string name = in.text(fact_size_max);
    std::string value = in.text(fact_size_max);
    peer.facts.emplace_back(std::move(name), std::move(value));
  }
  peer.tick = in.u64();
  if (!in.ok()) return wrong("facts: end early");
  if (peer.tick >= limits::tick_count_max) return wrong_number("tick", peer.tick, limits::tick_count_max - 1);
  if (const Status status = read_roots(in, peer); !status) return status.error();
  const std::uint8_t flags = in.u8();
  peer.has_state = (flags & flag_state) != 0;
  peer.is_cut = (flags & flag_cut) != 0;
  peer.lost_state = (flags & flag_lost) != 0;
  if (!in.ok() || (flags & ~flag_mask) != 0 || (peer.is_cut && !peer.has_state) || (peer.lost_state && peer.has_state))
    return wrong("flags: found " + std::to_string(flags) + ", which cannot be");
  if ((flags & flag_inputs) != 0)
    if (const Status status = read_inputs(in, peer); !status) return status.error();
  const std::uint32_t cells_size = in.u32();
  if (cells_size > cell_list_size_max) return wrong_number("bytes of cells", cells_size, cell_list_size_max);
  const ByteView cells = in.bytes(cells_size);
  ComposedCells composed;
  if (!in.ok() || (!cells.empty() && !composed.apply(CellLayout(schema), cells)))
    return wrong("cells: found no list of the tables of this trace");
  peer.cells.assign(cells.begin(), cells.end());
  if (const Status status = read_tables(schema, in, peer); !status) return status.error();
  if (!peer.tables.empty() && !peer.has_state) return wrong("rows: found some of a state that is not known");
  if (!in.ok() || !in.at_end()) return wrong("ends early, or bytes follow");
  return peer;
}

}  // namespace ticktrue::replay
