// Pitfall: the padding between the members of a struct is hashed, although it is never written.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstring>

#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

struct Order {
  std::uint8_t kind;
  std::uint32_t target;  // three bytes of padding before it
};

class Padding : public Game {
 public:
  Padding() : Game(8) {}

 private:
  void rules(float) override {
    if (tick() != 33) return;
    std::uint8_t order[sizeof(Order)];
    // Order order; order.kind = 2; order.target = 5; -- the bytes between both members keep old bytes of the stack.
    std::memset(order, machine == Machine::recorder ? 0x00 : 0xcd, sizeof order);
    const std::uint32_t target = 5;
    order[offsetof(Order, kind)] = 2;
    std::memcpy(order + offsetof(Order, target), &target, sizeof target);
    std::uint32_t hash = 0;
    for (const std::uint8_t byte : order) hash = 31 * hash + byte;
    units[7].score = static_cast<std::int32_t>(hash % 100);
  }
};

}  // namespace

const Pitfall padding{
    "padding", make_game<Padding>, verifier::VerifyMode::replay, verifier::Verdict::diverged, 33, "score", {7}};

}  // namespace ticktrue::pitfalls
