// The list of traces for a command: files, directories, and the shard of one machine.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// A directory is replaced by its *.ttr files, sorted by name. Other words are unchanged.
/// Errors: io (a directory that cannot be listed or has no trace).
Result<std::vector<std::string>> list_traces(const std::vector<std::string>& words);

/// Part `index` (from 1) of `count`.
struct Shard {
  std::uint64_t index = 1;
  std::uint64_t count = 1;
};
/// "2/8". Errors: usage.
Result<Shard> parse_shard(const std::string& text);

/// Each count-th file of the sorted list. The shards are disjoint and their union is the list. A shard depends only on
/// the names.
std::vector<std::string> take_shard(std::vector<std::string> files, const Shard& shard);

}  // namespace ticktrue::verifier
