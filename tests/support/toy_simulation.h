// A tiny deterministic simulation with every kind of column, for tests of recording, reading and verifying.
// SPDX-License-Identifier: MIT
//
// Bodies drift in the plane, pull each other through links, and change by inputs. Its tables: world (one row), bodies
// (keyed by id), links (keyed by the ids of both bodies). Stages: inputs, forces, move.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/simulation.h"
#include "base/state/state_view.h"

namespace ticktrue::test {

struct ToyWorld {
  double gravity = -9.8125;  // m/s^2
  std::uint64_t tick_count = 0;
  std::uint32_t next_id = 0;
  std::int32_t score = 0;
};
struct ToyBody {
  std::uint32_t id = 0;
  std::uint32_t partner = no_reference;
  double position[2] = {0, 0};  // m
  float velocity[2] = {0, 0};   // m/s
  std::int32_t charge = 0;
  std::uint16_t hits = 0;
  std::uint8_t kind = 0;
  std::uint8_t asleep = 0;
};
struct ToyLink {
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  float stiffness = 0;
};
static_assert(sizeof(ToyWorld) == 24 && sizeof(ToyBody) == 40 && sizeof(ToyLink) == 12, "rows have no padding");

enum class ToyEvent : std::uint8_t { push = 1, spawn = 2, remove = 3, gravity = 4, poison = 5 };

/// The toy's canonical input bytes: events of u8 kind, u32 body id, f64 value.
class ToyInputs {
 public:
  ToyInputs& push(std::uint32_t id, double value) { return add(ToyEvent::push, id, value); }
  ToyInputs& spawn(double x) { return add(ToyEvent::spawn, 0, x); }
  ToyInputs& remove(std::uint32_t id) { return add(ToyEvent::remove, id, 0); }
  ToyInputs& gravity(double value) { return add(ToyEvent::gravity, 0, value); }
  /// Makes a velocity infinite, for tests of states that are not finite.
  ToyInputs& poison(std::uint32_t id) { return add(ToyEvent::poison, id, 0); }
  Bytes take() { return out_.take(); }

 private:
  ToyInputs& add(ToyEvent kind, std::uint32_t id, double value) {
    out_.u8(static_cast<std::uint8_t>(kind));
    out_.u32(id);
    out_.f64(value);
    return *this;
  }
  ByteWriter out_;
};

class ToySimulation : public Simulation {
 public:
  static constexpr std::size_t input_stage = 0, force_stage = 1, move_stage = 2;

  explicit ToySimulation(std::uint32_t body_count) {
    for (std::uint32_t i = 0; i < body_count; ++i) spawn(1.5 * i, 0.25 * i);
    for (std::uint32_t i = 0; i + 1 < body_count; i += 2) {
      bodies[i].partner = i + 1;
      links.push_back({i, i + 1, 0.5F});
    }
    refresh();
  }
  // The view points to this object's rows, so the object cannot be copied.
  ToySimulation(const ToySimulation&) = delete;
  ToySimulation& operator=(const ToySimulation&) = delete;

  static Bytes setup(std::uint32_t body_count) {
    ByteWriter out;
    out.u32(body_count);
    return out.take();
  }
  static Result<std::unique_ptr<Simulation>> make(ByteView setup) {
    ByteReader in(setup);
    const std::uint32_t body_count = in.u32();
    if (!in.ok() || !in.at_end())
      return Error{ErrorCode::corrupt, "toy setup: size: found another, expected 4 bytes", ""};
    if (body_count > 100'000) return Error{ErrorCode::limit, "toy setup: body count: too many", ""};
    return std::unique_ptr<Simulation>(std::make_unique<ToySimulation>(body_count));
  }

  static const StateSchema& schema() {
    static const StateSchema made = make_schema();
    return made;
  }
  static const std::vector<std::string>& stages() {
    static const std::vector<std::string> names{"inputs", "forces", "move"};
    return names;
  }

  Status accept(const TickInput& input) const override {
    ByteReader in(input.inputs);
    std::uint32_t next_id = world.next_id;
    while (in.ok() && !in.at_end()) {
      const auto kind = static_cast<ToyEvent>(in.u8());
      const std::uint32_t id = in.u32();
      in.f64();
      if (kind < ToyEvent::push || kind > ToyEvent::poison)
        return Error{ErrorCode::invalid_input, "toy input: kind: found an unknown one, expected 1..5", ""};
      if (kind == ToyEvent::spawn) ++next_id;
      if (id >= next_id && kind != ToyEvent::spawn && kind != ToyEvent::gravity)
        return Error{ErrorCode::invalid_input, "toy input: body " + std::to_string(id) + ": no such id was issued", ""};
    }
    if (!in.ok()) return Error{ErrorCode::invalid_input, "toy input: size: found a part of an event", ""};
    return {};
  }

  Status step(const TickInput& input, StageObserver* observer) override {
    apply(input.inputs);
    finish_stage(input_stage, observer);
    for (const ToyLink& link : links) {
      ToyBody* a = find(link.body_a);
      ToyBody* b = find(link.body_b);
      for (int lane = 0; lane < 2; ++lane) {
        const float pull = link.stiffness * static_cast<float>((b->position[lane] - a->position[lane]) * input.dt);
        a->velocity[lane] += pull;
        b->velocity[lane] -= pull;
      }
    }
    finish_stage(force_stage, observer);
    for (ToyBody& body : bodies) {
      body.velocity[1] += static_cast<float>(world.gravity * input.dt);
      for (int lane = 0; lane < 2; ++lane) body.position[lane] += static_cast<double>(body.velocity[lane]) * input.dt;
      if (body.position[1] < 0) {
        body.position[1] = -body.position[1];
        body.velocity[1] = -0.75F * body.velocity[1];
        ++body.hits;
        world.score += body.charge;
      }
    }
    ++world.tick_count;
    finish_stage(move_stage, observer);
    return {};
  }

  const StateView& state() const override { return view_; }

  Status load(ByteView image) override {
    const Result<std::vector<ImageTable>> tables = check_image(schema(), image);
    if (!tables) return tables.error();
    if ((*tables)[0].row_count != 1)
      return Error{ErrorCode::corrupt, "toy image: world rows: found another number, expected 1", ""};
    decode(0, (*tables)[0], &world);
    bodies.assign((*tables)[1].row_count, {});
    decode(1, (*tables)[1], bodies.data());
    links.assign((*tables)[2].row_count, {});
    decode(2, (*tables)[2], links.data());
    refresh();
    return {};
  }

  std::span<const std::string> stage_names() const override { return stages(); }

  std::string row_name(std::size_t table, std::size_t row) const override {
    return table == 1 && row < bodies.size() ? "toy_" + std::to_string(bodies[row].id) : "";
  }

  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    static constexpr const char* names[] = {"push", "spawn", "remove", "gravity", "poison"};
    std::string text;
    ByteReader in(inputs);
    while (in.ok() && !in.at_end()) {
      const unsigned kind = in.u8();
      const std::uint32_t id = in.u32();
      const double value = in.f64();
      if (!in.ok() || kind < 1 || kind > 5) return "";
      text += "{\"tick\":" + std::to_string(tick) + ",\"type\":\"" + names[kind - 1] +
              "\",\"body\":" + std::to_string(id) + ",\"value\":" + std::to_string(value) + "}\n";
    }
    return text;
  }

  /// The rows themselves. A test may change values between ticks, and calls refresh() after adding or removing rows.
  ToyWorld world;
  std::vector<ToyBody> bodies;  // by id
  std::vector<ToyLink> links;   // by (body_a, body_b)
  void refresh() {
    view_.schema = &schema();
    view_.tables = {rows(&world, 1), rows(bodies.data(), bodies.size()), rows(links.data(), links.size())};
  }

  /// Called after each stage, before the observer, so that a test can inject a fault.
  std::function<void(ToySimulation&, std::size_t stage)> disturb;

 private:
  static StateSchema make_schema() {
    StateSchema schema;
    schema.tables.resize(3);
    TableSchema& world_table = schema.tables[0];
    world_table.name = "world";
    add(world_table, "gravity", ScalarType::f64, 1);
    add(world_table, "tick_count", ScalarType::u64, 1);
    add(world_table, "next_id", ScalarType::u32, 1);
    add(world_table, "score", ScalarType::i32, 1);
    TableSchema& body_table = schema.tables[1];
    body_table.name = "bodies";
    body_table.key_column_count = 1;
    add(body_table, "id", ScalarType::u32, 1);
    Column& partner = add(body_table, "partner", ScalarType::u32, 1);
    partner.target = 1;
    partner.optional = true;
    add(body_table, "position", ScalarType::f64, 2);
    add(body_table, "velocity", ScalarType::f32, 2);
    add(body_table, "charge", ScalarType::i32, 1);
    add(body_table, "hits", ScalarType::u16, 1);
    add(body_table, "kind", ScalarType::u8, 1).max = 3;
    add(body_table, "asleep", ScalarType::u8, 1).max = 1;
    TableSchema& link_table = schema.tables[2];
    link_table.name = "links";
    link_table.key_column_count = 2;
    add(link_table, "body_a", ScalarType::u32, 1).target = 1;
    add(link_table, "body_b", ScalarType::u32, 1).target = 1;
    add(link_table, "stiffness", ScalarType::f32, 1);
    return schema;
  }
  static Column& add(TableSchema& table, const char* name, ScalarType type, std::uint8_t lane_count) {
    static constexpr std::uint8_t sizes[] = {1, 2, 4, 8, 4, 8, 4, 8};  // by ScalarType, u8 first
    Column column;
    column.name = name;
    column.type = type;
    column.lane_count = lane_count;
    column.offset = static_cast<std::uint16_t>(table.row_size);
    table.row_size += static_cast<std::uint32_t>(sizes[static_cast<std::size_t>(type) - 1]) * lane_count;
    table.columns.push_back(std::move(column));
    return table.columns.back();
  }

  template <typename Row>
  static TableRows rows(const Row* first, std::size_t row_count) {
    static_assert(std::is_trivially_copyable_v<Row>);
    return {reinterpret_cast<const std::uint8_t*>(first), static_cast<std::uint32_t>(row_count)};
  }
  template <typename Row>
  static void decode(std::size_t table, const ImageTable& image, Row* first) {
    decode_rows(schema().tables[table], image, reinterpret_cast<std::uint8_t*>(first));
  }

  ToyBody* find(std::uint32_t id) {
    const auto at = std::lower_bound(bodies.begin(), bodies.end(), id,
                                     [](const ToyBody& body, std::uint32_t wanted) { return body.id < wanted; });
    return at != bodies.end() && at->id == id ? &*at : nullptr;
  }
  void spawn(double x, double y) {
    ToyBody body;
    body.id = world.next_id++;
    body.position[0] = x;
    body.position[1] = y + 1;
    body.velocity[0] = 0.125F;
    body.charge = static_cast<std::int32_t>(body.id % 5) - 2;
    body.kind = static_cast<std::uint8_t>(body.id % 3);
    bodies.push_back(body);
  }
  void apply(ByteView inputs) {
    ByteReader in(inputs);
    while (in.ok() && !in.at_end()) {
      const auto kind = static_cast<ToyEvent>(in.u8());
      const std::uint32_t id = in.u32();
      const double value = in.f64();
      ToyBody* body = find(id);
      if (kind == ToyEvent::spawn) spawn(value, 0);
      if (kind == ToyEvent::gravity) world.gravity = value;
      if (body == nullptr) continue;  // the body was removed earlier: allowed, without effect
      if (kind == ToyEvent::push) body->velocity[0] += static_cast<float>(value);
      if (kind == ToyEvent::poison) body->velocity[1] = INFINITY;
      if (kind == ToyEvent::remove) remove(id);
    }
  }
  void remove(std::uint32_t id) {
    std::erase_if(links, [&](const ToyLink& link) { return link.body_a == id || link.body_b == id; });
    std::erase_if(bodies, [&](const ToyBody& body) { return body.id == id; });
    for (ToyBody& body : bodies)
      if (body.partner == id) body.partner = no_reference;
  }
  void finish_stage(std::size_t stage, StageObserver* observer) {
    refresh();
    if (disturb) disturb(*this, stage);
    if (observer != nullptr) observer->after_stage(stage, view_);
  }

  StateView view_;
};

inline const SimulationInfo toy_info{"ticktrue.toy", 1, &ToySimulation::make};

}  // namespace ticktrue::test
