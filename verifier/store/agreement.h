// Decisions that workers need before they share work: the first worker decides, and all others follow.
// SPDX-License-Identifier: MIT
//
// A file STORE/agreed/ab/cdef... is published once. A damaged file is set aside, and the next worker decides again. Two
// workers can then follow different decisions. This costs only time: the report finds missing work.
#pragma once

#include <optional>
#include <string>

#include "base/bytes.h"
#include "base/result.h"
#include "verifier/store/store_folder.h"

namespace ticktrue::verifier {

/// The decision under this key; nothing: no decision yet. Errors: io.
Result<std::optional<Bytes>> find_agreement(const StoreFolder& folder, const std::string& key);

/// Publishes `wanted` unless another worker has decided; returns the valid decision. Errors: io.
Result<Bytes> agree_on(const StoreFolder& folder, const std::string& key, ByteView wanted);

}  // namespace ticktrue::verifier
