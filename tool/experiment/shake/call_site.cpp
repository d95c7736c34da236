// Finds call sites with addr2line (debug information) and objdump (disassembly), both of binutils.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/call_site.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "base/plain_text.h"
#include "verifier/runs/child.h"

namespace ticktrue::shake {
namespace {

namespace fs = std::filesystem;

constexpr double tool_time_s = 30;
constexpr std::size_t place_count_max = 16;
constexpr double disassembly_time_s = 60;

std::string hex(std::uint64_t value) {
  std::ostringstream text;
  text << "0x" << std::hex << value;
  return text.str();
}

/// The debug information of an executable that is loaded at its link address holds absolute addresses.
bool is_at_fixed_address(const std::string& path) {
  constexpr std::size_t type_offset = 16;
  constexpr char type_executable = 2;
  char head[type_offset + 1] = {};
  std::ifstream in(path, std::ios::binary);
  in.read(head, sizeof head);
  return in && head[type_offset] == type_executable;
}

bool is_system_library(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  for (const char* beginning : {"libc.so", "libc-", "libm.so", "libm-", "libstdc++", "libgcc_s", "ld-linux", "libdl",
                                "libpthread", "libc++", "libticktrue", "libffi", "_ctypes"})
    if (name.compare(0, std::string(beginning).size(), beginning) == 0) return true;
  return false;
}

/// Whether a source file belongs to a library. The place of interest is then the caller.
bool is_library_source(const std::string& file) {
  const std::string name = fs::path(file).filename().string();
  return name == "ticktrue.hpp" || name == "ticktrue.h" || file.compare(0, 5, "/usr/") == 0 ||
         file.find("/c++/") != std::string::npos;
}

struct SourcePlace {
  std::string function;
  std::string file;
  unsigned line = 0;
};

SourcePlace source_place(const std::string& function, std::string place) {
  const std::size_t note = place.find(" (discriminator");
  if (note != std::string::npos) place.erase(note);
  const std::size_t colon = place.rfind(':');
  SourcePlace found;
  if (function != "??") found.function = plain_line(function);
  if (colon != std::string::npos && place.compare(0, 2, "??") != 0) {
    found.file = plain_line(place.substr(0, colon));
    found.line = static_cast<unsigned>(std::strtoul(place.c_str() + colon + 1, nullptr, 10));
  }
  return found;
}

/// The source places of each address, innermost first. The following places are the functions into which it was
/// inlined.
std::vector<std::vector<SourcePlace>> source_places(const std::string& module,
                                                    const std::vector<std::uint64_t>& addresses) {
  verifier::ChildCommand command;
  command.argv = {"addr2line", "-e", module, "-a", "-f", "-C", "-i"};
  for (const std::uint64_t address : addresses) command.argv.push_back(hex(address));
  command.limits.time_s = tool_time_s;
  const verifier::ChildResult result = verifier::run_child(command);
  std::vector<std::vector<SourcePlace>> places;
  std::istringstream lines(result.output);
  std::string line;
  std::string place;
  while (std::getline(lines, line)) {
    if (line.compare(0, 2, "0x") == 0) {
      places.emplace_back();
      continue;
    }
    if (places.empty() || !std::getline(lines, place)) break;
    places.back().push_back(source_place(line, place));
  }
  places.resize(addresses.size());
  return places;
}

std::vector<SourcePlace> source_places(const std::string& module, std::uint64_t address) {
  return source_places(module, std::vector<std::uint64_t>{address}).front();
}

/// The call site of a return address, which follows the call. Absent if the call site is in a header of a library.
std::optional<CallSite> program_site(const shim::Module& module, std::uint64_t offset) {
  CallSite site;
  site.module = plain_line(module.path);
  site.offset = offset;
  const std::uint64_t address = (is_at_fixed_address(module.path) ? module.base : 0) + offset - 1;
  const std::vector<SourcePlace> places = source_places(module.path, address);
  for (const SourcePlace& place : places) {
    if (is_library_source(place.file)) continue;
    site.function = place.function;
    site.file = place.file;
    site.line = place.line;
    return site;
  }
  return places.empty() ? std::optional<CallSite>(site) : std::nullopt;
}

/// Shortens "Ship::steer(double, int)" to "Ship::steer".
std::string short_name(const std::string& function) {
  std::string name = function;
  const std::string anonymous = "(anonymous namespace)::";
  for (std::size_t at = name.find(anonymous); at != std::string::npos; at = name.find(anonymous))
    name.erase(at, anonymous.size());
  const std::size_t parameters = name.find('(');
  return parameters == 0 || parameters == std::string::npos ? name : name.substr(0, parameters);
}

}  // namespace

std::string CallSite::text() const {
  std::string text;
  if (!file.empty())
    text = fs::path(file).filename().string() + ":" + std::to_string(line);
  else if (!module.empty())
    text = fs::path(module).filename().string() + "+" + hex(offset);
  if (function.empty()) return text;
  const std::string name = short_name(function);
  return text.empty() ? name : name + " (" + text + ")";
}

std::string CallSite::name() const {
  return function.empty() ? text() : short_name(function);
}

std::vector<std::vector<CallSite>> call_frames(const std::string& module, std::uint64_t base,
                                               const std::vector<std::uint64_t>& offsets) {
  constexpr std::size_t address_count_max = 1'000;  // in one command line
  std::vector<std::vector<CallSite>> frames(offsets.size());
  if (is_system_library(module)) return frames;
  const std::uint64_t added = is_at_fixed_address(module) ? base : 0;
  for (std::size_t begin = 0; begin < offsets.size(); begin += address_count_max) {
    const std::size_t end = std::min(offsets.size(), begin + address_count_max);
    std::vector<std::uint64_t> addresses;
    for (std::size_t i = begin; i < end; ++i) addresses.push_back(added + offsets[i] - 1);
    const std::vector<std::vector<SourcePlace>> places = source_places(module, addresses);
    for (std::size_t i = begin; i < end; ++i) {
      for (const SourcePlace& place : places[i - begin])
        if (!is_library_source(place.file))
          frames[i].push_back({place.function, place.file, place.line, plain_line(module), offsets[i]});
      if (places[i - begin].empty()) frames[i].push_back({"", "", 0, plain_line(module), offsets[i]});
    }
  }
  return frames;
}

CallSite call_site(const shim::Page& page, std::uint32_t module, std::uint64_t offset) {
  if (module >= page.module_count || module >= shim::module_count_max) return {};
  if (const auto site = program_site(page.modules[module], offset)) return *site;
  CallSite site;
  site.module = plain_line(page.modules[module].path);
  site.offset = offset;
  return site;
}

std::string address_text(const std::string& module, std::uint64_t address) {
  CallSite site;
  site.module = plain_line(module);
  site.offset = address;
  for (const SourcePlace& place : source_places(module, address)) {
    if (is_library_source(place.file)) continue;
    site.function = place.function;
    site.file = place.file;
    site.line = place.line;
    break;
  }
  return site.text();
}

CallSite call_site(const shim::Page& page, const shim::CallRecord& record) {
  for (std::uint32_t i = 0; i < record.depth && i < shim::stack_depth_max; ++i) {
    const shim::CodePlace& place = record.stack[i];
    if (place.module >= page.module_count || place.module >= shim::module_count_max) continue;
    const shim::Module& module = page.modules[place.module];
    if (is_system_library(module.path)) continue;
    if (const auto site = program_site(module, place.offset)) return *site;
  }
  return {};
}

std::vector<std::string> find_instructions(const std::string& program) {
  std::vector<std::string> places;
  if (program.empty()) return places;
  verifier::ChildCommand command;
  command.argv = {"sh", "-c", "objdump -d --no-show-raw-insn \"$1\" | grep -E '\\b(rdrand|rdseed|rdtscp?)\\b'", "sh",
                  program};
  command.limits.time_s = disassembly_time_s;
  const verifier::ChildResult result = verifier::run_child(command);
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line) && places.size() < place_count_max;) {
    char* end = nullptr;
    const std::uint64_t address = std::strtoull(line.c_str(), &end, 16);
    std::istringstream words(end != nullptr && *end == ':' ? end + 1 : "");
    std::string instruction;
    if (!(words >> instruction)) continue;
    places.push_back(instruction + " at " + address_text(program, address));
  }
  return places;
}

}  // namespace ticktrue::shake
