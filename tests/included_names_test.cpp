// Every source only names what it includes, so that it compiles alone and not only in a unity build.
// SPDX-License-Identifier: MIT
//
// Verified: each type of the project that a file uses is declared in the file or in a file that it includes, directly
// or indirectly. For a common name of the standard library, a header that declares the name is included.
// Not verified: functions and constants of the project. tests/each_file.py compiles each file alone.
#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/source_tree.h"

namespace {

using namespace ticktrue::source_tree;

using Names = std::set<std::string>;

struct Source {
  Names includes;
  Names uses;
  Names declares;    // declared names, and names of template parameters
  Names introduces;  // type definitions among `declares`, which other files may use
  Names standard;    // std::NAME
  Names headers;     // <NAME>
};

std::size_t skip_spaces(const std::string& code, std::size_t at) {
  while (at < code.size() && (code[at] == ' ' || code[at] == '\n')) ++at;
  return at;
}

struct StandardHeader {
  std::string_view name;
  std::string_view names;   // names in std that the header declares
  std::string_view brings;  // headers that every library includes with it
};
constexpr StandardHeader standard_headers[] = {
    {"algorithm",
     "sort stable_sort min max minmax clamp find find_if any_of all_of none_of count count_if copy fill reverse equal "
     "max_element min_element lower_bound upper_bound binary_search remove_if transform nth_element mismatch",
     "iterator utility"},
    {"array", "array", "cstddef iterator utility"},
    {"atomic", "atomic", ""},
    {"charconv", "to_chars from_chars", "system_error"},
    {"chrono", "chrono", "ctime limits string"},
    {"cmath", "sqrt fabs hypot isfinite isnan sin cos atan2 pow log exp round lround ceil floor nextafter signbit", ""},
    {"condition_variable", "condition_variable", "chrono mutex"},
    {"csignal", "signal raise sig_atomic_t", ""},
    {"cstddef", "size_t ptrdiff_t byte", ""},
    {"cstdint", "uint8_t uint16_t uint32_t uint64_t int8_t int16_t int32_t int64_t uintptr_t uintmax_t", ""},
    {"cstdio", "printf fprintf snprintf FILE fopen fclose fputs fwrite fflush fread", ""},
    {"cstdlib", "getenv abort exit strtol strtoull strtoul strtod malloc free system atexit realloc calloc", ""},
    {"cstring", "memcpy memcmp memset memmove memchr strlen strcmp strerror strchr", ""},
    {"deque", "deque", "iterator"},
    {"filesystem", "filesystem", "chrono cstdint iterator memory string string_view system_error utility"},
    {"fstream", "ifstream ofstream fstream", "string system_error"},
    {"functional", "function invoke less greater", "tuple utility"},
    {"iterator", "back_inserter istreambuf_iterator make_move_iterator distance next prev", "cstddef"},
    {"limits", "numeric_limits", ""},
    {"map", "map multimap", "iterator tuple utility"},
    {"memory", "unique_ptr make_unique shared_ptr make_shared", "cstddef new tuple utility"},
    {"mutex", "mutex lock_guard unique_lock scoped_lock call_once once_flag", "chrono system_error"},
    {"new", "bad_alloc nothrow", ""},
    {"numeric", "accumulate iota gcd", ""},
    {"optional", "optional nullopt", "utility"},
    {"set", "set multiset", "iterator utility"},
    {"span", "span", "array cstddef"},
    {"sstream", "ostringstream istringstream stringstream", "string"},
    {"string", "string to_string stoi stol stoul stoull stod getline", "cstddef cstdio cstdint iterator string_view"},
    {"string_view", "string_view", "cstddef iterator"},
    {"system_error", "error_code errc", "string"},
    {"thread", "thread this_thread", "chrono"},
    {"tuple", "tuple tie", "utility"},
    {"utility", "pair move exchange swap forward make_pair", ""},
    {"variant", "variant monostate holds_alternative get_if visit", "utility"},
    {"vector", "vector", "cstddef iterator"},
};

Names words_of(std::string_view text) {
  std::istringstream in{std::string(text)};
  return {std::istream_iterator<std::string>(in), {}};
}

/// Reads the words of the code in order. A word of several letters that begins with a capital is a type.
Source read_source(const SourceFile& file) {
  const std::string code = code_of(file.text);
  const bool in_header = is_header(file.path);
  Source source;
  source.includes = includes_of(file.text);
  std::string before;  // the previous word
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
    if (before == "std" && mark == ':') source.standard.insert(word);
    if (before == "include" && mark == '<' && at < code.size() && code[at] == '>') source.headers.insert(word);
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

/// The headers of the standard library that these files include, and the headers that come with them.
Names standard_reached(const Sources& sources, const Names& files) {
  Names reached;
  for (const std::string& file : files)
    if (const auto source = sources.find(file); source != sources.end())
      reached.insert(source->second.headers.begin(), source->second.headers.end());
  for (std::size_t size = 0; size != reached.size();) {
    size = reached.size();
    for (const StandardHeader& header : standard_headers)
      if (reached.count(std::string(header.name)) > 0) reached.merge(words_of(header.brings));
  }
  return reached;
}

/// "path uses std::name of <header>".
std::vector<std::string> missing_standard(const Sources& sources) {
  std::map<std::string, std::string> header_of;
  for (const StandardHeader& header : standard_headers)
    for (const std::string& name : words_of(header.names)) header_of[name] = header.name;
  std::vector<std::string> missing;
  for (const auto& [path, source] : sources) {
    Names files;
    add_included(sources, path, files);
    const Names reached = standard_reached(sources, files);
    for (const std::string& name : source.standard)
      if (const auto header = header_of.find(name); header != header_of.end() && reached.count(header->second) == 0)
        missing.push_back(path + " uses std::" + name + " of <" + header->second + ">");
  }
  return missing;
}

std::vector<SourceFile> product_files() {
  std::vector<SourceFile> files;
  for (SourceFile& file : source_tree())
    if (top_of(file.path) != "tests" && top_of(file.path) != "bench") files.push_back(std::move(file));
  REQUIRE(files.size() > 400);
  return files;
}

TEST_CASE("every source includes the types that it uses", "[tidy]") {
  for (const std::string& what : missing_includes(read_sources(product_files())))
    FAIL_CHECK(what << ": error: include that header, a build file by file fails");
}

TEST_CASE("every source includes the headers of the standard library that it uses", "[tidy]") {
  for (const std::string& what : missing_standard(read_sources(product_files())))
    FAIL_CHECK(what << ": error: include that header, a build file by file may fail");
}

TEST_CASE("a standard name whose header is not included fires", "[tidy][self]") {
  const SourceFile header{"a/names.h", "#include <map>\n"};
  const auto missing = [&](const std::string& code) {
    return missing_standard(read_sources({header, {"a/user.cpp", code}}));
  };
  CHECK(missing("std::vector<int> v;") == std::vector<std::string>{"a/user.cpp uses std::vector of <vector>"});
  CHECK(missing("#include <vector>\nstd::vector<int> v;").empty());
  CHECK(missing("#include \"a/names.h\"\nstd::map<int, std::pair<int, int>> m;").empty());
  CHECK(missing("#include \"a/names.h\"\nstd::map<int, std::string> m;").size() == 1);
  CHECK(missing("// std::map\nconst char* text = \"std::map\"; other::map m; std::unknown u;").empty());
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
