// Hash, image, validation and comparison of states, over their columns.
// SPDX-License-Identifier: MIT
#include "base/state/state_view.h"

#include <algorithm>
#include <array>
#include <compare>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/hash.h"
#include "base/limits.h"
#include "base/row_kernels.h"
#include "base/state/child_tables.h"

namespace ticktrue {
namespace {

constexpr std::size_t hash_block_size = 16 * 1024;

std::size_t scalar_size(ScalarType type) {
  return scalar_info(type)->size;
}

std::uint64_t read_scalar(const std::uint8_t* bytes, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return value;
}

bool is_finite_bits(ScalarType type, std::uint64_t bits) {
  if (type == ScalarType::f32) return (bits & 0x7f800000u) != 0x7f800000u;
  if (type == ScalarType::f64) return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
  return true;
}

/// The value of a signed integer of `size` bytes.
std::int64_t signed_value(std::uint64_t bits, std::size_t size) {
  const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
  return static_cast<std::int64_t>((bits ^ sign) - sign);
}

/// The value of a lane for range checks. Integers beyond 2^53 lose low bits, which no range of ours looks at.
double lane_value(ScalarType type, std::uint64_t bits) {
  switch (type) {
    case ScalarType::f32:
      return float_of_bits(static_cast<std::uint32_t>(bits));
    case ScalarType::f64:
      return double_of_bits(bits);
    default:
      break;
  }
  const ScalarInfo& info = *scalar_info(type);
  return info.is_signed ? static_cast<double>(signed_value(bits, info.size)) : static_cast<double>(bits);
}

/// Rows in canonical byte order: the machine's own where that is little-endian, else a swapped copy in `buffer`.
ByteView canonical_rows(const TableSchema& table, const TableRows& rows, Bytes& buffer) {
  const std::size_t size = static_cast<std::size_t>(rows.row_count) * table.row_size;
  if constexpr (machine_is_little_endian) return {rows.data, size};
  buffer.assign(rows.data, rows.data + size);
  for (std::size_t row = 0; row < rows.row_count; ++row)
    for (const Column& column : table.columns)
      reverse_scalar_bytes(buffer.data() + row * table.row_size + column.offset, scalar_size(column.type),
                           column.lane_count);
  return buffer;
}

std::strong_ordering compare_keys(const TableSchema& table, const std::uint8_t* a, const std::uint8_t* b) {
  for (std::size_t i = 0; i < table.key_column_count; ++i) {
    const Column& column = table.columns[i];
    const std::size_t size = scalar_size(column.type);
    const std::uint64_t value_a = read_scalar(a + column.offset, size);
    const std::uint64_t value_b = read_scalar(b + column.offset, size);
    if (value_a != value_b) return value_a <=> value_b;
  }
  return std::strong_ordering::equal;
}

std::string place_text(const TableSchema& table, std::size_t row, const Column& column, std::size_t lane) {
  std::string text = table.name + "[" + std::to_string(row) + "]." + column.name;
  if (column.lane_count > 1) text += "[" + std::to_string(lane) + "]";
  return text;
}

}  // namespace

namespace {

/// Appends what the root hash covers of a table.
void digest_table(const TableSchema& table, const TableRows& table_rows, ByteWriter& digest) {
  Bytes buffer;
  const ByteView rows = canonical_rows(table, table_rows, buffer);
  digest.u64(hash64({reinterpret_cast<const std::uint8_t*>(table.name.data()), table.name.size()}));
  digest.u64(table_rows.row_count);
  for (std::size_t offset = 0; offset < rows.size(); offset += hash_block_size)
    digest.u64(hash64(rows.subspan(offset, std::min(hash_block_size, rows.size() - offset))));
}

}  // namespace

std::uint64_t root_hash(const StateView& state) {
  ByteWriter digest;
  for (std::size_t t = 0; t < state.tables.size(); ++t) digest_table(state.schema->tables[t], state.tables[t], digest);
  return hash64(digest.view());
}

std::uint64_t root_hash(const StateView& state, std::vector<std::uint64_t>& table_hashes) {
  ByteWriter digest;
  table_hashes.clear();
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const std::size_t begin = digest.size();
    digest_table(state.schema->tables[t], state.tables[t], digest);
    table_hashes.push_back(hash64(digest.view().subspan(begin)));
  }
  return hash64(digest.view());
}

void encode_image(const StateView& state, Bytes& out) {
  out.clear();
  Bytes buffer;
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const ByteView rows = canonical_rows(state.schema->tables[t], state.tables[t], buffer);
    const std::uint32_t row_count = state.tables[t].row_count;
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(row_count >> (8 * i)));
    out.insert(out.end(), rows.begin(), rows.end());
  }
}

void join_image(std::span<const ImageTable> tables, Bytes& out) {
  out.clear();
  for (const ImageTable& table : tables) {
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(table.row_count >> (8 * i)));
    out.insert(out.end(), table.rows.begin(), table.rows.end());
  }
}

std::vector<ImageTable> canonical_tables(const StateView& state, Bytes& buffer) {
  std::vector<ImageTable> tables;
  tables.reserve(state.tables.size());
  if constexpr (machine_is_little_endian) {
    for (std::size_t t = 0; t < state.tables.size(); ++t) {
      const TableRows& rows = state.tables[t];
      const std::size_t size = static_cast<std::size_t>(rows.row_count) * state.schema->tables[t].row_size;
      tables.push_back({{rows.data, size}, rows.row_count});
    }
    return tables;
  }
  encode_image(state, buffer);
  return *split_image(*state.schema, buffer);
}

Result<std::vector<ImageTable>> split_image(const StateSchema& schema, ByteView image) {
  if (image.size() > limits::state_image_size_max)
    return Error{ErrorCode::corrupt,
                 "state image: size: found " + std::to_string(image.size()) + ", expected at most " +
                     std::to_string(limits::state_image_size_max),
                 ""};
  ByteReader in(image);
  std::vector<ImageTable> tables;
  for (const TableSchema& table : schema.tables) {
    ImageTable part;
    part.row_count = in.u32();
    const std::uint64_t size = static_cast<std::uint64_t>(part.row_count) * table.row_size;
    if (!in.ok() || size > in.remaining())
      return Error{ErrorCode::corrupt,
                   "state image: table " + table.name + ": ends early: " + std::to_string(part.row_count) +
                       " rows of " + std::to_string(table.row_size) + " bytes do not fit",
                   ""};
    part.rows = in.bytes(static_cast<std::size_t>(size));
    tables.push_back(part);
  }
  if (!in.at_end())
    return Error{ErrorCode::corrupt, "state image: " + std::to_string(in.remaining()) + " bytes left over", ""};
  return tables;
}

Result<std::vector<ImageTable>> check_image(const StateSchema& schema, ByteView image) {
  Result<std::vector<ImageTable>> tables = split_image(schema, image);
  if (!tables) return tables;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    const ImageTable& part = (*tables)[t];
    for (std::size_t row = 0; row < part.row_count; ++row) {
      const std::uint8_t* bytes = part.rows.data() + row * table.row_size;
      if (row > 0 && table.key_column_count > 0 && compare_keys(table, bytes - table.row_size, bytes) >= 0)
        return Error{ErrorCode::corrupt,
                     "state image: " + place_text(table, row, table.columns[0], 0) + ": rows must ascend by key", ""};
      for (const Column& column : table.columns) {
        const std::size_t size = scalar_size(column.type);
        for (std::size_t lane = 0; lane < column.lane_count; ++lane) {
          const std::uint64_t bits = read_scalar(bytes + column.offset + lane * size, size);
          const double value = lane_value(column.type, bits);
          if (column.optional && bits == no_reference) continue;
          if (!is_finite_bits(column.type, bits) || value < column.min || value > column.max)
            return Error{ErrorCode::corrupt,
                         "state image: " + place_text(table, row, column, lane) + ": out of range: found " +
                             lane_text(column.type, bits) + ", expected " +
                             lane_text(ScalarType::f64, bits_of(column.min)) + ".." +
                             lane_text(ScalarType::f64, bits_of(column.max)),
                         ""};
          if (column.target < 0) continue;
          const auto target = static_cast<std::size_t>(column.target);
          const TableSchema& other = schema.tables[target];
          std::size_t low = 0, high = (*tables)[target].row_count;
          while (low < high) {
            const std::size_t middle = low + (high - low) / 2;
            if (read_scalar((*tables)[target].rows.data() + middle * other.row_size, 4) < bits)
              low = middle + 1;
            else
              high = middle;
          }
          if (low == (*tables)[target].row_count ||
              read_scalar((*tables)[target].rows.data() + low * other.row_size, 4) != bits)
            return Error{ErrorCode::corrupt,
                         "state image: " + place_text(table, row, column, lane) + ": refers to no row of " +
                             other.name + ": found id " + std::to_string(bits),
                         ""};
        }
      }
    }
  }
  if (const Status status = check_children(schema, *tables); !status) return status.error();
  return tables;
}

void decode_rows(const TableSchema& table, const ImageTable& rows, std::uint8_t* out) {
  std::copy(rows.rows.begin(), rows.rows.end(), out);
  if constexpr (!machine_is_little_endian)
    for (std::size_t row = 0; row < rows.row_count; ++row)
      for (const Column& column : table.columns)
        reverse_scalar_bytes(out + row * table.row_size + column.offset, scalar_size(column.type), column.lane_count);
}

namespace {

/// What the 32-bit words of rows are tested with: not finite if (word & mask) == want. Words without an exponent never
/// are. Short rows of long tables are tested in groups, so that vectors cover a group without overlap. Rows of usual
/// size need no memory from the heap.
class ExponentTests {
 public:
  ExponentTests(const TableSchema& table, std::size_t row_count) : row_words_(table.row_size / 4) {
    if (table.row_size % 4 != 0) return;
    const bool groups = row_count >= grouped_rows_least || row_words_ < kernel_words_least;
    while (groups && word_count() % vector_words != 0 && 2 * word_count() <= few_words) group_rows_ *= 2;
    if (word_count() > few_words) many_.resize(2 * word_count());
    std::uint32_t* const mask = many_.empty() ? few_ : many_.data();
    std::uint32_t* const want = mask + word_count();
    std::fill_n(mask, row_words_, 0u);
    std::fill_n(want, row_words_, 1u);
    for (const Column& column : table.columns) {
      if (!is_float(column.type)) continue;
      if (column.offset % 4 != 0) return;
      const bool is_double = column.type == ScalarType::f64;
      const std::size_t size_words = is_double ? 2 : 1;
      const std::size_t high_word = is_double && machine_is_little_endian ? 1 : 0;
      for (std::size_t lane = 0; lane < column.lane_count; ++lane) {
        const std::size_t word = column.offset / 4 + lane * size_words + high_word;
        mask[word] = want[word] = is_double ? 0x7ff00000u : 0x7f800000u;
      }
    }
    for (std::size_t word = row_words_; word < word_count(); ++word) {
      mask[word] = mask[word - row_words_];
      want[word] = want[word - row_words_];
    }
    exist_ = true;
  }

  bool exist() const { return exist_; }  // false: floats do not lie on words

  /// Requires: exist().
  bool any_match(const TableRows& rows) const {
    constexpr std::size_t block_size = 16 * 1024;  // bytes: a block stays in the nearest cache while it is tested
    const std::size_t group_size = 4 * word_count();
    const std::size_t block_groups = std::max<std::size_t>(1, block_size / group_size);
    const std::size_t group_count = rows.row_count / group_rows_;
    for (std::size_t first = 0; first < group_count; first += block_groups)
      if (row_kernels().any_match(rows.data + first * group_size, word_count(),
                                  std::min(block_groups, group_count - first), mask(), want()))
        return true;
    // Fewer rows than a group.
    const std::size_t word_end = rows.row_count % group_rows_ * row_words_;
    const std::uint8_t* const rest = rows.data + group_count * group_size;
    for (std::size_t word = 0; word < word_end; ++word) {
      std::uint32_t bits;
      std::memcpy(&bits, rest + 4 * word, sizeof bits);
      if ((bits & mask()[word]) == want()[word]) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t vector_words = 8;  // of the widest kernels
  static constexpr std::size_t kernel_words_least = 4;
  static constexpr std::size_t grouped_rows_least = 64;  // fewer rows do not pay for longer masks
  static constexpr std::size_t few_words = 128;

  std::size_t word_count() const { return group_rows_ * row_words_; }  // of a group
  const std::uint32_t* mask() const { return many_.empty() ? few_ : many_.data(); }
  const std::uint32_t* want() const { return mask() + word_count(); }

  std::size_t row_words_;
  std::size_t group_rows_ = 1;
  bool exist_ = false;
  std::uint32_t few_[2 * few_words];
  std::vector<std::uint32_t> many_;
};

/// Whether a value of the table may not be finite: true also where that has to be looked at lane by lane.
bool is_suspect(const TableSchema& table, const TableRows& rows) {
  const auto has_float = [](const Column& column) { return is_float(column.type); };
  if (rows.row_count == 0 || std::none_of(table.columns.begin(), table.columns.end(), has_float)) return false;
  const ExponentTests tests(table, rows.row_count);
  return !tests.exist() || tests.any_match(rows);
}

}  // namespace

namespace {

/// The first lane of a table whose bits `is_sought`, in row, column order.
template <typename Sought>
std::optional<StatePlace> find_lane(const StateView& state, std::size_t t, Sought is_sought) {
  const TableSchema& table = state.schema->tables[t];
  const TableRows& rows = state.tables[t];
  if (rows.row_count == 0) return std::nullopt;  // the data of an empty table may be null
  Bytes buffer;
  const ByteView bytes = canonical_rows(table, rows, buffer);
  for (std::size_t row = 0; row < rows.row_count; ++row)
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      for (std::size_t lane = 0; lane < table.columns[c].lane_count; ++lane) {
        const StatePlace place{t, row, c, lane};
        if (is_sought(table.columns[c].type, lane_bits(table, bytes, place))) return place;
      }
  return std::nullopt;
}

}  // namespace

std::optional<StatePlace> find_non_finite(const StateView& state) {
  for (std::size_t t = 0; t < state.tables.size(); ++t)
    if (is_suspect(state.schema->tables[t], state.tables[t]))
      if (const auto place =
              find_lane(state, t, [](ScalarType type, std::uint64_t bits) { return !is_finite_bits(type, bits); }))
        return place;
  return std::nullopt;
}

std::optional<StatePlace> find_negative_zero(const StateView& state) {
  const auto is_negative_zero = [](ScalarType type, std::uint64_t bits) {
    const ScalarInfo& scalar = *scalar_info(type);
    return scalar.is_float && bits == std::uint64_t{1} << (8 * scalar.size - 1);
  };
  for (std::size_t t = 0; t < state.tables.size(); ++t)
    if (const auto place = find_lane(state, t, is_negative_zero)) return place;
  return std::nullopt;
}

std::uint64_t lane_bits(const TableSchema& table, ByteView canonical, const StatePlace& place) {
  const Column& column = table.columns[place.column];
  const std::size_t size = scalar_size(column.type);
  const std::size_t offset = place.row * table.row_size + column.offset + place.lane * size;
  TICKTRUE_ASSERT(offset + size <= canonical.size());
  return read_scalar(canonical.data() + offset, size);
}

std::string lane_text(ScalarType type, std::uint64_t bits) {
  char text[40];
  if (type == ScalarType::f32) {
    const float value = float_of_bits(static_cast<std::uint32_t>(bits));
    for (int digits = 6; digits <= 9; ++digits) {
      std::snprintf(text, sizeof text, "%.*g", digits, static_cast<double>(value));
      if (std::strtof(text, nullptr) == value) break;
    }
  } else if (type == ScalarType::f64) {
    const double value = double_of_bits(bits);
    for (int digits = 15; digits <= 17; ++digits) {
      std::snprintf(text, sizeof text, "%.*g", digits, value);
      if (std::strtod(text, nullptr) == value) break;
    }
  } else if (const ScalarInfo& info = *scalar_info(type); info.is_signed) {
    return std::to_string(signed_value(bits, info.size));
  } else {
    return std::to_string(bits);
  }
  for (char& c : text)
    if (c == ',') c = '.';  // of the locale that the program has set
  return text;
}

std::string lane_hex(ScalarType type, std::uint64_t bits) {
  return hex64(bits).substr(16 - 2 * scalar_size(type));
}

std::optional<std::uint64_t> ulp_distance(ScalarType type, std::uint64_t a, std::uint64_t b) {
  if (type != ScalarType::f32 && type != ScalarType::f64) return std::nullopt;
  const bool is_f32 = type == ScalarType::f32;
  const std::uint64_t sign = is_f32 ? 0x80000000u : 0x8000000000000000u;
  const std::uint64_t infinity = is_f32 ? 0x7f800000u : 0x7ff0000000000000u;
  if ((a & ~sign) > infinity || (b & ~sign) > infinity) return std::nullopt;
  const bool same_sign = (a & sign) == (b & sign);
  const std::uint64_t magnitude_a = a & ~sign;
  const std::uint64_t magnitude_b = b & ~sign;
  if (same_sign) return magnitude_a > magnitude_b ? magnitude_a - magnitude_b : magnitude_b - magnitude_a;
  return magnitude_a + magnitude_b;
}

std::vector<LaneDifference> diff_images(const StateSchema& schema, std::span<const ImageTable> expected,
                                        std::span<const ImageTable> got, std::size_t count_max) {
  std::vector<LaneDifference> differences;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    const ImageTable& a = expected[t];
    const ImageTable& b = got[t];
    std::size_t row_a = 0, row_b = 0;
    while (row_a < a.row_count || row_b < b.row_count) {
      if (differences.size() >= count_max) return differences;
      const std::uint8_t* bytes_a = row_a < a.row_count ? a.rows.data() + row_a * table.row_size : nullptr;
      const std::uint8_t* bytes_b = row_b < b.row_count ? b.rows.data() + row_b * table.row_size : nullptr;
      if (bytes_a && bytes_b && std::memcmp(bytes_a, bytes_b, table.row_size) == 0) {
        ++row_a, ++row_b;
        continue;
      }
      // A changed key looks like one row gone and one row new. Where both neighbours still fit, it is one changed row.
      bool take_a = bytes_a != nullptr, take_b = bytes_b != nullptr;
      if (take_a && take_b && table.key_column_count > 0 && a.row_count != b.row_count) {
        const auto order = compare_keys(table, bytes_a, bytes_b);
        if (order < 0) take_b = false;
        if (order > 0) take_a = false;
      }
      const std::size_t column_count =
          take_a && take_b ? table.columns.size() : std::max<std::size_t>(table.key_column_count, 1);
      const std::uint8_t* key_row = take_a ? bytes_a : bytes_b;
      for (std::size_t c = 0; c < column_count; ++c) {
        const Column& column = table.columns[c];
        const std::size_t size = scalar_size(column.type);
        for (std::size_t lane = 0; lane < column.lane_count; ++lane) {
          LaneDifference difference;
          difference.place = {t, take_a ? row_a : row_b, c, lane};
          if (table.key_column_count > 0)
            difference.id = read_scalar(key_row + table.columns[0].offset, scalar_size(table.columns[0].type));
          const std::size_t offset = column.offset + lane * size;
          if (take_a) difference.expected = read_scalar(bytes_a + offset, size);
          if (take_b) difference.got = read_scalar(bytes_b + offset, size);
          if (difference.expected != difference.got && differences.size() < count_max)
            differences.push_back(difference);
        }
      }
      if (take_a) ++row_a;
      if (take_b) ++row_b;
    }
  }
  return differences;
}

}  // namespace ticktrue
