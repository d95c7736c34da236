// Parts of `ticktrue corpus` that have a file of their own.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tool/corpus/corpus_run.h"
#include "tool/output/cli.h"

namespace ticktrue::cli {

inline constexpr std::uint64_t lease_max_s = 86'400;

void add_corpus_log(CLI::App& corpus, CliContext& context);
void add_corpus_slurm(CLI::App& corpus, CliContext& context);

struct CorpusPage {
  std::string path;
  std::string store;
  bool allow_truncated = false;
};
/// Writes a page about the units, over an older file. The page of the worst trace is inside of it. Errors: io.
Status write_corpus_page(const std::vector<verifier::CorpusUnit>& units, const verifier::BuildSubject& build,
                         const CorpusPage& page);

}  // namespace ticktrue::cli
