// Finds the single bit of a state that must be flipped to get the recorded hash, by trying every bit.
// SPDX-License-Identifier: MIT
//
// A trace may store no more of a tick than its root hash. Where the recorder's memory lost one bit (a fault of the
// machine, a stray write), the state here differs from the recorded one in that bit alone, and among the states next to
// it only that one has the recorded hash: a wrong one would have it with probability (number tried) / 2^64.
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/state_view.h"
#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

// Some ten seconds on one core; a state of a thousand bodies has a tenth of it.
inline constexpr std::uint64_t single_changes_max = 20'000'000;

/// `image` with the one bit changed that gives it the hash `wanted`; nothing if no single bit does, or if there are
/// more than single_changes_max to try. `thread_count` threads share the work. Errors: corrupt (the image does not
/// fit).
Result<std::optional<Bytes>> find_single_bit(const StateSchema& schema, ByteView image, std::uint64_t wanted,
                                             unsigned thread_count);

/// If the trace stores only a hash of the differing tick and one flipped bit explains the hash: adds that place and its
/// meaning to the divergence of `findings`.
void explain_by_single_bit(const WalkContext& context, const Mismatch& mismatch, Findings& findings);

}  // namespace ticktrue::verifier
