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

/// Of tables whose numbers ascend, each with rows.
void encode_shown(std::span<const ShownRows> tables, Bytes& out);

/// Views into `bytes`. `whole`: the schema with the shown columns. Errors: corrupt.
Result<std::vector<ShownRows>> decode_shown(const StateSchema& whole, ByteView bytes);

/// The values of a row for people: "glow 0.5, place (1, 2)". Requires: a row of `rows`.
std::string shown_row_text(const TableSchema& whole, const ShownRows& rows, std::size_t row);

}  // namespace ticktrue::replay
