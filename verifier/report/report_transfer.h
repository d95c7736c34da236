// A report as bytes, from a child process to its parent.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Encodes the fields in the order of their structs. Only for processes of the same build, or of builds with the same
/// digest (verifier/store).
Bytes encode_report(Report report);
/// Accepts or refuses any bytes. Errors: corrupt.
Result<Report> decode_report(ByteView bytes);

}  // namespace ticktrue::verifier
