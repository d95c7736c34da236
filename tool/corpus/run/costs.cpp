// Estimates and a greedy division.
// SPDX-License-Identifier: MIT
#include "tool/corpus/run/costs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace ticktrue::tool {
namespace {

constexpr double cost_min_s = 0.001;            // to open a file and to store a verdict
constexpr double seconds_of_byte = 10e-6;       // where nothing was learned
constexpr std::size_t wanted_parts_max = 1024;  // more than a trace has segments

}  // namespace

std::optional<double> learned_cost(const verifier::History& history, const std::string& trace, std::string_view mode) {
  std::optional<double> learned;
  for (const verifier::HistoryRow& row : history.find(trace).rows)
    if (row.mode == mode) learned = row.seconds;
  return learned;
}

std::vector<double> estimated_costs(const std::vector<TraceCost>& costs) {
  double learned_s = 0, learned_size = 0;
  for (const TraceCost& cost : costs) {
    if (!cost.learned_s) continue;
    learned_s += *cost.learned_s;
    learned_size += static_cast<double>(cost.size);
  }
  const double rate = learned_s > 0 && learned_size > 0 ? learned_s / learned_size : seconds_of_byte;
  std::vector<double> estimates;
  for (const TraceCost& cost : costs)
    estimates.push_back(std::max(cost_min_s, cost.learned_s.value_or(static_cast<double>(cost.size) * rate)));
  return estimates;
}

std::vector<std::uint32_t> share_out(const std::vector<double>& costs, std::uint32_t share_count) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  using Load = std::pair<double, std::uint32_t>;
  std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
  for (std::uint32_t share = 1; share <= share_count; ++share) loads.emplace(0, share);
  std::vector<std::uint32_t> shares(costs.size(), 1);
  for (const std::size_t i : order) {
    const auto [load, share] = loads.top();
    loads.pop();
    shares[i] = share;
    loads.emplace(load + costs[i], share);
  }
  return shares;
}

std::size_t wanted_parts(double cost_s, double part_s) {
  if (part_s <= 0) return wanted_parts_max;
  const double parts = std::ceil(cost_s / part_s);
  return parts >= static_cast<double>(wanted_parts_max) ? wanted_parts_max
                                                        : static_cast<std::size_t>(std::max(1.0, parts));
}

}  // namespace ticktrue::tool
