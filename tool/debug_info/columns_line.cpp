// Decides as include/ticktrue.hpp does which members are columns, and writes the lines and the table.
// SPDX-License-Identifier: MIT
#include "tool/debug_info/columns_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace ticktrue::debug_info {
namespace {

constexpr std::size_t nested_max = 32;
constexpr std::uint64_t lane_count_max = 255;
constexpr std::size_t line_size_max = 120;

/// A name as it begins in namespace std, and what a member of such a type is.
struct StandardType {
  std::string_view name;
  std::string_view refusal;
};
constexpr std::string_view text_refusal =
    "is text of wide characters: other bytes on other machines. Use UTF-8 in a std::string";
constexpr std::string_view container_refusal =
    "is a container whose elements do not lie side by side. Use a std::vector, sorted where the order is not fixed";
constexpr std::string_view pointers_refusal = "is a list of pointers: other addresses in every run. Use indices or ids";
constexpr std::string_view pointer_refusal =
    "is a pointer or a reference: another address in every run. Use an index or an id";
constexpr StandardType standard_types[] = {
    {"basic_string", text_refusal},      {"vector", container_refusal},
    {"deque", container_refusal},        {"list", container_refusal},
    {"forward_list", container_refusal}, {"map", container_refusal},
    {"multimap", container_refusal},     {"set", container_refusal},
    {"multiset", container_refusal},     {"unordered_", container_refusal},
    {"span", container_refusal},         {"queue", container_refusal},
    {"stack", container_refusal},        {"priority_queue", container_refusal},
    {"unique_ptr", pointer_refusal},     {"shared_ptr", pointer_refusal},
    {"weak_ptr", pointer_refusal},
};

/// The numbers that a type consists of.
struct Numbers {
  std::size_t type = 0;     // place of a scalar
  std::uint64_t count = 0;  // lanes
};

class Layouts {
 public:
  explicit Layouts(const StructTypes& types) : types_(types.types) {}

  std::vector<StructLayout> all() {
    if (!types_.empty()) add(0, 0);
    return std::move(layouts_);
  }

 private:
  const Type& at(std::size_t place) const { return types_[place]; }

  static bool is_scalar(const Type& type) {
    switch (type.kind) {
      case Type::Kind::floating:
        return type.size == 4 || type.size == 8;
      case Type::Kind::boolean:
        return type.size == 1;
      case Type::Kind::integer:
      case Type::Kind::enumeration:
        return type.size == 1 || type.size == 2 || type.size == 4 || type.size == 8;
      default:
        return false;
    }
  }

  /// The member of this name, also in an anonymous union or struct.
  std::optional<std::size_t> type_of_member(const Type& record, std::string_view name, std::size_t depth) const {
    for (const Field& field : record.fields) {
      if (field.name == name && !field.is_private && !field.is_bit_field) return field.type;
      if (!field.name.empty() || field.is_base || depth > 2 || at(field.type).kind != Type::Kind::record) continue;
      if (const auto inner = type_of_member(at(field.type), name, depth + 1)) return inner;
    }
    return {};
  }

  /// Each unit of the program may have a `double` of its own.
  bool is_same_scalar(std::size_t a, std::size_t b) const {
    return at(a).kind == at(b).kind && at(a).size == at(b).size && at(a).name == at(b).name;
  }

  /// x, y and perhaps z, w of one scalar type that fill the struct.
  std::optional<Numbers> vector_of(const Type& record) const {
    const auto x = type_of_member(record, "x", 0), y = type_of_member(record, "y", 0);
    if (!x || !y || !is_same_scalar(*x, *y) || !is_scalar(at(*x))) return {};
    const auto z = type_of_member(record, "z", 0), w = type_of_member(record, "w", 0);
    const std::uint64_t count = 2u + (z && is_same_scalar(*z, *x) ? 1u : 0u) + (w && is_same_scalar(*w, *x) ? 1u : 0u);
    if (record.is_union || record.size != count * at(*x).size) return {};
    return Numbers{*x, count};
  }

  std::optional<Numbers> numbers_of(std::size_t place, std::size_t depth) const {
    const Type& type = at(place);
    if (depth > nested_max) return {};
    if (is_scalar(type)) return Numbers{place, 1};
    if (type.kind == Type::Kind::record) return vector_of(type);
    if (type.kind != Type::Kind::array || type.count == 0) return {};
    std::optional<Numbers> element = numbers_of(type.element, depth + 1);
    if (element) element->count = type.count > lane_count_max ? lane_count_max + 1 : element->count * type.count;
    return element;
  }

  static std::string_view standard_refusal(const Type& type) {
    if (type.scope.size() < 2 || type.scope[0] != "std") return {};
    for (const StandardType& standard : standard_types)
      if (type.scope.back().compare(0, standard.name.size(), standard.name) == 0) return standard.refusal;
    return {};
  }

  static bool is_std_text(const Type& type) {
    if (type.scope.size() < 2 || type.scope[0] != "std") return false;
    for (const char* name :
         {"basic_string<char,", "basic_string<char8_t,", "basic_string_view<char,", "basic_string_view<char8_t,"})
      if (type.scope.back().rfind(name, 0) == 0) return true;
    return false;
  }

  /// Why the elements of a list cannot be recorded; empty: they can.
  std::string list_refusal(std::size_t element, std::size_t depth) {
    const Type& type = at(element);
    if (type.kind == Type::Kind::boolean)
      return "is a list of bits, which have no addresses. Use std::vector<std::uint8_t>";
    if (type.kind == Type::Kind::pointer) return std::string(pointers_refusal);
    if (std::find(open_.begin(), open_.end(), element) != open_.end())
      return "is a list of the struct that it is in. Keep indices or ids in it";
    const std::string refusal = refusal_of(element, depth + 1);
    return refusal.empty() ? "" : "is a list of " + type.name + ", and that " + refusal;
  }

  /// Why the type is no column; empty: it is one, or its columns have lines of their own by now.
  std::string refusal_of(std::size_t place, std::size_t depth) {
    const Type& type = at(place);
    if (depth > nested_max) return "is nested too deep to be looked at";
    if (const std::optional<Numbers> numbers = numbers_of(place, 0))
      return numbers->count <= lane_count_max ? ""
                                              : "has more than 255 numbers. Make them rows of a table of their own";
    switch (type.kind) {
      case Type::Kind::pointer:
        return std::string(pointer_refusal);
      case Type::Kind::floating:
        return "is " + type.name + ": other bytes on other machines. Use double";
      case Type::Kind::array:
        return type.count == 0 ? "is an array of unknown size. Make its rows a table of their own"
                               : refusal_of(type.element, depth + 1);
      case Type::Kind::record:
        break;
      default:
        return "is of a type that is no column: " + type.name;
    }
    if (is_std_text(type)) return "";
    if (type.is_list) return list_refusal(type.element, depth);
    if (const std::string_view standard = standard_refusal(type); !standard.empty()) return std::string(standard);
    if (type.is_union) return "is a union: nothing says which member is valid. Keep a value of each beside it";
    if (type.scope.empty() || type.scope[0] == "std")
      return "is a struct that nobody can write TICKTRUE_COLUMNS for. Keep its values in members";
    return add(place, depth + 1) ? "" : "is a struct of which no member is a column";
  }

  /// The layout of a record, behind those that it needs. False: it has no columns.
  bool add(std::size_t place, std::size_t depth) {
    const Type& type = at(place);
    const auto known =
        std::find_if(layouts_.begin(), layouts_.end(), [&](const auto& l) { return l.name == type.name; });
    if (known != layouts_.end()) return known->has_columns();
    StructLayout layout;
    layout.name = type.name;
    const auto behind = type.scope.begin() + static_cast<std::ptrdiff_t>(type.namespace_count);
    layout.scope.assign(type.scope.begin(), behind);
    for (auto part = behind; part != type.scope.end(); ++part)
      layout.local_name += (layout.local_name.empty() ? "" : "::") + *part;
    layout.size = type.size;
    open_.push_back(place);
    add_members(type, {0, false, false}, layout, depth);
    open_.pop_back();
    // total order: by offset, then in the order of the debug information
    std::stable_sort(layout.members.begin(), layout.members.end(),
                     [](const LayoutMember& a, const LayoutMember& b) { return a.offset < b.offset; });
    find_gaps(layout);
    for (const LayoutMember& member : layout.members)
      layout.has_private = layout.has_private || (member.is_private && member.refusal.empty());
    const bool has_columns = layout.has_columns();
    if (has_columns || depth == 0) layouts_.push_back(std::move(layout));
    return has_columns;
  }

  struct Inside {
    std::uint64_t offset = 0;
    bool is_base = false;
    bool is_union = false;
  };

  void add_members(const Type& record, Inside inside, StructLayout& layout, std::size_t depth) {
    if (depth > nested_max || layout.members.size() > 4096) return;
    for (const Field& field : record.fields) {
      const Type& type = at(field.type);
      const std::uint64_t offset = inside.offset + field.offset;
      if (field.name.empty() && type.kind == Type::Kind::record && !field.is_virtual) {
        add_members(type, {offset, inside.is_base || field.is_base, inside.is_union || type.is_union}, layout,
                    depth + 1);
        continue;
      }
      if (field.name.empty()) {
        layout.members.push_back(
            {"(base)", field.type_name, offset, type.size, "is a virtual base, at no fixed place", false});
        continue;
      }
      LayoutMember member{field.name, field.type_name, offset, type.size, "", field.is_private};
      if (field.name.rfind("_vptr", 0) == 0)
        member.refusal = "is the compiler's, for virtual functions: an address";
      else if (field.is_bit_field)
        member.refusal = "is a bit-field, which has no address. Use a whole integer";
      else if (inside.is_union)
        member.refusal = "is one of a union: nothing says which member is valid. Keep a value of each beside it";
      else if (inside.is_base && field.is_private)
        member.refusal = "is private in a base, out of reach";
      else
        member.refusal = refusal_of(field.type, depth);
      layout.members.push_back(std::move(member));
    }
  }

  static void find_gaps(StructLayout& layout) {
    std::uint64_t end = 0;
    for (const LayoutMember& member : layout.members) {
      if (member.offset > end) layout.gaps.push_back({end, member.offset - 1});
      end = std::max(end, member.offset + member.size);
    }
    if (end < layout.size) layout.gaps.push_back({end, layout.size - 1});
  }

  const std::vector<Type>& types_;
  std::vector<StructLayout> layouts_;
  std::vector<std::size_t> open_;  // records whose members are being looked at
};

std::string gap_text(const Gap& gap) {
  return gap.first == gap.last ? std::to_string(gap.first) : fmt::format("{}..{}", gap.first, gap.last);
}

/// Words behind `head`, in lines of at most 120 characters.
std::string wrapped(const std::string& head, const std::vector<std::string>& words, const std::string& end) {
  std::string text = head;
  std::size_t column = head.size();
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word = words[i] + (i + 1 < words.size() ? "," : end);
    if (i > 0 && column + 1 + word.size() > line_size_max) {
      text += "\n    ";
      column = 4;
    } else if (i > 0) {
      text += " ";
      ++column;
    }
    text += word;
    column += word.size();
  }
  return text + "\n";
}

/// The line of one struct and what is to be said of it, inside of its namespace.
std::string struct_text(const StructLayout& layout) {
  std::string text, name = layout.local_name;
  // Commas of template arguments would end the argument of the macro.
  if (name.find(',') != std::string::npos) {
    name = "TicktrueRow" + std::to_string(layout.size);
    text += "using " + name + " = " + layout.local_name + ";\n";
  }
  std::vector<std::string> columns;
  std::size_t width = 0;
  for (const LayoutMember& member : layout.members) {
    if (member.refusal.empty())
      columns.push_back(member.name);
    else
      width = std::max(width, member.name.size());
  }
  if (columns.empty()) {
    text += "// " + layout.local_name + ": no member is a column\n";
  } else if (layout.has_private) {
    text += "// Has private members. This line stands inside of " + layout.local_name + ":\n";
    text += wrapped("// friend TICKTRUE_COLUMNS(" + name + ", ", columns, ")");
  } else {
    text += wrapped("TICKTRUE_COLUMNS(" + name + ", ", columns, ")");
  }
  for (const LayoutMember& member : layout.members)
    if (!member.refusal.empty()) text += fmt::format("//   left out  {:<{}}  {}\n", member.name, width, member.refusal);
  std::string gaps;
  for (const Gap& gap : layout.gaps) gaps += (gaps.empty() ? "" : ", ") + gap_text(gap);
  if (!gaps.empty()) text += "//   padding   bytes " + gaps + " of " + std::to_string(layout.size) + ", in no trace\n";
  return text;
}

}  // namespace

bool StructLayout::has_columns() const {
  return std::any_of(members.begin(), members.end(), [](const LayoutMember& m) { return m.refusal.empty(); });
}

std::vector<StructLayout> struct_layouts(const StructTypes& types) {
  return Layouts(types).all();
}

std::string columns_text(const std::vector<StructLayout>& layouts) {
  std::string text;
  std::vector<std::string> open;
  const auto change = [&](const std::vector<std::string>& scope) {
    if (scope == open) return;
    for (auto part = open.rbegin(); part != open.rend(); ++part)
      text += "}" + (part->empty() ? std::string() : "  // namespace " + *part) + "\n";
    for (const std::string& part : scope) text += "namespace " + part + (part.empty() ? "{\n" : " {\n");
    open = scope;
  };
  for (const StructLayout& layout : layouts) {
    change(layout.scope);
    text += struct_text(layout);
  }
  change({});
  return text;
}

std::string layout_table(const StructLayout& layout) {
  struct Row {
    std::uint64_t offset, size;
    std::string name, type;
  };
  std::vector<Row> rows;
  for (const LayoutMember& m : layout.members)
    rows.push_back({m.offset, m.size, m.name + (m.refusal.empty() ? "" : " *"), m.type});
  for (const Gap& gap : layout.gaps) rows.push_back({gap.first, gap.last - gap.first + 1, "-", "padding"});
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.offset < b.offset; });
  std::size_t width = 6;
  for (const Row& row : rows) width = std::max(width, row.name.size());
  std::string text =
      fmt::format("{}  {} bytes\n  offset  size  {:<{}}  type\n", layout.name, layout.size, "member", width);
  for (const Row& row : rows)
    text += fmt::format("  {:>6}  {:>4}  {:<{}}  {}\n", row.offset, row.size, row.name, width, row.type);
  const bool has_refused = std::any_of(layout.members.begin(), layout.members.end(),
                                       [](const LayoutMember& m) { return !m.refusal.empty(); });
  return text + (has_refused ? "  * no column\n" : "");
}

}  // namespace ticktrue::debug_info
