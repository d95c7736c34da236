// Parts of `ticktrue corpus` that have a file of their own.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tool/corpus/program_subject.h"
#include "tool/corpus/run/corpus_run.h"
#include "tool/output/cli.h"

namespace ticktrue::cli {

inline constexpr std::uint64_t lease_max_s = 86'400;

void add_corpus_log(CLI::App& corpus, CliContext& context);
void add_corpus_slurm(CLI::App& corpus, CliContext& context);

/// A program that verifies its own traces, as the command line names it.
struct CorpusProgram {
  std::optional<std::string> words;
  std::vector<std::string> files;
  std::string commit = "-";
  std::uint64_t timeout_s = 600;
};
/// `runs`: the command runs the program, or has it run.
void add_program_options(CLI::App& command, CorpusProgram& options, bool runs);
/// Null: there is no --command. Errors: usage, io, limit, unsupported.
Result<std::shared_ptr<const tool::ProgramSubject>> open_program(const CorpusProgram& options, const std::string& mode);

struct CorpusPage {
  std::string path;
  std::string store;
  bool allow_truncated = false;
};
/// Writes a page about the units, over an older file. The page of the worst trace is inside of it. Errors: io.
Status write_corpus_page(const std::vector<tool::CorpusUnit>& units, const tool::BuildSubject& build,
                         const CorpusPage& page);

}  // namespace ticktrue::cli
