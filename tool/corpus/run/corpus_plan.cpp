// What is done before any unit runs: costs, parts, shards, order.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>

#include "base/parallel/jobs.h"
#include "tool/corpus/run/corpus_run_impl.h"
#include "tool/corpus/run/shard_plan.h"
#include "verifier/store/agreement.h"
#include "verifier/verify/segments.h"

namespace ticktrue::tool {
namespace {

Bytes encode_part_count(std::size_t count) {
  ByteWriter out;
  out.u64(count);
  return out.take();
}

}  // namespace

std::optional<std::size_t> read_part_count(ByteView bytes) {
  ByteReader in(bytes);
  const std::uint64_t count = in.u64();
  if (!in.ok() || !in.at_end() || count < 1 || count > verifier::segment_count_max) return std::nullopt;
  return static_cast<std::size_t>(count);
}

void CorpusRun::begin_unit(std::size_t i) {
  if (!identify(i) || is_done_by_store(i)) return;
  learn_cost(i);
}

void CorpusRun::learn_cost(std::size_t i) {
  State& state = states_[i];
  state.cost = {learned_cost(history_, names_of(i).history(), mode_name(options_.mode)), state.identity->facts.size};
  state.has_cost = true;
}

void CorpusRun::estimate_costs() {
  std::vector<TraceCost> costs;
  for (const State& state : states_)
    if (state.has_cost) costs.push_back(state.cost);
  const std::vector<double> estimates = estimated_costs(costs);
  auto next = estimates.begin();
  for (State& state : states_)
    if (state.has_cost) state.cost_s = *next++;
}

std::size_t CorpusRun::parts_of(std::size_t i) {
  const State& state = states_[i];
  const double cost_s = state.cost.learned_s.value_or(0);
  if (options_.mode != verifier::VerifyMode::replay || has_plugins_ || options_.program || cost_s <= options_.part_s)
    return 1;
  const std::string key = names_of(i).parts();
  Result<std::optional<Bytes>> found = find_agreement(store_.folder(), key);
  if (found && !*found) {
    Result<replay::TraceReader> reader = replay::TraceReader::open(files_[i]);
    if (!reader) return 1;
    const std::size_t wanted = count_trace_parts(*reader, wanted_parts(cost_s, options_.part_s));
    if (wanted == 1) return 1;
    Result<Bytes> agreed = agree_on(store_.folder(), key, encode_part_count(wanted));
    if (agreed)
      found = std::optional<Bytes>(std::move(*agreed));
    else
      found = agreed.error();
  }
  if (!found) {
    const std::lock_guard<std::mutex> guard(lock_);
    units_[i].warnings.push_back("not cut into parts: " + found.error().message);
    return 1;
  }
  return read_part_count(**found).value_or(1);
}

void CorpusRun::cut_unit(std::size_t i) {
  State& state = states_[i];
  // What was no match before is found again by a run from tick 0 in any case.
  if ((state.was_red || state.is_recheck) && !is_shared_by_shards(state)) {
    state.parts.clear();
    return;
  }
  if (!state.parts.empty()) return;
  if (const std::size_t count = parts_of(i); count > 1) state.parts.resize(count);
}

Status CorpusRun::take_shard_units() {
  const auto shard_count = static_cast<std::uint32_t>(options_.shard->count);
  std::vector<std::size_t> order(files_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return files_[a] < files_[b]; });
  std::vector<PlannedFile> planned;
  for (const std::size_t i : order) {
    const std::optional<replay::FileFacts> facts = replay::file_facts(files_[i]);
    planned.push_back({std::filesystem::path(files_[i]).filename().string(), facts ? facts->size : 0});
  }
  const std::string key =
      plan_key(planned, shard_count, hex128(build_.engine) + hex128(build_.libraries) + build_.options);
  Result<std::optional<Bytes>> bytes = find_agreement(store_.folder(), key);
  if (!bytes) return bytes.error();
  if (!*bytes) {
    const Result<Bytes> wanted = make_plan(order, shard_count);
    if (!wanted) return wanted.error();
    Result<Bytes> agreed = agree_on(store_.folder(), key, *wanted);
    if (!agreed) return agreed.error();
    *bytes = std::move(*agreed);
  }
  const std::optional<ShardPlan> plan = decode_plan(**bytes, files_.size(), shard_count);
  if (!plan)
    return Error{ErrorCode::io, store_.folder().path() + ": the plan of the shards is not one for these traces",
                 "remove " + store_.folder().path_of("agreed/" + verifier::spread_name(key))};
  my_count_ = 0;
  for (std::size_t at = 0; at < order.size(); ++at) take_planned(states_[order[at]], plan->traces[at]);
  return {};
}

void CorpusRun::take_planned(State& state, const std::vector<std::uint32_t>& shards) {
  const auto is_mine = [&](std::uint32_t shard) { return shard == options_.shard->index; };
  state.is_mine = std::any_of(shards.begin(), shards.end(), is_mine);
  if (!state.is_mine) return;
  ++*my_count_;
  if (shards.size() == 1) return;
  state.parts.resize(shards.size());
  for (std::size_t p = 0; p < shards.size(); ++p) state.parts[p].is_mine = is_mine(shards[p]);
}

Result<Bytes> CorpusRun::make_plan(const std::vector<std::size_t>& order, std::uint32_t shard_count) {
  std::vector<std::size_t> parts(files_.size(), 1);
  const Status status = run_jobs(files_.size(), thread_count(), [&](std::size_t i) {
    // Here a trace that cannot be read is no finding yet: it is one of the shard that gets it.
    const Result<TraceIdentity> identity = identify_trace(files_[i], index_, false);
    if (!identity) return;
    states_[i].identity = *identity;
    learn_cost(i);
    parts[i] = parts_of(i);
  });
  if (!status) return status.error();
  estimate_costs();
  std::vector<std::size_t> parts_in_order;
  std::vector<double> costs;
  for (const std::size_t i : order) {
    parts_in_order.push_back(parts[i]);
    costs.push_back(states_[i].cost_s);
    states_[i].identity.reset();
    states_[i].has_cost = false;
  }
  return encode_plan(plan_shards(parts_in_order, costs, shard_count));
}

std::vector<CorpusRun::Job> CorpusRun::most_expensive_first() {
  estimate_costs();
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const State& state = states_[i];
    if (!state.is_mine || state.is_done) continue;
    const double part_count = std::max<double>(1, static_cast<double>(state.parts.size()));
    for (std::size_t p = 0; p < state.parts.size(); ++p)
      if (state.parts[p].is_mine) jobs.push_back({i, p, state.cost_s / part_count});
    // Of a trace that is cut, the run from tick 0 stands behind its parts and waits for a part that is no match.
    jobs.push_back({i, std::nullopt, state.cost_s / part_count});
  }
  std::stable_sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) { return a.cost_s > b.cost_s; });
  return jobs;
}

}  // namespace ticktrue::tool
