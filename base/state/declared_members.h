// Members of a struct as a program in C declares them, read into columns: type, lanes and bytes are checked.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/limits.h"
#include "base/result.h"
#include "base/state/gathered_state.h"

namespace ticktrue {

/// Added to a type: the column is stored and printed, and never judged.
inline constexpr int shown_type_flag = 0x100;

/// A type without the flag; none of the known types where it is out of range.
inline ScalarType declared_type(int type) {
  const int plain = type & ~shown_type_flag;
  return static_cast<ScalarType>(type >= 0 && plain <= 255 ? plain : 0);
}
inline bool is_declared_shown(int type) {
  return type >= 0 && (type & shown_type_flag) != 0;
}

/// Bounded: an unterminated name is too long, not a read out of bounds.
inline std::string_view bounded_name(const char* text) {
  return text == nullptr ? std::string_view() : std::string_view(text, strnlen(text, limits::name_size_max + 1));
}

/// A member of a struct: `size` bytes (0: not told) from `offset` on; `lane_count` 0: as many as fill them.
struct DeclaredMember {
  std::string_view name;
  int type = 0;
  std::uint32_t lane_count = 0;
  std::size_t offset = 0;
  std::size_t size = 0;
};
/// Errors: usage (a wrong name, a size that is not that of the lanes). `place` begins the message.
Result<RowMember> read_member(const std::string& place, const DeclaredMember& member);

/// The members of a struct of the C interface. Errors: usage. `place` begins the message.
template <typename Member>
Result<std::vector<RowMember>> read_members(const std::string& place, const Member* members,
                                            std::uint32_t member_count) {
  if ((members == nullptr && member_count > 0) || member_count > limits::column_count_max)
    return Error{ErrorCode::usage,
                 place + "members: found " + (members == nullptr ? "null" : std::to_string(member_count)) +
                     ", expected 1.." + std::to_string(limits::column_count_max),
                 "each member of the struct that is compared is one of them"};
  std::vector<RowMember> row;
  for (std::uint32_t i = 0; i < member_count; ++i) {
    const Member& member = members[i];
    Result<RowMember> read =
        read_member(place, {bounded_name(member.name), member.type, member.lanes, member.offset, member.size});
    if (!read) return read.error();
    row.push_back(*read);
  }
  return row;
}

}  // namespace ticktrue
