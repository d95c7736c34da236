// Running, printing and reading the hashes of random worlds.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_hashes.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <string_view>
#include <system_error>

#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"

namespace ticktrue::engine {
namespace {

/// Removes the number at the beginning of `text`, and one tab after it.
bool take_number(std::string_view& text, int base, std::uint64_t& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out, base);
  if (error != std::errc() || end == text.data()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (text.empty()) return true;
  if (text[0] != '\t') return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

WorldHash hash_world(std::uint64_t seed, CacheReport* counts) {
  const RandomWorld world = random_world(seed, hashed_worlds);
  Result<std::unique_ptr<Engine>> made = make_engine(world.scene);
  TICKTRUE_ASSERT(made.has_value());
  Engine& engine = **made;
  WorldHash result{seed, 0, 0};
  std::size_t next = 0;
  for (std::uint64_t tick = 0; tick < world.tick_count; ++tick) {
    std::vector<Input> of_tick;
    for (; next < world.inputs.size() && world.inputs[next].tick == tick; ++next)
      if (world.inputs[next].kind != InputKind::end) of_tick.push_back(world.inputs[next]);
    Bytes bytes;
    encode_inputs(of_tick, bytes);
    const TickInput input{world.scene.settings.dt, bytes};
    if (!engine.accept(input)) break;
    if (!engine.step(input, nullptr) || find_non_finite(engine.state())) break;
    result.tick_count = tick + 1;
    result.hash = root_hash(engine.state());
  }
  if (counts) add_counts(*counts, engine.cache_report());
  return result;
}

std::string print_world_hashes(const std::vector<WorldHash>& worlds) {
  std::string text =
      "# Root hashes of random worlds (engine/random_worlds/world_hashes.h), the same in every build and on every "
      "platform.\n# Written by `ticktrue soak --write-hashes FILE`.\n# seed\tticks\thash\n";
  for (const WorldHash& world : worlds)
    text += std::to_string(world.seed) + "\t" + std::to_string(world.tick_count) + "\t" + hex64(world.hash) + "\n";
  return text;
}

Result<std::vector<WorldHash>> parse_world_hashes(const std::string& text, const std::string& place) {
  std::vector<WorldHash> worlds;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (line.empty() || line[0] == '#') continue;
    WorldHash world;
    std::string_view left = line;
    if (!take_number(left, 10, world.seed) || !take_number(left, 10, world.tick_count) ||
        !take_number(left, 16, world.hash) || !left.empty())
      return Error{
          ErrorCode::corrupt,
          place + ":" + std::to_string(number) + ": found \"" + std::string(line) + "\", expected seed, ticks and hash",
          ""};
    worlds.push_back(world);
  }
  if (worlds.empty())
    return Error{ErrorCode::corrupt, place + ": found no world, expected lines of seed, ticks and hash",
                 "ticktrue soak --write-hashes " + place + " makes the file"};
  return worlds;
}

}  // namespace ticktrue::engine
