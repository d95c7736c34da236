// Which bytes a trace has, so that a verdict can be named by them.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/hash128.h"
#include "base/result.h"
#include "replay/file/file_calls.h"
#include "verifier/store/stat_index.h"

namespace ticktrue::tool {

/// The name of the bytes of a trace, and the file that had them.
struct TraceIdentity {
  replay::FileFacts facts;
  Hash128 hash;
};

/// From the index where the file is the same; with `reads` every byte is read. Errors: io (also a file that changes
/// meanwhile).
Result<TraceIdentity> identify_trace(const std::string& file, verifier::StatIndex& index, bool reads);

/// That a trace changed while it was verified.
Error changed_trace_error(const std::string& file);

}  // namespace ticktrue::tool
