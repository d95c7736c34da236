// Forged traces of version 3, with every checksum right: each limit holds, and one more is refused.
// SPDX-License-Identifier: MIT
#include <functional>
#include <limits>

#include "base/limits.h"
#include "replay/format/identity.h"
#include "replay/format/payload.h"
#include "replay/format/peer.h"
#include "replay/format/table_list.h"
#include "tests/damage/forger.h"
#include "tests/replay/third_sessions.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using damage::Forger;
using replay::ChunkKind;
using replay::Detail;
using replay::Feature;
using replay::RecordTag;
using replay::TraceCondition;

constexpr std::size_t table_count = 3;

/// Three tables of one byte a row. Every tick is full, and every feature is on.
replay::TraceSetup setup_with(std::uint32_t features, Detail detail = Detail::full) {
  replay::TraceSetup setup = toy_setup(1);
  setup.schema = {};
  for (std::size_t t = 0; t < table_count; ++t) {
    TableSchema table;
    table.name = "t" + std::to_string(t);
    table.row_size = 1;
    table.columns.resize(1);
    table.columns[0].name = "byte";
    table.columns[0].type = ScalarType::u8;
    setup.schema.tables.push_back(table);
  }
  setup.detail = detail;
  setup.full_last = detail == Detail::full ? 1'000 : 0;
  setup.features = features & ~1u;
  setup.stage_interval = 1;
  return setup;
}
constexpr std::uint32_t all_features = replay::feature_mask;
constexpr std::uint32_t no_tail = all_features & ~static_cast<std::uint32_t>(Feature::tail);

Forger begin_third(const replay::TraceSetup& setup) {
  Forger forger(replay::format_version_third);
  ByteWriter payload;
  replay::encode_setup(setup, payload);
  forger.setup(payload.view());
  forger.facts({replay::Codec::zstd, {}});
  return forger;
}

/// A list of tables, by skip, row count and one byte for all its rows.
struct Listed {
  std::uint64_t skip = 0;
  std::uint32_t row_count = 0;
  std::uint8_t value = 0;
};
Bytes list(std::uint8_t base, const std::vector<Listed>& tables) {
  ByteWriter out;
  out.u8(base);
  out.varint(tables.size());
  for (const Listed& table : tables) {
    out.varint(table.skip);
    out.u32(table.row_count);
    out.bytes(Bytes(table.row_count, table.value));
  }
  return out.take();
}

const Bytes whole_list = list(0, {{0, 2, 7}, {1, 1, 9}});  // tables 0 and 2

Bytes number(std::uint64_t value) {
  ByteWriter out;
  out.u64(value);
  return out.take();
}

Bytes note(std::size_t topic_size, std::size_t size) {
  ByteWriter out;
  out.text(std::string(topic_size, 't'));
  out.bytes(Bytes(size, 1));
  return out.take();
}

Bytes marks(std::uint64_t id, std::uint64_t count = 1) {
  ByteWriter out;
  out.u64(1);
  out.varint(1);
  out.varint(id);
  out.varint(count);
  out.u32(3);
  return out.take();
}

/// The fault that a reader finds in a trace that `write` continues behind its first checkpoint.
std::string fault_of(const replay::TraceSetup& setup, const std::function<void(Forger&)>& write) {
  Forger forger = begin_third(setup);
  forger.list(ChunkKind::checkpoint, whole_list);
  write(forger);
  const ThirdTrace all = read_third(forger.take());
  if (all.tail.condition == TraceCondition::damaged) return all.tail.message;
  REQUIRE(all.tail.condition == TraceCondition::truncated);  // it has no end
  return "";
}

/// Of records in the first tick, which ends with a root.
std::string fault_of_records(const std::vector<std::pair<RecordTag, Bytes>>& records,
                             std::uint32_t features = no_tail) {
  return fault_of(setup_with(features), [&](Forger& forger) {
    forger.open_ticks();
    for (const auto& [tag, body] : records) forger.record(tag, body);
    forger.record(RecordTag::root, number(5));
    forger.close_ticks();
  });
}

void full_tick(Forger& forger, ByteView image) {
  forger.open_ticks();
  forger.record(RecordTag::root_image, number(1));
  forger.close_ticks();
  forger.list(ChunkKind::image, image);
}

TEST_CASE("a list of tables that contradicts itself is refused", "[replay][third][forgery][corruption]") {
  const auto of_checkpoint = [](ByteView bytes, std::uint64_t image_size) {
    Forger forger = begin_third(setup_with(no_tail));
    forger.list(ChunkKind::checkpoint, bytes, image_size);
    const ThirdTrace all = read_third(forger.take());
    CHECK(all.checkpoints.empty() == (all.tail.condition == TraceCondition::damaged));
    return all.tail.condition == TraceCondition::damaged ? all.tail.message : std::string();
  };
  const auto of = [&](const Bytes& bytes) { return of_checkpoint(bytes, bytes.size()); };
  CHECK(of(whole_list).empty());
  CHECK(of(list(0, {})).empty());
  CHECK(contains(of(list(0, {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}})), "found 4 tables, expected at most 3"));
  CHECK(contains(of(list(0, {{3, 1, 0}})), "skip: found 3 behind table 0 of 3"));
  CHECK(contains(of(list(0, {{1, 1, 0}, {1, 1, 0}})), "skip: found 1 behind table 2 of 3"));
  CHECK(contains(of(list(0, {{1ull << 63, 1, 0}})), "skip: found 9223372036854775808"));
  CHECK(contains(of(list(0, {{0, 0, 0}})), "table t0: is listed and has no rows"));
  CHECK(contains(of(list(1, {{0, 1, 0}})), "base: found 1, expected 0: no state of one tick less stands before it"));
  CHECK(contains(of(list(2, {{0, 1, 0}})), "base: found 2, expected 0"));
  Bytes huge = list(0, {{0, 1, 0}});
  std::fill(huge.begin() + 3, huge.begin() + 7, std::uint8_t{0xff});
  CHECK(contains(of(huge), "rows: found 4294967295"));
  Bytes longer = whole_list;
  longer.push_back(0);
  CHECK(contains(of(longer), "by its list of tables"));
  for (std::size_t size = 0; size < whole_list.size(); ++size) {
    CAPTURE(size);
    CHECK(!of(Bytes(whole_list.begin(), whole_list.begin() + static_cast<std::ptrdiff_t>(size))).empty());
  }
}

TEST_CASE("an image of changes holds what changed, and needs the state before",
          "[replay][third][forgery][corruption]") {
  const auto of = [](const std::vector<Bytes>& images) {
    return fault_of(setup_with(no_tail), [&](Forger& forger) {
      for (const Bytes& image : images) full_tick(forger, image);
    });
  };
  CHECK(of({list(1, {{0, 2, 8}}), list(1, {{0, 2, 7}, {0, 1, 1}})}).empty());
  CHECK(of({list(1, {}), list(1, {})}).empty());
  CHECK(of({list(1, {{0, 0, 0}}), list(1, {{0, 1, 0}})}).empty());
  CHECK(contains(of({list(1, {{0, 2, 7}})}), "table t0: is listed and has the rows of the tick before"));
  CHECK(contains(of({list(1, {{1, 0, 0}})}), "table t1: is listed and has the rows of the tick before"));
  CHECK(contains(of({whole_list}), "base: found 0, expected 1: the state of one tick less stands before it"));
  // A tick without image between: the state before is not known.
  CHECK(contains(fault_of(setup_with(no_tail),
                          [](Forger& forger) {
                            forger.open_ticks();
                            forger.record(RecordTag::root, number(1));
                            forger.close_ticks();
                            full_tick(forger, list(1, {}));
                          }),
                 "base: found 1, expected 0"));
}

TEST_CASE("cells list what changed in their chunk", "[replay][third][forgery][corruption]") {
  struct Cells {
    std::uint64_t skip;
    std::uint64_t row_count;
    std::uint32_t column;
  };
  const auto body = [](std::uint8_t base, const std::vector<Cells>& tables, std::uint64_t partition_cells = 4) {
    ByteWriter out;
    out.u8(base);
    out.varint(tables.size());
    for (const Cells& table : tables) {
      out.varint(table.skip);
      out.varint(table.row_count);
      if (table.row_count > 0) out.u32(table.column);
    }
    out.varint(partition_cells);
    out.bytes(Bytes(static_cast<std::size_t>(8 * std::min<std::uint64_t>(partition_cells, 5'000))));
    return out.take();
  };
  const auto of = [](const std::vector<Bytes>& records) {
    return fault_of(setup_with(no_tail, Detail::cells), [&](Forger& forger) {
      forger.open_ticks();
      for (const Bytes& record : records) {
        forger.record(RecordTag::cells, record);
        forger.record(RecordTag::root, number(1));
      }
      forger.close_ticks();
    });
  };
  const Bytes first = body(0, {{0, 2, 1}, {1, 5, 6}});
  CHECK(of({first}).empty());
  CHECK(of({body(0, {}, 4'096)}).empty());
  CHECK(of({first, body(1, {}), body(1, {{0, 2, 9}}), body(1, {{2, 0, 0}}), body(1, {{2, 5, 6}})}).empty());
  const std::vector<std::vector<Bytes>> wrong{
      {body(1, {})},                      // nothing before it in the chunk
      {first, first},                     // not relative to the record before
      {first, body(1, {{0, 2, 1}})},      // no difference
      {first, body(1, {{1, 0, 0}})},      // the same: no rows before either
      {body(0, {{0, 0, 0}})},             // listed without rows
      {body(0, {{3, 1, 1}})},             // behind the last table
      {body(0, {{2, 1, 1}, {0, 1, 1}})},  // the same
      {body(0, {{0, 1ull << 32, 1}})},    // too many rows
      {body(0, {}, 4'097)},
      {body(0, {}, 0)},  // too many cells, and none
      {body(2, {})},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    CAPTURE(i);
    CHECK(contains(of(wrong[i]), "whose counts do not add up"));
  }
  for (std::size_t size = 1; size < first.size(); ++size)
    CHECK(!of({Bytes(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(size))}).empty());
}

TEST_CASE("each limit of records outside of the chain holds", "[replay][third][forgery][limits]") {
  const std::pair<RecordTag, Bytes> name{RecordTag::name, Bytes(4, 'n')};
  CHECK(fault_of_records({{RecordTag::note, note(64, 4'096)}}).empty());
  CHECK(contains(fault_of_records({{RecordTag::note, note(65, 0)}}), "note: topic"));
  CHECK(contains(fault_of_records({{RecordTag::note, note(0, 0)}}), "note: topic"));
  CHECK(
      contains(fault_of_records({{RecordTag::note, note(1, 4'097)}}), "note: found 4097 bytes, expected at most 4096"));
  CHECK(contains(fault_of_records({{RecordTag::note, note(64, 5'000)}}), "record size"));

  CHECK(fault_of_records({{RecordTag::name, Bytes(256, 'n')}}).empty());
  CHECK(contains(fault_of_records({{RecordTag::name, Bytes(257, 'n')}}), "record size"));
  CHECK(contains(fault_of_records({{RecordTag::name, {}}}), "record size"));
  std::vector<std::pair<RecordTag, Bytes>> names;
  for (std::uint8_t i = 0; names.size() < 1'024; i = static_cast<std::uint8_t>((i + 1) % 32))
    names.emplace_back(RecordTag::name, Bytes{static_cast<std::uint8_t>(names.size() / 32), i});
  CHECK(fault_of_records(names).empty());
  names.push_back(name);
  CHECK(contains(fault_of_records(names), "names of marks: found more than 1024 in a chunk"));

  CHECK(contains(fault_of_records({name, name}), "names of marks: found the same one twice in a chunk"));
  CHECK(fault_of_records({name, {RecordTag::marks, marks(0)}}).empty());
  CHECK(contains(fault_of_records({name, {RecordTag::marks, marks(1)}}), "a name that does not stand before"));
  CHECK(contains(fault_of_records({name, {RecordTag::marks, marks(0, 0)}}), "a name without marks"));
  CHECK(contains(fault_of_records({name, {RecordTag::marks, marks(0)}, {RecordTag::marks, marks(0)}}),
                 "marks: found a second record in one tick"));
  Bytes longer = marks(0);
  longer.push_back(0);
  CHECK(contains(fault_of_records({name, {RecordTag::marks, longer}}), "marks: sizes do not add up"));
  CHECK(contains(fault_of_records({{RecordTag::marks, Bytes(16'385)}}), "record size"));

  ByteWriter mark_list;
  mark_list.u8(0);
  while (mark_list.size() + 9 <= replay::mark_list_size_max) {
    mark_list.varint(0);
    mark_list.u64(4);
  }
  const Bytes largest = mark_list.take();
  CHECK(fault_of_records({name, {RecordTag::mark_list, largest}}).empty());
  CHECK(contains(fault_of_records({name, {RecordTag::mark_list, largest}, {RecordTag::mark_list, Bytes(10)}}),
                 "mark list: found more than 1048576 bytes in one tick"));
  CHECK(contains(fault_of_records({{RecordTag::mark_list, largest}}), "a name that does not stand before"));
  CHECK(contains(fault_of_records({name, {RecordTag::mark_list, {2}}}), "flags: found others than bit 0"));
  CHECK(contains(fault_of(setup_with(no_tail, Detail::root),
                          [&](Forger& forger) {
                            forger.open_ticks();
                            forger.record(RecordTag::name, name.second);
                            forger.record(RecordTag::mark_list, Bytes{0});
                          }),
                 "mark list: found one of a tick not stored in full"));

  for (const unsigned tag : {68u, 100u, 127u})
    CHECK(contains(fault_of_records({{static_cast<RecordTag>(tag), Bytes(3)}}),
                   "record tag: found " + std::to_string(tag) + ", expected 1..6, 15, 64..67 or 128..255"));
  std::vector<std::pair<RecordTag, Bytes>> many(1'000, {RecordTag::note, note(1, 4'096)});
  CHECK(fault_of_records(many).empty());
  many.insert(many.end(), 30, many[0]);
  CHECK(contains(fault_of_records(many), "records outside of the chain: found more than 4194304 bytes"));
}

TEST_CASE("a chunk or record whose feature is off is refused", "[replay][third][forgery][corruption]") {
  CHECK(contains(fault_of_records({{RecordTag::note, note(1, 1)}}, 0), "whose feature (notes) is off in the setup"));
  CHECK(contains(fault_of_records({{RecordTag::name, Bytes(1)}}, 0), "whose feature (marks) is off in the setup"));
  const auto of_chunk = [](ChunkKind kind, std::uint32_t features) {
    return fault_of(setup_with(features), [&](Forger& forger) { forger.content(kind, Bytes(3)); });
  };
  CHECK(of_chunk(ChunkKind::save, no_tail).empty());
  CHECK(contains(of_chunk(ChunkKind::save, 0), "(save): kind: found 10, expected checkpoint, ticks or end"));
  CHECK(contains(of_chunk(ChunkKind::shown, 0), "(shown): kind: found 9"));
  CHECK(contains(of_chunk(ChunkKind::peer, 0), "(peer): kind: found 11"));
  replay::TraceSetup setup = setup_with(0);
  setup.features = 64;
  ByteWriter payload;
  replay::encode_setup(setup, payload);
  const auto decoded = replay::decode_setup(payload.view(), replay::format_version_third);
  REQUIRE(!decoded);
  CHECK(contains(decoded.error().message, "features: found bit 6, expected bits 0..5"));
}

Bytes encoded(const replay::PeerRecord& peer) {
  ByteWriter out;
  replay::encode_peer(peer, out);
  return out.take();
}

/// A player of the session of setup_with, who has other rows. Player 254 records.
replay::PeerRecord peer_of(std::size_t player) {
  replay::PeerRecord peer;
  peer.player = static_cast<std::uint32_t>(player);
  peer.recorder = 254 - (player == 254 ? 1 : 0);
  peer.session_identity = replay::session_identity(setup_with(no_tail));
  peer.tick = 8;
  peer.roots = {{7, 1}, {8, 2}};
  peer.has_state = true;
  peer.tables = {{1, {0, 4}, {0, 3}, {5, 6}}};
  return peer;
}

TEST_CASE("saves and peers stand where they must", "[replay][third][forgery][corruption]") {
  const auto of = [](const std::function<void(Forger&)>& write) { return fault_of(setup_with(no_tail), write); };
  CHECK(contains(of([](Forger& forger) {
                   forger.content(ChunkKind::save, Bytes(3));
                   forger.content(ChunkKind::save, Bytes(3));
                 }),
                 "a save directly behind a checkpoint alone, at most one"));
  CHECK(contains(of([](Forger& forger) {
                   forger.chunk(0x90, Bytes(1));
                   forger.content(ChunkKind::save, Bytes(3));
                 }),
                 "a save directly behind a checkpoint alone"));
  CHECK(contains(of([](Forger& forger) {
                   full_tick(forger, list(1, {}));
                   forger.content(ChunkKind::save, Bytes(3));
                 }),
                 "a save directly behind a checkpoint alone"));
  CHECK(contains(of([](Forger& forger) { forger.content(ChunkKind::save, Bytes(3), false, 1ull << 40); }),
                 "save: size: found 1099511627776, expected at most 268435456"));
  CHECK(contains(of([](Forger& forger) {
                   forger.content(ChunkKind::save, Bytes(replay::image_part_size), true, 2 * replay::image_part_size);
                   forger.chunk(0x90, Bytes(1));
                 }),
                 "the next part of a shown image or a save"));
  const auto peers = [&](std::size_t count, bool has_more) {
    return of([&](Forger& forger) {
      for (std::size_t i = 0; i < count; ++i) forger.bound_chunk(ChunkKind::peer, encoded(peer_of(i)));
      if (!has_more) return;
      forger.open_ticks();
      forger.close_ticks();
    });
  };
  CHECK(peers(254, false).empty());
  CHECK(contains(peers(1, true), "the end behind the peers"));
  // A peer that is lost leaves its place; one of 256 players would have number 255.
  const auto of_two = [&](const replay::PeerRecord& one, const replay::PeerRecord& other) {
    return of([&](Forger& forger) {
      forger.bound_chunk(ChunkKind::peer, encoded(one));
      forger.bound_chunk(ChunkKind::peer, encoded(other));
    });
  };
  CHECK(of_two(peer_of(3), peer_of(7)).empty());
  CHECK(contains(of_two(peer_of(3), peer_of(3)), "player: found 3 behind 3, expected them ascending"));
  CHECK(contains(of_two(peer_of(3), peer_of(2)), "player: found 2 behind 3, expected them ascending"));
  replay::PeerRecord other = peer_of(7);
  other.recorder = 9;
  CHECK(contains(of_two(peer_of(3), other), "another recorder or tick"));
  other = peer_of(7);
  other.tick = 4;
  CHECK(contains(of_two(peer_of(3), other), "another recorder or tick"));
}

TEST_CASE("a forged peer is refused: each limit holds, and one more is not", "[replay][third][forgery][corruption]") {
  const replay::TraceSetup setup = setup_with(no_tail);
  const auto fault = [&](const Bytes& payload) {
    return fault_of(setup, [&](Forger& forger) { forger.bound_chunk(ChunkKind::peer, payload); });
  };
  const auto fault_with = [&](const std::function<void(replay::PeerRecord&)>& change) {
    replay::PeerRecord peer = peer_of(3);
    change(peer);
    return fault(encoded(peer));
  };
  CHECK(fault_with([](replay::PeerRecord&) {}).empty());
  CHECK(contains(fault(Bytes(5)), "peer: ends early"));
  Bytes more = encoded(peer_of(3));
  more.push_back(0);
  CHECK(contains(fault(more), "bytes follow"));
  for (std::size_t size = 0; size < encoded(peer_of(3)).size(); ++size) {
    const Bytes whole = encoded(peer_of(3));
    CAPTURE(size);
    CHECK(contains(fault(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), "(peer): peer: "));
  }
  CHECK(fault_with([](replay::PeerRecord& peer) { peer.player = 254, peer.recorder = 0; }).empty());
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.player = 255; }),
                 "player: found 255, expected at most 254"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.player = peer.recorder; }), "who recorded"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.tick = limits::tick_count_max; }), "tick: found"));
  const auto with_roots = [&](std::size_t count) {
    return fault_with([count](replay::PeerRecord& peer) {
      peer.roots.clear();
      for (std::size_t i = 0; i < count; ++i) peer.roots.push_back({i, i});
    });
  };
  CHECK(with_roots(replay::peer_root_count_max).empty());
  CHECK(contains(with_roots(replay::peer_root_count_max + 1), "roots: found 65537, expected at most 65536"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) {
                   peer.roots = {{limits::tick_count_max, 1}, {limits::tick_count_max + 1, 1}};
                 }),
                 "behind the last that there can be"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.facts.assign(257, {"a", "b"}); }), "facts: found 257"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.has_state = false; }), "of a state that is not known"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) {
                   peer.has_state = false;
                   peer.tables.clear();
                   peer.is_cut = true;
                 }),
                 "flags: found"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.lost_state = true; }), "flags: found"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.cells = Bytes(3); }), "cells: found no list"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.tables[0].table = table_count; }), "are of no table"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.tables[0].removed = {4, 4}; }), "do not ascend"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.tables[0] = {}; }), "found no row"));
  CHECK(contains(fault_with([](replay::PeerRecord& peer) { peer.session_identity ^= 1; }),
                 "rows: found those of another game"));
  const auto with_rows = [&](std::size_t count) {
    return fault_with([count](replay::PeerRecord& peer) {
      peer.tables[0].removed.clear();
      peer.tables[0].rows.clear();
      for (std::uint32_t i = 0; i < count; ++i) peer.tables[0].rows.push_back(i);
      peer.tables[0].bytes = Bytes(count);
    });
  };
  CHECK(with_rows(replay::peer_row_count_max).empty());
  CHECK(contains(with_rows(replay::peer_row_count_max + 1), "rows: found 65537, expected at most 65536"));
  // Counts that the bytes cannot hold are refused before anything is made of them.
  Bytes counts = encoded(peer_of(3));
  const std::size_t at = counts.size() - 14;  // the count of the rows of its table
  for (std::size_t i = 0; i < 4; ++i) counts[at + i] = 0xff;
  CHECK(contains(fault(counts), "(peer): peer: "));
}

TEST_CASE("a peer is read as it was written", "[replay][third]") {
  const replay::TraceSetup setup = setup_with(no_tail);
  replay::PeerRecord peer = peer_of(3);
  peer.is_cut = true;
  peer.inputs = replay::inputs_of(0.25, Bytes(100, 7));
  peer.facts = {{"compiler", "x"}, {"caller.fused", "yes"}};
  peer.roots = {{5, 1}, {6, 2}, {9, 3}, {1000, 4}};
  const auto read = replay::decode_peer(setup.schema, encoded(peer));
  REQUIRE(read);
  CHECK(*read == peer);
  CHECK(read->inputs->begin.size() == replay::input_begin_max);
  CHECK(read->root_at(9) == 3);
  CHECK(!read->root_at(7));
  CHECK(!read->root_at(1001));
  replay::PeerRecord nothing;
  nothing.player = 1;
  nothing.lost_state = true;
  const auto empty = replay::decode_peer(setup.schema, encoded(nothing));
  REQUIRE(empty);
  CHECK(*empty == nothing);
}

TEST_CASE("what saves unpack to is bounded by the file", "[replay][third][forgery][limits]") {
  SKIP_UNLESS(replay::has_codec(replay::Codec::zstd), "a build without zstd");
  // One save: its parts unpack to many times the bytes of the file.
  const Bytes part(replay::image_part_size);
  Forger forger = begin_third(setup_with(no_tail));
  forger.list(ChunkKind::checkpoint, whole_list);
  for (std::uint64_t i = 0; i < 60; ++i) {
    replay::ImagePart fields;
    fields.image_size = 60 * part.size();
    fields.offset = i * part.size();
    fields.size = static_cast<std::uint32_t>(part.size());
    ByteWriter payload;
    replay::encode_image_part(fields, part, true, payload);
    forger.bound_chunk(ChunkKind::save, payload.view());
  }
  CHECK(contains(read_third(forger.take()).tail.message, "save: state image: bytes: found "));
  // Many of them, each small enough alone.
  Forger many = begin_third(setup_with(no_tail));
  for (std::uint64_t tick = 0; tick < 2'000; ++tick) {
    many.list(ChunkKind::checkpoint, whole_list);
    many.content(ChunkKind::save, part, true);
    many.open_ticks();
    many.record(RecordTag::root, number(1));
    many.close_ticks();
  }
  const Bytes bytes = many.take();
  REQUIRE(bytes.size() < 2'000 * 600);
  CHECK(contains(read_third(bytes).tail.message, "bytes of all images"));
}

TEST_CASE("a state that grows by changes is bounded by the file", "[replay][third][forgery][limits]") {
  SKIP_UNLESS(replay::has_codec(replay::Codec::zstd), "a build without zstd");
  replay::TraceSetup setup = setup_with(no_tail);
  const TableSchema table = setup.schema.tables[0];
  setup.schema.tables.clear();
  for (std::size_t t = 0; t < 200; ++t) {
    setup.schema.tables.push_back(table);
    setup.schema.tables.back().name += std::to_string(t);
  }
  Forger forger = begin_third(setup);
  forger.list(ChunkKind::checkpoint, list(0, {}));
  const std::uint32_t size = 900'000;  // of each table
  for (std::uint64_t t = 0; t < 100; ++t) {
    const Bytes image = list(1, {{t, size, 0}});
    forger.open_ticks();
    forger.record(RecordTag::root_image, number(1));
    forger.close_ticks();
    forger.image(ChunkKind::image, 1, image, image.size(), true, SIZE_MAX);
  }
  const ThirdTrace all = read_third(forger.take());
  CHECK(contains(all.tail.message, "state image: bytes of all its tables: found "));
  CHECK(all.ticks.size() < 20);
}

TEST_CASE("the time and the first tick are what they may be", "[replay][third][forgery][corruption]") {
  const auto of = [](std::uint32_t features, std::uint64_t tick, double time_s) {
    Forger forger = begin_third(setup_with(features));
    forger.begin_at(tick);
    forger.list(ChunkKind::checkpoint, whole_list, whole_list.size(), time_s);
    const ThirdTrace all = read_third(forger.take());
    return all.tail.condition == TraceCondition::damaged ? all.tail.message : std::string();
  };
  CHECK(of(no_tail, 0, 3.5).empty());
  for (const double time_s : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0})
    CHECK(contains(of(no_tail, 0, time_s), "state image: time: found no finite length of time"));
  CHECK(of(all_features, 5, 1).empty());
  CHECK(of(all_features, limits::tick_count_max, 1).empty());
  CHECK(contains(of(all_features, limits::tick_count_max + 1, 1), "first tick: found 1099511627777, expected 0"));
  CHECK(contains(of(no_tail, 5, 1), "first tick: found 5, expected 0"));
  // A second checkpoint, and the end, before the first.
  Forger forger = begin_third(setup_with(all_features));
  forger.begin_at(9);
  forger.list(ChunkKind::checkpoint, whole_list);
  forger.begin_at(4);
  ByteWriter end;
  replay::encode_end({replay::EndReason::complete, 4, ""}, end);
  forger.end(end.view());
  CHECK(contains(read_third(forger.take()).tail.message, "first tick: found 4, expected 9"));
}

TEST_CASE("stage hashes stand in the full range and in ticks that the interval divides",
          "[replay][third][forgery][corruption]") {
  replay::TraceSetup setup = setup_with(no_tail, Detail::root);
  setup.stage_interval = 2;
  setup.stages = {"move"};
  const auto of = [&](std::uint64_t tick_with_stages) {
    return fault_of(setup, [&](Forger& forger) {
      forger.open_ticks();
      for (std::uint64_t tick = 0; tick < 4; ++tick) {
        if (tick == tick_with_stages) forger.record(RecordTag::stages, number(1));
        forger.record(RecordTag::root, number(1));
      }
      forger.close_ticks();
    });
  };
  CHECK(of(0).empty());
  CHECK(of(2).empty());
  CHECK(contains(of(1), "stage hashes: found 1 where the setup has none or 1"));
}

/// Rows of one byte, and texts of them in pieces of four bytes, whose owners are numbers of rows.
replay::TraceSetup setup_with_texts() {
  replay::TraceSetup setup = setup_with(no_tail);
  setup.schema.tables.resize(1);
  TableSchema& texts = setup.schema.tables.emplace_back();
  texts.name = "texts";
  texts.form = TableForm::text;
  texts.parent = 0;
  texts.key_column_count = 2;
  for (const char* name : {"owner", "index", "size", "bytes"}) {
    Column& column = texts.columns.emplace_back();
    column.name = name;
    column.offset = static_cast<std::uint16_t>(texts.row_size);
    texts.row_size += 4;
  }
  return setup;
}

struct Piece {
  std::uint32_t owner = 0;
  std::uint32_t index = 0;
  std::uint32_t size = 0;
  std::uint32_t bytes = 0;
};

/// With base 1, the texts alone.
Bytes texts_list(std::uint8_t base, const std::vector<Piece>& pieces) {
  ByteWriter out;
  out.u8(base);
  out.varint(base == 0 ? 2 : 1);
  if (base == 0) {
    out.varint(0);
    out.u32(2);  // rows
    out.u16(0);
  }
  out.varint(base == 0 ? 0 : 1);
  out.u32(static_cast<std::uint32_t>(pieces.size()));
  for (const Piece& piece : pieces)
    for (const std::uint32_t value : {piece.owner, piece.index, piece.size, piece.bytes}) out.u32(value);
  return out.take();
}

TEST_CASE("a reader refuses pieces of texts that break a rule", "[replay][third][forgery][corruption][children]") {
  const std::vector<Piece> good{{0, 0, 4, 0x61616161}, {0, 1, 2, 0x6161}, {1, 0, 1, 0x61}};
  const auto of = [&](const std::vector<Piece>& pieces, bool in_tick) {
    Forger forger = begin_third(setup_with_texts());
    forger.list(ChunkKind::checkpoint, texts_list(0, in_tick ? good : pieces));
    if (in_tick) full_tick(forger, texts_list(1, pieces));
    const ThirdTrace all = read_third(forger.take());
    return all.tail.condition == TraceCondition::damaged ? all.tail.message : std::string();
  };
  CHECK(of(good, false).empty());
  CHECK(of({good[0], good[1]}, true).empty());
  struct Case {
    std::vector<Piece> pieces;
    std::string message;
  };
  const std::vector<Case> cases{
      {{{2, 0, 1, 0x61}}, "texts[0]: owner: found 2, expected a row of t0, which has 2"},
      {{{0, 0, 4, 0x61616161}, {0, 2, 1, 0x61}}, "texts[1]: index: found 2, expected 1: it counts without gap"},
      {{{0, 1, 1, 0x61}}, "texts[0]: index: found 1, expected 0"},
      {{{0, 0, 3, 0x616161}, {0, 1, 1, 0x61}}, "texts[0]: size: found 3, expected 4: another piece follows"},
      {{{0, 0, 0, 0}}, "texts[0]: size: found 0, expected 1..4"},
      {{{0, 0, 0xffffffff, 0}}, "texts[0]: size: found 4294967295, expected 1..4"},
      {{{1, 0, 2, 0x616161}}, "texts[0]: byte 2, which is unused: found 97, expected 0"},
      {{{1, 0, 1, 0x61}, {0, 0, 1, 0x61}}, "texts[1]: owner: found 0, expected at least 1"},
  };
  for (const Case& one : cases)
    for (const bool in_tick : {false, true}) {
      CAPTURE(one.message, in_tick);
      const std::string message = of(one.pieces, in_tick);
      CAPTURE(message);
      CHECK(contains(message, one.message));
    }
}

}  // namespace
}  // namespace ticktrue::test
