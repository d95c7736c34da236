// Parts that the pitfalls share: a tiny game whose whole state is saved, a place for its rules, the expected finding.
// SPDX-License-Identifier: MIT
//
// Each pitfall is one file: a game with one real determinism bug. docs/pitfalls.md explains the pitfalls.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "verifier/report/report.h"
#include "verifier/verify/verify.h"

namespace ticktrue::pitfalls {

/// Many of these bugs only appear on another machine: another compiler, standard library, heap or processor.
/// This variable selects the machine, and the game imitates what that machine would do.
enum class Machine : std::uint8_t { recorder, other };
extern Machine machine;

struct Unit {
  std::uint32_t id = 0;
  float position = 0;  // m
  float velocity = 0;  // m/s
  std::int32_t score = 0;
};

/// Units on a line. A tick moves them, then applies the rules.
class Game : public Simulation {
 public:
  explicit Game(std::uint32_t unit_count);

  Status accept(const TickInput&) const override { return {}; }
  Status step(const TickInput& input, StageObserver* observer) override;
  const StateView& state() const override { return view_; }
  Status load(ByteView image) override;
  std::span<const std::string> stage_names() const override { return {}; }
  std::string row_name(std::size_t table, std::size_t row) const override;
  std::string inputs_text(std::uint64_t, ByteView) const override { return {}; }

 protected:
  virtual void rules(float dt) = 0;
  std::uint64_t tick() const { return tick_; }  // the current tick

  std::vector<Unit> units;

 private:
  std::uint64_t tick_ = 0;
  StateView view_;
};

/// A game with a bug, and the expected report of verify.
struct Pitfall {
  const char* name;
  Result<std::unique_ptr<Simulation>> (*make)(ByteView setup);
  verifier::VerifyMode mode;  // the mode that finds the bug
  verifier::Verdict verdict;
  std::uint64_t tick;  // the first differing tick
  const char* column;  // of the table "units"
  std::vector<std::uint32_t> units;
};

template <typename G>
Result<std::unique_ptr<Simulation>> make_game(ByteView) {
  return std::unique_ptr<Simulation>(std::make_unique<G>());
}

extern const Pitfall argument_order, contraction, float_to_int, flush_to_zero, libm, negative_zero, padding,
    pointer_order, rand_call, thread_order, unordered_iteration, unsaved_state, unstable_sort, wall_clock;

}  // namespace ticktrue::pitfalls
