// objdump of binutils disassembles; addr2line names the places.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/instructions.h"

#include <cstdlib>
#include <sstream>

#include "tool/experiment/shake/call_site.h"
#include "verifier/runs/child.h"

namespace ticktrue::shake {
namespace {

constexpr std::size_t place_count_max = 16;
constexpr double disassembly_time_s = 60;

}  // namespace

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
