// The bytes that players exchange before tick 0. They find differences in setup, columns, build or floats by name.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/schema.h"
#include "replay/format/trace.h"

namespace ticktrue::capi {

inline constexpr std::size_t hello_size_max = std::size_t{1} << 20;

/// The facts of one player's game.
struct Hello {
  std::uint64_t identity = 0;  // of the session
  std::string simulation;
  std::uint32_t version = 0;
  double dt = 0;  // s
  std::uint64_t setup_size = 0;
  std::uint64_t setup_hash = 0;
  Bytes setup_begin;   // the first bytes of the setup
  StateSchema schema;  // judged columns; empty: too many for a message
  replay::BuildFacts facts;
};

Hello make_hello(const replay::TraceSetup& setup, const replay::BuildFacts& facts);
Bytes encode_hello(const Hello& hello);
/// Errors: corrupt.
Result<Hello> decode_hello(ByteView bytes);

/// The differences, one line each. Lines name the sides "here" and "there".
struct HelloDifferences {
  std::vector<std::string> refusals;  // the two players would not play the same game
  std::vector<std::string> warnings;
};
HelloDifferences hello_differences(const Hello& here, const Hello& there);

}  // namespace ticktrue::capi
