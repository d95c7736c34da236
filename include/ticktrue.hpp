// The C++20 layer over ticktrue.h: the program names each member of a struct once, and the session registers them.
// SPDX-License-Identifier: MIT
//
//   TICKTRUE_COLUMNS(Unit, id, pos, vel, name, inventory)           // once, beside the struct
//   ticktrue::Session session(argc, argv, "mygame");                // --record F, --verify F
//   session.table("units", units);                                  // std::vector<Unit>, may grow and move
//   while (...) { if (!session.begin_tick()) break; step(); session.end_tick(); }
//   return session.close();
//
// docs/any_simulation.md, "C++: five lines", explains it. Rules:
// - Header-only over the C interface: the same calls, the same bytes in a trace. `handle()` returns the C session.
// - Only exhausted memory and callbacks of the program throw. It builds with -fno-exceptions and -fno-rtti.
// - A failed recording never ends the game: calls return true, `error()` has the reason, `close()` returns 2.
// - If a verification ends, differs or fails, calls return false: leave the loop.
// - A session without --record and --verify is off: calls return true and do nothing.
#pragma once

#include <ticktrue.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace ticktrue {

/// States that a type consists of `count` equal numbers and nothing else, if the header cannot detect this:
///   template <> struct ticktrue::lanes<Matrix4> : ticktrue::lanes_of<float, 16> {};
template <class T>
struct lanes;
template <class Scalar, std::size_t Count>
struct lanes_of {
  using scalar = Scalar;
  static constexpr std::size_t count = Count;
};

namespace detail {

template <class T>
struct Of {};
struct Ignore {
  template <class Entry>
  constexpr void operator()(Entry) const {}
};

template <class T>
concept HasLanes = requires {
  typename lanes<T>::scalar;
  lanes<T>::count;
};
/// TICKTRUE_COLUMNS must be in the namespace of the struct: the call is found by its argument (ADL).
template <class T>
concept HasColumns = requires {
  ticktrue_columns_of(Of<T>{}, Ignore{});
};
template <class T>
concept IsScalar = (std::is_arithmetic_v<T> && !std::is_same_v<T, long double>) || std::is_enum_v<T>;
template <class T>
concept IsSmartPointer = requires(const T& pointer) {
  typename T::element_type;
  pointer.get();
};
template <class T>
concept IsContainer = requires(const T& container) {
  container.begin();
  container.end();
};
template <class T>
concept IsContiguous = requires(const T& container) {
  {*std::data(container)};
  {std::size(container)};
};

template <class T>
struct ArrayOf {
  using element = void;
  static constexpr std::size_t count = 0;
};
template <class T, std::size_t Count>
struct ArrayOf<T[Count]> {
  using element = std::remove_cv_t<T>;
  static constexpr std::size_t count = Count;
};
template <class T, std::size_t Count>
struct ArrayOf<std::array<T, Count>> {
  using element = std::remove_cv_t<T>;
  static constexpr std::size_t count = Count;
};
template <class T>
concept IsArray = !std::is_void_v<typename ArrayOf<T>::element>;

/// The number of x, y, z, w in a vector of equal numbers without padding; 0: not such a vector.
template <class T>
constexpr std::size_t vector_size() {
  if constexpr (requires(T & v) { requires IsScalar<decltype(v.x)> && std::is_same_v<decltype(v.x), decltype(v.y)>; }) {
    constexpr std::size_t count = sizeof(T) / sizeof(decltype(std::declval<T&>().x));
    constexpr bool has_z = requires(T & v) {
      requires std::is_same_v<decltype(v.x), decltype(v.z)>;
    };
    constexpr bool has_w = requires(T & v) {
      requires std::is_same_v<decltype(v.x), decltype(v.w)>;
    };
    constexpr bool is_whole = sizeof(T) == count * sizeof(decltype(std::declval<T&>().x));
    return is_whole && count == 2u + (has_z ? 1u : 0u) + (has_w ? 1u : 0u) ? count : 0;
  } else {
    return 0;
  }
}

/// The kind of a member. Texts, bytes and lists become separate tables, linked to the rows to which they belong.
enum class Kind {
  numbers,
  columns,
  text,
  bytes,
  list,
  pointer,
  wide_text,
  container,
  pointers,
  bad_list,
  long_double,
  too_wide,
  other
};

template <class T>
constexpr std::size_t lane_count();
template <class T>
constexpr Kind kind_of();

template <class T>
concept IsByte = std::is_same_v<T, unsigned char> || std::is_same_v<T, char> || std::is_same_v<T, std::byte> ||
    std::is_same_v<T, char8_t>;

/// The adjacent elements of a container.
template <class C>
using ElementOf = std::remove_cvref_t<decltype(*std::data(std::declval<const C&>()))>;

template <class Element>
constexpr Kind list_kind() {
  if constexpr (IsByte<Element>) {
    return Kind::bytes;
  } else {
    constexpr Kind kind = kind_of<Element>();
    constexpr bool is_list = kind == Kind::numbers || kind == Kind::columns || kind == Kind::text ||
                             kind == Kind::bytes || kind == Kind::list;
    return is_list ? Kind::list : kind == Kind::pointer || kind == Kind::pointers ? Kind::pointers : Kind::bad_list;
  }
}

template <class T>
constexpr Kind plain_kind() {
  if constexpr (std::is_reference_v<T> || std::is_pointer_v<T> || std::is_member_pointer_v<T> || IsSmartPointer<T>)
    return Kind::pointer;
  else if constexpr (HasLanes<T>)
    return Kind::numbers;
  else if constexpr (HasColumns<T>)
    return Kind::columns;
  else if constexpr (std::is_same_v<T, long double>)
    return Kind::long_double;
  else if constexpr (IsScalar<T> || vector_size<T>() > 0)
    return Kind::numbers;
  else if constexpr (IsArray<T>)
    return ArrayOf<T>::count > 0 ? plain_kind<typename ArrayOf<T>::element>() : Kind::other;
  else if constexpr (!IsContainer<T>)
    return Kind::other;
  else if constexpr (!IsContiguous<T>)
    return Kind::container;
  else if constexpr (requires { typename T::traits_type; })
    return sizeof(ElementOf<T>) == 1 ? Kind::text : Kind::wide_text;
  else
    return list_kind<ElementOf<T>>();
}

template <class T>
constexpr Kind kind_of() {
  if constexpr (plain_kind<std::remove_cv_t<T>>() != Kind::numbers)
    return plain_kind<std::remove_cv_t<T>>();
  else
    return lane_count<std::remove_cv_t<T>>() <= 255 ? Kind::numbers : Kind::too_wide;
}

template <class T>
constexpr std::size_t lane_count() {
  if constexpr (HasLanes<T>) {
    static_assert(sizeof(T) == lanes<T>::count * sizeof(typename lanes<T>::scalar),
                  "ticktrue: lanes: the type has other bytes beside these numbers: padding, or further members");
    return lanes<T>::count;
  } else if constexpr (IsArray<T>) {
    static_assert(sizeof(T) == ArrayOf<T>::count * sizeof(typename ArrayOf<T>::element));
    return ArrayOf<T>::count * lane_count<typename ArrayOf<T>::element>();
  } else if constexpr (IsScalar<T>) {
    return 1;
  } else {
    return vector_size<T>();
  }
}

/// The type of the numbers in T.
template <class T>
constexpr auto number_in() {
  if constexpr (HasLanes<T>)
    return Of<typename lanes<T>::scalar>{};
  else if constexpr (IsArray<T>)
    return number_in<typename ArrayOf<T>::element>();
  else if constexpr (std::is_enum_v<T>)
    return Of<std::underlying_type_t<T>>{};
  else if constexpr (std::is_arithmetic_v<T>)
    return Of<T>{};
  else
    return number_in<decltype(std::declval<T&>().x)>();
}

/// One of TICKTRUE_U8..TICKTRUE_F64. Signed numbers of 8 and 16 bits are compared by their bits, as in ticktrue.h.
template <class T>
constexpr int type_of(Of<T>) {
  static_assert(sizeof(T) == 1 || sizeof(T) == 2 || sizeof(T) == 4 || sizeof(T) == 8);
  if constexpr (std::is_floating_point_v<T>)
    return sizeof(T) == 4 ? TICKTRUE_F32 : TICKTRUE_F64;
  else if constexpr (sizeof(T) <= 2)
    return sizeof(T) == 1 ? TICKTRUE_U8 : TICKTRUE_U16;
  else if constexpr (sizeof(T) == 4)
    return std::is_signed_v<T> ? TICKTRUE_I32 : TICKTRUE_U32;
  else
    return std::is_signed_v<T> ? TICKTRUE_I64 : TICKTRUE_U64;
}

enum class Role { plain, key, shown, text, reference };

template <class T>
constexpr bool can_be_key() {
  if constexpr (std::is_enum_v<T>)
    return std::is_unsigned_v<std::underlying_type_t<T>>;
  else
    return std::is_unsigned_v<T> && !std::is_same_v<T, bool>;
}
template <class T>
constexpr bool can_refer() {
  if constexpr (kind_of<T>() == Kind::numbers)
    return type_of(number_in<std::remove_cv_t<T>>()) == TICKTRUE_U32;
  else
    return false;
}

/// Whether T can be a text that ends at its first zero.
template <class T>
constexpr bool is_char_array() {
  return IsByte<typename ArrayOf<T>::element>;
}

/// A member in TICKTRUE_COLUMNS.
template <class T, Role member_role>
struct Entry {
  using type = std::remove_cv_t<T>;
  static constexpr Role role = member_role;
  const char* name;
  std::size_t offset;  // bytes
  const char* target;  // of a reference: a table
};

/// A column in the form of the library.
struct Column {
  std::string name;
  int type;
  std::uint32_t lanes;
  std::size_t offset;  // bytes from the begin of a row
  std::size_t size;    // bytes
  Role role;
  const char* target;
};

struct List;

/// The columns and lists of a row, or of an element of a list.
struct Layout {
  std::vector<Column> columns;
  std::vector<List> lists;
};

/// A text, a byte string or a list in a row.
struct List {
  std::string name;  // appended to the name of the table
  Kind kind;         // text, bytes or list
  ticktrue_elements elements;
  std::size_t offset;  // bytes from the begin of a row
  std::size_t stride;  // bytes
  Layout layout;       // of an element
};

/// The elements of a C at `offset` bytes in a row.
template <class C>
const void* elements_of(void* offset, const void* row, std::uint32_t, std::size_t* count) {
  const auto* at = static_cast<const unsigned char*>(row) + reinterpret_cast<std::uintptr_t>(offset);
  if constexpr (IsArray<C>) {
    const void* end = std::memchr(at, 0, sizeof(C));
    *count = end == nullptr ? sizeof(C) : static_cast<std::size_t>(static_cast<const unsigned char*>(end) - at);
    return at;
  } else {
    const C& container = *static_cast<const C*>(static_cast<const void*>(at));
    *count = static_cast<std::size_t>(std::size(container));
    return std::data(container);
  }
}

template <class T>
constexpr std::size_t column_count();
template <class T>
constexpr bool has_shown();

inline constexpr int depth_max = 8;  // of nested lists

/// Appends the columns and lists of a T at `offset` bytes in a row. In an element of a list (`depth` 1 or deeper), the
/// struct itself has the name "".
template <class T, int depth = 0>
void add_columns(const std::string& name, std::size_t offset, Role role, const char* target, Layout& layout) {
  using Type = std::remove_cv_t<T>;
  if constexpr (is_char_array<Type>()) {
    if (role == Role::text) {
      layout.lists.push_back({name, Kind::text, &elements_of<Type>, offset, 1, {}});
      return;
    }
  }
  if constexpr (kind_of<Type>() == Kind::numbers) {
    constexpr int type = type_of(number_in<Type>());
    layout.columns.push_back(
        {name, type, static_cast<std::uint32_t>(lane_count<Type>()), offset, sizeof(Type), role, target});
  } else if constexpr (IsArray<Type>) {
    using Element = typename ArrayOf<Type>::element;
    for (std::size_t i = 0; i < ArrayOf<Type>::count; ++i)
      add_columns<Element, depth>(name + "[" + std::to_string(i) + "]", offset + i * sizeof(Element), role, target,
                                  layout);
  } else if constexpr (HasColumns<Type>) {
    ticktrue_columns_of(Of<Type>{}, [&](auto entry) {
      using Member = decltype(entry);
      const bool is_nested = !name.empty() || depth > 0;
      // A key orders the rows of a table. In a nested struct it is an ordinary column.
      const Role own = is_nested && Member::role == Role::key ? Role::plain : Member::role;
      std::string member = name.empty() ? std::string(entry.name) : name + "." + entry.name;
      // These names are taken: each list has such columns.
      if (depth > 0 && (member == "owner" || member == "index")) member = "value." + member;
      add_columns<typename Member::type, depth>(member, offset + entry.offset, role == Role::shown ? role : own,
                                                entry.target, layout);
    });
  } else if constexpr (kind_of<Type>() == Kind::text || kind_of<Type>() == Kind::bytes) {
    layout.lists.push_back({name, kind_of<Type>(), &elements_of<Type>, offset, 1, {}});
  } else if constexpr (kind_of<Type>() == Kind::list) {
    using Element = ElementOf<Type>;
    static_assert(depth < depth_max, "ticktrue: a list holds itself, or lists that are nested more than 8 times");
    static_assert(!has_shown<Element>(), "ticktrue: the elements of a list have a shown(...) member: leave it out");
    static_assert(column_count<Element>() <= 254, "ticktrue: the elements of a list have more than 254 columns");
    if constexpr (depth < depth_max) {
      List& list = layout.lists.emplace_back();
      list.name = name;
      list.kind = Kind::list;
      list.elements = &elements_of<Type>;
      list.offset = offset;
      list.stride = sizeof(Element);
      Layout element;
      add_columns<Element, depth + 1>(HasColumns<Element> && !HasLanes<Element> ? "" : "value", 0, Role::plain, nullptr,
                                      element);
      list.layout = std::move(element);
    }
  }
}

/// Whether a T has texts, bytes or lists whose elements are outside the T.
template <class T>
constexpr bool has_lists() {
  if constexpr (IsArray<T>) {
    return has_lists<typename ArrayOf<T>::element>();
  } else if constexpr (HasLanes<T> || !HasColumns<T>) {
    return kind_of<T>() == Kind::text || kind_of<T>() == Kind::bytes || kind_of<T>() == Kind::list;
  } else {
    bool has = false;
    ticktrue_columns_of(Of<T>{}, [&](auto entry) { has = has || has_lists<typename decltype(entry)::type>(); });
    return has;
  }
}

template <class T>
constexpr bool has_shown() {
  if constexpr (IsArray<T>) {
    return has_shown<typename ArrayOf<T>::element>();
  } else if constexpr (HasLanes<T> || !HasColumns<T>) {
    return false;
  } else {
    bool has = false;
    ticktrue_columns_of(Of<T>{}, [&](auto entry) {
      has = has || decltype(entry)::role == Role::shown || has_shown<typename decltype(entry)::type>();
    });
    return has;
  }
}

template <class T>
constexpr std::size_t column_count() {
  if constexpr (kind_of<T>() == Kind::numbers) {
    return 1;
  } else if constexpr (IsArray<T>) {
    return ArrayOf<T>::count * column_count<typename ArrayOf<T>::element>();
  } else if constexpr (!HasColumns<T>) {
    return 0;  // refused where the program names the member
  } else {
    std::size_t count = 0;
    ticktrue_columns_of(Of<T>{}, [&](auto entry) { count += column_count<typename decltype(entry)::type>(); });
    return count;
  }
}

template <class T>
constexpr bool keys_lead() {
  bool holds = true;
  if constexpr (HasColumns<T>) {
    bool is_leading = true;
    ticktrue_columns_of(Of<T>{}, [&](auto entry) {
      const bool is_key = decltype(entry)::role == Role::key;
      holds = holds && (!is_key || is_leading);
      is_leading = is_leading && is_key;
    });
  }
  return holds;
}

/// The address and number of the rows of a table.
struct Rows {
  const void* first = nullptr;
  std::size_t count = 0;
  bool operator==(const Rows&) const = default;
};

/// Whether C is a single row, not a container of rows.
template <class C>
constexpr bool is_single_row() {
  return !IsArray<C> && !IsContainer<C> && (!IsContiguous<C> || HasColumns<C>);
}

template <class C>
constexpr auto row_of() {
  if constexpr (std::is_array_v<C>)
    return Of<std::remove_cv_t<std::remove_all_extents_t<C>>>{};
  else if constexpr (is_single_row<C>())
    return Of<std::remove_cv_t<C>>{};
  else if constexpr (IsContiguous<C>)
    return Of<std::remove_cvref_t<decltype(*std::data(std::declval<const C&>()))>>{};
  else
    return Of<void>{};
}

template <class C, class Row>
Rows rows_of(const void* at) {
  const C& container = *static_cast<const C*>(at);
  if constexpr (std::is_array_v<C>)
    return {&container, sizeof(C) / sizeof(Row)};
  else if constexpr (is_single_row<C>())
    return {&container, 1};
  else
    return {std::data(container), static_cast<std::size_t>(std::size(container))};
}

template <class Row>
constexpr bool is_row() {
  if constexpr (std::is_void_v<Row>)
    return false;
  else
    return plain_kind<Row>() == Kind::columns || plain_kind<Row>() == Kind::numbers;
}

template <class Row>
constexpr void check_row(Of<Row>) {
  if constexpr (std::is_void_v<Row>) {
    static_assert(!std::is_void_v<Row>,
                  "ticktrue: table: the rows do not lie side by side: copy them into a std::vector before end_tick");
  } else {
    constexpr Kind kind = plain_kind<Row>();
    static_assert(kind != Kind::pointer,
                  "ticktrue: table: the rows are pointers: copy what they point to into a std::vector before end_tick");
    static_assert(kind == Kind::pointer || is_row<Row>(),
                  "ticktrue: table: the rows have no columns: write TICKTRUE_COLUMNS(Row, members...) beside the "
                  "struct; `ticktrue columns PROGRAM Row` prints that line");
    if constexpr (is_row<Row>()) {
      static_assert(column_count<Row>() <= 256, "ticktrue: table: more than 256 columns: make two tables of them");
      static_assert(column_count<Row>() > 0,
                    "ticktrue: table: the rows have texts and lists alone: add a number to TICKTRUE_COLUMNS, as an id");
      static_assert(keys_lead<Row>(), "ticktrue: TICKTRUE_COLUMNS: key(...) members come first");
    }
  }
}

/// The data of a session; the callbacks of the C interface point to it.
struct Core {
  struct Table {
    std::uint32_t number;
    const void* container;
    Rows (*rows)(const void* container);
    Rows known;
  };
  struct Reference {
    std::string table, column;
    const char* target;
  };

  ticktrue_session* session = nullptr;
  std::vector<Table> tables;
  std::vector<Reference> references;  // registered when all tables are registered
  ticktrue_saver saver = nullptr;
  ticktrue_loader loader = nullptr;
  void* user = nullptr;
  std::uint64_t ticks = 0;  // used while the library counts no ticks
  std::string closed_error;

  Core() = default;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core() { close(); }

  int close() {
    if (session == nullptr) return 0;
    closed_error = ticktrue_message(session);
    return ticktrue_close(std::exchange(session, nullptr));
  }

  /// Registers containers that have grown or moved.
  void refresh() {
    if (session == nullptr) return;
    for (Table& table : tables) {
      const Rows rows = table.rows(table.container);
      if (rows == table.known) continue;
      table.known = rows;
      const auto count = static_cast<std::uint32_t>(rows.count < UINT32_MAX ? rows.count : UINT32_MAX);
      ticktrue_rows(session, table.number, rows.first, count);
    }
  }

  void refer() {
    for (const Reference& r : references) ticktrue_reference(session, r.table.c_str(), r.column.c_str(), r.target);
    references.clear();
  }

  static std::size_t save(void* core, void* buffer, std::size_t size) {
    const Core& self = *static_cast<const Core*>(core);
    return self.saver(self.user, buffer, size);
  }
  static int load(void* core, const void* bytes, std::size_t size) {
    Core& self = *static_cast<Core*>(core);
    const int status = self.loader(self.user, bytes, size);
    if (status == 0) self.refresh();
    return status;
  }
};

/// The bytes of a T as inputs of a tick, without padding. A bool from a trace becomes 0 or 1.
template <class T>
int input_of(ticktrue_session* session, unsigned char* at) {
  if constexpr (std::is_same_v<T, bool>) {
    unsigned char byte = *at != 0 ? 1 : 0;
    const int status = ticktrue_input(session, &byte, 1);
    const bool value = byte != 0;
    std::memcpy(at, &value, 1);
    return status;
  } else if constexpr (IsArray<T> && !HasLanes<T>) {
    using Element = typename ArrayOf<T>::element;
    int status = TICKTRUE_OK;
    for (std::size_t i = 0; i < ArrayOf<T>::count && status == TICKTRUE_OK; ++i)
      status = input_of<Element>(session, at + i * sizeof(Element));
    return status;
  } else if constexpr (HasColumns<T> && !HasLanes<T>) {
    int status = TICKTRUE_OK;
    ticktrue_columns_of(Of<T>{}, [&](auto entry) {
      if (status == TICKTRUE_OK) status = input_of<typename decltype(entry)::type>(session, at + entry.offset);
    });
    return status;
  } else {
    return ticktrue_input(session, at, sizeof(T));
  }
}

template <class T>
constexpr bool has_plain_bytes() {
  return std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T> && !std::is_pointer_v<T>;
}
template <class T>
constexpr bool can_be_input() {
  const Kind kind = kind_of<T>();
  return (kind == Kind::columns && !has_lists<T>()) || kind == Kind::numbers || kind == Kind::too_wide ||
         (kind == Kind::other && has_plain_bytes<T>());
}

template <class State, class Save>
std::size_t save_state(void* state, void* buffer, std::size_t size) {
  const auto bytes = Save{}(*static_cast<const State*>(state));
  static_assert(sizeof(*std::data(bytes)) == 1, "ticktrue: saves: save returns bytes: std::string, std::vector<char>");
  const auto count = static_cast<std::size_t>(std::size(bytes));
  if (count > 0 && count <= size) std::memcpy(buffer, std::data(bytes), count);
  return count;
}
template <class State, class Load>
int load_state(void* state, const void* bytes, std::size_t size) {
  return Load{}(*static_cast<State*>(state), std::span(static_cast<const std::byte*>(bytes), size)) ? 0 : 1;
}
template <class State>
std::size_t copy_state(void* state, void* buffer, std::size_t size) {
  if (size >= sizeof(State)) std::memcpy(buffer, state, sizeof(State));
  return sizeof(State);
}
template <class State>
int paste_state(void* state, const void* bytes, std::size_t size) {
  if (size != sizeof(State)) return 1;
  std::memcpy(state, bytes, size);
  return 0;
}

}  // namespace detail

/// The options of ticktrue.h, with the same names and meanings, and functions to fill them in.
struct Options : ticktrue_options {
  /// `facts`: of the unit that makes the options. Never pass this argument.
  explicit Options(const char* program, const char* facts = TICKTRUE_CALLER_FACTS) : ticktrue_options() {
    struct_size = sizeof(ticktrue_options);
    name = program;
    caller_facts = facts;
  }

  /// The data with which the program can begin again, such as a struct of level, seed and players. Session::setup
  /// returns it.
  /// Requires: `value` lives until the session is opened.
  template <class T>
  Options& set_setup(const T& value) {
    static_assert(detail::has_plain_bytes<T>(),
                  "ticktrue: set_setup: takes a struct of integers without padding; else set setup and setup_size");
    setup = &value;
    setup_size = sizeof value;
    return *this;
  }

  /// Makes a recording store marks and notes. Otherwise they are dropped.
  Options& marks() {
    flags |= TICKTRUE_MARKS;
    return *this;
  }

  /// Save and load of the program's state. Neither lambda may capture:
  ///   save(const State&) returns bytes, such as std::string or std::vector<char>;
  ///   load(State&, std::span<const std::byte>) returns whether the bytes were a valid state.
  /// Requires: `state` lives as long as the session.
  template <class State, class Save, class Load>
  Options& saves(State& state, Save, Load) {
    static_assert(std::is_empty_v<Save> && std::is_empty_v<Load>,
                  "ticktrue: saves: the lambdas capture nothing: they are given the state");
    save = &detail::save_state<State, Save>;
    load = &detail::load_state<State, Load>;
    user = &state;
    return *this;
  }
  /// The same for a state in one block of memory without pointers.
  template <class State>
  Options& saves(State& state) {
    static_assert(std::is_trivially_copyable_v<State>,
                  "ticktrue: saves: the state is more than one block of memory: give the lambdas save and load");
    save = &detail::copy_state<State>;
    load = &detail::paste_state<State>;
    user = &state;
    return *this;
  }
};

/// A recording or a verification of a program that owns its loop. The destructor closes it. Calls return whether the
/// program must continue.
class Session {
 public:
  /// Records with `--record FILE` among the words, verifies with `--verify FILE`, and is otherwise off. `program` is
  /// the name of the simulation. The facts about the build are those of the unit that opens the session.
  Session(int argc, char* const* argv, const char* program, const char* facts = TICKTRUE_CALLER_FACTS)
      : Session(argc, argv, Options(program, facts)) {}
  Session(int argc, char* const* argv, const Options& options)
      : core_(std::make_unique<detail::Core>()), is_verifying_(asks_to_verify(argc, argv)) {
    const ticktrue_options wrapped = wrap(options);
    core_->session = ticktrue_open_arguments(&wrapped, argc, argv);
  }
  /// With mode and path of the options.
  explicit Session(const Options& options)
      : core_(std::make_unique<detail::Core>()), is_verifying_(options.mode == TICKTRUE_VERIFY) {
    const ticktrue_options wrapped = wrap(options);
    core_->session = ticktrue_open(&wrapped);
  }

  /// Registers a table before the first tick: a std::vector, std::array, std::span or array of rows, or a single struct
  /// as a table of one row. Rows are structs with TICKTRUE_COLUMNS, or numbers (one column "value"). Texts and lists
  /// among the members are registered as the tables "units.name" and "units.inventory".
  /// Requires: `container` stays at its address until the session is closed; its rows may grow, shrink and move.
  template <class Container>
  bool table(const char* name, Container&& container) {
    using C = std::remove_reference_t<Container>;
    static_assert(std::is_lvalue_reference_v<Container>,
                  "ticktrue: table: the session keeps the address of the container: give it a name");
    constexpr auto row = detail::row_of<std::remove_cv_t<C>>();
    detail::check_row(row);
    return add_table<std::remove_cv_t<C>>(name, &container, row);
  }

  /// Inputs of the tick that begins next: a number, a vector, or a struct with TICKTRUE_COLUMNS or without padding.
  /// Record: stores the value. Verify: replaces it by the recorded one.
  template <class T>
  bool input(T& value) {
    static_assert(!std::is_const_v<T>, "ticktrue: input: a verification replaces the value: it is not const");
    static_assert(detail::can_be_input<T>(),
                  "ticktrue: input: has padding, pointers or no fixed size: write TICKTRUE_COLUMNS for the struct");
    if constexpr (detail::can_be_input<T>() && !std::is_const_v<T>)
      return goes_on(detail::input_of<T>(core_->session, reinterpret_cast<unsigned char*>(&value)));
    else
      return false;
  }
  /// The same for a list: its size is also recorded and restored.
  template <class T, class Allocator>
  bool input(std::vector<T, Allocator>& values) {
    auto count = static_cast<std::uint32_t>(values.size());
    if (core_->session == nullptr) return true;
    int status = ticktrue_input(core_->session, &count, sizeof count);
    if (status != TICKTRUE_OK) return goes_on(status);
    if (count != values.size()) {
      // The count comes from the trace. If it exceeds the limit of a tick, the library refuses it before it uses the
      // memory.
      if (count > input_size_max / sizeof(T)) return goes_on(ticktrue_input(core_->session, &count, SIZE_MAX));
      values.resize(count);
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!input(values[i])) return false;
    return true;
  }
  /// The same for `size` bytes.
  bool input(void* data, std::size_t size) { return goes_on(ticktrue_input(core_->session, data, size)); }

  /// Verify: sets `value` to the recorded setup. Record: sets it to the setup of the options. Off: unchanged.
  /// Returns false and changes nothing if the recorded setup has another size.
  template <class T>
  [[nodiscard]] bool setup(T& value) const {
    static_assert(detail::has_plain_bytes<T>(),
                  "ticktrue: setup: takes a struct of integers without padding; else ticktrue_setup(handle(), ...)");
    if (core_->session == nullptr) return true;
    std::size_t size = 0;
    const void* bytes = ticktrue_setup(core_->session, &size);
    if (bytes == nullptr || size != sizeof value) return false;
    std::memcpy(&value, bytes, size);
    return true;
  }

  /// Begins a tick. Leave the loop if it returns false.
  bool begin_tick() { return begin(nullptr); }
  /// The same with an own length: `dt` (s) is recorded, or replaced by the recorded one.
  bool begin_tick(double& dt) { return begin(&dt); }
  bool begin_tick(float& dt) {
    double exact = static_cast<double>(dt);
    const bool runs = begin(&exact);
    dt = static_cast<float>(exact);
    return runs;
  }
  /// Ends the tick: the rows are hashed and written, or compared.
  bool end_tick() {
    core_->refresh();
    const int status = ticktrue_end_tick(core_->session);
    core_->ticks = counts() ? ticktrue_tick(core_->session) : core_->ticks + 1;
    return goes_on(status);
  }

  /// Stages of a tick: see ticktrue_add_stage.
  bool add_stage(const char* name) { return goes_on(ticktrue_add_stage(core_->session, name)); }
  bool stage(const char* name) {
    core_->refresh();
    return goes_on(ticktrue_stage(core_->session, name));
  }

  /// Marks a number in the running tick: see ticktrue_mark. Requires: Options::marks.
  template <class T>
  void mark(const char* name, T value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "ticktrue: mark: takes a number or an enum");
    if constexpr (std::is_floating_point_v<T>)
      ticktrue_mark_f64(core_->session, name, static_cast<double>(value));
    else
      ticktrue_mark(core_->session, name, static_cast<std::uint64_t>(value));
  }
  /// Adds a text about the tick: see ticktrue_note.
  bool note(const char* topic, const char* text) { return goes_on(ticktrue_note(core_->session, topic, text)); }

  /// Rollback: see ticktrue_rewind and ticktrue_confirm.
  bool rewind(std::uint64_t tick) {
    core_->ticks = tick;
    return goes_on(ticktrue_rewind(core_->session, tick));
  }
  bool confirm(std::uint64_t tick) { return goes_on(ticktrue_confirm(core_->session, tick)); }
  bool seek(std::uint64_t tick) {
    core_->refresh();
    return goes_on(ticktrue_seek(core_->session, tick));
  }

  /// Write a file about a desync, and the present content of the black box as a trace: see ticktrue_bundle and
  /// ticktrue_box_save. False: nothing was written, and error() has the reason.
  bool bundle(const char* path) { return ticktrue_bundle(core_->session, path) == TICKTRUE_OK; }
  bool box_save(const char* path) { return ticktrue_box_save(core_->session, path) == TICKTRUE_OK; }

  /// The number of ticks done, also if the session is off or a recording has failed.
  std::uint64_t tick() const { return counts() ? ticktrue_tick(core_->session) : core_->ticks; }
  bool is_on() const { return core_->session != nullptr; }
  bool is_verifying() const { return is_verifying_; }
  /// The error; empty: none. Also valid after close().
  const char* error() const {
    return core_->session != nullptr ? ticktrue_message(core_->session) : core_->closed_error.c_str();
  }
  /// For all calls of ticktrue.h; null: the session is off.
  ticktrue_session* handle() const { return core_->session; }

  /// Ends the session and prints its report. Returns the exit code of the tool; 0 if the session is off.
  int close() { return core_->close(); }

 private:
  static constexpr std::size_t input_size_max = std::size_t{8} << 20;  // bytes per tick

  /// Reads the words as ticktrue_open_arguments does.
  static bool asks_to_verify(int argc, char* const* argv) {
    for (int i = 1; i < argc && argv != nullptr && argv[i] != nullptr; ++i) {
      if (std::strcmp(argv[i], "--verify") == 0) return true;
      if (std::strcmp(argv[i], "--record") == 0) return false;
    }
    return false;
  }

  ticktrue_options wrap(const Options& options) {
    ticktrue_options wrapped = options;
    core_->saver = options.save;
    core_->loader = options.load;
    core_->user = options.user;
    // The library refuses one of them alone.
    if (options.save != nullptr) wrapped.save = &detail::Core::save;
    if (options.load != nullptr) wrapped.load = &detail::Core::load;
    wrapped.user = core_.get();
    return wrapped;
  }

  bool goes_on(int status) const { return status == TICKTRUE_OK || !is_verifying_; }
  /// Whether the library counts the ticks.
  bool counts() const { return core_->session != nullptr && ticktrue_status(core_->session) == TICKTRUE_OK; }

  bool begin(double* dt) {
    if (core_->session == nullptr) return true;
    core_->refresh();
    core_->refer();
    return goes_on(ticktrue_begin_tick(core_->session, dt));
  }

  template <class C, class Row>
  bool add_table(const char* name, const void* container, detail::Of<Row>) {
    if constexpr (detail::is_row<Row>()) {
      if (core_->session == nullptr) return true;
      detail::Layout layout;
      constexpr bool is_number = detail::kind_of<Row>() == detail::Kind::numbers;
      detail::add_columns<Row>(is_number ? "value" : "", 0, detail::Role::plain, nullptr, layout);
      const std::uint32_t number = register_table(name, sizeof(Row), layout.columns);
      if (number == TICKTRUE_NO_TABLE) return goes_on(TICKTRUE_FAILED);
      register_lists(name, layout.lists);
      std::erase_if(core_->tables, [&](const detail::Core::Table& table) { return table.number == number; });
      core_->tables.push_back({number, container, &detail::rows_of<C, Row>, {}});
    }
    return goes_on(ticktrue_status(core_->session));
  }

  std::vector<ticktrue_member> members_of(const std::string& table, const std::vector<detail::Column>& columns) {
    std::vector<ticktrue_member> members;
    for (const detail::Column& column : columns) {
      const bool is_shown = column.role == detail::Role::shown;
      members.push_back({column.name.c_str(), is_shown ? column.type | TICKTRUE_SHOWN : column.type, column.lanes,
                         column.offset, column.size});
      if (column.role == detail::Role::reference) core_->references.push_back({table, column.name, column.target});
    }
    return members;
  }

  std::uint32_t register_table(const char* name, std::size_t stride, const std::vector<detail::Column>& columns) {
    const std::vector<ticktrue_member> members = members_of(name, columns);
    std::uint32_t keys = 0;
    for (const detail::Column& column : columns) keys += column.role == detail::Role::key ? 1 : 0;
    const std::uint32_t number =
        ticktrue_table(core_->session, name, stride, members.data(), static_cast<std::uint32_t>(members.size()));
    if (number != TICKTRUE_NO_TABLE && keys > 0) ticktrue_key(core_->session, name, keys);
    return number;
  }

  /// Finds a list for the library, by the address of its row and the offset in the row.
  void register_lists(const std::string& parent, const std::vector<detail::List>& lists) {
    for (const detail::List& list : lists) {
      const std::string name = parent + "." + list.name;
      void* const offset = reinterpret_cast<void*>(static_cast<std::uintptr_t>(list.offset));
      if (list.kind == detail::Kind::text) {
        ticktrue_text(core_->session, name.c_str(), parent.c_str(), list.elements, offset);
      } else if (list.kind == detail::Kind::bytes) {
        ticktrue_bytes(core_->session, name.c_str(), parent.c_str(), list.elements, offset);
      } else {
        const std::vector<ticktrue_member> members = members_of(name, list.layout.columns);
        ticktrue_child(core_->session, name.c_str(), parent.c_str(), list.elements, offset, list.stride, members.data(),
                       static_cast<std::uint32_t>(members.size()));
        register_lists(name, list.layout.lists);
      }
    }
  }

  std::unique_ptr<detail::Core> core_;  // null only after a move
  bool is_verifying_ = false;
};

}  // namespace ticktrue

// These pragmas keep the hundred steps of the macro expansion out of messages about a member. They also turn off a
// warning about offsetof in a struct with bases or private members, which all these compilers support.
#if defined(__clang__)
#define TICKTRUE_QUIET_OFFSETS_ \
  _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Winvalid-offsetof\"")
#define TICKTRUE_LOUD_OFFSETS_ _Pragma("clang diagnostic pop")
#else
#define TICKTRUE_QUIET_OFFSETS_
#define TICKTRUE_LOUD_OFFSETS_
#endif
#if defined(__GNUC__)
#pragma GCC system_header
#endif

/// Names the members of a struct that are its columns, in order. It belongs in the namespace of the struct, after the
/// struct. `friend TICKTRUE_COLUMNS(...)` inside the struct can use private members; `template <class T>` may precede
/// it. A member is named as it is, or as one of
///   key(id)                       first members: rows ascend by these and are compared by these
///   shown(sprite)                 stored and printed, never compared
///   text(label)                   an array of char that holds a text up to its first zero
///   reference(target, "units")    a u32 that holds keys of the rows of that table, or 0xffffffff
#define TICKTRUE_COLUMNS(Row, ...)                                                         \
  constexpr void ticktrue_columns_of(::ticktrue::detail::Of<Row>, auto&& ticktrue_visit) { \
    using TicktrueRow = Row;                                                               \
    TICKTRUE_QUIET_OFFSETS_                                                                \
    TICKTRUE_EXPAND_(TICKTRUE_EACH_(__VA_ARGS__))                                          \
    TICKTRUE_LOUD_OFFSETS_                                                                 \
  }

// `key(id)` becomes TICKTRUE_ROLE_key(id), which is a macro. `id` becomes TICKTRUE_ROLE_id, which is not a macro and is
// dropped.
#define TICKTRUE_ROLE_key(member) , key, member, nullptr
#define TICKTRUE_ROLE_shown(member) , shown, member, nullptr
#define TICKTRUE_ROLE_text(member) , text, member, nullptr
#define TICKTRUE_ROLE_reference(member, target) , reference, member, target
#define TICKTRUE_MEMBER_(member) TICKTRUE_MEMBER_ROLE_(TICKTRUE_ROLE_##member, plain, member, nullptr, )
#define TICKTRUE_MEMBER_ROLE_(...) TICKTRUE_MEMBER_ENTRY_(__VA_ARGS__)
#define TICKTRUE_MEMBER_ENTRY_(dropped, role, member, target, ...)                                                     \
  TICKTRUE_REFUSE_(member, pointer,                                                                                    \
                   "is a pointer or a reference: another address in every run. Use an index or an id")                 \
  TICKTRUE_REFUSE_(member, wide_text,                                                                                  \
                   "is text of wide characters: other bytes on other machines. Use UTF-8 in a std::string")            \
  TICKTRUE_REFUSE_(                                                                                                    \
      member, container,                                                                                               \
      "is a container whose elements do not lie side by side. Use a std::vector, sorted where the order is not fixed") \
  TICKTRUE_REFUSE_(member, pointers, "is a list of pointers: other addresses in every run. Use indices or ids")        \
  TICKTRUE_REFUSE_(                                                                                                    \
      member, bad_list,                                                                                                \
      "is a list whose elements have no columns. Write TICKTRUE_COLUMNS for the element before this line")             \
  TICKTRUE_REFUSE_(member, long_double, "is long double: other bytes on other machines. Use double")                   \
  TICKTRUE_REFUSE_(member, too_wide, "has more than 255 numbers. Make them rows of a table of their own")              \
  TICKTRUE_REFUSE_(member, other,                                                                                      \
                   "is a struct without columns, or has padding. Write TICKTRUE_COLUMNS for it before this line, "     \
                   "or specialise ticktrue::lanes")                                                                    \
  static_assert(::ticktrue::detail::Role::role != ::ticktrue::detail::Role::key ||                                     \
                    ::ticktrue::detail::can_be_key<decltype(TicktrueRow::member)>(),                                   \
                "ticktrue: key(" #member "): is no unsigned integer");                                                 \
  static_assert(::ticktrue::detail::Role::role != ::ticktrue::detail::Role::reference ||                               \
                    ::ticktrue::detail::can_refer<decltype(TicktrueRow::member)>(),                                    \
                "ticktrue: reference(" #member ", ...): is no std::uint32_t");                                         \
  static_assert(::ticktrue::detail::Role::role != ::ticktrue::detail::Role::text ||                                    \
                    ::ticktrue::detail::is_char_array<decltype(TicktrueRow::member)>(),                                \
                "ticktrue: text(" #member "): is no array of char; a std::string needs no word around it");            \
  static_assert(::ticktrue::detail::Role::role != ::ticktrue::detail::Role::shown ||                                   \
                    !::ticktrue::detail::has_lists<decltype(TicktrueRow::member)>(),                                   \
                "ticktrue: shown(" #member "): is a text or a list, which is always compared: leave it out");          \
  ticktrue_visit(::ticktrue::detail::Entry<decltype(TicktrueRow::member), ::ticktrue::detail::Role::role>{             \
      #member, offsetof(TicktrueRow, member), target});
#define TICKTRUE_REFUSE_(member, kind, hint)                                                                    \
  static_assert(::ticktrue::detail::kind_of<decltype(TicktrueRow::member)>() != ::ticktrue::detail::Kind::kind, \
                "ticktrue: " #member " " hint);

// TICKTRUE_MEMBER_ for each argument: the preprocessor scans the list again until it is empty, at most 340 times.
#define TICKTRUE_EACH_(member, ...) TICKTRUE_MEMBER_(member) __VA_OPT__(TICKTRUE_AGAIN_ TICKTRUE_PARENS_(__VA_ARGS__))
#define TICKTRUE_AGAIN_() TICKTRUE_EACH_
#define TICKTRUE_PARENS_ ()
#define TICKTRUE_EXPAND_(...) TICKTRUE_EXPAND4_(TICKTRUE_EXPAND4_(TICKTRUE_EXPAND4_(TICKTRUE_EXPAND4_(__VA_ARGS__))))
#define TICKTRUE_EXPAND4_(...) TICKTRUE_EXPAND3_(TICKTRUE_EXPAND3_(TICKTRUE_EXPAND3_(TICKTRUE_EXPAND3_(__VA_ARGS__))))
#define TICKTRUE_EXPAND3_(...) TICKTRUE_EXPAND2_(TICKTRUE_EXPAND2_(TICKTRUE_EXPAND2_(TICKTRUE_EXPAND2_(__VA_ARGS__))))
#define TICKTRUE_EXPAND2_(...) TICKTRUE_EXPAND1_(TICKTRUE_EXPAND1_(TICKTRUE_EXPAND1_(TICKTRUE_EXPAND1_(__VA_ARGS__))))
#define TICKTRUE_EXPAND1_(...) __VA_ARGS__
