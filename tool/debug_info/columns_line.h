// The TICKTRUE_COLUMNS lines of a struct: which members are columns, and why the others are not.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tool/debug_info/program_types.h"

namespace ticktrue::debug_info {

/// A member, with those of bases and anonymous structs as if they were its own.
struct LayoutMember {
  std::string name;
  std::string type;
  std::uint64_t offset = 0;  // bytes
  std::uint64_t size = 0;    // bytes
  std::string refusal;       // why it is no column, and what to do; empty: it is one
  bool is_private = false;
};

/// Bytes that belong to no member.
struct Gap {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

struct StructLayout {
  std::string name;                   // with its namespaces
  std::vector<std::string> scope;     // namespaces; an empty name is an anonymous one
  std::string local_name;             // in that namespace
  std::uint64_t size = 0;             // bytes
  std::vector<LayoutMember> members;  // by offset
  std::vector<Gap> gaps;
  bool has_private = false;  // among its columns

  bool has_columns() const;
};

/// Those of the struct and of the structs in it that need lines of their own: inner ones first, each once.
std::vector<StructLayout> struct_layouts(const StructTypes& types);

/// Lines for a C++ source: they compile behind the structs, in the global namespace.
std::string columns_text(const std::vector<StructLayout>& layouts);

/// Offsets, sizes, types and padding of one struct.
std::string layout_table(const StructLayout& layout);

}  // namespace ticktrue::debug_info
