// A campaign: a program is recorded once for each seed, and each trace is judged.
// SPDX-License-Identifier: MIT
//
// Verified: of each seed that the program ends by itself and leaves a whole trace, and that a second run of it,
// verifying or recording, gives every tick again. Not verified: what two runs on this machine have in common; libraries
// of the program do not count in its digest.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/campaign/campaign_results.h"
#include "verifier/runs/child_end.h"

namespace ticktrue::campaign {

struct CampaignOptions {
  std::vector<std::string> record;  // words, with {seed}, and {trace} or {}; without a trace, --record TRACE is added
  std::vector<std::string> verify;  // words as of verify --command; empty: each seed is recorded twice
  bool restore = false;             // a trace with saves is verified in mode restore too
  bool keeps_traces = false;        // also of seeds that match
  std::string folder;               // absolute: for traces and results
  double time_s = 600;              // of a run
};

/// XXH3-128 of the words, and of each file that a word names: the program, or a script. Errors: usage (there is no such
/// program), io.
Result<std::string> program_digest(const CampaignOptions& options);

struct Judged {
  SeedResult result;
  std::vector<verifier::EscapedChild> escaped;  // processes that left the program's process group
};
/// Records and judges one seed. From any thread. `run_folder`: for the files of runs. A result of Verdict::error is
/// about the machine, not the seed.
Judged judge_seed(const CampaignOptions& options, std::uint64_t seed, const std::string& run_folder);

/// The command that shows the finding of a red seed again. `folder`: as the user named it.
std::string again_command(const CampaignOptions& options, const SeedResult& result, const std::string& folder);

}  // namespace ticktrue::campaign
