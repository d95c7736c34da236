// Which rows of the tables of choices a world has, and whether the world runs otherwise without them.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tool/experiment/soak/soak.h"

namespace ticktrue::verifier::soak {

/// Rows not yet seen with an effect in effect_count_wanted worlds, those with the fewest first.
std::vector<std::string> rows_to_measure(const WorldSource& source, const std::map<std::string, RowCoverage>& rows);

/// Adds the world's rows and pairs of rows to `counts`, and runs the world without the first few of `wanted` that it
/// has.
void count_rows(const WorldSource& source, const WorldSource::World& world, std::uint64_t world_seed,
                const BaseRun& base, const std::vector<std::string>& wanted, const EngineMaker& make,
                SoakCounters& counts);

/// Whether the run without a row differs: the hash of the state (where both have the same tables), the bodies, or
/// tables with rows of their own that only the world with the row has. It is run until it differs, or has taken twice
/// the estimated work of the base run.
bool has_effect(const BaseRun& base, const SoakCase& without, const EngineMaker& make);

}  // namespace ticktrue::verifier::soak
