// A report as bytes, from a child process to the one that waits for it.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The fields in the order of their structs. The encoding is only for processes of the same build, or of builds with
/// one digest (verifier/store).
Bytes encode_report(Report report);
/// Any bytes are read or refused. Errors: corrupt.
Result<Report> decode_report(ByteView bytes);

}  // namespace ticktrue::verifier
