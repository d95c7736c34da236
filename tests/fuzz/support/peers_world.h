// A player of a live game in memory, one tick old: what the harness of messages talks to, and what makes its seeds.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>

#include "base/state/state_view.h"
#include "capi/peers/peers.h"

namespace ticktrue::fuzz {

struct PeersWorld {
  StateSchema schema;
  Bytes units;
  Bytes links;
  std::unique_ptr<capi::Peers> peers;
  std::uint32_t player = 0;

  /// `change`: of a value. `player`: 0 or 1, the other is the peer.
  explicit PeersWorld(std::uint32_t own_player = 0, std::uint8_t change = 0) : player(own_player) {
    TableSchema unit_table{"units", {{"id", ScalarType::u32}, {"place", ScalarType::f32, 2}}, 12, 1};
    unit_table.columns[1].offset = 4;
    TableSchema link_table{"links", {{"unit", ScalarType::u32}, {"kind", ScalarType::u8}}, 5, 0};
    link_table.columns[0].target = 0;
    link_table.columns[0].optional = true;
    link_table.columns[1].offset = 4;
    schema.tables = {unit_table, link_table};
    units.assign(12 * 5, 0);
    links.assign(5 * 7, 0);
    for (std::size_t i = 0; i < 5; ++i) units[12 * i] = static_cast<std::uint8_t>(3 * i);
    for (std::size_t i = 0; i < 7; ++i) links[5 * i] = static_cast<std::uint8_t>(3 * (i % 5));
    units[12 * 2 + 5] = change;
    links[5 * 3 + 4] = change;
    peers = std::make_unique<capi::Peers>(player, capi::KeptTicks::size_default);
    replay::TraceSetup setup;
    setup.simulation = "fuzz";
    setup.dt = 0.5;
    setup.schema = schema;
    peers->set_game(setup, {{"version", "1"}, {"caller.fused", "no"}});
    peers->keep_states();
    const Bytes inputs{1, 2, 3};
    peers->add(0, root_hash(view()), 0.5, inputs, view());
  }
  /// Of this object, which must stay where it is.
  StateView view() const { return {&schema, {{units.data(), 5}, {links.data(), 7}}}; }
  /// The first bytes of a message that comes to this player from the other.
  Bytes fields() const {
    PeersWorld other(1 - player, 9);
    other.peers->add_root(player, 0, root_hash(view()));
    return other.peers->next_message(player, 300);
  }
};

}  // namespace ticktrue::fuzz
