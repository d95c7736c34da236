// Scenes with joints that tests build inline, and access to their state.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <string_view>

#include "engine/engine.h"
#include "engine/scene/scene_fields.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {

using engine::Joint;
using engine::JointKind;

constexpr double dt = 1.0 / 60;                       // s, tick length of these scenes
constexpr double pendulum_period_60 = 2.13232427506;  // s, of a pendulum of 1 m from 60 degrees, g = 10

/// A disc of 0.1 m radius with this mass and inertia.
inline Body bob(Point position, double mass = 1, double inertia = 0.01) {
  Body body = body_of(disc_shape(0.1), position);
  body.mass = engine::ExplicitMass{mass, inertia, {}};
  return body;
}

inline Body peg(Point position) {
  return body_of(disc_shape(0.05), position, BodyType::static_body);
}

inline Joint joint_of(JointKind kind, std::uint32_t body_a, std::uint32_t body_b) {
  Joint joint;
  joint.kind = kind;
  joint.body_a = body_a;
  joint.body_b = body_b;
  return joint;
}

/// Resets the fields that joints of this kind do not have to their defaults.
inline void drop_unused_fields(Joint& joint) {
  const auto& row = info_of(engine::joint_kinds, joint.kind);
  const Joint unset;
  engine::visit_own_fields(
      [&](const auto& field, auto& value, const auto& default_value) {
        if (key_of(row, field.own).empty()) value = default_value;
      },
      joint, unset);
}

inline engine::JointSpring absolute_spring(double stiffness, double damping = 0) {
  return {true, 0, 0, stiffness, damping};
}

/// One lane of a column of the table "joints". Requires: the row exists.
inline double joint_value(const engine::Engine& engine, std::size_t row, std::string_view column, int lane = 0) {
  const StateView& view = engine.state();
  const auto table = view.schema->find_table("joints");
  REQUIRE(table.has_value());
  REQUIRE(row < view.tables[*table].row_count);
  const TableSchema& schema = view.schema->tables[*table];
  for (const Column& c : schema.columns) {
    if (c.name != column) continue;
    const std::uint8_t* at = view.tables[*table].data + row * schema.row_size + c.offset;
    if (c.type == ScalarType::f32) {
      float value;
      std::memcpy(&value, at + 4 * lane, 4);
      return static_cast<double>(value);
    }
    if (c.type == ScalarType::f64) {
      double value;
      std::memcpy(&value, at + 8 * lane, 8);
      return value;
    }
    std::uint32_t value;
    std::memcpy(&value, at + 4 * lane, 4);
    return value;
  }
  FAIL("no such column");
  return 0;
}

inline std::size_t joint_count(const engine::Engine& engine) {
  const StateView& view = engine.state();
  const auto table = view.schema->find_table("joints");
  return table ? view.tables[*table].row_count : 0;
}

}  // namespace ticktrue::test
