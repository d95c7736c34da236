// The hash of the list of units.
// SPDX-License-Identifier: MIT
#include "tool/corpus/engine_digest.h"

#include <string>
#include <string_view>

namespace ticktrue::tool {
namespace {

Hash128 digest_of(std::string_view text) {
  return hash128({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace

std::optional<Hash128> engine_digest() {
  const std::string_view units(engine_units);
  if (units.empty()) return std::nullopt;
  return digest_of(units);
}

std::optional<Hash128> program_verification_digest() {
  const std::string_view programs(program_units);
  if (programs.empty() || !engine_digest()) return std::nullopt;
  return digest_of(engine_units + std::string(programs));
}

}  // namespace ticktrue::tool
