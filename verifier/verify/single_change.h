// Finds the single bit of a state whose flip gives the recorded hash, by trying every bit.
// SPDX-License-Identifier: MIT
//
// A trace may store only the root hash of a tick. If the recorder's memory lost one bit (a hardware fault, a stray
// write), the recorded state differs from the state here in this bit alone. A flip of another bit gives the recorded
// hash with probability (number of tries) / 2^64.
#pragma once

#include <cstdint>
#include <optional>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/state_view.h"
#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

// About ten seconds on one core. A state of a thousand bodies needs a tenth of this number.
inline constexpr std::uint64_t single_changes_max = 20'000'000;

/// `image` with the one flipped bit that gives the hash `wanted`. Nothing: no single bit does, or there are more than
/// single_changes_max bits. `thread_count` threads share the work. Errors: corrupt (the image does not fit the schema).
Result<std::optional<Bytes>> find_single_bit(const StateSchema& schema, ByteView image, std::uint64_t wanted,
                                             unsigned thread_count);

/// Does nothing unless the trace stores only a hash of the differing tick. If one flipped bit explains this hash, adds
/// the place of the bit and its meaning to the divergence of `findings`.
void explain_by_single_bit(const WalkContext& context, const Mismatch& mismatch, Findings& findings);

}  // namespace ticktrue::verifier
