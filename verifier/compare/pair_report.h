// Combines the verdicts of two builds on one trace: where they agree with it, and where they differ.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The verdict of the other build on the trace.
struct OtherVerdict {
  OtherBuild build;
  std::string got_hash;  // hex64, of the tick at which it diverged; empty: unknown
};

/// `here` is the report of one build. The result is the report of the pair. match: both builds reproduce the recorded
/// bits. diverged: the first difference between the builds; if the builds agree with each other, the first difference
/// from the recording. `locate` is called if the builds differ, with a divergence at the right tick: it fills in the
/// rest, with the other build as "expected". If a build gives no verdict on its bits, its verdict is that of the pair.
Report pair_report(Report here, const OtherVerdict& other, const std::function<void(Report& pair)>& locate);

/// The same for two programs that verified the trace in their own sessions. Both reports are about one trace. A program
/// is not compared after the tick at which it leaves the recording.
Report pair_of_programs(Report here, const Report& there, const std::string& there_name);

/// The report if the other build could not be examined.
Report pair_failed(Report here, const std::string& other_name, const std::string& what, const std::string& hint);

}  // namespace ticktrue::verifier
