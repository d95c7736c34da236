// A player of a live game in memory, one tick old: what the harness of messages talks to, and what makes its seeds.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/assert.h"
#include "base/state/gathered_state.h"
#include "capi/peers/peers.h"

namespace ticktrue::fuzz {

struct PeersWorld {
  struct Item {
    std::uint8_t kind = 0;
    std::string label;
  };
  struct Unit {
    std::uint32_t id = 0;
    float place[2] = {0, 0};
    std::string name;
    std::vector<std::uint8_t> picture;
    std::vector<Item> bag;
  };
  struct Link {
    std::uint32_t unit = 0;
    std::uint8_t kind = 0;
  };

  std::vector<Unit> units{5};
  std::vector<Link> links{7};
  GatheredState state;
  const StateSchema& schema = state.schema();
  std::unique_ptr<capi::Peers> peers;
  std::uint32_t player = 0;

  /// `change`: of a value, a text and an element. `player`: 0 or 1, the other is the peer.
  explicit PeersWorld(std::uint32_t own_player = 0, std::uint8_t change = 0) : player(own_player) {
    for (std::size_t i = 0; i < units.size(); ++i) {
      units[i].id = static_cast<std::uint32_t>(3 * i);
      units[i].name = "a unit with a long name, and the number " + std::to_string(i);
      units[i].picture.assign(30 * i, 7);
      units[i].bag = {{1, "axe"}, {2, ""}};
    }
    for (std::size_t i = 0; i < links.size(); ++i) links[i].unit = static_cast<std::uint32_t>(3 * (i % 5));
    units[2].place[0] = static_cast<float>(change);
    links[3].kind = change;
    if (change != 0) {
      units[1].name[3] = static_cast<char>('a' + change);
      units[2].picture[9] = change;
      units[4].bag.push_back({change, "rope"});
    }
    register_tables();
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
  PeersWorld(const PeersWorld&) = delete;
  PeersWorld& operator=(const PeersWorld&) = delete;

  const StateView& view() const { return state.view(); }
  /// The first bytes of a message that comes to this player from the other.
  Bytes fields() const {
    PeersWorld other(1 - player, 9);
    other.peers->add_root(player, 0, root_hash(view()));
    return other.peers->next_message(player, 300);
  }

 private:
  template <typename List>
  static const void* first_of(const List& list, std::size_t* count) {
    *count = list.size();
    return list.data();
  }

  void register_tables() {
    const auto name = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return first_of(static_cast<const Unit*>(owner)->name, count);
    };
    const auto picture = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return first_of(static_cast<const Unit*>(owner)->picture, count);
    };
    const auto bag = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return first_of(static_cast<const Unit*>(owner)->bag, count);
    };
    const auto label = [](void*, const void* owner, std::uint32_t, std::size_t* count) {
      return first_of(static_cast<const Item*>(owner)->label, count);
    };
    const RowMember unit[] = {{"id", ScalarType::u32, 1, offsetof(Unit, id)},
                              {"place", ScalarType::f32, 2, offsetof(Unit, place)}};
    const RowMember link[] = {{"unit", ScalarType::u32, 1, offsetof(Link, unit)},
                              {"kind", ScalarType::u8, 1, offsetof(Link, kind)}};
    const RowMember item[] = {{"kind", ScalarType::u8, 1, offsetof(Item, kind)}};
    const auto unit_table = state.table("units", sizeof(Unit), unit);
    const auto link_table = state.table("links", sizeof(Link), link);
    TICKTRUE_ASSERT(unit_table && link_table && state.key("units", 1) && state.reference("links", "unit", "units"));
    TICKTRUE_ASSERT(state.child("units.name", "units", {TableForm::text, name, nullptr, 1}, {}));
    TICKTRUE_ASSERT(state.child("units.picture", "units", {TableForm::bytes, picture, nullptr, 1}, {}));
    TICKTRUE_ASSERT(state.child("units.bag", "units", {TableForm::rows, bag, nullptr, sizeof(Item)}, item));
    TICKTRUE_ASSERT(state.child("units.bag.label", "units.bag", {TableForm::text, label, nullptr, 1}, {}));
    TICKTRUE_ASSERT(state.rows(*unit_table, units.data(), static_cast<std::uint32_t>(units.size())));
    TICKTRUE_ASSERT(state.rows(*link_table, links.data(), static_cast<std::uint32_t>(links.size())));
    TICKTRUE_ASSERT(state.freeze() && state.gather());
  }
};

}  // namespace ticktrue::fuzz
