// Runs the tool itself on the cases of tests/cli/cases, and compares its help with docs/cli.md.
// SPDX-License-Identifier: MIT
//
// Each case runs in a fresh directory. A case file holds cases, each made of these lines:
//   === SENTENCE                            begins a case; the case proves the sentence
//   << NAME                                 a file of the directory; its lines end with `>>`
//   $ COMMAND                               run by sh; `ticktrue` is the tool, `inject_fault` that of tests/page;
//                                           the following checks are about this command
//   $^ COMMAND                              the same; the previous command must have printed this command
//   exit N                                  exit code (default 0)
//   stdout: TEXT      stderr: TEXT          the output contains the text
//   stdout!: TEXT     stderr!: TEXT         the output does not contain the text
//   stdout empty      stderr empty
//   stderr errors N                         N lines begin with `ticktrue: error: `
//   file NAME         no file NAME          the file exists, or does not exist, after the command
// Blank lines and lines that begin with # are ignored.
//
// TICKTRUE_UPDATE_DOCS=1 ticktrue_tests "[cli][docs]" rewrites the help texts of docs/cli.md, and "[cli][describe]"
// rewrites tests/cli/describe.expected.
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/text.h"

using ticktrue::test::contains;

namespace {

namespace fs = std::filesystem;

const fs::path root = TICKTRUE_SOURCE_DIR;

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
}

/// A new directory for each case, with the tool in bin/.
class CaseDirectory {
 public:
  CaseDirectory() {
    std::string name = (fs::temp_directory_path() / "ticktrue_cli_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
    fs::create_directory(path_ / "bin");
    fs::create_symlink(TICKTRUE_TOOL, path_ / "bin" / "ticktrue");
    fs::create_symlink(fs::path(TICKTRUE_TOOL).parent_path() / "inject_fault", path_ / "bin" / "inject_fault");
    fs::create_directory(path_ / "work");
  }
  CaseDirectory(const CaseDirectory&) = delete;
  ~CaseDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  fs::path work() const { return path_ / "work"; }

  struct Outcome {
    int exit_code = -1;  // -1: killed by a signal
    std::string out;
    std::string err;
  };
  Outcome run(const std::string& command) const {
    const std::string line = "cd '" + work().string() + "' && PATH='" + (path_ / "bin").string() +
                             "':\"$PATH\" && export PATH && { " + command + "\n} >'" + (path_ / "out").string() +
                             "' 2>'" + (path_ / "err").string() + "' </dev/null";
    const int status = std::system(line.c_str());
    Outcome outcome;
    if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
    outcome.out = read_file(path_ / "out");
    outcome.err = read_file(path_ / "err");
    return outcome;
  }

 private:
  fs::path path_;
};

struct Check {
  std::string text;  // line of the case file
  std::string kind;
  std::string value;
};
struct Step {
  std::vector<std::pair<std::string, std::string>> files;  // name, content: written before the command runs
  std::string command;
  std::vector<Check> checks;
  bool was_printed = false;  // the previous step must have printed the command
};
struct Case {
  std::string place;  // file:line
  std::string sentence;
  std::vector<Step> steps;
};

constexpr std::array<std::string_view, 11> check_kinds{
    "exit ",        "stdout: ",       "stderr: ", "stdout!: ", "stderr!: ",    "stdout empty",
    "stderr empty", "stderr errors ", "file ",    "no file ",  "stdout lines "};

std::vector<Case> read_cases(const fs::path& path) {
  std::vector<Case> cases;
  std::vector<std::pair<std::string, std::string>> files;
  std::ifstream in(path);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::string place = path.filename().string() + ":" + std::to_string(number);
    if (line.find_first_not_of(" \t") == std::string::npos || line[0] == '#') continue;
    CAPTURE(place, line);
    if (line.compare(0, 4, "=== ") == 0) {
      cases.push_back({place, line.substr(4), {}});
      continue;
    }
    REQUIRE_FALSE(cases.empty());
    if (line.compare(0, 3, "<< ") == 0) {
      const std::string name = line.substr(3);
      std::string content;
      bool is_closed = false;
      for (std::string text; !is_closed && std::getline(in, text); ++number) {
        is_closed = text == ">>";
        if (!is_closed) content += text + "\n";
      }
      REQUIRE(is_closed);
      files.emplace_back(name, content);
      continue;
    }
    if (line.compare(0, 2, "$ ") == 0 || line.compare(0, 3, "$^ ") == 0) {
      const bool was_printed = line[1] == '^';
      cases.back().steps.push_back({std::move(files), line.substr(was_printed ? 3 : 2), {}, was_printed});
      files.clear();
      continue;
    }
    const auto kind = std::find_if(check_kinds.begin(), check_kinds.end(),
                                   [&](std::string_view k) { return line.compare(0, k.size(), k) == 0; });
    REQUIRE(kind != check_kinds.end());
    REQUIRE_FALSE(cases.back().steps.empty());
    cases.back().steps.back().checks.push_back({line, std::string(*kind), line.substr(kind->size())});
  }
  return cases;
}

long count_lines(const std::string& text, std::string_view beginning) {
  long count = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) count += line.compare(0, beginning.size(), beginning) == 0;
  return count;
}

bool holds(const Check& check, const CaseDirectory::Outcome& outcome, const fs::path& work) {
  if (check.kind == "exit ") return true;  // compared by the caller
  if (check.kind == "stdout: ") return contains(outcome.out, check.value);
  if (check.kind == "stderr: ") return contains(outcome.err, check.value);
  if (check.kind == "stdout!: ") return !contains(outcome.out, check.value);
  if (check.kind == "stderr!: ") return !contains(outcome.err, check.value);
  if (check.kind == "stdout empty") return outcome.out.empty();
  if (check.kind == "stderr empty") return outcome.err.empty();
  if (check.kind == "stdout lines ") return count_lines(outcome.out, "") == std::stol(check.value);
  if (check.kind == "stderr errors ") return count_lines(outcome.err, "ticktrue: error: ") == std::stol(check.value);
  if (check.kind == "file ") return fs::exists(work / check.value);
  if (check.kind == "no file ") return !fs::exists(work / check.value);
  return false;
}

void run_case(const Case& one) {
  const CaseDirectory directory;
  std::string printed;  // by the previous step
  for (const Step& step : one.steps) {
    for (const auto& [name, content] : step.files) write_file(directory.work() / name, content);
    if (step.was_printed) {
      CAPTURE(one.place, one.sentence, printed);
      CHECK_THAT(printed, Catch::Matchers::Contains(step.command));
    }
    const CaseDirectory::Outcome outcome = directory.run(step.command);
    printed = outcome.out + outcome.err;
    int expected_exit = 0;
    for (const Check& check : step.checks)
      if (check.kind == "exit ") expected_exit = std::stoi(check.value);
    const std::string place = one.place + ": " + one.sentence;
    CAPTURE(place, step.command, outcome.out, outcome.err);
    CHECK(outcome.exit_code == expected_exit);
    for (const Check& check : step.checks) {
      CAPTURE(check.text);
      CHECK(holds(check, outcome, directory.work()));
    }
  }
}

void run_cases(const std::string& file) {
  const std::vector<Case> cases = read_cases(root / "tests/cli/cases" / file);
  REQUIRE_FALSE(cases.empty());
  for (const Case& one : cases) run_case(one);
}

std::string help_of(const std::string& words) {
  const CaseDirectory directory;
  const CaseDirectory::Outcome outcome = directory.run("ticktrue " + words + " --help");
  CAPTURE(words, outcome.err);
  REQUIRE(outcome.exit_code == 0);
  return outcome.out;
}

}  // namespace

TEST_CASE("bad scenes give one clear line and exit 2, and write nothing", "[cli][scenes][equivalence]") {
  run_cases("bad_scenes.case");
}
TEST_CASE("bad inputs give one clear line and exit 2, and write nothing", "[cli][inputs][equivalence]") {
  run_cases("bad_inputs.case");
}
TEST_CASE("a wrong command line is told with what would be right", "[cli][usage][equivalence]") {
  run_cases("usage.case");
}
TEST_CASE("files are not overwritten unasked, and what the system refuses is told", "[cli][files][equivalence]") {
  run_cases("files.case");
}
TEST_CASE("a session goes from scene to trace to states and back", "[cli][session][equivalence]") {
  run_cases("session.case");
}
TEST_CASE("shake tells what is wrong with its words, and finds the engine of this project quiet", "[cli][shake]") {
  run_cases("shake.case");
}
TEST_CASE("a failing session is reduced to one that its own command shows", "[cli][reduce][equivalence]") {
  run_cases("reduce.case");
}
TEST_CASE("the first bad commit of a repository is named", "[cli][bisect][equivalence]") {
  run_cases("bisect.case");
}
TEST_CASE("traces are verified in parts, in parallel, on shards and against other builds",
          "[cli][verify][equivalence]") {
  run_cases("verify.case");
}
TEST_CASE("verify runs a program, and neither its exit code nor its word alone is a match", "[cli][programs]") {
  run_cases("programs.case");
}
TEST_CASE("a campaign records and judges each seed, and goes on where it was stopped", "[cli][campaign]") {
  run_cases("campaign.case");
}
TEST_CASE("golden traces are recorded, checked and told apart", "[cli][golden][equivalence]") {
  run_cases("golden.case");
}
TEST_CASE("a corpus is verified once, by any number of workers", "[cli][corpus][equivalence]") {
  run_cases("corpus.case");
}
TEST_CASE("live inputs are recorded as they arrive", "[cli][live][equivalence]") {
  run_cases("live.case");
}
TEST_CASE("scenes of another editor become scene files", "[cli][import][equivalence]") {
  run_cases("import_rube.case");
}
TEST_CASE("pages are written when they should be, and over nothing", "[cli][report][equivalence]") {
  run_cases("report.case");
}
TEST_CASE("scenes, stages, columns and the machine are described", "[cli][upkeep][equivalence]") {
  run_cases("upkeep.case");
}

TEST_CASE("compare, accuracy and stress print what they found, and refuse what they cannot do", "[cli][study]") {
  run_cases("study.case");
}
TEST_CASE("what a user's file claims is judged or told, and joints tell all that they hold", "[cli][study]") {
  run_cases("claims.case");
}
TEST_CASE("each command that a message prints can be run as it stands", "[cli][hints][equivalence]") {
  run_cases("hints.case");
}
TEST_CASE("the window's sessions and pictures work without a display", "[cli][play]") {
  run_cases("play.case");
}
TEST_CASE("options that people rarely type", "[cli][play]") {
  run_cases("options.case");
}

TEST_CASE("more shapes in one place than a tick can look at are told, and what came before is kept", "[cli][limits]") {
  run_cases("crowds.case");
}
TEST_CASE("ten scenes are described word for word", "[cli][describe][golden]") {
  // describe.expected has files as in cases. The output of a command follows its line "$ COMMAND".
  const fs::path path = root / "tests/cli/describe.expected";
  const std::string text = read_file(path);
  const CaseDirectory directory;
  std::string updated;
  std::istringstream in(text);
  int run_count = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.compare(0, 3, "<< ") == 0) {
      std::string content;
      for (std::string inner; std::getline(in, inner) && inner != ">>";) content += inner + "\n";
      write_file(directory.work() / line.substr(3), content);
      updated += line + "\n" + content + ">>\n";
    }
    if (line.compare(0, 2, "$ ") != 0) continue;
    std::string expected;
    for (std::string inner; in.peek() != EOF && in.peek() != '$' && in.peek() != '<' && std::getline(in, inner);)
      expected += inner + "\n";
    const CaseDirectory::Outcome outcome = directory.run(line.substr(2));
    CAPTURE(line, outcome.err);
    CHECK(outcome.exit_code == 0);
    if (std::getenv("TICKTRUE_UPDATE_DOCS") == nullptr) CHECK(outcome.out == expected);
    updated += line + "\n" + outcome.out;
    ++run_count;
  }
  CHECK(run_count == 10);
  if (std::getenv("TICKTRUE_UPDATE_DOCS") != nullptr && updated != text) write_file(path, updated);
}
TEST_CASE("every case file is run", "[cli][cases][equivalence]") {
  const std::string own_text = read_file(root / "tests/cli/cli_test.cpp");
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "tests/cli/cases")) {
    const std::string name = entry.path().filename().string();
    CAPTURE(name);
    CHECK(contains(own_text, "run_cases(\"" + name + "\")"));
  }
}

TEST_CASE("the examples of each help work in order, in an empty directory", "[cli][docs][equivalence]") {
  std::istringstream in(read_file(root / "docs/cli.md"));
  int run_count = 0;
  for (std::string line; std::getline(in, line);) {
    const std::string begin = "```text ticktrue ";
    // These commands need no file and take long.
    const bool is_long = contains(line, "crosscheck") || contains(line, "accuracy") || contains(line, "stress");
    if (line.compare(0, begin.size(), begin) != 0 || is_long) continue;
    const CaseDirectory directory;
    bool in_examples = false;
    for (std::string inner; std::getline(in, inner) && inner != "```";) {
      in_examples = inner == "Examples:" || inner == "Example:" || (in_examples && inner.compare(0, 2, "  ") == 0);
      if (!in_examples || inner.compare(0, 2, "  ") != 0 || contains(inner, "git bisect")) continue;
      const CaseDirectory::Outcome outcome = directory.run(inner);
      CAPTURE(line, inner, outcome.out, outcome.err);
      CHECK(outcome.exit_code == (contains(inner, "diff") ? 1 : 0));
      ++run_count;
    }
  }
  CHECK(run_count >= 20);
}

TEST_CASE("docs/cli.md shows the help texts of the tool word for word", "[cli][docs][equivalence]") {
  // A block: a line "```text ticktrue WORDS --help", the help, a line "```".
  const fs::path path = root / "docs/cli.md";
  const std::string text = read_file(path);
  std::string updated;
  std::istringstream in(text);
  std::vector<std::string> documented;
  for (std::string line; std::getline(in, line);) {
    updated += line + "\n";
    const std::string begin = "```text ticktrue ";
    if (line.compare(0, begin.size(), begin) != 0) continue;
    std::string words = line.substr(begin.size());
    REQUIRE(contains(words, "--help"));
    words.erase(words.find("--help"));
    documented.push_back(words);
    std::string block;
    for (std::string inner; std::getline(in, inner) && inner != "```";) block += inner + "\n";
    const std::string help = help_of(words);
    if (std::getenv("TICKTRUE_UPDATE_DOCS") == nullptr) CHECK(block == help);
    updated += help + "```\n";
  }
  if (std::getenv("TICKTRUE_UPDATE_DOCS") != nullptr && updated != text) write_file(path, updated);

  // Every subcommand that the top-level help lists has its block.
  std::istringstream top(help_of(""));
  bool in_group = false;
  int listed_count = 0;
  for (std::string line; std::getline(top, line);) {
    if (line == "session:" || line == "study:" || line == "upkeep:") {
      in_group = true;
      continue;
    }
    if (line.compare(0, 2, "  ") != 0 || line[2] == ' ') {
      in_group = in_group && !line.empty() && line[0] == ' ';
      continue;
    }
    if (!in_group) continue;
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    CAPTURE(name);
    CHECK(std::find(documented.begin(), documented.end(), name + " ") != documented.end());
    ++listed_count;
  }
  CHECK(listed_count >= 13);
}
