// Without libdw: no debug information can be read.
// SPDX-License-Identifier: MIT
#include "tool/debug_info/program_types.h"

namespace ticktrue::debug_info {
namespace {

Error left_out() {
  return {ErrorCode::unsupported, "debug information: found a build of ticktrue without libdw, which reads it",
          "install libdw-dev and build anew"};
}

}  // namespace

bool can_read_debug_info() {
  return false;
}

Result<std::vector<StructName>> struct_names(const std::string&) {
  return left_out();
}

Result<std::vector<StructTypes>> find_structs(const std::string&, const std::string&) {
  return left_out();
}

}  // namespace ticktrue::debug_info
