// Documents keep the rules of the tree: links, named files, the length of sentences, the list in README.md.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "tests/support/catch.h"
#include "tests/support/source_tree.h"

namespace {

using namespace ticktrue::source_tree;
namespace fs = std::filesystem;

/// Targets of [text](target) in a Markdown text. Code blocks are skipped.
std::vector<std::string> links_of(std::string_view markdown) {
  std::vector<std::string> links;
  bool in_block = false;
  for (const std::string& line : lines_of(markdown)) {
    if (starts_with(line, "```")) in_block = !in_block;
    if (in_block) continue;
    for (std::size_t at = line.find("]("); at != std::string::npos; at = line.find("](", at + 1)) {
      const std::size_t end = line.find(')', at);
      if (end != std::string::npos) links.push_back(line.substr(at + 2, end - at - 2));
    }
  }
  return links;
}

TEST_CASE("every link between documents leads to a file", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  std::vector<SourceFile> documents = files_below(root, "docs", {".md"});
  for (const char* name : {"README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"})
    if (fs::exists(root / name)) documents.push_back({name, read_text(root / name)});
  REQUIRE(documents.size() >= 5);
  for (const SourceFile& document : documents)
    for (const std::string& link : links_of(document.text)) {
      if (contains(link, "://") || starts_with(link, "#") || starts_with(link, "mailto:")) continue;
      const std::string target = link.substr(0, link.find('#'));
      if (!fs::exists((root / document.path).parent_path() / target))
        FAIL_CHECK(document.path << ": error: the link " << link << " leads to no file");
    }
}

/// Paths in backticks that look like files of this tree, because their folder exists.
std::vector<std::string> paths_of(std::string_view markdown) {
  std::vector<std::string> paths;
  for (std::size_t open = markdown.find('`'); open != std::string_view::npos;) {
    const std::size_t close = markdown.find('`', open + 1);
    if (close == std::string_view::npos) break;
    const std::string_view name = markdown.substr(open + 1, close - open - 1);
    const bool is_path =
        contains(name, "/") && name.find_first_of(" <>*{}()=?:\n") == std::string_view::npos &&
        is_one_of(
            top_of(name),
            "include,base,engine,replay,verifier,tool,capi,shim,examples,tests,bench,traces,scenes,docs,cmake,.ci");
    if (is_path) paths.emplace_back(name);
    open = markdown.find('`', close + 1);
  }
  return paths;
}

/// Whether a path names a decision by its number alone, such as docs/decisions/0014.
bool is_short_name_of_a_decision(const std::string& path) {
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(TICKTRUE_SOURCE_DIR) / "docs/decisions"))
    if (starts_with("docs/decisions/" + entry.path().filename().string(), path + "-")) return true;
  return false;
}

TEST_CASE("every file that a document of the whole tree names is there", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  // Decisions and measurements tell of the tree as it was.
  std::vector<fs::path> documents{"ARCHITECTURE.md", "CONTRIBUTING.md", "README.md"};
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") documents.push_back(fs::path("docs") / entry.path().filename());
  CHECK(documents.size() >= 20);
  std::size_t count = 0;
  for (const fs::path& document : documents) {
    const std::vector<std::string> paths = paths_of(read_text(root / document));
    count += paths.size();
    for (const std::string& path : paths)
      if (!fs::exists(root / path) && !is_short_name_of_a_decision(path))
        FAIL_CHECK(document.string() << ": error: names " << path << ", which is not there");
  }
  CHECK(count >= 200);
}

/// The words of a Markdown line. A code span counts as one word, the target of a link as none.
std::string words_of(std::string_view line) {
  std::string text;
  std::size_t at = 0;
  while (at < line.size()) {
    std::size_t end = at;
    if (line[at] == '`') {
      text += "code";
      end = line.find('`', at + 1);
    } else if (starts_with(line.substr(at), "](")) {
      end = line.find(')', at);
    } else {
      text += line[at];
    }
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  return text;
}

constexpr int words_max = 25;

/// Sentences of more than words_max words, outside of code blocks. A list item and a table cell end a sentence.
std::vector<std::string> long_sentences_of(std::string_view markdown) {
  std::vector<std::string> found;
  std::string sentence;
  int count = 0;
  const auto end_sentence = [&] {
    if (count > words_max) found.push_back(sentence);
    sentence.clear();
    count = 0;
  };
  bool in_block = false;
  for (const std::string& line : lines_of(markdown)) {
    const std::string_view mark = std::string_view(line).substr(std::min(line.find_first_not_of(' '), line.size()));
    const bool is_fence = starts_with(mark, "```");
    const bool is_row = starts_with(mark, "|");
    if (is_fence) in_block = !in_block;
    if (mark.empty() || is_fence || is_row || starts_with(mark, "- ") || starts_with(mark, "#")) end_sentence();
    if (is_fence || in_block) continue;
    std::istringstream words(words_of(mark));
    for (std::string word; words >> word;) {
      if (is_row && word == "|") end_sentence();
      if (std::none_of(word.begin(), word.end(), is_word)) continue;
      sentence += (sentence.empty() ? "" : " ") + word;
      ++count;
      const std::size_t last = word.find_last_not_of("\"*)");
      if (last != std::string::npos && std::string_view(".;?!").find(word[last]) != std::string_view::npos)
        end_sentence();
    }
  }
  end_sentence();
  return found;
}

TEST_CASE("documents that are kept plain have sentences of at most 25 words", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  std::vector<SourceFile> documents = files_below(root, "docs/measurements", {".md"});
  for (const char* name : {"README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs/determinism.md", "docs/glossary.md",
                           "docs/decisions/README.md"})
    documents.push_back({name, read_text(root / name)});
  for (const SourceFile& document : documents) {
    CHECK_FALSE(document.text.empty());
    for (const std::string& sentence : long_sentences_of(document.text))
      FAIL_CHECK(document.path << ": error: more than " << words_max << " words, make two sentences: " << sentence);
  }
}

TEST_CASE("a landed decision is not edited", "[tidy][docs]") {
  const fs::path folder = fs::path(TICKTRUE_SOURCE_DIR) / "docs/decisions";
  const std::vector<std::string> rows = lines_of(read_text(folder / "records.tsv"));
  REQUIRE_FALSE(rows.empty());
  for (const SourceFile& record : files_below(TICKTRUE_SOURCE_DIR, "docs/decisions", {".md"})) {
    const fs::path path(record.path);
    if (path.parent_path().generic_string() != "docs/decisions" || path.filename() == "README.md") continue;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(record.text.data());
    const std::string row =
        path.filename().string() + "\t" + ticktrue::hex64(ticktrue::hash64({bytes, record.text.size()}));
    INFO("A record has another hash than docs/decisions/records.tsv: write a new record. The row of a new one:\n"
         << row);
    CHECK(std::count(rows.begin(), rows.end(), row) == 1);
  }
}

TEST_CASE("README.md leads to every document, and the glossary has at most 15 words", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  const std::vector<std::string> links = links_of(read_text(root / "README.md"));
  for (const SourceFile& document : files_below(root, "docs", {".md"})) {
    const std::string folder = fs::path(document.path).parent_path().generic_string();
    if (folder != "docs" && fs::path(document.path).filename() != "README.md") continue;
    CAPTURE(document.path);
    CHECK(std::count(links.begin(), links.end(), document.path) >= 1);
  }
  int count = 0;
  for (const std::string& line : lines_of(read_text(root / "docs/glossary.md"))) count += starts_with(line, "| **");
  CHECK(count > 0);
  CHECK(count <= 15);
}

TEST_CASE("every step of the ways in ARCHITECTURE.md is there", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  int count = 0;
  for (const std::string& line : lines_of(read_text(root / "ARCHITECTURE.md"))) {
    const std::size_t middle = line.find("`: `");
    if (!starts_with(line, "- `") || middle == std::string::npos || line.back() != '`') continue;
    const std::string path = line.substr(3, middle - 3), name = line.substr(middle + 4, line.size() - middle - 5);
    CAPTURE(path, name);
    bool found = false;
    for (const std::string& code : lines_of(code_of(read_text(root / path)))) found = found || uses(code, name, false);
    CHECK(found);
    ++count;
  }
  CHECK(count >= 15);
}

// --- the rules fire -------------------------------------------------------------------------------------------------

TEST_CASE("links are found outside code blocks", "[tidy][self]") {
  CHECK(links_of("see [a](b.md) and [c](d.md#e)\n```\n[x](y)\n```\n") == std::vector<std::string>{"b.md", "d.md#e"});
}

TEST_CASE("a sentence of 26 words fires, one of 25 does not", "[tidy][self]") {
  std::string words;
  for (int i = 1; i < words_max; ++i) words += "word ";
  CHECK(long_sentences_of(words + "end.").empty());
  CHECK(long_sentences_of(words + "`one code span`.").empty());
  CHECK(long_sentences_of(words + "[end](a/b c.md).").empty());
  CHECK(long_sentences_of(words + "end.\n" + words + "end.").empty());
  CHECK(long_sentences_of("- " + words + "\n- " + words).empty());
  CHECK(long_sentences_of("| " + words + " | " + words + " |").empty());
  CHECK(long_sentences_of("```\n" + words + words + "\n```\n").empty());
  CHECK(long_sentences_of(words + "\nnext end.").size() == 1);
  CHECK(long_sentences_of("| short | " + words + "next end. |").size() == 1);
  CHECK(long_sentences_of("(" + words + "next end.) Short.").size() == 1);
}

}  // namespace
