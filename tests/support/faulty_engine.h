// An engine that makes one mistake, like a build that computes differently.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <span>
#include <string>

#include "engine/engine.h"

namespace ticktrue::test {

/// A bit that is flipped in the state at the end of a tick.
struct Fault {
  std::uint64_t tick = 0;
  std::size_t row = 0;  // of bodies
  unsigned bit = 0;     // 0: the lowest
};

/// An engine that makes the fault once, in lane 0 of a velocity.
class FaultyEngine : public Simulation {
 public:
  FaultyEngine(engine::Engine& engine, const Fault& fault) : engine_(engine), fault_(fault) {}
  Status accept(const TickInput& input) const override { return engine_.accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = engine_.step(input, observer); !did) return did;
    if (engine_.tick() != fault_.tick + 1) return {};
    const StateSchema& schema = *engine_.state().schema;
    const std::size_t table = *schema.find_table("bodies");
    Bytes image;
    encode_image(engine_.state(), image);
    const auto tables = split_image(schema, image);
    if (!tables || fault_.row >= (*tables)[table].row_count) std::abort();
    std::size_t at = static_cast<std::size_t>((*tables)[table].rows.data() - image.data()) +
                     fault_.row * schema.tables[table].row_size;
    for (const Column& column : schema.tables[table].columns)
      if (column.name == "velocity") at += column.offset;
    image[at + fault_.bit / 8] = static_cast<std::uint8_t>(image[at + fault_.bit / 8] ^ 1u << fault_.bit % 8);
    if (!engine_.load(image)) std::abort();
    return {};
  }
  const StateView& state() const override { return engine_.state(); }
  Status load(ByteView image) override { return engine_.load(image); }
  std::span<const std::string> stage_names() const override { return engine_.stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return engine_.row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return engine_.inputs_text(tick, inputs);
  }

 private:
  engine::Engine& engine_;
  Fault fault_;
};

}  // namespace ticktrue::test
