// Structs from DWARF: finds them in all units of a program, a library or an object file, and follows their types.
// SPDX-License-Identifier: MIT
// Source: DWARF Debugging Information Format, version 5, 2017, chapters 3 and 5; read with libdw of elfutils.
#include <dwarf.h>
#include <elfutils/libdw.h>
#include <elfutils/libdwfl.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include "tool/debug_info/program_types.h"

namespace ticktrue::debug_info {
namespace {

constexpr std::size_t depth_max = 64;           // of namespaces and structs inside each other, and of names of types
constexpr std::size_t type_count_max = 20'000;  // of one struct
constexpr std::size_t file_size_max = std::size_t{4} << 30;

struct CloseProgram {
  void operator()(Dwfl* program) const { dwfl_end(program); }
};
using Program = std::unique_ptr<Dwfl, CloseProgram>;

/// Where a struct stands: an empty name is an anonymous namespace.
struct Scope {
  std::vector<std::string> names;
  std::size_t namespace_count = 0;
};

struct Found {
  Dwarf_Die die{};
  Scope scope;
  std::string name;  // the last part
};

std::string qualified(const Scope& scope, const std::string& name) {
  std::string text;
  for (const std::string& part : scope.names) text += (part.empty() ? "(anonymous)" : part) + "::";
  return text + name;
}

std::string name_of(Dwarf_Die& die) {
  const char* name = dwarf_diename(&die);
  return name == nullptr ? "" : std::string(name, strnlen(name, 4096));
}

bool has_flag(Dwarf_Die& die, unsigned attribute) {
  Dwarf_Attribute found;
  bool flag = false;
  return dwarf_attr_integrate(&die, attribute, &found) != nullptr && dwarf_formflag(&found, &flag) == 0 && flag;
}

std::optional<std::uint64_t> number_of(Dwarf_Die& die, unsigned attribute) {
  Dwarf_Attribute found;
  Dwarf_Word number = 0;
  if (dwarf_attr_integrate(&die, attribute, &found) == nullptr || dwarf_formudata(&found, &number) != 0) return {};
  return number;
}

/// A declaration becomes its definition in a type unit of its own.
void follow_signature(Dwarf_Die& die) {
  Dwarf_Attribute found;
  Dwarf_Die definition;
  if (dwarf_attr(&die, DW_AT_signature, &found) != nullptr && dwarf_formref_die(&found, &definition) != nullptr)
    die = definition;
}

bool type_of(Dwarf_Die& die, Dwarf_Die& type) {
  Dwarf_Attribute found;
  if (dwarf_attr_integrate(&die, DW_AT_type, &found) == nullptr || dwarf_formref_die(&found, &type) == nullptr)
    return false;
  follow_signature(type);
  return true;
}

bool is_record(int tag) {
  return tag == DW_TAG_structure_type || tag == DW_TAG_class_type || tag == DW_TAG_union_type;
}

bool has_members(Dwarf_Die& record) {
  Dwarf_Die child;
  if (dwarf_child(&record, &child) != 0) return false;
  std::size_t left = 100'000;
  do {
    const int tag = dwarf_tag(&child);
    if (tag == DW_TAG_inheritance) return true;
    if (tag == DW_TAG_member && !has_flag(child, DW_AT_external)) return true;
  } while (--left > 0 && dwarf_siblingof(&child, &child) == 0);
  return false;
}

/// All records of a program that are defined in a namespace or in another record.
class Search {
 public:
  explicit Search(std::uint64_t visits_max) : visits_left_(visits_max) {}

  void unit(Dwarf_Die& die) { children(die, {}, 0); }
  bool has_ended_early() const { return visits_left_ == 0; }
  std::vector<Found> found;

 private:
  void children(Dwarf_Die& parent, const Scope& scope, std::size_t depth) {
    Dwarf_Die child;
    if (depth > depth_max || dwarf_child(&parent, &child) != 0) return;
    do {
      if (visits_left_ == 0) return;
      --visits_left_;
      visit(child, scope, depth);
    } while (dwarf_siblingof(&child, &child) == 0);
  }

  void visit(Dwarf_Die& die, const Scope& scope, std::size_t depth) {
    const int tag = dwarf_tag(&die);
    if (tag == DW_TAG_namespace) {
      Scope inner = scope;
      inner.names.push_back(name_of(die));
      ++inner.namespace_count;
      return children(die, inner, depth + 1);
    }
    if (tag == DW_TAG_typedef) return visit_typedef(die, scope);
    if (!is_record(tag)) return;
    Dwarf_Die named = die;
    follow_signature(named);
    const std::string name = name_of(named);
    if (name.empty()) return;
    Scope own = scope;
    // Defined outside of the struct that declares it.
    Dwarf_Attribute attribute;
    Dwarf_Die declaration;
    if (dwarf_attr(&die, DW_AT_specification, &attribute) != nullptr &&
        dwarf_formref_die(&attribute, &declaration) != nullptr)
      if (const auto declared = declared_.find(dwarf_dieoffset(&declaration)); declared != declared_.end())
        own = declared->second;
    if (is_declaration(die))
      declared_[dwarf_dieoffset(&die)] = own;
    else if (tag != DW_TAG_union_type && has_members(die))
      found.push_back({die, own, name});
    Scope inner = own;
    inner.names.push_back(name);
    children(die, inner, depth + 1);
  }

  /// A struct without a name, as in C: typedef struct { ... } Unit;
  void visit_typedef(Dwarf_Die& die, const Scope& scope) {
    Dwarf_Die target;
    if (!type_of(die, target) || dwarf_tag(&target) != DW_TAG_structure_type || !name_of(target).empty()) return;
    if (has_members(target)) found.push_back({target, scope, name_of(die)});
  }

  /// Of this entry itself: a definition refers to its declaration, which has the flag.
  static bool is_declaration(Dwarf_Die& die) {
    Dwarf_Attribute attribute;
    bool flag = false;
    return dwarf_attr(&die, DW_AT_declaration, &attribute) != nullptr && dwarf_formflag(&attribute, &flag) == 0 && flag;
  }

  std::uint64_t visits_left_;
  std::map<Dwarf_Off, Scope> declared_;
};

/// The types of one struct, each of them once.
class Types {
 public:
  /// Names of the records with their namespaces, by their place.
  explicit Types(const std::map<const void*, const Found*>& records) : records_(records) {}

  StructTypes of(const Found& found) {
    Dwarf_Die die = found.die;
    add(die, 0);
    types_.types[0].name = qualified(found.scope, found.name);
    types_.types[0].scope = found.scope.names;
    types_.types[0].scope.push_back(found.name);
    types_.types[0].namespace_count = found.scope.namespace_count;
    return std::move(types_);
  }

 private:
  /// Through typedefs and const. False: there is no type, as in void.
  static bool peel(Dwarf_Die& die) {
    for (std::size_t i = 0; i < depth_max; ++i) {
      const int tag = dwarf_tag(&die);
      if (tag != DW_TAG_typedef && tag != DW_TAG_const_type && tag != DW_TAG_volatile_type) return true;
      if (!type_of(die, die)) return false;
    }
    return false;
  }

  /// As the source writes the type.
  std::string text(Dwarf_Die die, std::size_t depth) {
    if (depth > depth_max) return "...";
    const int tag = dwarf_tag(&die);
    Dwarf_Die target;
    const auto inner = [&] { return type_of(die, target) ? text(target, depth + 1) : std::string("void"); };
    switch (tag) {
      case DW_TAG_const_type:
        return "const " + inner();
      case DW_TAG_volatile_type:
        return "volatile " + inner();
      case DW_TAG_pointer_type:
        return inner() + "*";
      case DW_TAG_reference_type:
        return inner() + "&";
      case DW_TAG_rvalue_reference_type:
        return inner() + "&&";
      case DW_TAG_subroutine_type:
        return "function";
      case DW_TAG_ptr_to_member_type:
        return "pointer to member";
      case DW_TAG_array_type: {
        std::string text = inner();
        for (const std::uint64_t count : counts_of(die)) text += "[" + (count == 0 ? "" : std::to_string(count)) + "]";
        return text;
      }
      default:
        break;
    }
    if (const auto record = records_.find(die.addr); record != records_.end()) {
      const std::string whole = qualified(record->second->scope, record->second->name);
      return whole.rfind("std::__cxx11::basic_string<char,", 0) == 0 ? "std::string" : whole;
    }
    const std::string name = name_of(die);
    return name.empty() ? "(no name)" : name;
  }

  /// Elements of each dimension; 0: not known.
  static std::vector<std::uint64_t> counts_of(Dwarf_Die& array) {
    std::vector<std::uint64_t> counts;
    Dwarf_Die child;
    if (dwarf_child(&array, &child) != 0) return counts;
    do {
      if (dwarf_tag(&child) != DW_TAG_subrange_type) continue;
      if (const auto count = number_of(child, DW_AT_count))
        counts.push_back(*count);
      else if (const auto last = number_of(child, DW_AT_upper_bound); last && *last < UINT32_MAX)
        counts.push_back(*last + 1);
      else
        counts.push_back(0);
    } while (counts.size() < 16 && dwarf_siblingof(&child, &child) == 0);
    return counts;
  }

  /// The place of the type in the list.
  std::size_t add(Dwarf_Die die, std::size_t depth) {
    const bool is_known = peel(die);
    const std::string name = text(die, 0);
    if (const auto known = places_.find(die.addr); known != places_.end() && is_known) return known->second;
    const std::size_t place = types_.types.size();
    types_.types.emplace_back().name = name;
    if (!is_known || depth > depth_max || place >= type_count_max) return place;
    places_[die.addr] = place;
    fill(die, place, depth);
    return place;
  }

  void fill(Dwarf_Die& die, std::size_t place, std::size_t depth) {
    const int tag = dwarf_tag(&die);
    types_.types[place].size = number_of(die, DW_AT_byte_size).value_or(0);
    if (tag == DW_TAG_base_type) {
      types_.types[place].kind = base_kind(number_of(die, DW_AT_encoding).value_or(0));
    } else if (tag == DW_TAG_enumeration_type) {
      types_.types[place].kind = Type::Kind::enumeration;
    } else if (tag == DW_TAG_array_type) {
      fill_array(die, place, depth);
    } else if (is_record(tag)) {
      fill_record(die, place, depth);
    } else if (tag == DW_TAG_pointer_type || tag == DW_TAG_reference_type || tag == DW_TAG_rvalue_reference_type ||
               tag == DW_TAG_ptr_to_member_type) {
      types_.types[place].kind = Type::Kind::pointer;
      if (types_.types[place].size == 0) types_.types[place].size = 8;
    }
  }

  static Type::Kind base_kind(std::uint64_t encoding) {
    switch (encoding) {
      case DW_ATE_float:
        return Type::Kind::floating;
      case DW_ATE_boolean:
        return Type::Kind::boolean;
      case DW_ATE_signed:
      case DW_ATE_unsigned:
      case DW_ATE_signed_char:
      case DW_ATE_unsigned_char:
      case DW_ATE_UTF:
        return Type::Kind::integer;
      default:
        return Type::Kind::unknown;
    }
  }

  void set_array(std::size_t place, std::size_t element, std::uint64_t count) {
    Type& type = types_.types[place];
    const std::uint64_t size = types_.types[element].size;
    type.kind = Type::Kind::array;
    type.element = element;
    type.count = size != 0 && count > UINT32_MAX / size ? 0 : count;
    type.size = type.count * size;
  }

  void fill_array(Dwarf_Die& die, std::size_t place, std::size_t depth) {
    Dwarf_Die element;
    if (!type_of(die, element)) return;
    std::uint64_t count = 1;
    for (const std::uint64_t each : counts_of(die)) count = each > UINT32_MAX || count > UINT32_MAX ? 0 : count * each;
    set_array(place, add(element, depth + 1), count);
  }

  void fill_record(Dwarf_Die& die, std::size_t place, std::size_t depth) {
    if (const auto record = records_.find(die.addr); record != records_.end()) {
      Type& type = types_.types[place];
      type.name = qualified(record->second->scope, record->second->name);
      type.scope = record->second->scope.names;
      type.scope.push_back(record->second->name);
      type.namespace_count = record->second->scope.namespace_count;
    }
    const int tag = dwarf_tag(&die);
    types_.types[place].kind = Type::Kind::record;
    types_.types[place].is_union = tag == DW_TAG_union_type;
    if (is_std_array(types_.types[place]) && fill_std_array(die, place, depth)) return;
    if (is_std_list(types_.types[place]) && fill_std_list(die, place, depth)) return;
    Dwarf_Die child;
    if (dwarf_child(&die, &child) != 0) return;
    std::size_t left = type_count_max;
    do {
      const int child_tag = dwarf_tag(&child);
      const bool is_base = child_tag == DW_TAG_inheritance;
      if (!is_base && (child_tag != DW_TAG_member || has_flag(child, DW_AT_external))) continue;
      Dwarf_Die type;
      if (!type_of(child, type)) continue;
      Field field = field_of(child, is_base, tag == DW_TAG_class_type);
      field.type = add(type, depth + 1);
      field.type_name = text(type, 0);
      types_.types[place].fields.push_back(std::move(field));
    } while (--left > 0 && dwarf_siblingof(&child, &child) == 0);
  }

  static Field field_of(Dwarf_Die& die, bool is_base, bool is_private_by_default) {
    Field field;
    field.name = is_base ? "" : name_of(die);
    field.is_base = is_base;
    const auto access = number_of(die, DW_AT_accessibility);
    field.is_private = access ? *access != DW_ACCESS_public : is_private_by_default;
    field.is_bit_field = number_of(die, DW_AT_bit_size).has_value();
    const auto virtuality = number_of(die, DW_AT_virtuality);
    field.is_virtual = virtuality.value_or(DW_VIRTUALITY_none) != DW_VIRTUALITY_none;
    if (const auto offset = number_of(die, DW_AT_data_member_location))
      field.offset = *offset;
    else if (const auto bits = number_of(die, DW_AT_data_bit_offset))
      field.offset = *bits / 8;
    return field;
  }

  static bool is_std_array(const Type& type) {
    return type.scope.size() >= 2 && type.scope[0] == "std" && type.scope.back().rfind("array<", 0) == 0;
  }
  static bool is_std_list(const Type& type) {
    if (type.scope.size() < 2 || type.scope[0] != "std") return false;
    return type.scope.back().rfind("vector<", 0) == 0 || type.scope.back().rfind("span<", 0) == 0;
  }
  /// By its first template argument.
  bool fill_std_list(Dwarf_Die& die, std::size_t place, std::size_t depth) {
    Dwarf_Die child, element;
    if (dwarf_child(&die, &child) != 0) return false;
    do {
      if (dwarf_tag(&child) != DW_TAG_template_type_parameter || !type_of(child, element)) continue;
      const std::size_t of_element = add(element, depth + 1);
      types_.types[place].element = of_element;
      types_.types[place].is_list = true;
      return true;
    } while (dwarf_siblingof(&child, &child) == 0);
    return false;
  }
  /// By its template arguments: a type and a number.
  bool fill_std_array(Dwarf_Die& die, std::size_t place, std::size_t depth) {
    Dwarf_Die child, element;
    std::optional<std::uint64_t> count;
    bool has_element = false;
    if (dwarf_child(&die, &child) != 0) return false;
    do {
      if (dwarf_tag(&child) == DW_TAG_template_type_parameter && !has_element) has_element = type_of(child, element);
      if (dwarf_tag(&child) == DW_TAG_template_value_parameter) count = number_of(child, DW_AT_const_value);
    } while ((!has_element || !count) && dwarf_siblingof(&child, &child) == 0);
    if (!has_element || !count) return false;
    const std::uint64_t size = types_.types[place].size;
    set_array(place, add(element, depth + 1), *count);
    types_.types[place].size = size;
    return true;
  }

  const std::map<const void*, const Found*>& records_;
  std::map<const void*, std::size_t> places_;
  StructTypes types_;
};

struct Opened {
  Program program;
  std::vector<Found> found;
};

Result<std::uint64_t> size_of_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return Error{ErrorCode::io, path + ": " + std::strerror(errno), ""};
  if (!S_ISREG(status.st_mode)) return Error{ErrorCode::io, path + ": found no regular file, expected a program", ""};
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > file_size_max)
    return Error{ErrorCode::limit, path + ": found " + std::to_string(size) + " bytes, expected at most 4 GiB", ""};
  return size;
}

/// Each module: one for a file, one for each member of an archive.
int search_module(Dwfl_Module* module, void**, const char*, Dwarf_Addr, void* search) {
  Dwarf_Addr bias = 0;
  Dwarf* dwarf = dwfl_module_getdwarf(module, &bias);
  if (dwarf == nullptr) return DWARF_CB_OK;
  Dwarf_CU* unit = nullptr;
  Dwarf_Die die, type;
  while (dwarf_get_units(dwarf, unit, &unit, nullptr, nullptr, &die, &type) == 0)
    static_cast<Search*>(search)->unit(die);
  return DWARF_CB_OK;
}

Result<Opened> open_program(const std::string& path) {
  const Result<std::uint64_t> size = size_of_file(path);
  if (!size) return size.error();
  // The file itself, and the one that its debug link names beside it. No server is asked.
  ::unsetenv("DEBUGINFOD_URLS");
  static const Dwfl_Callbacks calls = {&dwfl_build_id_find_elf, &dwfl_standard_find_debuginfo,
                                       &dwfl_offline_section_address, nullptr};
  Opened opened;
  opened.program.reset(dwfl_begin(&calls));
  if (opened.program == nullptr) return Error{ErrorCode::limit, path + ": libdw: " + dwfl_errmsg(-1), ""};
  dwfl_report_begin(opened.program.get());
  const bool is_object = dwfl_report_offline(opened.program.get(), path.c_str(), path.c_str(), -1) != nullptr;
  const int code = dwfl_errno();
  dwfl_report_end(opened.program.get(), nullptr, nullptr);
  if (!is_object)
    return Error{ErrorCode::corrupt, path + ": found no ELF file that can be read: " + dwfl_errmsg(code),
                 "a program, a shared library or an object file"};
  // An entry has at least a byte; compressed sections are a few times as large as in the file.
  Search search((std::uint64_t{1} << 20) + 16 * *size);
  dwfl_getmodules(opened.program.get(), &search_module, &search, 0);
  if (search.has_ended_early())
    return Error{ErrorCode::corrupt, path + ": debug information: found more entries than the file has bytes", ""};
  if (search.found.empty())
    return Error{ErrorCode::unsupported, path + ": debug information: found no struct, expected DWARF",
                 "compile with -g, and do not strip the file"};
  opened.found = std::move(search.found);
  return opened;
}

/// "Unit" and "game::Unit" are names of game::Unit; "Pair" is one of Pair<int>.
bool is_named(const Found& found, const std::string& name) {
  std::string whole = qualified(found.scope, found.name);
  if (whole == name) return true;
  if (name.find('<') == std::string::npos) whole = qualified(found.scope, found.name.substr(0, found.name.find('<')));
  if (whole == name) return true;
  return whole.size() > name.size() + 2 &&
         whole.compare(whole.size() - name.size() - 2, std::string::npos, "::" + name) == 0;
}

/// Of the language and its library: namespace std, and names with an underscore in front.
bool is_reserved(const Found& found) {
  const std::string& first = found.scope.names.empty() ? found.name : found.scope.names[0];
  return first == "std" || first.rfind("_", 0) == 0 || first.find(' ') < first.find('<');
}

/// What two definitions of one struct have in common.
std::string shape_of(const StructTypes& types) {
  std::string shape = types.types[0].name + " " + std::to_string(types.types[0].size);
  for (const Field& field : types.types[0].fields)
    shape += " " + field.name + "@" + std::to_string(field.offset) + ":" + field.type_name;
  return shape;
}

}  // namespace

bool can_read_debug_info() {
  return true;
}

Result<std::vector<StructName>> struct_names(const std::string& path) {
  Result<Opened> opened = open_program(path);
  if (!opened) return opened.error();
  std::set<std::pair<std::string, std::uint64_t>> names;
  for (Found& found : opened->found)
    if (!is_reserved(found))
      names.insert({qualified(found.scope, found.name), number_of(found.die, DW_AT_byte_size).value_or(0)});
  std::vector<StructName> result;
  for (const auto& [name, size] : names) result.push_back({name, size});
  return result;
}

Result<std::vector<StructTypes>> find_structs(const std::string& path, const std::string& name) {
  Result<Opened> opened = open_program(path);
  if (!opened) return opened.error();
  std::map<const void*, const Found*> records;
  for (const Found& found : opened->found) records[found.die.addr] = &found;
  std::map<std::string, StructTypes> by_shape;
  for (const Found& found : opened->found) {
    if (!is_named(found, name)) continue;
    StructTypes types = Types(records).of(found);
    by_shape.emplace(shape_of(types), std::move(types));
  }
  std::vector<StructTypes> result;
  for (auto& [shape, types] : by_shape) result.push_back(std::move(types));
  // The whole name says which: game::Unit beside ui::game::Unit.
  const auto is_whole = [&name](const StructTypes& types) { return types.types[0].name == name; };
  if (std::any_of(result.begin(), result.end(), is_whole))
    result.erase(std::remove_if(result.begin(), result.end(), [&](const auto& t) { return !is_whole(t); }),
                 result.end());
  if (result.empty()) return Error{ErrorCode::usage, path + ": struct " + name + ": found none of this name", ""};
  return result;
}

}  // namespace ticktrue::debug_info
