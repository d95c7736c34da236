// The verdicts of two builds on one trace, put together: where they agree with it, and where they part.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// What the other build said of the trace.
struct OtherVerdict {
  OtherBuild build;
  std::string got_hash;  // hex64, of the tick at which it diverged; empty: not known
};

/// `here` is the report of the one build. The result is the report of the pair: match if both give the recorded bits;
/// diverged with the first difference between them, or, where they agree with each other, between both and the
/// recording. `locate` is called where they part, with a divergence that has its tick: it fills in the rest, "expected"
/// being the other build. What a build says that is no verdict on its bits is the verdict of the pair.
Report pair_report(Report here, const OtherVerdict& other, const std::function<void(Report& pair)>& locate);

/// The same of two programs, each of which verified the trace in a session of its own. Both reports are of one trace.
/// A program is not compared behind the tick at which it leaves the recording.
Report pair_of_programs(Report here, const Report& there, const std::string& there_name);

/// That the other build could not be examined.
Report pair_failed(Report here, const std::string& other_name, const std::string& what, const std::string& hint);

}  // namespace ticktrue::verifier
