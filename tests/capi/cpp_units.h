// A struct with every kind of member that TICKTRUE_COLUMNS takes, and the same columns in words of the C interface.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ticktrue.hpp>
#include <vector>

namespace ticktrue_example {

struct Vec2 {
  float x, y;
};
struct Vec3 {
  double x, y, z;
};
/// As in vector libraries: several names for the same bytes.
struct Vec4 {
  union {
    float x, r;
  };
  union {
    float y, g;
  };
  union {
    float z, b;
  };
  union {
    float w, a;
  };
};
struct Matrix {
  float at[4];
  float trace() const { return at[0] + at[3]; }
};
enum class Team : std::uint8_t { red, blue };
enum Order : int { wait = -1, move = 1 };

/// With padding inside and behind.
struct Slot {
  std::uint8_t item;
  std::uint32_t count;
  bool is_used;
};
TICKTRUE_COLUMNS(Slot, item, count, is_used)

struct Base {
  std::uint32_t id;
};

struct Unit : Base {
  bool is_alive;
  char letter;
  std::int8_t mood;
  std::uint8_t level;
  std::int16_t hp;
  std::uint16_t armor;
  std::int32_t gold;
  std::uint32_t flags;
  std::int64_t score;
  std::uint64_t seed;
  float heat;
  double mass;
  Team team;
  Order order;
  Vec2 pos;
  Vec3 far;
  Vec4 color;
  Matrix turn;
  std::array<std::uint16_t, 3> ammo;
  double wear[2];
  Vec2 corners[2];
  bool doors[3];
  Slot hand;
  std::array<Slot, 2> bag;
  std::uint32_t target;
  float glow;
  const char* name;
};

}  // namespace ticktrue_example

template <>
struct ticktrue::lanes<ticktrue_example::Matrix> : ticktrue::lanes_of<float, 4> {};

namespace ticktrue_example {

TICKTRUE_COLUMNS(Unit, key(id), is_alive, letter, mood, level, hp, armor, gold, flags, score, seed, heat, mass, team,
                 order, pos, far, color, turn, ammo, wear, corners, doors, hand, bag, reference(target, "units"),
                 shown(glow))

/// The columns that the line above stands for.
struct ExpectedColumn {
  const char* name;
  int type;
  std::uint32_t lanes;
  std::size_t offset;  // bytes
};

inline std::vector<ExpectedColumn> expected_columns() {
  const Unit unit{};
  const auto at = [&unit](const auto& member) {
    return static_cast<std::size_t>(reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&unit));
  };
  return {{"id", TICKTRUE_U32, 1, at(unit.id)},
          {"is_alive", TICKTRUE_U8, 1, at(unit.is_alive)},
          {"letter", TICKTRUE_U8, 1, at(unit.letter)},
          {"mood", TICKTRUE_U8, 1, at(unit.mood)},
          {"level", TICKTRUE_U8, 1, at(unit.level)},
          {"hp", TICKTRUE_U16, 1, at(unit.hp)},
          {"armor", TICKTRUE_U16, 1, at(unit.armor)},
          {"gold", TICKTRUE_I32, 1, at(unit.gold)},
          {"flags", TICKTRUE_U32, 1, at(unit.flags)},
          {"score", TICKTRUE_I64, 1, at(unit.score)},
          {"seed", TICKTRUE_U64, 1, at(unit.seed)},
          {"heat", TICKTRUE_F32, 1, at(unit.heat)},
          {"mass", TICKTRUE_F64, 1, at(unit.mass)},
          {"team", TICKTRUE_U8, 1, at(unit.team)},
          {"order", TICKTRUE_I32, 1, at(unit.order)},
          {"pos", TICKTRUE_F32, 2, at(unit.pos)},
          {"far", TICKTRUE_F64, 3, at(unit.far)},
          {"color", TICKTRUE_F32, 4, at(unit.color)},
          {"turn", TICKTRUE_F32, 4, at(unit.turn)},
          {"ammo", TICKTRUE_U16, 3, at(unit.ammo)},
          {"wear", TICKTRUE_F64, 2, at(unit.wear)},
          {"corners", TICKTRUE_F32, 4, at(unit.corners)},
          {"doors", TICKTRUE_U8, 3, at(unit.doors)},
          {"hand.item", TICKTRUE_U8, 1, at(unit.hand.item)},
          {"hand.count", TICKTRUE_U32, 1, at(unit.hand.count)},
          {"hand.is_used", TICKTRUE_U8, 1, at(unit.hand.is_used)},
          {"bag[0].item", TICKTRUE_U8, 1, at(unit.bag[0].item)},
          {"bag[0].count", TICKTRUE_U32, 1, at(unit.bag[0].count)},
          {"bag[0].is_used", TICKTRUE_U8, 1, at(unit.bag[0].is_used)},
          {"bag[1].item", TICKTRUE_U8, 1, at(unit.bag[1].item)},
          {"bag[1].count", TICKTRUE_U32, 1, at(unit.bag[1].count)},
          {"bag[1].is_used", TICKTRUE_U8, 1, at(unit.bag[1].is_used)},
          {"target", TICKTRUE_U32, 1, at(unit.target)},
          {"glow", TICKTRUE_F32 | TICKTRUE_SHOWN, 1, at(unit.glow)}};
}

inline std::size_t scalar_size(int type) {
  switch (type & ~TICKTRUE_SHOWN) {
    case TICKTRUE_U8:
      return 1;
    case TICKTRUE_U16:
      return 2;
    case TICKTRUE_U32:
    case TICKTRUE_I32:
    case TICKTRUE_F32:
      return 4;
    default:
      return 8;
  }
}

/// A unit of a key, whose padding holds `filler`.
inline Unit make_unit(std::uint32_t id, int filler) {
  Unit unit;
  std::memset(static_cast<void*>(&unit), filler, sizeof unit);
  const auto set = [](auto& member) { std::memset(static_cast<void*>(&member), 0, sizeof member); };
  for (const ExpectedColumn& column : expected_columns())
    std::memset(reinterpret_cast<char*>(&unit) + column.offset, 0, scalar_size(column.type) * column.lanes);
  set(unit.name);
  unit.id = id;
  unit.target = 0xffffffffu;
  unit.mass = 1 + id;
  unit.seed = 0x9e3779b97f4a7c15ull * (id + 1);
  return unit;
}

/// Changes what a tick changes: some value of every column but id, target and the shown one.
inline void step(Unit& unit, std::uint32_t tick) {
  unit.seed = unit.seed * 6364136223846793005ull + 1442695040888963407ull;
  const auto bits = static_cast<std::uint32_t>(unit.seed >> 33);
  unit.is_alive = bits % 2 == 0;
  unit.letter = static_cast<char>('a' + bits % 26);
  unit.mood = static_cast<std::int8_t>(bits % 256 - 128);
  unit.level = static_cast<std::uint8_t>(tick);
  unit.hp = static_cast<std::int16_t>(-static_cast<int>(bits % 1000));
  unit.armor = static_cast<std::uint16_t>(bits);
  unit.gold -= static_cast<std::int32_t>(bits % 100);
  unit.flags ^= bits;
  unit.score -= bits;
  unit.heat += 0.25f;
  unit.mass *= 1.0009765625;
  unit.team = bits % 3 == 0 ? Team::blue : Team::red;
  unit.order = bits % 5 == 0 ? wait : move;
  unit.pos = {unit.pos.x + 0.5f, unit.pos.y - 0.125f};
  unit.far = {unit.far.x + 0.1, unit.far.y - 0.2, unit.far.z + 0.3};
  unit.color.x += 0.5f;
  unit.color.a += 0.25f;
  unit.turn.at[bits % 4] += 1;
  unit.ammo[bits % 3] = static_cast<std::uint16_t>(bits);
  unit.wear[bits % 2] += 0.01;
  unit.corners[bits % 2].y += 1;
  unit.doors[bits % 3] = !unit.doors[bits % 3];
  unit.hand.count += bits % 7;
  unit.bag[bits % 2].item = static_cast<std::uint8_t>(bits);
  unit.bag[1].is_used = bits % 4 == 0;
}

}  // namespace ticktrue_example
