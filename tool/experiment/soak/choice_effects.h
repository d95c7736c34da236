// The choices (rows of the tables of choices) that a world uses, and whether its run differs without them.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tool/experiment/soak/soak.h"

namespace ticktrue::soak {

/// Choices with an effect in fewer than effect_count_wanted worlds, in ascending order of that count.
std::vector<std::string> choices_to_measure(const WorldSource& source,
                                            const std::map<std::string, ChoiceCoverage>& choices);

/// Adds the choices of the world and their pairs to `counts`. Runs the world without each of the first few choices in
/// `wanted` that the world uses.
void count_choices(const WorldSource& source, const WorldSource::World& world, std::uint64_t world_seed,
                   const BaseRun& base, const std::vector<std::string>& wanted, const EngineMaker& make,
                   SoakCounters& counts);

/// Whether the run without a choice differs in the hash of the state, in the bodies, or in the tables with rows. Hashes
/// are compared if both runs have the same tables. Only rows that the base run has alone count as a difference. The run
/// ends at a difference, or at twice the estimated work of the base run.
bool has_effect(const BaseRun& base, const SoakCase& without, const EngineMaker& make);

}  // namespace ticktrue::soak
