// The build id that a linker stores in the ELF notes of a program.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/bytes.h"

namespace ticktrue::verifier {

/// The build fact of a trace that identifies the recording program.
inline constexpr std::string_view build_id_fact = "program.build_id";

enum class ByteOrder { little, big };
inline constexpr ByteOrder native_order = machine_is_little_endian ? ByteOrder::little : ByteOrder::big;

/// The build id among the notes of one segment, as lower-case hexadecimal digits; empty: none. `alignment`: 4 or 8
/// bytes. `order`: byte order of the program.
std::string build_id_among(ByteView notes, std::size_t alignment, ByteOrder order = native_order);

}  // namespace ticktrue::verifier
