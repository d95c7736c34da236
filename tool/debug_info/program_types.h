// The structs of a compiled program, as its debug information describes them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::debug_info {

/// A member of a struct, or a base.
struct Field {
  std::string name;          // empty: a base, or an anonymous struct or union
  std::string type_name;     // as the source has it
  std::size_t type = 0;      // place in StructTypes::types
  std::uint64_t offset = 0;  // bytes
  bool is_base = false;
  bool is_private = false;
  bool is_bit_field = false;
  bool is_virtual = false;  // a virtual base: no fixed offset
};

struct Type {
  enum class Kind { floating, integer, boolean, enumeration, pointer, array, record, unknown };
  Kind kind = Kind::unknown;
  std::string name;         // records with their namespaces
  std::uint64_t size = 0;   // bytes
  std::uint64_t count = 0;  // of an array; 0: not known
  std::size_t element = 0;  // of an array or a list
  bool is_list = false;     // std::vector and std::span: `element` lies elsewhere
  bool is_union = false;    // of a record
  std::vector<std::string>
      scope;  // of a record: namespaces, then structs around it; an empty name: anonymous namespace
  std::size_t namespace_count = 0;  // of the scope
  std::vector<Field> fields;
};

/// A struct and the types of its members.
struct StructTypes {
  std::vector<Type> types;  // [0]: the struct
};

/// A struct that the program defines.
struct StructName {
  std::string name;        // with its namespaces
  std::uint64_t size = 0;  // bytes
};

/// Whether this build reads debug information. Else the functions below fail with `unsupported`.
bool can_read_debug_info();

/// Every struct with members, sorted by name; without those of the language and its library.
/// Errors: io, corrupt, unsupported (no debug information), limit.
Result<std::vector<StructName>> struct_names(const std::string& path);

/// The definitions of a struct by its name, with or without namespaces: several where namespaces, or files of the
/// program, define different ones. Errors: as above, and usage where there is none.
Result<std::vector<StructTypes>> find_structs(const std::string& path, const std::string& name);

}  // namespace ticktrue::debug_info
