// Every source names only what it includes: it compiles alone, not only beside others in a unity build.
// SPDX-License-Identifier: MIT
//
// Verified: each type of the project that a file uses is declared in the file or in what it includes, directly or not.
// Not verified: functions, constants, types of the standard library.
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/source_tree.h"

namespace {

using namespace ticktrue::source_tree;

using Names = std::set<std::string>;

struct Source {
  Names includes;
  Names uses;
  Names declares;    // and names of parameters of templates
  Names introduces;  // of `declares`, what others may take from here: definitions of types
};

std::size_t skip_spaces(const std::string& code, std::size_t at) {
  while (at < code.size() && (code[at] == ' ' || code[at] == '\n')) ++at;
  return at;
}

/// Words of the code in order. A type is a word of several letters that begins with a capital.
Source read_source(const SourceFile& file) {
  const std::string code = code_of(file.text);
  const bool in_header = is_header(file.path);
  Source source;
  source.includes = includes_of(file.text);
  std::string before;  // the word before
  for (std::size_t at = 0; at < code.size();) {
    if (!is_word(code[at])) {
      ++at;
      continue;
    }
    const std::size_t begin = at;
    while (at < code.size() && is_word(code[at])) ++at;
    const std::string word = code.substr(begin, at - begin);
    const char mark = begin > 0 ? code[begin - 1] : ' ';
    const bool is_type = word.size() > 1 && word[0] >= 'A' && word[0] <= 'Z';
    if (is_type && mark != '.' && mark != '>' && mark != ':') source.uses.insert(word);
    const bool is_named =
        before == "class" || before == "struct" || before == "enum" || before == "using" || before == "typename";
    if (is_type && is_named) {
      source.declares.insert(word);
      std::size_t next = skip_spaces(code, at);
      if (code.compare(next, 5, "final") == 0) next = skip_spaces(code, next + 5);
      const bool is_definition = next < code.size() && (code[next] == '{' || code[next] == ':' || code[next] == '=');
      if (in_header && is_definition && before != "typename") source.introduces.insert(word);
    }
    before = word;
  }
  return source;
}

using Sources = std::map<std::string, Source>;

Sources read_sources(const std::vector<SourceFile>& files) {
  Sources sources;
  for (const SourceFile& file : files) sources[file.path] = read_source(file);
  return sources;
}

void add_included(const Sources& sources, const std::string& path, Names& reached) {
  if (!reached.insert(path).second) return;
  const auto source = sources.find(path);
  if (source == sources.end()) return;
  for (const std::string& next : source->second.includes) add_included(sources, next, reached);
}

/// "path uses Name of header" for each name that no included file declares.
std::vector<std::string> missing_includes(const Sources& sources) {
  std::map<std::string, std::string> header_of;
  for (const auto& [path, source] : sources)
    for (const std::string& name : source.introduces) header_of[name] = path;
  std::vector<std::string> missing;
  for (const auto& [path, source] : sources) {
    Names reached;
    add_included(sources, path, reached);
    Names known;
    for (const std::string& other : reached)
      if (const auto found = sources.find(other); found != sources.end())
        known.insert(found->second.declares.begin(), found->second.declares.end());
    for (const std::string& name : source.uses)
      if (header_of.count(name) > 0 && known.count(name) == 0)
        missing.push_back(path + " uses " + name + " of " + header_of[name]);
  }
  return missing;
}

TEST_CASE("every source includes the types that it uses", "[tidy]") {
  std::vector<SourceFile> files;
  for (SourceFile& file : source_tree())
    if (top_of(file.path) != "tests" && top_of(file.path) != "bench") files.push_back(std::move(file));
  REQUIRE(files.size() > 400);
  for (const std::string& what : missing_includes(read_sources(files)))
    FAIL_CHECK(what << ": error: include that header, a build file by file fails");
}

TEST_CASE("a type that is used and not included fires", "[tidy][self]") {
  const SourceFile colour{"a/colour.h", "struct Colour {};\nenum class Kind : int { x };\nusing Rows = int;\n"};
  const SourceFile between{"a/between.h", "#include \"a/colour.h\"\n"};
  const auto missing = [&](const std::string& code) {
    return missing_includes(read_sources({colour, between, {"a/user.cpp", code}}));
  };
  CHECK(missing("Colour c;") == std::vector<std::string>{"a/user.cpp uses Colour of a/colour.h"});
  CHECK(missing("void f(Kind, Rows);").size() == 2);
  CHECK(missing("#include \"a/colour.h\"\nColour c; Kind k; Rows r;").empty());
  CHECK(missing("#include \"a/between.h\"\nColour c;").empty());
  CHECK(missing("struct Colour;\nColour* c;").empty());
  CHECK(missing("template <typename Rows> void f(Rows);").empty());
  CHECK(missing("// Colour\nconst char* text = \"Colour\"; other::Colour c; x.Rows;").empty());
}

}  // namespace
