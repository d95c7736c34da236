// Compares setups fact by fact.
// SPDX-License-Identifier: MIT
#include "verifier/compare/setup_difference.h"

#include "base/hash.h"
#include "verifier/locate/schema_difference.h"

namespace ticktrue::verifier {
namespace {

std::string number_text(double value) {
  return lane_text(ScalarType::f64, bits_of(value));
}

std::string bytes_summary(const Bytes& bytes) {
  return std::to_string(bytes.size()) + " bytes, hash " + hex64(hash64(bytes));
}

std::string stages_summary(const std::vector<std::string>& stages) {
  std::string text;
  for (const std::string& stage : stages) text += (text.empty() ? "" : ", ") + stage;
  return text;
}

}  // namespace

std::size_t compare_setups(const replay::TraceSetup& a, const replay::TraceSetup& b,
                           std::vector<SetupDifference>& out) {
  const std::size_t before = out.size();
  if (a.simulation != b.simulation) out.push_back({"simulation", a.simulation, b.simulation});
  if (a.physics_version != b.physics_version)
    out.push_back({"physics version", std::to_string(a.physics_version), std::to_string(b.physics_version)});
  // With equal setups, another range comes from another build. With different setups, the range may follow from the
  // setup.
  const Ranges ranges = a.setup == b.setup ? Ranges::any : Ranges::same;
  if (const auto precision = precision_difference(a.schema, b.schema))
    out.push_back({precision->place, precision->a, precision->b});
  else if (const auto difference = first_schema_difference(a.schema, b.schema, ranges))
    out.push_back({"schema: " + difference->place, difference->a, difference->b});
  const std::size_t blocking = out.size() - before;
  if (a.stages != b.stages) out.push_back({"stages", stages_summary(a.stages), stages_summary(b.stages)});
  if (a.title != b.title) out.push_back({"title", a.title, b.title});
  if (bits_of(a.dt) != bits_of(b.dt)) out.push_back({"dt", number_text(a.dt), number_text(b.dt)});
  if (a.setup != b.setup) out.push_back({"setup", bytes_summary(a.setup), bytes_summary(b.setup)});
  return blocking;
}

}  // namespace ticktrue::verifier
