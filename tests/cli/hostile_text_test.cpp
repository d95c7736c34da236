// Control bytes and workflow commands in a scene, a trace and a file name pass through every command that shows them.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "base/plain_text.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/scene_json.h"
#include "tests/damage/forger.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

// Without a slash, because the text is also part of a file name. The last byte is not UTF-8.
const std::string hostile =
    "\x1b[31m\n::error::x\r  ##[error]y\x07\x7f\xc2\x9b"
    "2J\xe2\x80\xae\n::warning::z<script>&#10;\xff";
// A text that a scene accepts, because scenes refuse C0 characters.
const std::string hostile_name =
    "::error::x ##[error]y\xc2\x9b"
    "2J\xe2\x80\xae</script>";

std::string file_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The output of both streams of the tool.
std::string output_of(std::vector<std::string> words, const TemporaryFolder& folder) {
  const std::string messages = folder.file("messages");
  words.insert(words.begin(), TICKTRUE_TOOL);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const int out = ::open(messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ::dup2(out, 1);
    ::dup2(out, 2);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) <= 6);
  return file_text(messages);
}

/// The first line of `text` that could control a terminal or a runner; empty if none can.
std::string first_fault(const std::string& text, bool has_annotations) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::string escaped_controls = line;
    // plain_text is idempotent: a second call changes nothing.
    if (has_annotations && (line.rfind("::error file=", 0) == 0 || line.rfind("::warning file=", 0) == 0)) continue;
    if (plain_text(escaped_controls) != line) return line;
  }
  return "";
}

/// A scene with the text as its name and as the name of every body.
std::string hostile_scene(const std::string& text) {
  Result<engine::Scene> scene = engine::make_builtin_scene("stack?boxes=2");
  REQUIRE(scene);
  scene->name = text;
  for (engine::Body& body : scene->bodies) body.name = text;
  return engine::print_scene(*scene);
}

TEST_CASE("nothing of a scene, a trace or a file name steers what shows it, in any command",
          "[cli][hostile_text][corruption]") {
  const TemporaryFolder folder;
  const std::string scene = folder.file("x" + hostile + ".json");
  std::ofstream(scene, std::ios::binary) << hostile_scene(hostile_name);
  const std::string refused = folder.file("refused" + hostile + ".json");
  std::ofstream(refused, std::ios::binary) << hostile_scene("\x1b[2J\n::error::x");
  const std::string trace = folder.file(hostile + ".ttr");
  const std::string page = folder.file("page.html"), saved = folder.file("saved");
  std::vector<std::vector<std::string>> runs{
      {"record", scene, "--ticks", "20", "--detail", "full", "-o", trace, "--force"},
      {"record", scene, "--ticks", "20", "-o", trace},
      {"run", refused, "--ticks", "5"},
      {"run", scene, "--ticks", "5"},
      {"run", scene, "--ticks", "5", "--json"},
      {"describe", scene},
      {"describe", scene, "--json"},
      {"scenes", scene, "--print"},
      {"scenes", hostile},
      {"verify", scene, "--mode", "twice", "--ticks", "5"},
      {"verify", folder.file("absent" + hostile)},
      {"verify", trace, "--mode", hostile},
      {"inject", trace, "--count", "1", "--seed", "1"},
      {"inject", trace, "--count", "1", "--seed", "1", "--json"},
      {hostile}};
  std::vector<std::string> traces{trace};
  const damage::Recording recording = damage::read_recording(TICKTRUE_SOURCE_DIR "/traces/stack_full_f32.ttr");
  for (const damage::Recipe& recipe : damage::recipes())
    for (std::uint64_t seed = 1; recipe.name == "texts" && seed <= 4; ++seed) {
      traces.push_back(folder.file("forged" + std::to_string(seed) + hostile + ".ttr"));
      write_file(traces.back(), recipe.forge(recording, seed));
    }
  for (const std::string& file : traces)
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"verify", file},
                                               {"verify", file, "--json"},
                                               {"verify", file, "--github", "--junit", saved + ".xml"},
                                               {"show", file},
                                               {"show", file, "--json"},
                                               {"show", file, "--ticks", "0..3"},
                                               {"show", file, "--inputs"},
                                               {"replay", file},
                                               {"replay", file, "--format", "jsonl"},
                                               {"replay", file, "--format", "jsonl", "-o", saved + ".jsonl", "--force"},
                                               {"diff", file, TICKTRUE_SOURCE_DIR "/traces/stack_full_f32.ttr"},
                                               {"diff", trace, file, "--json"},
                                               {"recover", file, "-o", saved + ".ttr", "--force"},
                                               {"report", file, "-o", page, "--force"}})
      runs.push_back(words);
  for (const std::vector<std::string>& words : runs) {
    CAPTURE(words);
    const std::string text = output_of(words, folder);
    CHECK(first_fault(text, words.size() > 2 && words[2] == "--github") == "");
    for (const char* end : {".xml", ".jsonl"}) CHECK(first_fault(file_text(saved + end), false) == "");
  }
  // The style sheet of the page has lines that begin with `::`.
  const std::string html = file_text(page);
  REQUIRE(!html.empty());
  CHECK(std::none_of(html.begin(), html.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
  }));
  CHECK(!contains(html, "##["));
  CHECK(!contains(html, "\xe2\x80\xae"));
  CHECK(!contains(html, "\xc2\x9b"));
}

}  // namespace
}  // namespace ticktrue::test
