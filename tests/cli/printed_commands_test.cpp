// Runs the commands that the documents print, and compares the shown output with the real output.
// SPDX-License-Identifier: MIT
//
// A command is one of:
//   - a line "$ COMMAND" of a fenced block; the lines below it, up to the next command, are its output;
//   - a line without "$ " in a block that is marked `sh`, or whose first line begins like a command;
//   - a line below a heading of a help text in docs/cli.md ("Examples:" and similar);
//   - a line "- run: ticktrue ..." of a workflow;
//   - a line "  again   ticktrue ..." of a report, and `ticktrue ...` within a text.
// Commands of a document run in order in one folder. Commands of a help text run in a separate folder. Commands of the
// last kind are only parsed (--parse-only), with placeholders such as FILE unchanged. `./dev ...` must be in `./dev
// help`.
//
// tests/cli/printed_commands.tsv has the exceptions, each with its reason. A command fails if it does not work and has
// no exception. An unneeded exception fails, and so does a number of exceptions that differs from the stated number.
//
// TICKTRUE_UPDATE_DOCS=1 ticktrue_tests "[printed]" rewrites differing outputs that contain no "...".
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/box2d3.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test::printed {
namespace {

namespace fs = std::filesystem;

const fs::path tree = TICKTRUE_SOURCE_DIR;

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool begins_with(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

enum class How { run, parse, leave };

struct PrintedCommand {
  std::string document;
  std::size_t line = 0;
  std::size_t part = 0;  // folder in which it runs: 0 for the document, else of a help text
  std::string text;
  How how = How::run;
  std::vector<std::string> output;  // as the document shows it
  std::string place() const { return document + ":" + std::to_string(line); }
};

/// Removes a comment: "   # why".
std::string without_comment(std::string text) {
  if (const std::size_t mark = text.find("  #"); mark != std::string::npos) text.erase(mark);
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

bool looks_like_command(const std::string& line) {
  static const std::regex beginning(R"(^(ticktrue|\./dev|cmake|git|build/release/\w+|export|cc|c\+\+|\./\w+) .*)");
  return std::regex_match(line, beginning);
}

/// Replaces placeholders by words that can be parsed.
std::string with_values(std::string text) {
  static const std::pair<std::regex, const char*> rules[] = {
      {std::regex(R"([\[\]])"), ""},
      {std::regex(R"(\.\.\.)"), ""},
      {std::regex(R"((\b|:)A\.\.B\b)"), "$011..2"},
      {std::regex(R"(\bI/N\b)"), "1/2"},
      {std::regex(R"(\b(N|S|I|SEED)\b)"), "1"},
      {std::regex(R"(SCENE\|TRACE)"), "SCENE"},
  };
  for (const auto& [rule, value] : rules) text = std::regex_replace(text, rule, value);
  return text;
}

class Collector {
 public:
  std::vector<PrintedCommand> commands;

  void read_markdown(const std::string& document) {
    document_ = document;
    const std::vector<std::string> lines = lines_of(text_of(tree / document));
    std::size_t part = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!begins_with(lines[i], "```")) {
        read_text(i, lines[i]);
        continue;
      }
      const std::string info = lines[i].substr(3);
      std::size_t end = i + 1;
      while (end < lines.size() && lines[end] != "```") ++end;
      const std::vector<std::string> block(lines.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                           lines.begin() + static_cast<std::ptrdiff_t>(end));
      if (begins_with(info, "text ticktrue "))
        read_help(i + 1, block, ++part);
      else if (info.empty() || info == "sh" || begins_with(info, "text"))
        read_block(i + 1, block, info == "sh");
      else if (info == "yaml")
        read_steps(i + 1, block);
      i = end;
    }
  }

  /// Reads "- run: COMMAND" lines of the workflow whose command is the built tool.
  void read_workflow(const std::string& document) {
    document_ = document;
    read_steps(0, lines_of(text_of(tree / document)));
  }

 private:
  void add(std::size_t index, How how, const std::string& text, std::size_t part = 0) {
    commands.push_back({document_, index + 1, part, text, how, {}});
  }

  /// Reads `ticktrue ...` and `./dev ...` within a text. One or two names alone are the name of a command.
  void read_text(std::size_t index, const std::string& line) {
    static const std::regex span(R"(`((?:ticktrue|\./dev) [^`]*)`)");
    static const std::regex name(R"(ticktrue [a-z]+( (mouse|rube|check|update|verify|report))?)");
    for (std::sregex_iterator it(line.begin(), line.end(), span), end; it != end; ++it) {
      const std::string text = (*it)[1];
      add(index, How::parse, std::regex_match(text, name) ? text + " --help" : with_values(text));
    }
  }

  void read_steps(std::size_t first, const std::vector<std::string>& lines) {
    static const std::regex step(R"( *- run: (?:\S*/bin/)?(ticktrue .*))");
    static const std::regex part_of_matrix(R"(\$\{\{ matrix\.shard \}\})");
    std::smatch found;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (std::regex_match(lines[i], found, step))
        add(first + i, How::run, std::regex_replace(found.str(1), part_of_matrix, "1"));
  }

  void read_block(std::size_t first, const std::vector<std::string>& block, bool is_shell) {
    const bool has_prompt = std::any_of(block.begin(), block.end(), [](const auto& l) { return begins_with(l, "$ "); });
    const bool is_script = !has_prompt && !block.empty() && (is_shell || looks_like_command(block.front()));
    PrintedCommand* current = nullptr;
    for (std::size_t i = 0; i < block.size(); ++i) {
      const std::size_t begin = i;
      std::string line = block[i];
      const bool is_command = has_prompt ? begins_with(line, "$ ") : is_script && !line.empty() && line[0] != '#';
      if (!is_command) {
        if (current != nullptr) current->output.push_back(line);
        if (begins_with(line, "  again   ticktrue ")) {
          const std::string text = line.substr(line.find("ticktrue"));
          add(first + i, How::parse, text.substr(0, text.find(", ")));
          current = nullptr;
        }
        continue;
      }
      while (!line.empty() && line.back() == '\\' && i + 1 < block.size())
        line = line.substr(0, line.size() - 1) + block[++i];
      add(first + begin, How::run, without_comment(has_prompt ? line.substr(2) : line));
      current = &commands.back();
    }
  }

  /// Reads a help text: `ticktrue ...`, and the indented lines below a heading that begin like a command.
  void read_help(std::size_t first, const std::vector<std::string>& block, std::size_t part) {
    bool in_examples = false;
    for (std::size_t i = 0; i < block.size(); ++i) {
      const bool is_indented = begins_with(block[i], "  ");
      in_examples = block[i] == "Examples:" || block[i] == "Example:" || block[i] == "In a window:" ||
                    (in_examples && is_indented);
      if (in_examples && is_indented) add(first + i, How::run, block[i].substr(2), part);
      if (!is_indented && block[i].find('`') != std::string::npos) read_text(first + i, block[i]);
    }
  }

  std::string document_;
};

std::vector<PrintedCommand> printed_commands() {
  Collector collector;
  for (const char* document : {"README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"}) collector.read_markdown(document);
  std::set<std::string> documents;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(tree / "docs"))
    if (entry.path().extension() == ".md") documents.insert(fs::relative(entry.path(), tree).generic_string());
  for (const std::string& document : documents) collector.read_markdown(document);
  for (const char* workflow : {"docs/ci.yml", "docs/ci_engine.yml"}) collector.read_workflow(workflow);
  return std::move(collector.commands);
}

/// One row of the table of exceptions.
struct Exception {
  std::size_t line = 0;
  std::string document;  // "*": any
  std::string what;      // prepare, exit N, output, parse, leave
  std::string command;
  std::string reason;
  bool is_used = false;
};

struct Exceptions {
  std::vector<Exception> rows;
  std::map<std::string, std::size_t> counts;  // stated in the table: number of rows of each kind

  Exception* find(const PrintedCommand& command, const std::string& kind) {
    for (Exception& row : rows)
      if ((row.document == "*" || row.document == command.document) && begins_with(row.what, kind) &&
          (row.command == command.text || (row.command == "*" && command.how == How::run)))
        return &row;
    return nullptr;
  }
};

Exceptions read_exceptions() {
  Exceptions table;
  const std::vector<std::string> lines = lines_of(text_of(tree / "tests/cli/printed_commands.tsv"));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty() || lines[i][0] == '#') continue;
    std::vector<std::string> cells{""};
    for (const char c : lines[i])
      if (c == '\t')
        cells.emplace_back();
      else
        cells.back().push_back(c);
    CAPTURE(i + 1, lines[i]);
    if (cells[0] == "count") {
      REQUIRE(cells.size() == 3);
      table.counts[cells[1]] = std::stoul(cells[2]);
      continue;
    }
    REQUIRE(cells.size() == 4);
    CHECK(cells[3].size() > 5);  // the reason
    table.rows.push_back({i + 1, cells[0], cells[1], cells[2], cells[3], false});
  }
  return table;
}

struct Outcome {
  int exit_code = -1;
  std::string output;  // both streams
};

/// A folder with the tool in bin/, and in parse/ a tool that only parses.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "ticktrue_printed_XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
    for (const char* part : {"bin", "parse", "work", "home"}) fs::create_directory(path_ / part);
    fs::create_symlink(TICKTRUE_TOOL, path_ / "bin/ticktrue");
    std::ofstream(path_ / "parse/ticktrue") << "#!/bin/sh\nexec '" TICKTRUE_TOOL "' --parse-only \"$@\"\n";
    fs::permissions(path_ / "parse/ticktrue", fs::perms::owner_all);
  }
  Folder(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  Outcome run(const std::string& command, How how) const {
    const std::string tools = (path_ / (how == How::parse ? "parse" : "bin")).string();
    const std::string line = "cd '" + (path_ / "work").string() + "' && PATH='" + tools + "':\"$PATH\" HOME='" +
                             (path_ / "home").string() + "' TREE='" + tree.string() +
                             "' && export PATH HOME TREE && unset GITHUB_STEP_SUMMARY DISPLAY WAYLAND_DISPLAY; { " +
                             command + "\n} >'" + (path_ / "out").string() + "' 2>&1 </dev/null";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(path_ / "out")};
  }

 private:
  fs::path path_;
};

/// Replaces the parts of a line that differ between runs or builds.
std::string without_chance(const std::string& line) {
  static const std::pair<std::regex, const char*> rules[] = {
      {std::regex(R"([0-9.e-]+ ms/tick)"), "# ms/tick"},
      {std::regex(R"(ticktrue [0-9.]+ \(.*)"), "ticktrue #"},
  };
  std::string text = line;
  for (const auto& [rule, value] : rules) text = std::regex_replace(text, rule, value);
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

/// The first shown line that the output lacks; absent if the output has all shown lines in order. A line "..." (also
/// indented) stands for any number of lines.
std::optional<std::string> missing_line(const std::vector<std::string>& shown, const std::string& output) {
  const std::vector<std::string> found = lines_of(output);
  std::size_t at = 0;
  bool may_skip = false;
  for (const std::string& raw : shown) {
    const std::string line = without_chance(raw);
    if (line.find_first_not_of(' ') == line.find("...") && line.find("...") != std::string::npos) {
      may_skip = true;
      continue;
    }
    if (line.empty()) continue;
    while (at < found.size() && (may_skip || found[at].empty()) && without_chance(found[at]) != line) ++at;
    if (at == found.size() || without_chance(found[at]) != line) return raw;
    ++at;
    may_skip = false;
  }
  return std::nullopt;
}

/// Checks `./dev COMMAND --options`: `./dev help` must contain each word.
void check_dev(const PrintedCommand& command, const std::string& help) {
  std::istringstream words(command.text);
  std::string word;
  words >> word;
  bool is_first = true;
  while (words >> word && word != "#" && word != "&&") {
    if (is_first || begins_with(word, "--")) {
      CAPTURE(command.place(), command.text, word);
      CHECK(std::regex_search(help, std::regex((is_first ? "\n  " : "") + word + "\\b")));
    }
    is_first = false;
  }
}

/// Lines of a document below a command, and their replacement.
struct Replacement {
  std::size_t first = 0;  // counted from 0
  std::size_t count = 0;
  std::vector<std::string> lines;
};
using Replacements = std::map<std::string, std::vector<Replacement>>;  // by document, from the top

void write_anew(const Replacements& replacements) {
  for (const auto& [document, list] : replacements) {
    std::vector<std::string> lines = lines_of(text_of(tree / document));
    for (auto change = list.rbegin(); change != list.rend(); ++change) {
      const auto at = lines.begin() + static_cast<std::ptrdiff_t>(change->first);
      const auto next = lines.erase(at, at + static_cast<std::ptrdiff_t>(change->count));
      lines.insert(next, change->lines.begin(), change->lines.end());
    }
    std::ofstream out(tree / document, std::ios::binary);
    for (const std::string& line : lines) out << line << "\n";
  }
}

void run_command(const PrintedCommand& command, const Folder& folder, Exceptions& exceptions,
                 Replacements& replacements) {
  How how = command.how;
  int expected_exit = 0;
  if (Exception* row = exceptions.find(command, "exit ")) {
    row->is_used = true;
    expected_exit = std::stoi(row->what.substr(5));
  }
  if (Exception* row = exceptions.find(command, "parse")) {
    row->is_used = true;
    how = How::parse;
  }
  if (how != How::parse && contains(command.text, "box2d3") && !has_box2d3()) {
    WARN("skipped, Box2D 3 is not installed: " << command.text);
    return;
  }
  const Outcome outcome = folder.run(command.text, how);
  INFO(command.place() << ": " << command.text << "\n" << outcome.output);
  CHECK(outcome.exit_code == expected_exit);
  if (how == How::parse || command.output.empty()) return;
  if (Exception* row = exceptions.find(command, "output")) {
    row->is_used = true;
    return;
  }
  const std::optional<std::string> missing = missing_line(command.output, outcome.output);
  const bool is_whole = std::none_of(command.output.begin(), command.output.end(),
                                     [](const std::string& line) { return contains(line, "..."); });
  if (missing && is_whole && std::getenv("TICKTRUE_UPDATE_DOCS") != nullptr) {
    replacements[command.document].push_back({command.line, command.output.size(), lines_of(outcome.output)});
    return;
  }
  INFO("not printed in its place: " << missing.value_or(""));
  CHECK_FALSE(missing);
}

}  // namespace

TEST_CASE("every command that a document prints does what the document says", "[cli][docs][printed][equivalence]") {
  const std::vector<PrintedCommand> commands = printed_commands();
  Exceptions exceptions = read_exceptions();
  const std::string dev_help = text_of(tree / "dev");
  std::map<std::pair<std::string, std::size_t>, Folder> folders;
  Replacements replacements;
  std::size_t run_count = 0;
  for (const PrintedCommand& command : commands) {
    if (begins_with(command.text, "./dev ")) {
      check_dev(command, dev_help);
      continue;
    }
    if (Exception* row = exceptions.find(command, "leave")) {
      row->is_used = true;
      continue;
    }
    const bool is_new = folders.count({command.document, command.part}) == 0;
    const Folder& folder = folders[{command.document, command.part}];
    for (Exception& row : exceptions.rows) {
      if (!is_new || command.part != 0 || row.what != "prepare" || row.document != command.document) continue;
      const Outcome prepared = folder.run(row.command, How::run);
      INFO(row.document << ": " << row.command << "\n" << prepared.output);
      CHECK(prepared.exit_code == 0);
      row.is_used = true;
    }
    run_command(command, folder, exceptions, replacements);
    ++run_count;
  }
  write_anew(replacements);
  CHECK(run_count >= 150);
  std::map<std::string, std::size_t> counts;
  for (const Exception& row : exceptions.rows) {
    INFO("printed_commands.tsv:" << row.line << ": no document prints this: " << row.command);
    CHECK(row.is_used);
    ++counts[row.what.substr(0, row.what.find(' '))];
  }
  // A new row must also change the count.
  CHECK(counts == exceptions.counts);
}

TEST_CASE("the search for printed commands finds each way in which they are printed",
          "[cli][docs][printed][analytic]") {
  const std::vector<PrintedCommand> commands = printed_commands();
  const auto is_there = [&](const std::string& document, const std::string& text, How how) {
    return std::any_of(commands.begin(), commands.end(), [&](const PrintedCommand& command) {
      return command.document == document && command.text == text && command.how == how;
    });
  };
  CHECK(is_there("README.md", "./mygame --verify game.ttr", How::run));
  CHECK(is_there("README.md", "ticktrue reduce F.ttr", How::parse));
  CHECK(is_there("docs/ci_engine.yml", "ticktrue golden check traces --plugin ./engine.so", How::run));
  CHECK(is_there("docs/cli.md", "ticktrue env --check --json", How::run));
  CHECK(is_there("docs/scale.md", "ticktrue verify traces -j 2", How::run));
  CHECK(missing_line({"a 1", "...", "c"}, "a 1\nb\nc\n") == std::nullopt);
  CHECK(missing_line({"a 1", "c"}, "a 1\nb\nc\n") == std::optional<std::string>("c"));
  CHECK(missing_line({"time 0.5 ms/tick"}, "time 0.25 ms/tick\n") == std::nullopt);
}

}  // namespace ticktrue::test::printed
