// The source tree obeys its own rules: what is banned where, and what to use instead.
// SPDX-License-Identifier: MIT
//
// Verified: banned names and headers, direction of includes, first lines, marks without an issue, files outside of any
// build list, links between documents, length of sentences.
// Not verified: rules that need a parser (aliases, macros that hide a banned name, side effects in call arguments).
// clang-tidy and the golden traces cover those rules.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
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
namespace fs = std::filesystem;

// --- the rules ------------------------------------------------------------------------------------------------------

struct Ban {
  std::string_view where;  // comma-separated path prefixes; empty: everywhere
  std::string_view name;
  bool call;  // only counts as a function call
  std::string_view use;
};

constexpr std::string_view own_functions = "engine/math/trig.h or engine/math/exponential.h";
constexpr std::string_view own_sort = "std::sort over a total order";
constexpr std::string_view total_order = "a total order, named in a comment above: // total order: by KEY, then ID";
constexpr std::string_view id_order = "rows that ascend by id";
constexpr std::string_view bits_in = "numbers that come in with the scene or the inputs";
constexpr std::string_view time_in = "the dt of the tick's input";

// libm functions whose last bits differ between platforms. Also banned: each name with the suffixes f and l, with
// std::, and as __builtin_.
constexpr std::array libm{"sin",   "cos",   "tan",   "asin", "acos", "atan",   "atan2",  "sinh",   "cosh",  "tanh",
                          "asinh", "acosh", "atanh", "exp",  "exp2", "expm1",  "log",    "log2",   "log10", "log1p",
                          "pow",   "cbrt",  "hypot", "erf",  "erfc", "tgamma", "lgamma", "sincos", "exp10"};

constexpr Ban bans[] = {
    {"engine/", "sqrt", true, "__builtin_sqrt (the library's is misrounded on some targets)"},
    {"engine/", "sqrtf", true, "__builtin_sqrtf"},
    {"engine/", "fma", true, "a product and a sum (std::fma is wrong on some targets)"},
    {"engine/", "fmaf", true, "a product and a sum"},
    {"engine/", "__builtin_fma", false, "a product and a sum"},
    {"engine/", "__builtin_fmaf", false, "a product and a sum"},
    {"engine/", "fmin", true, "a < b ? a : b (the order of -0 and 0 is not fixed)"},
    {"engine/", "fmax", true, "a > b ? a : b"},
    {"engine/", "fminf", true, "a < b ? a : b"},
    {"engine/", "fmaxf", true, "a > b ? a : b"},
    {"engine/", "fmod", true, "own reduction from + - * /"},
    {"engine/", "remainder", true, "own reduction from + - * /"},
    {"engine/", "rint", true, "a clamped conversion (the rounding mode is not ours)"},
    {"engine/", "nearbyint", true, "a clamped conversion"},
    {"engine/", "lrint", true, "a clamped conversion"},
    {"engine/", "lround", true, "a clamped conversion"},
    {"engine/", "std::sort", false, total_order},
    {"engine/", "std::partial_sort", false, own_sort},
    {"engine/", "std::nth_element", false, own_sort},
    {"engine/", "std::make_heap", false, own_sort},
    {"engine/", "std::priority_queue", false, own_sort},
    {"engine/", "std::reduce", false, "a loop (its order is fixed)"},
    {"engine/", "std::transform_reduce", false, "a loop (its order is fixed)"},
    {"engine/", "std::execution", false, "a loop (its order is fixed)"},
    {"engine/", "std::unordered_map", false, id_order},
    {"engine/", "std::unordered_set", false, id_order},
    {"engine/", "std::unordered_multimap", false, id_order},
    {"engine/", "std::unordered_multiset", false, id_order},
    {"engine/", "std::hash", false, "hash64 of base/hash.h"},
    {"engine/", "uintptr_t", false, "an index or id (addresses differ from run to run)"},
    {"engine/", "std::owner_less", false, id_order},
    {"engine/", "rand", true, bits_in},
    {"engine/", "srand", true, bits_in},
    {"engine/", "drand48", true, bits_in},
    {"engine/", "std::mt19937", false, bits_in},
    {"engine/", "std::random_device", false, bits_in},
    {"engine/", "time", true, time_in},
    {"engine/", "clock", true, time_in},
    {"engine/", "clock_gettime", true, time_in},
    {"engine/", "gettimeofday", true, time_in},
    {"engine/", "getenv", true, "the scene's settings"},
    {"engine/", "long double", false, "Real or double (its size differs between targets)"},
    {"engine/", "thread_local", false, "a workspace of the stage"},
    {"engine/", "setlocale", true, "nothing: numbers are not parsed by locale"},
    {"engine/", "fopen", true, "text or bytes handed in (the engine knows no files)"},
    {"", "std::bit_cast", false, "__builtin_bit_cast (clang 14)"},
    {"", "std::source_location", false, "TICKTRUE_ASSERT"},
    {"", "std::ranges", false, "a loop, or the algorithm in std:: (clang 14)"},
    {"", "std::views", false, "a loop (clang 14)"},
    {"", "std::format", false, "fmt (g++ 12)"},
    {"", "std::expected", false, "Result of base/result.h"},
    {"", "std::experimental", false, "a plain loop over lanes (its masks are miscompiled for AVX-512)"},
    {"base/,engine/,replay/,verifier/,tool/", "assert", true, "TICKTRUE_ASSERT"},
    {"base/,engine/,replay/,verifier/,tool/", "std::endl", false, "a line break"},
    {"base/,engine/,replay/,verifier/,tool/", "const_cast", false, "a type that says who may write"},
};

struct HeaderBan {
  std::string_view where;       // comma-separated path prefixes; empty: everywhere
  std::string_view header;      // as written between the brackets; a trailing '/' means the folder
  std::string_view allowed_in;  // comma-separated path prefixes
  std::string_view use;
};

constexpr HeaderBan header_bans[] = {
    {"engine/", "random", "", bits_in},
    {"engine/", "chrono", "", time_in},
    {"engine/", "ctime", "", time_in},
    {"engine/", "time.h", "", time_in},
    {"engine/", "thread", "", "work handed in by the caller"},
    {"engine/", "future", "", "work handed in by the caller"},
    {"engine/", "mutex", "", "work handed in by the caller"},
    {"engine/", "execution", "", "a loop"},
    {"engine/", "unordered_map", "", id_order},
    {"engine/", "unordered_set", "", id_order},
    {"engine/", "cfenv", "", "the default rounding mode"},
    {"engine/", "complex", "", "engine/math"},
    {"engine/", "fstream", "", "text or bytes handed in (the engine knows no files)"},
    {"engine/", "filesystem", "", "text or bytes handed in (the engine knows no files)"},
    {"engine/", "iostream", "", "text or bytes handed in (the engine knows no files)"},
    {"engine/", "locale", "", "nothing: numbers are not parsed by locale"},
    {"", "cassert", "", "TICKTRUE_ASSERT of base/assert.h"},
    {"", "bit", "", "base/bytes.h (clang 14 has no std::bit_cast)"},
    {"", "ranges", "", "a loop (clang 14)"},
    {"", "format", "", "fmt (g++ 12)"},
    {"", "expected", "", "Result of base/result.h"},
    {"", "source_location", "", "TICKTRUE_ASSERT"},
    {"", "experimental/", "", "a plain loop over lanes"},
    {"", "xxhash.h", "base/row_kernels.cpp", "base/hash.h"},
    {"", "xxh3.h", "base/row_kernels.cpp", "base/hash.h"},
    {"", "zstd.h", "replay/", "TraceReader and TraceWriter"},
    {"", "box2d/", "tool/box2d/,bench/,tests/causes/clean/,tests/unsaved/box2d_rollback",
     "tool/box2d/box2d_peer.h (its bits are not portable)"},
    {"", "catch2/", "tests/support/catch.h,tests/main.cpp", "tests/support/catch.h"},
    {"", "CLI/", "tool/,bench/", "an options struct, filled by the subcommand"},
    {"", "benchmark/", "bench/", "bench/"},
    {"", "muParser.h", "tool/expression/expression.cpp", "tool/expression/expression.h"},
    {"", "SDL2/", "tool/play/window/window.cpp,tool/play/window/sdl2_loader.cpp", "tool/play/window/host.h"},
    {"", "elfutils/", "tool/debug_info/dwarf_types.cpp", "tool/debug_info/program_types.h"},
};

/// A room is a folder. Its files may include the room's own files and those of the listed rooms, but not those of
/// folders below a listed room.
struct Room {
  std::string_view folder;
  std::string_view may_include;  // comma-separated rooms; "core", "engine_face", ... stand for lists below
};
// The face and the model of the engine name the state rows and workspaces of the engine's rooms.
constexpr std::string_view core =
    "engine,engine/model,engine/broad_phase,engine/narrow_phase,engine/islands,engine/contacts,engine/joints,"
    "engine/joints/batched,engine/impacts,engine/integrators,engine/solvers,engine/stages,"
    "engine/scene,engine/simd,engine/math,base,base/state,base/parallel";
constexpr std::string_view before_islands = "base,base/parallel,engine/math,engine/simd,engine/scene,engine/model";
constexpr std::string_view all_but_tests = "*";
constexpr Room rooms[] = {
    {"base", ""},
    {"base/compiler", ""},
    {"base/state", "base"},
    {"base/parallel", "base"},
    {"engine/math", "base"},
    {"engine/simd", "base,engine/math"},
    {"engine/json", "base"},
    {"engine/scene", "base,base/state,engine/json,engine/math"},
    {"engine/builtin_scenes", "base,engine/json,engine/math,engine/scene"},
    {"engine/random_worlds", "base,engine,engine/builtin_scenes,engine/math,engine/scene"},
    {"engine/clock", "base,engine,engine/math,engine/scene"},
    {"engine", core},
    {"engine/model", core},
    {"engine/broad_phase", before_islands},
    {"engine/narrow_phase", before_islands},
    {"engine/islands", "base,base/parallel,engine/math,engine/model,engine/contacts,engine/joints,engine/impacts"},
    {"engine/contacts", "base,base/parallel,engine/math,engine/simd,engine/model,engine/islands,engine/integrators"},
    {"engine/joints",
     "base,base/parallel,base/state,engine/math,engine/scene,engine/model,engine/contacts,engine/joints/batched"},
    {"engine/joints/batched",
     "base,base/parallel,engine/math,engine/simd,engine/model,engine/integrators,engine/joints"},
    {"engine/joints/direct",
     "base,base/parallel,engine/math,engine/scene,engine/model,engine/islands,engine/integrators,engine/joints"},
    {"engine/impacts",
     "base,base/parallel,engine/math,engine/model,engine/narrow_phase,engine/contacts,engine/joints,"
     "engine/integrators"},
    {"engine/integrators", before_islands},
    {"engine/solvers",
     "base,base/parallel,engine/math,engine/model,engine/islands,engine/contacts,engine/joints,engine/joints/batched,"
     "engine/joints/direct,engine/impacts,engine/integrators"},
    {"engine/stages", "base,base/parallel,engine/math,engine/scene,engine/model,engine/narrow_phase"},
    {"replay/format", "base,base/state"},
    {"replay/file", "base"},
    {"replay", "base,base/state,replay/format,replay/file,replay/box"},
    {"replay/box", "base,base/compiler,base/state,replay,replay/format,replay/file"},
    {"include", ""},
    {"include/ticktrue", ""},
    {"verifier/report", "base,base/compiler,base/state,replay/format"},
    {"verifier/locate", "base,base/state,replay/format,verifier/report"},
    {"verifier/peers", "base,base/state,replay,replay/format,verifier/report,verifier/locate"},
    {"verifier/verify",
     "base,base/state,base/parallel,replay,replay/format,verifier/report,verifier/locate,verifier/peers"},
    {"verifier/runs", "base,replay/file,verifier/report"},
    {"verifier/compare",
     "base,base/state,replay,replay/format,verifier/report,verifier/locate,verifier/peers,verifier/verify,"
     "verifier/runs"},
    {"verifier/inject", "base,base/state,base/parallel,replay,verifier/report,verifier/verify"},
    {"verifier/corpus", "base,replay"},
    {"verifier/store", "base,replay/file,verifier/report"},
    {"verifier/plugins", "base,base/state,include,verifier/runs"},
    {"verifier/programs", "base,base/state,replay,replay/format,shim,verifier/report,verifier/runs,verifier/verify"},
    {"shim", ""},
    {"capi/peers",
     "base,base/state,replay,replay/format,replay/file,replay/box,verifier/report,verifier/locate,verifier/peers"},
    {"capi/marks", "base,base/compiler,replay/format,shim"},
    {"capi/unsaved", "base,base/compiler,base/state,shim,capi/marks"},
    {"capi",
     "base,base/compiler,base/state,replay,replay/format,replay/file,replay/box,include,shim,verifier/report,verifier/"
     "locate,verifier/peers,verifier/"
     "verify,capi/marks,"
     "capi/peers,capi/unsaved"},
    {"tool", "tool/cli"},
    {"tool/output", "below"},
    {"tool/environment", "below"},
    {"tool/import", "below"},
    {"tool/drawing", "below"},
    {"tool/debug_info", "below"},
    {"tool/box2d", "below"},
    {"tool/box2d3", "below,tool/box2d"},
    {"tool/session", "below,tool/output"},
    {"tool/campaign", "below"},
    {"tool/corpus", "below,tool/session"},
    {"tool/report_page", "below,tool/drawing,tool/output,tool/session"},
    {"tool/crosscheck", "below,tool/box2d,tool/box2d3"},
    {"tool/study", "below,tool/box2d,tool/box2d3,tool/crosscheck,tool/drawing,tool/session"},
    {"tool/study/stress", "below,tool/study"},
    {"tool/study/problem_file", "below,tool/expression,tool/output,tool/session,tool/study,tool/study/stress"},
    {"tool/experiment", "below"},
    {"tool/expression", "below,tool/study"},
    {"tool/experiment/reduce",
     "below,tool/crosscheck,tool/experiment,tool/experiment/oracle,tool/expression,tool/output,tool/session,"
     "tool/study"},
    {"tool/experiment/bisect", "below,tool/experiment/reduce,tool/output"},
    {"tool/experiment/shake", "below,shim,tool/experiment,tool/output"},
    {"tool/experiment/trail", "below,tool/experiment/shake,tool/output"},
    {"tool/experiment/unsaved", "below,tool/experiment/shake,tool/output"},
    {"tool/experiment/oracle", "below,tool/experiment,tool/session,tool/study"},
    {"tool/experiment/soak", "below,tool/experiment,tool/experiment/oracle,tool/session"},
    {"tool/play/picture", "below,tool/drawing,tool/output"},
    {"tool/play/window", "below,tool/play/picture"},
    {"tool/play", "below,tool/drawing,tool/output,tool/play/picture,tool/play/window,tool/session"},
    {"tool/cli", "below,tool/output,tool/session"},
    {"tool/cli/session",
     "below,tool/cli,tool/output,tool/session,tool/campaign,tool/corpus,tool/drawing,tool/experiment/reduce,"
     "tool/experiment/shake,tool/experiment/trail,tool/experiment/unsaved,tool/expression,tool/import,tool/play,"
     "tool/report_page"},
    {"tool/cli/study",
     "below,tool/cli,tool/output,tool/session,tool/crosscheck,tool/study,"
     "tool/study/problem_file,tool/study/stress"},
    {"tool/cli/upkeep",
     "below,tool/cli,tool/output,tool/session,tool/corpus,tool/debug_info,tool/environment,"
     "tool/experiment/bisect,"
     "tool/experiment/soak,tool/report_page"},
    {"bench", all_but_tests},
};

/// Whether `path` starts with one of the comma-separated prefixes.
bool is_under(std::string_view path, std::string_view prefixes) {
  while (!prefixes.empty()) {
    const std::size_t comma = std::min(prefixes.find(','), prefixes.size());
    if (starts_with(path, prefixes.substr(0, comma))) return true;
    prefixes.remove_prefix(std::min(comma + 1, prefixes.size()));
  }
  return false;
}

bool is_one_of(std::string_view name, std::string_view names) {
  while (!names.empty()) {
    const std::size_t comma = std::min(names.find(','), names.size());
    if (names.substr(0, comma) == name) return true;
    names.remove_prefix(std::min(comma + 1, names.size()));
  }
  return false;
}

std::string_view folder_of(std::string_view path) {
  return path.substr(0, std::min(path.rfind('/'), path.size()));
}

/// Rooms that every room of the tool may include: all except the tool, the tests and the internal rooms of the engine.
bool is_below_tool(std::string_view room) {
  return is_one_of(
      room,
      "base,base/state,base/parallel,replay,replay/format,replay/file,replay/box,include,engine,engine/"
      "math,engine/simd,"
      "engine/json,engine/scene,engine/builtin_scenes,engine/random_worlds,engine/clock,verifier/report,"
      "verifier/locate,verifier/peers,verifier/verify,verifier/runs,verifier/compare,verifier/inject,verifier/corpus,"
      "verifier/store,verifier/plugins,verifier/programs");
}

bool may_include(std::string_view from, std::string_view to) {
  for (const Room& room : rooms) {
    if (room.folder != from) continue;
    if (room.may_include == all_but_tests) return !starts_with(to, "tests");
    return is_one_of(to, room.may_include) || (is_one_of("below", room.may_include) && is_below_tool(to));
  }
  return false;
}

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
    if ((ban.where.empty() || is_under(file.path, ban.where)) && uses(line, ban.name, ban.call))
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
           "what it may see (rooms in tests/tidy_test.cpp)");
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

// The sources of libticktrue, and the files that may use words of a single compiler. These files are the header for all
// compilers, and the units that choose the instructions of kernels.
constexpr std::string_view library_sources =
    "base/,replay/,capi/,verifier/report/,verifier/locate/,verifier/peers/,verifier/verify/";
constexpr std::string_view compiler_words_in =
    "base/compiler/compiler.h,base/bytes.h,base/hash.cpp,base/row_kernels.cpp,base/parallel/workers.cpp";
constexpr std::array<std::string_view, 9> compiler_words{"__builtin_", "__attribute__", "__asm",
                                                         "__declspec", "__atomic_",     "__sync_",
                                                         "__int128",   "_Interlocked",  "_ReturnAddress"};

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

TEST_CASE("every file that a document of the whole tree names is there", "[tidy][docs]") {
  const fs::path root = TICKTRUE_SOURCE_DIR;
  for (const char* document : {"ARCHITECTURE.md", "CONTRIBUTING.md", "docs/determinism.md"}) {
    const std::vector<std::string> paths = paths_of(read_text(root / document));
    CAPTURE(document);
    CHECK(paths.size() >= 5);
    for (const std::string& path : paths)
      if (!fs::exists(root / path)) FAIL_CHECK(document << ": error: names " << path << ", which is not there");
  }
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
  }
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
