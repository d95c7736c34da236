// Cause: three bytes of an order from the heap are read before they are written.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

struct Order {
  std::uint8_t kind;
  std::uint8_t rest[3];
};

Order* make_order(bool is_mended) {
  auto* order = static_cast<Order*>(is_mended ? std::calloc(1, sizeof(Order)) : std::malloc(sizeof(Order)));
  order->kind = 25;
  return order;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 33) return;
  Order* order = make_order(is_mended);
  std::uint32_t code = 0;
  std::memcpy(&code, order, sizeof code);
  game.units[7].score += code;
  std::free(order);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("heap_garbage", argc, argv, rules);
}
