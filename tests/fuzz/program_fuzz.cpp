// Fuzzes what is read of a program: the list that its dynamic linker prints.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/fuzz.h"
#include "verifier/programs/linked_libraries.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const ByteView bytes(data, size);
  const auto libraries = verifier::listed_libraries("game", std::string(fuzz::text_of(bytes)));
  if (!libraries) {
    fuzz::require_message(libraries.error());
    return 0;
  }
  for (const std::string& path : *libraries) fuzz::require(path.find('/') != std::string::npos, "a library has a path");
  return 0;
}
