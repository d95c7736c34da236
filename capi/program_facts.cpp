// Reads the lines of a unit, and the build id of the running program.
// SPDX-License-Identifier: MIT
#include "capi/program_facts.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <utility>

#include "base/build_info.h"
#include "base/limits.h"
#include "base/state/gathered_state.h"
#include "capi/tick.h"
#include "verifier/report/build_id_note.h"
#include "verifier/report/report.h"

#if defined(__linux__) && defined(__ELF__)
#include <link.h>
#define TICKTRUE_HAS_PROGRAM_NOTES
#endif

namespace ticktrue::capi {
namespace {

constexpr std::size_t unit_count_max = 16;
constexpr std::size_t facts_per_unit_max = 32;
constexpr std::size_t fact_count_max = 240;  // in all units; a trace stores at most 256 facts
constexpr std::size_t name_size_max = 64;
constexpr std::size_t value_size_max = 4'096;  // a trace stores no longer value
constexpr std::size_t text_size_max = 65'536;

Error refused(const std::string& message, const std::string& hint) {
  return {ErrorCode::usage, "build facts: " + message, hint};
}

Error too_many(const std::string& what, std::size_t count_max, const std::string& hint) {
  return {ErrorCode::limit, "build facts: " + what + ": expected at most " + std::to_string(count_max), hint};
}

bool is_fact_name(std::string_view name) {
  return !name.empty() && name.size() <= name_size_max && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

Status ProgramFacts::add(std::string_view unit, const char* text) {
  const std::string place = unit.empty() ? "caller_facts" : "unit " + std::string(unit);
  const std::string hint = "give TICKTRUE_CALLER_FACTS, or lines \"name=value\"";
  if (text == nullptr) return refused(place + ": found null, expected lines", hint);
  const std::size_t size = strnlen(text, text_size_max + 1);
  if (size > text_size_max) return too_many(place + ": bytes", text_size_max, hint);
  if (std::find(units_.begin(), units_.end(), unit) != units_.end())
    return refused(place + ": stands twice", "the facts of each unit are given once in a session");
  if (units_.size() >= unit_count_max)
    return too_many("units", unit_count_max, "name the units whose floats decide the results");
  const std::string prefix = unit.empty() ? "caller." : "caller." + std::string(unit) + ".";
  replay::BuildFacts found;
  for (std::string_view left(text, size); !left.empty();) {
    const std::size_t end = std::min(left.find('\n'), left.size());
    const std::string_view line = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    if (line.empty()) continue;
    const std::size_t equals = std::min(line.find('='), line.size());
    const std::string name(line.substr(0, std::min(equals, name_size_max + 1)));
    if (equals == line.size()) return refused(place + ": found a line without '=': " + name, hint);
    if (!is_fact_name(name))
      return refused(
          place + ": name: found \"" + name + "\", expected 1.." + std::to_string(name_size_max) + " of a-z, 0-9 and _",
          hint);
    const std::string_view value = line.substr(equals + 1);
    if (value.size() > value_size_max) return too_many(place + ": " + name + ": bytes", value_size_max, hint);
    const auto same = [&](const auto& fact) { return fact.first == prefix + name; };
    if (std::any_of(found.begin(), found.end(), same)) return refused(place + ": " + name + ": stands twice", hint);
    if (found.size() >= facts_per_unit_max) return too_many(place + ": facts", facts_per_unit_max, hint);
    found.emplace_back(prefix + name, value);
  }
  if (units_facts_.size() + found.size() > fact_count_max)
    return too_many("facts of all units", fact_count_max, "name the units whose floats decide the results");
  units_.emplace_back(unit);
  units_facts_.insert(units_facts_.end(), found.begin(), found.end());
  return {};
}

replay::BuildFacts ProgramFacts::all() const {
  const BuildInfo& library = build_info();
  replay::BuildFacts facts{{"version", library.version}, {"commit", library.commit}, {"target", library.target}};
  if (!build_.empty()) facts.emplace_back("build", build_);
  if (const std::string floats = float_deviation(); !floats.empty()) facts.emplace_back("floats", floats);
  if (const std::string id = program_build_id(); !id.empty()) facts.emplace_back(verifier::build_id_fact, id);
  facts.insert(facts.end(), units_facts_.begin(), units_facts_.end());
  return facts;
}

#ifdef TICKTRUE_HAS_PROGRAM_NOTES

namespace {

int read_program(dl_phdr_info* program, std::size_t, void* text) {
  const auto is_loaded = [program](const ElfW(Phdr) & note) {
    for (int i = 0; i < program->dlpi_phnum; ++i) {
      const ElfW(Phdr)& segment = program->dlpi_phdr[i];
      if (segment.p_type == PT_LOAD && (segment.p_flags & PF_R) != 0 && note.p_vaddr >= segment.p_vaddr &&
          note.p_vaddr - segment.p_vaddr <= segment.p_filesz &&
          note.p_filesz <= segment.p_filesz - (note.p_vaddr - segment.p_vaddr))
        return true;
    }
    return false;
  };
  for (int i = 0; i < program->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = program->dlpi_phdr[i];
    if (segment.p_type != PT_NOTE || !is_loaded(segment)) continue;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(program->dlpi_addr + segment.p_vaddr);
    const std::string found =
        verifier::build_id_among({bytes, static_cast<std::size_t>(segment.p_filesz)}, segment.p_align == 8 ? 8 : 4);
    if (!found.empty()) *static_cast<std::string*>(text) = found;
  }
  return 1;  // the first object is the program; the later objects are libraries
}

}  // namespace

std::string program_build_id() {
  std::string text;
  dl_iterate_phdr(read_program, &text);
  return text;
}

#else

std::string program_build_id() {
  return "";
}

#endif

std::string program_command(const std::string& trace, std::span<const std::string_view> left_out) {
  std::vector<std::string> words;
#ifdef __linux__
  constexpr std::size_t size_max = std::size_t{64} << 10;
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  std::size_t size = 0;
  bool is_value_left_out = false;
  for (std::string word; std::getline(in, word, '\0') && (size += word.size()) < size_max;) {
    if (std::exchange(is_value_left_out, false)) continue;
    if (std::find(left_out.begin(), left_out.end(), word) != left_out.end())
      is_value_left_out = true;
    else if (word != trace)
      words.push_back(verifier::shell_word(word));
    else if (!words.empty() && words.back() == "--verify")
      words.pop_back();
    else
      words.emplace_back("{trace}");
  }
#else
  static_cast<void>(trace);
  static_cast<void>(left_out);
#endif
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

}  // namespace ticktrue::capi
