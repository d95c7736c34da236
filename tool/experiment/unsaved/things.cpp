// `nm` of binutils gives the source lines of variables, and addr2line the source lines of allocations.
// SPDX-License-Identifier: MIT
#include "tool/experiment/unsaved/things.h"

#include <cxxabi.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "base/count_text.h"
#include "base/plain_text.h"
#include "verifier/runs/child.h"

namespace ticktrue::unsaved {
namespace {

std::string demangled(const std::string& symbol) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(abi::__cxa_demangle(symbol.c_str(), nullptr, nullptr, &status),
                                                         &std::free);
  std::string text = status == 0 && name ? name.get() : symbol;
  // In C, a static variable of a function has a symbol such as `calls.0`.
  const std::size_t dot = text.rfind('.');
  if (status != 0 && dot != std::string::npos && dot > 0 && dot + 1 < text.size() &&
      text.find_first_not_of("0123456789", dot + 1) == std::string::npos)
    text.erase(dot);
  const std::string anonymous = "(anonymous namespace)::";
  for (std::size_t at = text.find(anonymous); at != std::string::npos; at = text.find(anonymous))
    text.erase(at, anonymous.size());
  return plain_line(text);
}

ThingKind kind_of(const std::string& owner) {
  if (owner == "variable") return ThingKind::variable;
  if (owner == "block") return ThingKind::heap;
  if (owner == "stack") return ThingKind::stack;
  return owner == "generator" ? ThingKind::generator : ThingKind::memory;
}

std::string source_text(const std::string& file, unsigned line) {
  return std::filesystem::path(file).filename().string() + ":" + std::to_string(line);
}

std::string bytes_text(std::uint64_t first, std::uint64_t last) {
  return first == last ? "byte " + std::to_string(first)
                       : "bytes " + std::to_string(first) + ".." + std::to_string(last);
}

/// "1,234"
std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
  return text;
}

}  // namespace

const char* name_of(ThingKind kind) {
  constexpr const char* names[] = {"variable", "heap", "stack", "generator", "memory"};
  return names[static_cast<std::size_t>(kind)];
}

std::string Thing::text() const {
  const std::string source = file.empty() ? "" : source_text(file, line);
  const std::string in = module.empty() ? "" : std::filesystem::path(module).filename().string();
  switch (kind) {
    case ThingKind::variable:
      return name + " (" + (source.empty() ? in : source) + "), " + count_text(size, "byte");
    case ThingKind::heap:
      return "block of " + grouped(size) + (size == 1 ? " byte" : " bytes") +
             (holder.empty() ? "" : " behind " + holder + ",") + " allocated " +
             (function.empty() ? "at a place that is not known" : "in " + function) +
             (source.empty() ? "" : " (" + source + ")") + ", " + bytes_text(first, last);
    case ThingKind::stack:
      return "local variable of a function that has not returned, " + bytes_text(first, last) + " of the stack there";
    case ThingKind::generator:
      return "state of rand and random of the C library";
    case ThingKind::memory:
      break;
  }
  return "variable without a name in " + in + ", " + count_text(size, "byte");
}

const std::map<std::string, ThingNames::SourceLine>& ThingNames::lines_of(const std::string& module) {
  const auto [found, is_new] = lines_.try_emplace(module);
  if (!is_new) return found->second;
  verifier::ChildCommand command;
  command.argv = {"nm", "-l", "--defined-only", module};
  command.limits.time_s = 60;
  command.limits.output_size_max = std::size_t{64} << 20;
  std::istringstream lines(verifier::run_child(command).output);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t tab = line.find('\t');
    const std::size_t name = line.rfind(' ', tab);
    const std::size_t colon = line.rfind(':');
    if (tab == std::string::npos || name == std::string::npos || colon == std::string::npos || colon < tab) continue;
    found->second[line.substr(name + 1, tab - name - 1)] = {
        plain_line(line.substr(tab + 1, colon - tab - 1)),
        static_cast<unsigned>(std::strtoul(line.c_str() + colon + 1, nullptr, 10))};
  }
  return found->second;
}

const std::vector<shake::CallSite>& ThingNames::frames(const std::string& module, std::uint64_t base,
                                                       std::uint64_t offset) {
  const auto [found, is_new] = frames_.try_emplace({module, offset});
  if (is_new && !module.empty()) found->second = shake::call_frames(module, base, {offset}).front();
  return found->second;
}

Thing ThingNames::thing(const nlohmann::ordered_json& unit) {
  Thing thing;
  thing.kind = kind_of(unit.at("owner").get<std::string>());
  thing.size = unit.at("size").get<std::uint64_t>();
  thing.first = unit.at("first").get<std::uint64_t>();
  thing.last = unit.at("last").get<std::uint64_t>();
  if (thing.kind == ThingKind::variable || thing.kind == ThingKind::memory)
    thing.module = unit.at("place").at("module").get<std::string>();
  if (thing.kind == ThingKind::variable) {
    const auto symbol = unit.at("name").get<std::string>();
    thing.name = demangled(symbol);
    const auto& lines = lines_of(thing.module);
    if (const auto line = lines.find(symbol); line != lines.end()) {
      thing.file = line->second.file;
      thing.line = line->second.line;
    }
  }
  if (const auto holder = unit.value("holder", std::string()); !holder.empty()) thing.holder = demangled(holder);
  for (const nlohmann::ordered_json& place : unit.at("stack")) {
    const std::vector<shake::CallSite>& found =
        frames(place.at("module").get<std::string>(), place.at("base").get<std::uint64_t>(),
               place.at("offset").get<std::uint64_t>());
    if (found.empty()) continue;
    thing.function = found.front().name();
    thing.file = found.front().file;
    thing.line = found.front().line;
    thing.module = found.front().module;
    break;
  }
  return thing;
}

bool is_same_place(const Thing& a, const Thing& b) {
  return a.kind == b.kind && a.name == b.name && a.module == b.module && a.file == b.file && a.line == b.line &&
         a.function == b.function && a.holder == b.holder && (a.size == b.size || a.kind == ThingKind::heap);
}

void merge(Thing& into, const Thing& from) {
  into.first = std::min(into.first, from.first);
  into.last = std::max(into.last, from.last);
  into.size = std::max(into.size, from.size);
}

std::vector<Thing> ThingNames::things(const nlohmann::ordered_json& units) {
  std::vector<Thing> things;
  for (const nlohmann::ordered_json& unit : units) {
    const Thing next = thing(unit);
    const auto same =
        std::find_if(things.begin(), things.end(), [&](const Thing& other) { return is_same_place(other, next); });
    if (same == things.end())
      things.push_back(next);
    else
      merge(*same, next);
  }
  const auto rank = [](const Thing& t) {
    constexpr int ranks[] = {0, 2, 4, 1, 3};
    return ranks[static_cast<std::size_t>(t.kind)];
  };
  std::stable_sort(things.begin(), things.end(), [&](const Thing& a, const Thing& b) { return rank(a) < rank(b); });
  // Pointers on the stack are dropped if a variable or a block differs, because they only follow from it.
  if (!things.empty() && things.front().kind != ThingKind::stack)
    std::erase_if(things, [](const Thing& t) { return t.kind == ThingKind::stack; });
  return things;
}

}  // namespace ticktrue::unsaved
