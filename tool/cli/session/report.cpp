// `ticktrue report`: verifies a trace and writes a page that shows what was found.
// SPDX-License-Identifier: MIT
#include "verifier/report/report.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tool/cli/commands.h"
#include "tool/output/progress.h"
#include "tool/report_page/report_page.h"
#include "tool/session/simulations.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/verify/verify.h"

namespace ticktrue::cli {
namespace {

struct ReportCommand {
  std::string file;
  std::string against;
  std::string output;
  bool force = false;
  bool allow_truncated = false;
};

verifier::Report verify_for_page(const ReportCommand& command) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(command.file);
  if (!reader) return verifier::open_error_report(command.file, reader.error());
  verifier::VerifyOptions options;
  options.simulation = tool::find_simulation(reader->setup().simulation);
  options.search_single_bit = true;
  Progress progress("verify " + command.file, reader->tick_count_hint().value_or(0));
  options.progress = [&](std::uint64_t ticks_done) { progress.update(ticks_done); };
  verifier::Report report = verifier::verify(*reader, options);
  progress.finish();
  if (options.simulation == nullptr && report.hint.empty())
    report.hint = tool::other_simulation_hint(command.file, reader->facts());
  return report;
}

Status write_page(const std::string& path, bool overwrite, const tool::Page& page) {
  auto file = verifier::DataFile::create(path, overwrite);
  if (!file) return file.error();
  if (const Status status = file->write(page.html); !status) return status;
  return file->close();
}

int run_report(const ReportCommand& command) {
  std::vector<std::string> read{command.file};
  if (!command.against.empty()) read.push_back(command.against);
  if (const Status status = verifier::check_not_read(command.output, read); !status) return fail_usage(status.error());
  if (const Status status = verifier::check_writable_target(command.output, command.force); !status)
    return fail_usage(status.error());
  const verifier::Report report = verify_for_page(command);
  if (report.verdict == verifier::Verdict::error) return fail_usage(Error{ErrorCode::io, report.reason, report.hint});

  tool::PageOptions options;
  options.against = command.against;
  options.command = "ticktrue report " + verifier::shell_word(command.file);
  if (!command.against.empty()) options.command += " --against " + verifier::shell_word(command.against);
  options.command += " -o " + verifier::shell_word(command.output);
  options.allow_truncated = command.allow_truncated;
  Progress progress("play " + command.file, 0);
  options.progress = [&](std::uint64_t done, std::uint64_t of) { progress.update(done, of); };
  const Result<tool::Page> page = tool::make_report_page(report, options);
  progress.finish();
  if (!page) return fail(page.error());
  if (const Status status = write_page(command.output, command.force, *page); !status)
    return fail_usage(status.error());
  const std::string against = page->against.empty() ? "" : "; against " + command.against + ": " + page->against;
  print_note(fmt::format("{}: {}{} ({} KB)", command.output, verifier::report_sentence(report), against,
                         (page->html.size() + 999) / 1000));
  return page->exit_code;
}

}  // namespace

Status write_failure_page(std::span<const verifier::Report> reports, const std::string& path, bool allow_truncated) {
  std::vector<int> codes;
  for (const verifier::Report& report : reports) codes.push_back(report.exit_code(allow_truncated));
  const int worst = worst_exit_code(codes);
  if (worst == exit_ok) return {};
  const verifier::Report* shown = nullptr;
  std::vector<verifier::Report> others;
  for (const verifier::Report& report : reports) {
    const int code = report.exit_code(allow_truncated);
    if (shown == nullptr && code == worst)
      shown = &report;
    else if (code != exit_ok)
      others.push_back(report);
  }
  tool::PageOptions options;
  options.others = others;
  options.allow_truncated = allow_truncated;
  options.command = "ticktrue verify " + verifier::shell_word(shown->file) + " --report " + verifier::shell_word(path);
  const Result<tool::Page> page = tool::make_report_page(*shown, options);
  if (!page) return page.error();
  return write_page(path, true, *page);
}

void add_report(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ReportCommand>();
  CLI::App* command = app.add_subcommand("report", "Write what verify finds as a page that plays the trace (HTML)")
                          ->group(group_session);
  command->add_option("FILE", options->file, "Trace; of a cut or damaged one, what is intact is shown")->required();
  command
      ->add_option("--against", options->against,
                   "Another trace of what should be the same session: its bodies as ghosts, and where both part")
      ->type_name("OTHER.ttr");
  command->add_option("-o,--output", options->output, "The page: one file, which loads nothing")
      ->required()
      ->type_name("OUT.html");
  command->add_flag("--force", options->force, "Replace an existing file");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "A trace that ends early is fine if every tick it has matches");
  set_examples(
      *command,
      "ticktrue record 'pyramid?base=10' --ticks 600 -o pyramid.ttr\n"
      "ticktrue report pyramid.ttr -o pyramid.html\n"
      "ticktrue record pyramid.ttr --detail full:100..200 -o again.ttr\n"
      "ticktrue report pyramid.ttr --against again.ttr -o both.html",
      "The exit code is that of verify, or of diff where that is worse. docs/report.md says what is on the page.");
  command->callback([options, &context] { context.exit_code = run_report(*options); });
}

}  // namespace ticktrue::cli
