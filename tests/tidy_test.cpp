// The source tree obeys its own rules: what is banned where, and what to use instead.
// SPDX-License-Identifier: MIT
//
// Verified: banned names and headers, direction of includes, first lines, marks without an issue, files outside of any
// build list.
// Not verified: rules that need a parser (aliases, macros that hide a banned name, side effects in call arguments).
// clang-tidy and the golden traces cover those rules.
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/source_tree.h"
#include "tests/tidy_rules.h"

namespace {

using namespace ticktrue::source_tree;
using namespace ticktrue::tidy;
namespace fs = std::filesystem;

// --- checking one file ----------------------------------------------------------------------------------------------

using Findings = std::vector<std::string>;

void report(Findings& findings, const SourceFile& file, std::size_t line, std::string_view what, std::string_view use) {
  findings.push_back(file.path + ":" + std::to_string(line) + ": error: " + std::string(what) + " is banned, use " +
                     std::string(use));
}

void check_first_lines(const SourceFile& file, const std::vector<std::string>& lines, Findings& findings) {
  if (lines.empty() || !starts_with(lines[0], "// ") || lines[0].size() < 15)
    report(findings, file, 1, "a first line without a comment", "// and one sentence of what the file is for");
  bool has_license = false;
  for (std::size_t i = 0; i < lines.size() && i < 6; ++i) has_license |= lines[i] == "// SPDX-License-Identifier: MIT";
  if (!has_license) report(findings, file, 2, "a file without a licence", "// SPDX-License-Identifier: MIT");
  if (is_header(file.path) && !contains(file.text, "#pragma once"))
    report(findings, file, 1, "a header without a guard", "#pragma once");
}

void check_names(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  for (const Ban& ban : bans)
    if ((ban.where.empty() || is_under(file.path, ban.where)) && !is_under(file.path, ban.allowed_in) &&
        uses(line, ban.name, ban.call))
      report(findings, file, number, ban.name, ban.use);
  if (starts_with(file.path, "engine/"))
    for (const std::string_view name : libm)
      for (const std::string_view prefix : {"", "__builtin_"})
        for (const std::string_view suffix : {"", "f", "l"}) {
          const std::string whole = std::string(prefix) + std::string(name) + std::string(suffix);
          if (uses(line, whole, true)) report(findings, file, number, whole, own_functions);
        }
  if (is_header(file.path) && uses(line, "using namespace", false))
    report(findings, file, number, "using namespace in a header", "the qualified name");
}

/// The namespaces of the rooms: a file of such a room opens no other, and no other file opens it.
void check_namespace(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  constexpr std::string_view begin = "namespace ticktrue";
  if (!starts_with(line, begin) || !contains(line, "{")) return;
  for (const RoomNamespace& room : room_namespaces) {
    const std::string_view opened = line.substr(std::string_view("namespace ").size());
    const bool opens =
        starts_with(opened, room.name) && (opened[room.name.size()] == ' ' || opened[room.name.size()] == ':');
    if (opens != starts_with(file.path, room.folder))
      report(findings, file, number, "the namespace in \"" + std::string(line) + "\"",
             "that of the room (room_namespaces in tests/tidy_rules.h)");
  }
}

/// Containers ordered by address: map<X*, ..>, set<X*>, less<X*>.
void check_pointer_keys(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  for (const std::string_view container : {"map<", "set<", "less<", "greater<"})
    for (std::size_t at = line.find(container); at != std::string_view::npos; at = line.find(container, at + 1)) {
      std::size_t end = at + container.size();
      for (int depth = 0; end < line.size(); ++end) {
        if (line[end] == '<') ++depth;
        if (line[end] == '>' && depth-- == 0) break;
        if (line[end] == ',' && depth == 0) break;
      }
      while (end > at && (line[end - 1] == ' ')) --end;
      if (end > at && line[end - 1] == '*') report(findings, file, number, "a pointer as a key", id_order);
    }
}

void check_include(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  const std::size_t open = line.find_first_of("<\"", 8);
  if (open == std::string_view::npos) return;
  const std::size_t close = line.find_first_of(">\"", open + 1);
  if (close == std::string_view::npos) return;
  const std::string_view name = line.substr(open + 1, close - open - 1);
  for (const HeaderBan& ban : header_bans) {
    const bool hit = ends_with(ban.header, "/") ? starts_with(name, ban.header) : name == ban.header;
    if (hit && (ban.where.empty() || is_under(file.path, ban.where)) && !is_under(file.path, ban.allowed_in))
      report(findings, file, number, "#include <" + std::string(name) + ">", ban.use);
  }
  if (line[open] == '<') return;
  if (!contains(name, "/") || starts_with(name, ".")) {
    report(findings, file, number, "the include path \"" + std::string(name) + "\"", "the path from the root");
    return;
  }
  const std::string_view from = folder_of(file.path), to = folder_of(name);
  if (starts_with(from, "tests") || from == to) return;
  if (!may_include(from, to))
    report(findings, file, number, std::string(from) + "/ that includes " + std::string(to) + "/",
           "what it may see (rooms in tests/tidy_rules.h)");
}

void check_marks(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  for (const std::string_view mark : {"FIX"
                                      "ME",
                                      "TO"
                                      "DO",
                                      "XX"
                                      "X",
                                      "HA"
                                      "CK"}) {
    if (!uses(line, mark, false)) continue;
    const std::size_t hash = line.find('#');
    const bool has_issue =
        hash != std::string_view::npos && hash + 1 < line.size() && line[hash + 1] >= '0' && line[hash + 1] <= '9';
    if (!has_issue) report(findings, file, number, std::string(mark) + " without an issue", "an issue, as #12");
  }
}

void check_compiler_words(const SourceFile& file, std::string_view line, std::size_t number, Findings& findings) {
  if (!is_under(file.path, library_sources) || is_under(file.path, compiler_words_in)) return;
  for (const std::string_view word : compiler_words)
    if (contains(line, word)) report(findings, file, number, word, "base/compiler/compiler.h (MSVC has other words)");
}

Findings check_file(const SourceFile& file) {
  Findings findings;
  const std::vector<std::string> lines = lines_of(file.text);
  const std::vector<std::string> code = lines_of(code_of(file.text));
  check_first_lines(file, lines, findings);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    check_marks(file, lines[i], i + 1, findings);
    if (i >= code.size()) continue;
    if (starts_with(code[i], "#include")) {
      check_include(file, code[i], i + 1, findings);
      continue;
    }
    const bool has_total_order = i > 0 && contains(lines[i - 1], "// total order: ");
    if (!has_total_order || !contains(code[i], "std::sort")) check_names(file, code[i], i + 1, findings);
    check_namespace(file, code[i], i + 1, findings);
    if (starts_with(file.path, "engine/")) check_pointer_keys(file, code[i], i + 1, findings);
    check_compiler_words(file, code[i], i + 1, findings);
  }
  return findings;
}

// --- checking the tree ----------------------------------------------------------------------------------------------

/// Whether a CMakeLists.txt in the folder of the file, or above it, names the file.
bool is_built(const fs::path& root, const std::string& path) {
  for (fs::path folder = fs::path(path).parent_path(); !folder.empty(); folder = folder.parent_path()) {
    const std::string list = read_text(root / folder / "CMakeLists.txt");
    if (contains(list, fs::path(path).lexically_relative(folder).generic_string())) return true;
  }
  return false;
}

TEST_CASE("the source tree keeps its rules", "[tidy][determinism]") {
  const std::vector<SourceFile> files = source_tree();
  REQUIRE(files.size() > 20);
  for (const SourceFile& file : files)
    for (const std::string& finding : check_file(file)) FAIL_CHECK(finding);
}

TEST_CASE("every source file is built and every header is included", "[tidy]") {
  const std::vector<SourceFile> files = source_tree();
  std::set<std::string> included;
  for (const SourceFile& file : files) included.merge(includes_of(file.text));
  for (const SourceFile& file : files_below(TICKTRUE_SOURCE_DIR, "tests/causes", {".c"}))
    included.merge(includes_of(file.text));
  for (const SourceFile& file : files) {
    if (ends_with(file.path, ".cpp") && !is_built(TICKTRUE_SOURCE_DIR, file.path))
      FAIL_CHECK(file.path << ":1: error: a file that no CMakeLists.txt names is banned, use or remove it");
    if (is_header(file.path) && included.count(file.path) == 0)
      FAIL_CHECK(file.path << ":1: error: a header that nobody includes is banned, use or remove it");
  }
}

TEST_CASE("every file that mutants are drawn from is there", "[tidy]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  std::istringstream words(read_text(root / "tests/mutants/mutants.py"));
  int count = 0;
  for (std::string word; words >> word;) {
    if (!starts_with(word, "engine/") || word.find('*') != std::string::npos) continue;
    CAPTURE(word);
    CHECK(fs::exists(root / word));
    ++count;
  }
  CHECK(count > 20);
}

// --- the rules fire -------------------------------------------------------------------------------------------------

constexpr std::string_view header_lines = "// A sample file of the test.\n// SPDX-License-Identifier: MIT\n";

Findings findings_in(const std::string& path, const std::string& code) {
  return check_file({path, std::string(header_lines) + (is_header(path) ? "#pragma once\n" : "") + code + "\n"});
}

TEST_CASE("a clean file has no finding", "[tidy][self]") {
  CHECK(
      findings_in("engine/math/vec2.h", "inline float length(Vec2 v) { return __builtin_sqrtf(dot(v, v)); }").empty());
  CHECK(findings_in("engine/stages/x.cpp", "#include \"base/bytes.h\"\nconst int big = 200'000; // rand() is banned")
            .empty());
  CHECK(findings_in("engine/stages/x.cpp", "SinCos r = sin_cos(a); use(r.sin, r.cos, arc_tangent(y, x), sort_rows(x));")
            .empty());
  CHECK(findings_in("engine/stages/x.cpp", "const char* text = \"std::sort, rand(), sin(x)\";").empty());
  CHECK(findings_in("engine/stages/x.cpp", "// total order: by key, then id\nstd::sort(a, b, before);").empty());
  CHECK(findings_in("engine/stages/x.cpp", "std::map<std::string, Row*> rows; std::vector<Row*> list;").empty());
  CHECK(findings_in("engine/stages/x.cpp", "step_time(1); run_time = 2;").empty());
  CHECK(findings_in("tool/main.cpp", "#include <chrono>\n#include <CLI/CLI.hpp>\nstd::sort(a, b);").empty());
}

TEST_CASE("every banned name fires once, at its line, with what to use", "[tidy][self]") {
  for (const Ban& ban : bans) {
    const std::string path =
        ban.where.empty() ? "replay/sample.cpp" : std::string(ban.where.substr(0, ban.where.find(','))) + "sample.cpp";
    const std::string code = "int a;\nx = " + std::string(ban.name) + (ban.call ? " (b);" : " b;");
    const Findings findings = findings_in(path, code);
    CAPTURE(ban.name, code);
    REQUIRE(findings.size() == 1);
    CHECK(findings[0] == path + ":4: error: " + std::string(ban.name) + " is banned, use " + std::string(ban.use));
    if (!ban.where.empty()) CHECK(findings_in("tests/sample.cpp", code).empty());
    if (!ban.allowed_in.empty())
      CHECK(findings_in(std::string(ban.allowed_in.substr(0, ban.allowed_in.find(','))) + ".cpp", code).empty());
  }
}

TEST_CASE("a file that opens the namespace of another room fires", "[tidy][self]") {
  CHECK(findings_in("tool/study/x.cpp", "namespace ticktrue::verifier {").size() == 1);
  CHECK(findings_in("verifier/report/x.cpp", "namespace ticktrue::tool {").size() == 1);
  CHECK(findings_in("verifier/report/x.cpp", "namespace ticktrue::replay {").size() == 2);
  CHECK(findings_in("verifier/report/x.cpp", "namespace ticktrue::verifier {").empty());
  CHECK(findings_in("engine/x.cpp", "namespace ticktrue::engine::TICKTRUE_PRECISION {").empty());
  CHECK(findings_in("tool/study/x.cpp", "namespace ticktrue::tool {").empty());
}

TEST_CASE("every libm function fires in the engine, in each spelling", "[tidy][self]") {
  for (const std::string name : libm)
    for (const std::string& spelling : {name, "std::" + name, name + "f", name + "l", "__builtin_" + name + "f"}) {
      CAPTURE(spelling);
      CHECK(findings_in("engine/sample.cpp", "x = " + spelling + "(y);").size() == 1);
      CHECK(findings_in("verifier/sample.cpp", "x = " + spelling + "(y);").empty());
    }
}

TEST_CASE("every banned header fires, and not where it is allowed", "[tidy][self]") {
  for (const HeaderBan& ban : header_bans) {
    const std::string name = std::string(ban.header) + (ends_with(ban.header, "/") ? "x.h" : "");
    CAPTURE(name);
    CHECK(findings_in("engine/sample.cpp", "#include <" + name + ">").size() == 1);
    if (!ban.allowed_in.empty()) {
      std::string path(ban.allowed_in.substr(0, ban.allowed_in.find(',')));
      if (!contains(path, ".")) path += "sample.cpp";
      CHECK(findings_in(path, "#include <" + name + ">").empty());
    }
  }
}

TEST_CASE("includes against the direction fire", "[tidy][self]") {
  const std::pair<const char*, const char*> wrong[] = {
      {"base/x.cpp", "engine/scene/scene.h"},
      {"base/x.cpp", "base/state/simulation.h"},
      {"base/parallel/x.cpp", "base/state/simulation.h"},
      {"engine/x.cpp", "replay/format/trace.h"},
      {"engine/x.cpp", "verifier/verify/verify.h"},
      {"engine/scene/x.cpp", "engine/model/state.h"},
      {"engine/math/x.cpp", "engine/scene/scene.h"},
      {"replay/x.cpp", "engine/scene/scene.h"},
      {"replay/x.cpp", "verifier/verify/verify.h"},
      {"replay/format/x.cpp", "replay/file/file.h"},
      {"replay/format/x.cpp", "replay/trace_reader.h"},
      {"replay/file/x.cpp", "replay/format/trace.h"},
      {"verifier/verify/x.cpp", "engine/engine.h"},
      {"verifier/verify/x.cpp", "verifier/compare/diff.h"},
      {"verifier/verify/x.cpp", "tests/support/catch.h"},
      {"verifier/plugins/x.cpp", "tool/session/simulations.h"},
      {"capi/x.cpp", "engine/engine.h"},
      {"tool/study/x.cpp", "engine/model/state.h"},
      {"tool/play/x.cpp", "tool/cli/commands.h"},
      {"tool/nowhere/x.cpp", "base/bytes.h"},
      {"bench/x.cpp", "tests/support/catch.h"},
      {"engine/x.cpp", "scene.h"},
      {"engine/x.cpp", "../base/bytes.h"},
  };
  for (const auto& [path, include] : wrong) {
    CAPTURE(path, include);
    CHECK(findings_in(path, "#include \"" + std::string(include) + "\"").size() == 1);
  }
  const std::pair<const char*, const char*> right[] = {
      {"engine/x.cpp", "base/bytes.h"},
      {"replay/x.cpp", "base/bytes.h"},
      {"replay/x.cpp", "replay/format/chunk.h"},
      {"verifier/verify/x.cpp", "replay/format/trace.h"},
      {"tool/cli/session/x.cpp", "verifier/verify/verify.h"},
      {"tests/x.cpp", "engine/model/state.h"},
      {"bench/x.cpp", "engine/scene/scene.h"},
      {"tool/play/x.cpp", "tool/drawing/svg.h"},
  };
  for (const auto& [path, include] : right) {
    CAPTURE(path, include);
    CHECK(findings_in(path, "#include \"" + std::string(include) + "\"").empty());
  }
}

TEST_CASE("rooms are few and shallow, and ARCHITECTURE.md tells what each is", "[tidy][docs]") {
  const std::string architecture = read_text(fs::path(TICKTRUE_SOURCE_DIR) / "ARCHITECTURE.md");
  std::map<std::string, int> counts;
  for (const SourceFile& file : source_tree()) ++counts[std::string(folder_of(file.path))];
  for (const auto& [folder, count] : counts) {
    CAPTURE(folder);
    CHECK(count <= 22);
    CHECK(std::count(folder.begin(), folder.end(), '/') <= 2);
    if (!starts_with(folder, "tests/")) CHECK(contains(architecture, "`" + folder + "/`"));
  }
  // Each room must have files.
  for (const Room& room : rooms) {
    CAPTURE(room.folder);
    CHECK(counts.count(std::string(room.folder)) == 1);
  }
}

TEST_CASE("pointers as keys fire", "[tidy][self]") {
  for (const std::string code : {"std::map<Body*, int> m;", "std::set<const Body *> s;", "std::less<Body*> l;",
                                 "std::map<std::vector<int>*, int> m;"}) {
    CAPTURE(code);
    CHECK(findings_in("engine/sample.cpp", code).size() == 1);
  }
  CHECK(findings_in("engine/sample.cpp", "std::map<std::pair<int, int>, Body*> m;").empty());
}

TEST_CASE("words of one compiler fire in the library, but not in the header for them", "[tidy][self]") {
  for (const std::string_view word : compiler_words) {
    const std::string code = "x = " + std::string(word) + "y(z);";
    CAPTURE(code);
    CHECK(findings_in("capi/x.cpp", code).size() == 1);
    CHECK(findings_in("verifier/report/x.cpp", code).size() == 1);
    CHECK(findings_in("base/compiler/compiler.h", code).empty());
    CHECK(findings_in("verifier/runs/x.cpp", code).empty());
    CHECK(findings_in("engine/x.cpp", code).empty());
  }
}

TEST_CASE("using namespace fires in headers only", "[tidy][self]") {
  CHECK(findings_in("verifier/x.h", "using namespace std;").size() == 1);
  CHECK(findings_in("verifier/x.cpp", "using namespace std;").empty());
}

TEST_CASE("marks fire unless they name an issue", "[tidy][self]") {
  CHECK(findings_in("base/x.cpp",
                    "// TO"
                    "DO: later")
            .size() == 1);
  CHECK(findings_in("base/x.cpp",
                    "// TO"
                    "DO #12: later")
            .empty());
  CHECK(findings_in("base/x.cpp",
                    "// FIX"
                    "ME")
            .size() == 1);
}

TEST_CASE("missing first lines fire", "[tidy][self]") {
  CHECK(check_file({"base/x.cpp", "#include <vector>\n"}).size() == 2);
  CHECK(check_file({"base/x.cpp", "// What this file is for.\nint a;\n"}).size() == 1);
  CHECK(check_file({"base/x.h", std::string(header_lines) + "int a;\n"}).size() == 1);
}

TEST_CASE("comments and literals are no code, digit separators are no literals", "[tidy][self]") {
  CHECK(code_of("a // b\nc") == "a     \nc");
  CHECK(code_of("a /* b\nc */ d") == "a     \n     d");
  CHECK(code_of("f(\"x\\\"y\") + g") == "f(\"    \") + g");
  CHECK(code_of("'\"' + rand()") == "' ' + rand()");
  CHECK(code_of("1'000 + rand() + 2'000") == "1'000 + rand() + 2'000");
  CHECK(code_of("R\"(rand() \")\" + x") == "R             + x");
}

}  // namespace
