// The bytes of a shown image, version 3: the shown columns of one state.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/gathered_state.h"

namespace ticktrue::replay {

/// Encodes tables with ascending numbers. Requires: each table has rows.
void encode_shown(std::span<const ShownRows> tables, Bytes& out);

/// The result refers to `bytes`. `whole`: the schema with the shown columns. Errors: corrupt.
Result<std::vector<ShownRows>> decode_shown(const StateSchema& whole, ByteView bytes);

/// The values of a row as text: "glow 0.5, place (1, 2)". Requires: a row of `rows`.
std::string shown_row_text(const TableSchema& whole, const ShownRows& rows, std::size_t row);

}  // namespace ticktrue::replay
