// A report as bytes, from a child process to the one that waits for it.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The fields in the order of their structs. The encoding is only for two processes of the same build.
Bytes encode_report(Report report);
/// Errors: corrupt.
Result<Report> decode_report(ByteView bytes);

}  // namespace ticktrue::verifier
