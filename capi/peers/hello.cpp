// Makes, reads and compares hello messages. docs/trace_format.md, "Hello".
// SPDX-License-Identifier: MIT
#include "capi/peers/hello.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string_view>

#include "base/hash.h"
#include "base/limits.h"
#include "base/state/state_view.h"
#include "replay/format/chunk.h"
#include "replay/format/identity.h"
#include "replay/format/payload.h"
#include "verifier/locate/schema_difference.h"
#include "verifier/report/fact_differences.h"

namespace ticktrue::capi {
namespace {

constexpr std::array<std::uint8_t, 4> hello_magic{'T', 'T', 'H', 1};
constexpr std::size_t hello_check_size = 8;
constexpr std::size_t setup_begin_max = 4'096;  // bytes at the begin of a setup that are compared one by one
constexpr std::size_t schema_size_max = std::size_t{512} << 10;
constexpr std::size_t facts_size_max = std::size_t{256} << 10;

Error wrong_hello(const std::string& what) {
  return {ErrorCode::corrupt, "hello: " + what, ""};
}

std::string f64_text(double value) {
  return lane_text(ScalarType::f64, bits_of(value));
}

const std::string* fact_of(const replay::BuildFacts& facts, std::string_view name) {
  for (const auto& [found, value] : facts)
    if (found == name) return &value;
  return nullptr;
}

std::string byte_text(std::uint8_t byte) {
  return hex32(byte).substr(6);
}

/// "setup: 4 bytes here, 5 there", or the first differing byte.
std::string setup_difference(const Hello& here, const Hello& there) {
  if (here.setup_size != there.setup_size)
    return "setup: here " + std::to_string(here.setup_size) + " bytes, there " + std::to_string(there.setup_size);
  const std::size_t size = std::min(here.setup_begin.size(), there.setup_begin.size());
  for (std::size_t i = 0; i < size; ++i)
    if (here.setup_begin[i] != there.setup_begin[i])
      return "setup: byte " + std::to_string(i) + " of " + std::to_string(here.setup_size) + ": here " +
             byte_text(here.setup_begin[i]) + ", there " + byte_text(there.setup_begin[i]);
  return "setup: " + std::to_string(here.setup_size) + " bytes on both sides, behind byte " + std::to_string(size) +
         " not the same";
}

/// The schema of one table alone, without its references.
StateSchema alone(const TableSchema& table) {
  StateSchema schema{{table}};
  TableSchema& copy = schema.tables[0];
  copy.parent = -1;
  for (Column& column : copy.columns) {
    column.target = -1;
    column.optional = false;
  }
  return schema;
}

std::string target_name(const StateSchema& schema, int target) {
  const auto index = static_cast<std::size_t>(target);
  return target < 0 || index >= schema.tables.size() ? "none" : schema.tables[index].name;
}

/// The first reference with another target. Requires: tables that are equal except for the targets of references.
std::optional<std::string> target_difference(const StateSchema& here, const TableSchema& a, const StateSchema& there,
                                             const TableSchema& b) {
  const auto line = [&](const std::string& what, int target_a, int target_b) -> std::optional<std::string> {
    const std::string name_a = target_name(here, target_a), name_b = target_name(there, target_b);
    if (name_a == name_b) return std::nullopt;
    return what + ": here " + name_a + ", there " + name_b;
  };
  if (auto found = line("table " + a.name + ": parent", a.parent, b.parent)) return found;
  for (std::size_t c = 0; c < a.columns.size(); ++c)
    if (auto found = line(a.name + "." + a.columns[c].name + ": refers to", a.columns[c].target, b.columns[c].target))
      return found;
  return std::nullopt;
}

void compare_tables(const Hello& here, const Hello& there, std::vector<std::string>& lines) {
  const std::size_t before = lines.size();
  for (const TableSchema& table : here.schema.tables) {
    const auto found = there.schema.find_table(table.name);
    if (!found) {
      lines.push_back("table " + table.name + ": only here");
      continue;
    }
    const TableSchema& other = there.schema.tables[*found];
    if (const auto difference = verifier::first_schema_difference(alone(table), alone(other), verifier::Ranges::any))
      lines.push_back(difference->place + ": here " + difference->a + ", there " + difference->b);
    else if (const auto target = target_difference(here.schema, table, there.schema, other))
      lines.push_back(*target);
  }
  for (const TableSchema& table : there.schema.tables)
    if (!here.schema.find_table(table.name)) lines.push_back("table " + table.name + ": only there");
  if (lines.size() > before) return;
  for (std::size_t t = 0; t < here.schema.tables.size(); ++t)
    if (here.schema.tables[t].name != there.schema.tables[t].name) {
      lines.push_back("tables: here " + here.schema.tables[t].name + " is number " + std::to_string(t) + ", there " +
                      there.schema.tables[t].name);
      return;
    }
}

void compare_facts(const Hello& here, const Hello& there, HelloDifferences& found) {
  const std::string none = "IEEE 754's defaults";
  const std::string* floats_here = fact_of(here.facts, "floats");
  const std::string* floats_there = fact_of(there.facts, "floats");
  const std::string a = floats_here != nullptr ? *floats_here : none;
  const std::string b = floats_there != nullptr ? *floats_there : none;
  if (a != b) found.refusals.push_back("floating point: here " + a + ", there " + b);
  for (const verifier::FactDifference& difference : verifier::fact_differences(here.facts, there.facts)) {
    std::vector<std::string>& lines = difference.changes_bits ? found.refusals : found.warnings;
    lines.push_back(verifier::difference_line(difference, "here", "there"));
  }
  for (const auto& [name, label] : {std::pair{"program.build_id", "build id"}, std::pair{"build", "build"},
                                    std::pair{"version", "library"}, std::pair{"target", "machine"}}) {
    const std::string* one = fact_of(here.facts, name);
    const std::string* other = fact_of(there.facts, name);
    if (one != nullptr && other != nullptr && *one != *other)
      found.warnings.push_back(std::string(label) + ": here " + *one + ", there " + *other);
  }
}

}  // namespace

Hello make_hello(const replay::TraceSetup& setup, const replay::BuildFacts& facts) {
  Hello hello;
  hello.identity = replay::session_identity(setup);
  hello.simulation = setup.simulation;
  hello.version = setup.physics_version;
  hello.dt = setup.dt;
  hello.setup_size = setup.setup.size();
  hello.setup_hash = replay::content_hash(setup.setup);
  const ByteView begin = ByteView(setup.setup).first(std::min(setup.setup.size(), setup_begin_max));
  hello.setup_begin.assign(begin.begin(), begin.end());
  ByteWriter schema;
  replay::encode_judged_schema(setup.schema, schema);
  if (schema.size() <= schema_size_max) hello.schema = judged_schema(setup.schema);
  std::size_t size = 0;
  for (const auto& [name, value] : facts) {
    size += name.size() + value.size();
    if (size > facts_size_max || hello.facts.size() >= replay::fact_count_max) break;
    hello.facts.emplace_back(name, value);
  }
  return hello;
}

Bytes encode_hello(const Hello& hello) {
  ByteWriter out;
  out.bytes(hello_magic);
  out.u64(hello.identity);
  out.text(hello.simulation);
  out.u32(hello.version);
  out.f64(hello.dt);
  out.u64(hello.setup_size);
  out.u64(hello.setup_hash);
  out.u32(static_cast<std::uint32_t>(hello.setup_begin.size()));
  out.bytes(hello.setup_begin);
  out.u8(hello.schema.tables.empty() ? 0 : 1);
  if (!hello.schema.tables.empty()) replay::encode_judged_schema(hello.schema, out);
  out.u16(static_cast<std::uint16_t>(hello.facts.size()));
  for (const auto& [name, value] : hello.facts) {
    out.text(name);
    out.text(value);
  }
  out.u64(hash64(out.view()));
  return out.take();
}

Result<Hello> decode_hello(ByteView bytes) {
  if (bytes.size() > hello_size_max)
    return wrong_hello("bytes: found " + std::to_string(bytes.size()) + ", expected at most " +
                       std::to_string(hello_size_max));
  if (bytes.size() < hello_magic.size() + hello_check_size ||
      !std::equal(hello_magic.begin(), hello_magic.end(), bytes.begin()))
    return wrong_hello("found other bytes, expected those of ticktrue_hello");
  const ByteView content = bytes.first(bytes.size() - hello_check_size);
  const std::uint64_t check = ByteReader(bytes.last(hello_check_size)).u64();
  if (const std::uint64_t found = hash64(content); found != check)
    return wrong_hello("check: found " + hex64(found) + ", expected " + hex64(check));
  ByteReader in(content.subspan(hello_magic.size()));
  Hello hello;
  hello.identity = in.u64();
  hello.simulation = in.text(limits::name_size_max);
  hello.version = in.u32();
  hello.dt = in.f64();
  hello.setup_size = in.u64();
  hello.setup_hash = in.u64();
  const std::uint32_t begin_size = in.u32();
  if (begin_size > setup_begin_max) return wrong_hello("setup: ends early");
  const ByteView begin = in.bytes(begin_size);
  hello.setup_begin.assign(begin.begin(), begin.end());
  const std::uint8_t has_schema = in.u8();
  if (!in.ok() || has_schema > 1) return wrong_hello("ends early, or a flag is neither 0 nor 1");
  if (has_schema != 0) {
    Result<StateSchema> schema = decode_schema(in, SchemaLayout::third);
    if (!schema) return wrong_hello(schema.error().message);
    if (has_shown_columns(*schema)) return wrong_hello("schema: found a shown column");
    hello.schema = std::move(*schema);
  }
  const std::uint16_t fact_count = in.u16();
  if (fact_count > replay::fact_count_max) return wrong_hello("too many facts");
  for (std::size_t i = 0; i < fact_count && in.ok(); ++i) {
    std::string name = in.text(replay::fact_size_max);
    std::string value = in.text(replay::fact_size_max);
    hello.facts.emplace_back(std::move(name), std::move(value));
  }
  if (!in.ok() || !in.at_end()) return wrong_hello("ends early, or bytes follow");
  return hello;
}

HelloDifferences hello_differences(const Hello& here, const Hello& there) {
  HelloDifferences found;
  std::vector<std::string>& lines = found.refusals;
  if (here.simulation != there.simulation)
    lines.push_back("simulation: here " + here.simulation + ", there " + there.simulation);
  if (here.version != there.version)
    lines.push_back("version: here " + std::to_string(here.version) + ", there " + std::to_string(there.version));
  if (bits_of(here.dt) != bits_of(there.dt))
    lines.push_back("dt: here " + f64_text(here.dt) + " s, there " + f64_text(there.dt) + " s");
  if (here.setup_size != there.setup_size || here.setup_hash != there.setup_hash)
    lines.push_back(setup_difference(here, there));
  if (!here.schema.tables.empty() && !there.schema.tables.empty()) compare_tables(here, there, lines);
  if (lines.empty() && here.identity != there.identity)
    lines.push_back("session identity: here " + hex64(here.identity) + ", there " + hex64(there.identity) +
                    ": the columns differ");
  compare_facts(here, there, found);
  return found;
}

}  // namespace ticktrue::capi
