// The subcommands: each adds itself to the command line and leaves its exit code in the context.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tool/output/cli.h"
#include "tool/session/session.h"
#include "verifier/report/report.h"
#include "verifier/verify/verify.h"

namespace ticktrue::cli {

// session
void add_run(CLI::App& app, CliContext& context);
void add_record(CLI::App& app, CliContext& context);
void add_replay(CLI::App& app, CliContext& context);
void add_play(CLI::App& app, CliContext& context);
void add_verify(CLI::App& app, CliContext& context);
void add_diff(CLI::App& app, CliContext& context);
void add_report(CLI::App& app, CliContext& context);
void add_show(CLI::App& app, CliContext& context);
void add_recover(CLI::App& app, CliContext& context);
void add_import(CLI::App& app, CliContext& context);
void add_reduce(CLI::App& app, CliContext& context);
void add_shake(CLI::App& app, CliContext& context);
void add_trail(CLI::App& app, CliContext& context);
void add_unsaved(CLI::App& app, CliContext& context);
void add_campaign(CLI::App& app, CliContext& context);

// study
void add_compare(CLI::App& app, CliContext& context);
void add_accuracy(CLI::App& app, CliContext& context);
void add_stress(CLI::App& app, CliContext& context);
void add_crosscheck(CLI::App& app, CliContext& context);

// upkeep
void add_describe(CLI::App& app, CliContext& context);
void add_scenes(CLI::App& app, CliContext& context);
void add_golden(CLI::App& app, CliContext& context);
void add_corpus(CLI::App& app, CliContext& context);
void add_bisect(CLI::App& app, CliContext& context);
void add_inject(CLI::App& app, CliContext& context);
void add_soak(CLI::App& app, CliContext& context);
void add_columns(CLI::App& app, CliContext& context);
void add_env(CLI::App& app, CliContext& context);

// shared by verify and report
/// Writes the page of the worst report, over an older file; the others that failed are listed in it. Nothing where none
/// failed. Errors: io.
Status write_failure_page(std::span<const verifier::Report> reports, const std::string& path, bool allow_truncated);

// shared by verify and corpus
std::vector<std::string> verify_mode_names();
/// The mode of such a name.
verifier::VerifyMode verify_mode_of(std::string_view name);

// shared by record and golden
/// The --detail of a recording. Errors: usage.
Status parse_detail(const std::string& text, tool::TraceChoices& choices);

}  // namespace ticktrue::cli
