// Which shard does what: a plan that all shards on one store follow.
// SPDX-License-Identifier: MIT
//
// Costs that are learned change with every verdict. So the first shard that starts writes the plan into the store, and
// the others read it: whenever they start, no unit is in two shards or in none. Shards on copies of a store agree if
// the copies held the same costs; what they miss otherwise is an error of `corpus report`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/hash128.h"

namespace ticktrue::tool {

/// For each trace its parts (one: it is not cut), and for each part the number of its shard, from 1.
struct ShardPlan {
  std::vector<std::vector<std::uint32_t>> traces;
};

/// `parts`: of each trace; `costs`: of each trace, shared evenly by its parts.
ShardPlan plan_shards(const std::vector<std::size_t>& parts, const std::vector<double>& costs,
                      std::uint32_t shard_count);

Bytes encode_plan(const ShardPlan& plan);
/// Nothing: it is no plan for so many traces and shards.
std::optional<ShardPlan> decode_plan(ByteView bytes, std::size_t trace_count, std::uint32_t shard_count);

struct PlannedFile {
  std::string name;  // without its folder: shards may see the corpus in different places
  std::uint64_t size = 0;
};
/// The name of the plan. `build`: what a verdict depends on beside the trace.
std::string plan_key(const std::vector<PlannedFile>& files, std::uint32_t shard_count, const std::string& build);

}  // namespace ticktrue::tool
