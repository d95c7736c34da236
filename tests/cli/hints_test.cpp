// Provokes each message in the sources that prints a command, and runs the command.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test::hints {
namespace {

namespace fs = std::filesystem;

const fs::path tree = TICKTRUE_SOURCE_DIR;

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct SourceHint {
  std::string place;
  std::string text;  // from "ticktrue" to the end of the literal or of the command
};

/// The command in a literal. The command ends at a backtick, a comma, a semicolon or English words.
std::string command_part(const std::string& literal, std::size_t at) {
  std::string text = literal.substr(at);
  for (const char* end : {"`", ",", ";", " here", " lists", " shows", " tells", " says", " makes", "\\n"})
    if (const std::size_t cut = text.find(end); cut != std::string::npos) text.erase(cut);
  return text;
}

/// Literals that contain "ticktrue SUBCOMMAND", or that continue after the tool's name with a subcommand. Examples in
/// help texts and descriptions are tested where they are printed. Statements of set_examples and add_subcommand, and
/// raw strings, are therefore skipped.
std::vector<SourceHint> hints_of(const fs::path& path) {
  std::vector<SourceHint> hints;
  static const std::regex literal(R"re("((?:[^"\\]|\\.)*)")re");
  static const std::regex command(
      R"re(ticktrue (run|record|replay|play|verify|diff|report|show|recover|import|compare|accuracy|stress|crosscheck)re"
      R"re(|describe|scenes|golden|corpus|inject|env|soak)re"
      R"re(|shake|trail|unsaved|reduce|bisect|campaign|columns|--help)(?![a-z])|^ (verify|record|replay|diff) )re");
  std::istringstream in(text_of(path));
  int number = 0;
  bool in_examples = false;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (contains(line, "set_examples(")) in_examples = true;
    const bool is_left_out = in_examples || line.find("//") == line.find_first_not_of(' ');
    if (contains(line, ");")) in_examples = false;
    if (is_left_out) continue;
    for (std::sregex_iterator it(line.begin(), line.end(), literal), end; it != end; ++it) {
      const std::string text = (*it)[1];
      std::smatch found;
      if (std::regex_search(text, found, command))
        hints.push_back({fs::relative(path, tree).generic_string() + ":" + std::to_string(number),
                         (found.str(0)[0] == ' ' ? "ticktrue" : "") +
                             command_part(text, static_cast<std::size_t>(found.position(0)))});
    }
  }
  return hints;
}

/// Literals that are not a command of a message, or whose command runs in another test: file, beginning of the literal,
/// reason.
struct Elsewhere {
  const char* file;
  const char* beginning;
  const char* reason;
};
constexpr Elsewhere elsewhere[] = {
    {"tool/cli/study/scenes.cpp", "ticktrue record {0}", "hints.case runs it with names in place of {0}"},
    {"tool/experiment/soak/failure_files.cpp", "ticktrue soak", "written beside a failure, which needs a fault"},
    {"engine/random_worlds/world_hashes.cpp", "ticktrue soak",
     "what a file says of itself: ./dev golden update runs it"},
    {"tool/cli/upkeep/soak.cpp", "ticktrue golden check traces", "needs a build that computes otherwise"},
    {"tool/experiment/soak/soak.cpp", "ticktrue soak", "what a file holds while a world is examined"},
    {"verifier/verify/verify.cpp", "ticktrue verify full.ttr --mode restore",
     "needs a simulation that hides a variable: tests/verifier/state_incomplete_test.cpp"},
    {"verifier/locate/locate_cells.cpp", "ticktrue verify full.ttr",
     "needs a build that computes otherwise: tests/verifier/against_build_test.cpp"},
    {"tool/experiment/soak/known_counts.cpp", "ticktrue soak", "runs random worlds for minutes"},
    {"verifier/report/report_ci.cpp", "ticktrue verify", "the name of a test suite and a headline"},
    {"tool/cli/study/compare.cpp", "ticktrue run", "a name within a help text: docs/cli.md is compared with it"},
    {"tool/cli/session/verify.cpp", "ticktrue report", "a name within a help text: docs/cli.md is compared with it"},
    {"tool/cli/session/import.cpp", "ticktrue import", "the end of a help text: printed_commands_test.cpp runs it"},
    {"tool/cli/study/accuracy_peer.cpp", "ticktrue accuracy --peer",
     "runs for minutes: parsed as an example of a help"},
    {"replay/format/trace.h", "ticktrue recover", "what the end of a trace says, no command"},
    {"verifier/compare/against_build.cpp", "ticktrue replay",
     "of another build: tests/verifier/against_build_test.cpp"},
    {"tool/play/player.cpp", "ticktrue replay", "needs a trace of 4,000,000 ticks; the command has no argument"},
    {"tool/play/command.cpp", "ticktrue play", "tests/cli/cases/play.case; ONE.ttr and OTHER.ttr stand for files"},
    {"tool/play/trace_mode.cpp", "ticktrue verify {}", "hints.case runs it with a name in place of {}"},
    {"tool/cli/session/reduce.cpp", "ticktrue soak", "a name within a help text: docs/cli.md is compared with it"},
    {"tool/cli/upkeep/bisect.cpp", "ticktrue verify {}", "a default, which needs a build of a whole repository"},
    {"tool/cli/upkeep/bisect.cpp", "ticktrue env", "a default, which needs a build of a whole repository"},
    {"capi/comparing.cpp", "ticktrue diff A B", "A and B stand for files: traces of a session without full detail"},
    {"capi/comparing.cpp", "ticktrue recover", "tests/examples/run.sh"},
    {"capi/comparing.cpp", "ticktrue shake", "tests/causes/causes_test.py runs it as a session prints it"},
    {"capi/comparing.cpp", "ticktrue trail", "tests/trail/trail_test.py runs it as a session prints it"},
    {"tool/session/plugin_session.cpp", "ticktrue recover", "tests/examples/run.sh"},
    {"tool/experiment/shake/launch.cpp", "ticktrue shake",
     "tests/trail/trail_test.py and tests/unsaved/unsaved_test.py run it as trail and unsaved print it"},
    {"tool/cli/session/replay.cpp", "ticktrue show ", "needs a trace of a session: tests/capi/session_test.cpp"},
    {"verifier/programs/verify_program.cpp", "ticktrue shake", "tests/cli/cases/programs.case runs it"},
    {"capi/comparing.cpp", "ticktrue unsaved", "tests/unsaved/unsaved_test.py runs it as a session prints it"},
    {"capi/peers/bundle.cpp", "ticktrue show", "needs a bundle of two players: tests/examples/run.sh"},
    {"verifier/peers/bundle.cpp", "ticktrue show", "needs a bundle of two players: tests/examples/run.sh"},
    {"replay/trace_reader.cpp", "ticktrue recover", "needs a black box: tests/capi/box_test.cpp"},
    {"tool/cli/session/trail.cpp", "ticktrue trail session.ttr", "in a help text, for a program with a session"},
    {"tool/cli/session/unsaved.cpp", "ticktrue unsaved session.ttr", "in a help text, for a program with a session"},
    {"tool/cli/upkeep/bisect.cpp", "ticktrue bisect v1.0", "in a help text, for a repository"},
    {"tool/cli/upkeep/columns.cpp", "ticktrue columns ",
     "needs a program with debug information: tests/cli/columns.sh"},
    {"tool/experiment/soak/cache_counts.cpp", "ticktrue soak",
     "what a file says of itself: ./dev golden update runs it"},
};

bool is_of(const SourceHint& hint, const Elsewhere& row) {
  return hint.place.compare(0, std::string(row.file).size(), row.file) == 0 &&
         hint.text.compare(0, std::string(row.beginning).size(), row.beginning) == 0;
}

bool is_elsewhere(const SourceHint& hint) {
  return std::any_of(std::begin(elsewhere), std::end(elsewhere),
                     [&](const Elsewhere& row) { return is_of(hint, row); });
}

}  // namespace

TEST_CASE("for every message that prints a command there is a case that runs it", "[cli][hints][equivalence]") {
  std::vector<std::string> commands;
  std::istringstream cases(text_of(tree / "tests/cli/cases/hints.case"));
  for (std::string line; std::getline(cases, line);)
    if (line.compare(0, 3, "$^ ") == 0) commands.push_back(line.substr(3));
  std::vector<SourceHint> hints;
  for (const char* folder : {"base", "engine", "replay", "verifier", "capi", "tool"})
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(tree / folder)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".h") continue;
      for (SourceHint& hint : hints_of(entry.path())) hints.push_back(std::move(hint));
    }
  CHECK(hints.size() >= 25);
  for (const Elsewhere& row : elsewhere) {
    INFO(row.file << ": no message has this: " << row.beginning);
    CHECK(std::any_of(hints.begin(), hints.end(), [&](const SourceHint& hint) { return is_of(hint, row); }));
  }
  for (const SourceHint& hint : hints) {
    if (is_elsewhere(hint)) continue;
    CAPTURE(hint.place, hint.text);
    CHECK(std::any_of(commands.begin(), commands.end(), [&](const std::string& command) {
      return command.compare(0, hint.text.size(), hint.text) == 0;
    }));
  }
}

}  // namespace ticktrue::test::hints
