// Options of `ticktrue corpus` about a program that verifies its own traces.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "tool/cli/commands.h"
#include "tool/cli/upkeep/corpus_commands.h"
#include "verifier/programs/command_words.h"

namespace ticktrue::cli {
namespace {

constexpr std::size_t commit_size_max = 64;
constexpr std::uint64_t timeout_max_s = 1'000'000;

bool is_printable(char c) {
  return c > ' ' && c <= '~';
}

}  // namespace

void add_program_options(CLI::App& command, CorpusProgram& options, bool runs) {
  command
      .add_option(
          "--command", options.words,
          "The program that recorded the traces verifies them, as with --command of verify. A verdict holds for "
          "its bytes, its libraries and its words")
      ->type_name("WORDS");
  command
      .add_option(
          "--program-file", options.files,
          "A file or folder that counts as part of the program: a script, a library that it loads while it runs, "
          "a file that it reads")
      ->type_name("PATH");
  if (!runs) return;
  add_number(command, "--timeout", options.timeout_s, "Seconds that a run of the program may take (default 600)",
             {1, timeout_max_s});
  command
      .add_option("--program-commit", options.commit,
                  "The commit that the program was built from: `corpus log` prints it (default -)")
      ->type_name("NAME");
}

Result<std::shared_ptr<const tool::ProgramSubject>> open_program(const CorpusProgram& options,
                                                                 const std::string& mode) {
  const auto refuse = [](const std::string& what, const std::string& hint = "") {
    return Error{ErrorCode::usage, what, hint};
  };
  if (!options.words) {
    if (!options.files.empty()) return refuse("--program-file: found no --command, expected the program");
    if (options.commit != "-") return refuse("--program-commit: found no --command, expected the program");
    return std::shared_ptr<const tool::ProgramSubject>();
  }
  if (mode != "replay")
    return refuse("--mode: found it with --command, expected it among the words of the program",
                  "as in --command './mygame --verify {} --mode restore'");
  if (options.commit.empty() || options.commit.size() > commit_size_max ||
      !std::all_of(options.commit.begin(), options.commit.end(), is_printable))
    return refuse("--program-commit: expected 1.." + std::to_string(commit_size_max) + " letters without blanks");
  Result<std::vector<std::string>> words = verifier::split_command(*options.words);
  if (!words) return words.error();
  tool::ProgramChoice choice;
  choice.words = *std::move(words);
  choice.more_files = options.files;
  choice.version = options.commit;
  choice.time_s = static_cast<double>(options.timeout_s);
  Result<tool::ProgramSubject> subject = tool::ProgramSubject::make(choice);
  if (!subject) return subject.error();
  return std::shared_ptr<const tool::ProgramSubject>(std::make_shared<tool::ProgramSubject>(*std::move(subject)));
}

}  // namespace ticktrue::cli
