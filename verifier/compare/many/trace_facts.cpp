// Compares setups and build facts of traces with one reference trace, and groups the traces by value.
// SPDX-License-Identifier: MIT
#include "verifier/compare/many/trace_facts.h"

#include <algorithm>
#include <tuple>

#include "base/hash.h"
#include "verifier/report/fact_differences.h"

namespace ticktrue::verifier {
namespace {

/// A fact whose value differs between one trace and the reference.
struct PairFact {
  std::string what;
  std::string reference;
  std::string value;
  bool changes_bits = false;
};

TraceGroup open_traces(std::span<const OpenedTrace> traces) {
  TraceGroup open;
  for (std::size_t i = 0; i < traces.size(); ++i)
    if (traces[i].reader != nullptr) open.push_back(i);
  return open;
}

/// One fact for each name, in order of first appearance. A trace without the fact has the value of the reference.
std::vector<TraceFact> merged(const TraceGroup& traces, const std::vector<std::vector<PairFact>>& facts) {
  std::vector<TraceFact> found;
  for (const std::vector<PairFact>& of_trace : facts)
    for (const PairFact& fact : of_trace) {
      const auto is_same = [&](const auto& other) { return other.what == fact.what; };
      if (std::any_of(found.begin(), found.end(), is_same)) continue;
      std::vector<std::string> values(facts.size());
      bool changes_bits = false;
      for (const std::size_t trace : traces) {
        const auto own = std::find_if(facts[trace].begin(), facts[trace].end(), is_same);
        values[trace] = own == facts[trace].end() ? fact.reference : own->value;
        changes_bits = changes_bits || (own != facts[trace].end() && own->changes_bits);
      }
      found.push_back(fact_of(fact.what, traces, values));
      found.back().changes_bits = changes_bits;
    }
  return found;
}

/// A sort key for groups of equal size. It does not depend on the order of the traces.
std::tuple<std::string, std::uint32_t, std::uint64_t> content_key(const replay::TraceSetup& setup) {
  ByteWriter schema;
  encode_schema(setup.schema, schema, SchemaLayout::third);
  return {setup.simulation, setup.physics_version, hash64(schema.view())};
}

}  // namespace

TraceFact fact_of(std::string what, const TraceGroup& traces, const std::vector<std::string>& values) {
  TraceFact fact{std::move(what), {}};
  const TraceGroups groups = group_traces(traces, [&](std::size_t i, std::size_t j) { return values[i] == values[j]; });
  for (const TraceGroup& group : groups.groups) fact.values.push_back({values[group.front()], group});
  return fact;
}

TraceGroup comparable_traces(std::span<const OpenedTrace> traces) {
  const TraceGroups classes = group_traces(open_traces(traces), [&](std::size_t i, std::size_t j) {
    std::vector<SetupDifference> ignored;
    return compare_setups(traces[i].reader->setup(), traces[j].reader->setup(), ignored) == 0;
  });
  const TraceGroup* best = &classes.groups.front();
  for (const TraceGroup& group : classes.groups)
    if (group.size() == best->size() &&
        content_key(traces[group.front()].reader->setup()) < content_key(traces[best->front()].reader->setup()))
      best = &group;
  return *best;
}

std::vector<TraceFact> setup_facts(std::span<const OpenedTrace> traces, std::size_t reference) {
  const TraceGroup open = open_traces(traces);
  std::vector<std::vector<PairFact>> facts(traces.size());
  for (const std::size_t i : open) {
    std::vector<SetupDifference> differences;
    compare_setups(traces[reference].reader->setup(), traces[i].reader->setup(), differences);
    for (SetupDifference& one : differences)
      facts[i].push_back({std::move(one.what), std::move(one.a), std::move(one.b)});
  }
  return merged(open, facts);
}

std::vector<TraceFact> build_facts(std::span<const OpenedTrace> traces) {
  TraceGroup telling;
  for (const std::size_t i : open_traces(traces))
    if (!program_line(traces[i].reader->facts()).empty()) telling.push_back(i);
  std::vector<std::vector<PairFact>> facts(traces.size());
  for (const std::size_t i : telling)
    for (FactDifference& one : fact_differences(traces[telling.front()].reader->facts(), traces[i].reader->facts()))
      facts[i].push_back({std::move(one.name), std::move(one.a), std::move(one.b), one.changes_bits});
  std::vector<TraceFact> found = merged(telling, facts);
  std::stable_partition(found.begin(), found.end(), [](const TraceFact& fact) { return fact.changes_bits; });
  return found;
}

}  // namespace ticktrue::verifier
