// What workers agree on before they share work: the first of them decides, all others follow.
// SPDX-License-Identifier: MIT
//
// A file STORE/agreed/ab/cdef... is published once. A damaged one is set aside, and the next worker decides again:
// then two workers can follow different decisions. That costs time: what is missing is found by the report.
#pragma once

#include <optional>
#include <string>

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// What was decided under this key; nothing: no decision yet. Errors: io.
Result<std::optional<Bytes>> find_agreement(const StoreFolder& folder, const std::string& key);

/// Decides, unless another worker did; gives what holds. Errors: io.
Result<Bytes> agree_on(const StoreFolder& folder, const std::string& key, ByteView wanted);

}  // namespace ticktrue::verifier
