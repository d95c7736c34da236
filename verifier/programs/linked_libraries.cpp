// Parses the lines of --list.
// SPDX-License-Identifier: MIT
#include "verifier/programs/linked_libraries.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "base/plain_text.h"

namespace ticktrue::verifier {
Result<std::vector<std::string>> listed_libraries(const std::string& program, const std::string& text) {
  // "\tlibm.so.6 => /lib/libm.so.6 (0x7f...)", "\t/lib64/ld-linux-x86-64.so.2 (0x7f...)", "\tlinux-vdso.so.1
  // (0x7f...)".
  constexpr std::string_view arrow = " => ";
  std::vector<std::string> libraries;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
    const std::size_t at = line.find(arrow);
    std::string path = at == std::string::npos ? line : line.substr(at + arrow.size());
    if (path == "not found")
      return Error{ErrorCode::io,
                   program + ": its library " + plain_line(line.substr(0, at)) + " was not found, expected one",
                   "the variable LD_LIBRARY_PATH names more folders"};
    path = path.substr(0, path.rfind(" ("));
    if (path.find('/') != std::string::npos) libraries.push_back(path);
  }
  return libraries;
}

}  // namespace ticktrue::verifier
