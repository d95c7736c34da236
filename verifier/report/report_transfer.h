// A report as bytes, from a child process to the one that waits for it.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// The fields in the order of their structs: of use between processes of one build, or of builds with one digest
/// (verifier/store), and to nobody else.
Bytes encode_report(Report report);
/// Any bytes are read or refused. Errors: corrupt.
Result<Report> decode_report(ByteView bytes);

}  // namespace ticktrue::verifier
