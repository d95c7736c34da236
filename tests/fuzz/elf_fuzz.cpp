// Fuzzes the search for a build id and a dynamic linker in files that may be programs.
// SPDX-License-Identifier: MIT
#include <sstream>
#include <string>

#include "tests/fuzz/support/fuzz.h"
#include "verifier/programs/elf_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  const std::string id = ticktrue::verifier::elf_build_id(in);
  ticktrue::fuzz::require(id.size() <= 128 && id.size() % 2 == 0, "a build id has at most 64 bytes");
  ticktrue::fuzz::require(id.find_first_not_of("0123456789abcdef") == std::string::npos, "it is digits");
  ticktrue::fuzz::require(ticktrue::verifier::elf_linker_name(in).size() <= 4'096, "a linker has a path");
  return 0;
}
