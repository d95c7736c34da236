// Plans as bytes.
// SPDX-License-Identifier: MIT
#include "tool/corpus/run/shard_plan.h"

#include <utility>

#include "tool/corpus/run/costs.h"

namespace ticktrue::tool {

ShardPlan plan_shards(const std::vector<std::size_t>& parts, const std::vector<double>& costs,
                      std::uint32_t shard_count) {
  std::vector<double> part_costs;
  for (std::size_t i = 0; i < parts.size(); ++i)
    part_costs.insert(part_costs.end(), parts[i], costs[i] / static_cast<double>(parts[i]));
  const std::vector<std::uint32_t> shards = share_out(part_costs, shard_count);
  ShardPlan plan;
  auto next = shards.begin();
  for (const std::size_t count : parts) {
    plan.traces.emplace_back(next, next + static_cast<std::ptrdiff_t>(count));
    next += static_cast<std::ptrdiff_t>(count);
  }
  return plan;
}

Bytes encode_plan(const ShardPlan& plan) {
  ByteWriter out;
  for (const std::vector<std::uint32_t>& trace : plan.traces) {
    out.u64(trace.size());
    for (const std::uint32_t shard : trace) out.u64(shard);
  }
  return out.take();
}

std::optional<ShardPlan> decode_plan(ByteView bytes, std::size_t trace_count, std::uint32_t shard_count) {
  ByteReader in(bytes);
  ShardPlan plan;
  for (std::size_t i = 0; i < trace_count; ++i) {
    const std::uint64_t part_count = in.u64();
    std::vector<std::uint32_t> trace;
    for (std::uint64_t p = 0; p < part_count && in.ok(); ++p) {
      const std::uint64_t shard = in.u64();
      if (shard < 1 || shard > shard_count) return std::nullopt;
      trace.push_back(static_cast<std::uint32_t>(shard));
    }
    if (!in.ok() || trace.empty()) return std::nullopt;
    plan.traces.push_back(std::move(trace));
  }
  if (!in.at_end()) return std::nullopt;
  return plan;
}

std::string plan_key(const std::vector<PlannedFile>& files, std::uint32_t shard_count, const std::string& build) {
  ByteWriter out;
  out.text("ticktrue.shards/1");
  out.text(build);
  out.u64(shard_count);
  for (const PlannedFile& file : files) {
    out.text(file.name);
    out.u64(file.size);
  }
  return hex128(hash128(out.view()));
}

}  // namespace ticktrue::tool
