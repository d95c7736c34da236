// The rules of the source tree as tables: banned names and headers, and which room may include which.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "tests/support/source_tree.h"

namespace ticktrue::tidy {

struct Ban {
  std::string_view where;  // comma-separated path prefixes; empty: everywhere
  std::string_view name;
  bool call;  // only counts as a function call
  std::string_view use;
  std::string_view allowed_in = {};  // comma-separated path prefixes
};

inline constexpr std::string_view own_functions = "engine/math/trig.h or engine/math/exponential.h";
inline constexpr std::string_view own_sort = "std::sort over a total order";
inline constexpr std::string_view total_order =
    "a total order, named in a comment above: // total order: by KEY, then ID";
inline constexpr std::string_view id_order = "rows that ascend by id";
inline constexpr std::string_view bits_in = "numbers that come in with the scene or the inputs";
inline constexpr std::string_view time_in = "the dt of the tick's input";

// libm functions whose last bits differ between platforms. Also banned: each name with the suffixes f and l, with
// std::, and as __builtin_.
inline constexpr std::array libm{"sin",  "cos",    "tan",    "asin",   "acos",  "atan", "atan2", "sinh",
                                 "cosh", "tanh",   "asinh",  "acosh",  "atanh", "exp",  "exp2",  "expm1",
                                 "log",  "log2",   "log10",  "log1p",  "pow",   "cbrt", "hypot", "erf",
                                 "erfc", "tgamma", "lgamma", "sincos", "exp10"};

inline constexpr Ban bans[] = {
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
    {"replay/,base/,engine/,verifier/,tool/,capi/", "std::thread", false, "base/parallel/",
     "base/parallel/,verifier/store/claims.cpp,tool/experiment/shake/terminal"},
    {"replay/,base/,engine/,verifier/,tool/,capi/", "std::async", true, "base/parallel/"},
    {"replay/,base/,engine/,verifier/,tool/,capi/", "::fork", true, "ChildProcess of verifier/runs/child_process.h",
     "verifier/runs/,tool/experiment/shake/facts.cpp,capi/unsaved/probe.cpp"},
    {"replay/,base/,engine/,verifier/,tool/,capi/", "::popen", true, "ChildProcess of verifier/runs/child_process.h",
     "tool/study/table.cpp"},
    {"base/,engine/,replay/,verifier/,tool/", "assert", true, "TICKTRUE_ASSERT"},
    {"base/,engine/,replay/,verifier/,tool/", "std::endl", false, "a line break"},
    {"base/,engine/,replay/,verifier/,tool/", "const_cast", false, "a type that says who may write"},
};

/// A room of the top level, and the namespace that its files alone open.
struct RoomNamespace {
  std::string_view folder;
  std::string_view name;
};
inline constexpr RoomNamespace room_namespaces[] = {{"engine/", "ticktrue::engine"},
                                                    {"replay/", "ticktrue::replay"},
                                                    {"verifier/", "ticktrue::verifier"},
                                                    {"capi/", "ticktrue::capi"},
                                                    {"shim/", "ticktrue::shim"}};

struct HeaderBan {
  std::string_view where;       // comma-separated path prefixes; empty: everywhere
  std::string_view header;      // as written between the brackets; a trailing '/' means the folder
  std::string_view allowed_in;  // comma-separated path prefixes
  std::string_view use;
};

inline constexpr HeaderBan header_bans[] = {
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
    {"", "box2d/", "tool/box2d/,tool/box2d3/box2d3_run.cpp,bench/,tests/causes/clean/,tests/unsaved/box2d_rollback",
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
  std::string_view may_include;  // comma-separated rooms; "core", "before_islands", ... stand for lists below
};
// The face and the model of the engine name the state rows and workspaces of the engine's rooms.
inline constexpr std::string_view core =
    "engine,engine/model,engine/broad_phase,engine/narrow_phase,engine/islands,engine/contacts,engine/joints,"
    "engine/joints/batched,engine/impacts,engine/integrators,engine/solvers,engine/stages,"
    "engine/scene,engine/simd,engine/math,base,base/state,base/parallel";
inline constexpr std::string_view before_islands =
    "base,base/parallel,engine/math,engine/simd,engine/scene,engine/model";
inline constexpr std::string_view all_but_tests = "*";
inline constexpr Room rooms[] = {
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
    {"engine/islands",
     "engine/integrators,base,base/parallel,engine/math,engine/model,engine/contacts,engine/joints,engine/joints/"
     "direct,engine/impacts"},
    {"engine/contacts", "base,base/parallel,engine/math,engine/simd,engine/model,engine/integrators"},
    {"engine/joints",
     "base,base/parallel,base/state,engine/math,engine/scene,engine/model,engine/contacts,engine/joints/batched"},
    {"engine/joints/batched",
     "base,base/parallel,engine/math,engine/simd,engine/model,engine/integrators,engine/joints"},
    {"engine/joints/direct",
     "base,base/parallel,engine/math,engine/scene,engine/model,engine/integrators,engine/joints"},
    {"engine/joints/gears", "base,engine/math,engine/scene,engine/model,engine/contacts,engine/joints"},
    {"engine/impacts",
     "base,base/parallel,engine/math,engine/model,engine/narrow_phase,engine/contacts,engine/joints,"
     "engine/joints/direct,engine/integrators"},
    {"engine/integrators", before_islands},
    {"engine/solvers",
     "base,base/parallel,engine/math,engine/model,engine/islands,engine/contacts,engine/joints,engine/joints/batched,"
     "engine/joints/direct,engine/joints/gears,engine/impacts,engine/integrators"},
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
    {"verifier/compare/many",
     "base,base/state,replay,replay/format,verifier/report,verifier/locate,verifier/peers,verifier/compare"},
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
     "base,base/compiler,base/state,replay,replay/format,replay/file,replay/box,include,shim,verifier/report,"
     "verifier/locate,verifier/peers,verifier/verify,capi/marks,capi/peers,capi/unsaved"},
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
    {"tool/corpus/run", "below,tool/corpus"},
    {"tool/report_page", "below,tool/drawing,tool/output,tool/session"},
    {"tool/crosscheck", "below,tool/box2d,tool/box2d3,tool/drawing"},
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
    {"tool/experiment/oracle", "below,tool/experiment,tool/expression,tool/session,tool/study"},
    {"tool/experiment/soak", "below,tool/experiment,tool/experiment/oracle,tool/session"},
    {"tool/play/picture", "below,tool/drawing,tool/expression,tool/output"},
    {"tool/play/window", "below,tool/play/picture"},
    {"tool/play", "below,tool/drawing,tool/output,tool/play/picture,tool/play/window,tool/session"},
    {"tool/cli", "below,tool/output,tool/session"},
    {"tool/cli/session",
     "below,tool/cli,tool/output,tool/session,tool/campaign,tool/corpus,tool/drawing,tool/experiment/reduce,"
     "tool/experiment/shake,tool/experiment/trail,tool/experiment/unsaved,tool/expression,tool/import,tool/play,"
     "tool/report_page"},
    {"tool/cli/study",
     "below,tool/cli,tool/output,tool/session,tool/crosscheck,tool/expression,tool/study,"
     "tool/study/problem_file,tool/study/stress"},
    {"tool/cli/upkeep",
     "below,tool/cli,tool/output,tool/session,tool/corpus,tool/corpus/run,tool/debug_info,tool/environment,"
     "tool/experiment/bisect,"
     "tool/experiment/soak,tool/report_page"},
    {"bench", all_but_tests},
};

/// Rooms that every room of the tool may include: all except the tool, the tests and the internal rooms of the engine.
inline bool is_below_tool(std::string_view room) {
  return source_tree::is_one_of(
      room,
      "base,base/state,base/parallel,replay,replay/format,replay/file,replay/box,include,engine,engine/math,"
      "engine/simd,engine/json,engine/scene,engine/builtin_scenes,engine/random_worlds,engine/clock,verifier/report,"
      "verifier/locate,verifier/peers,verifier/verify,verifier/runs,verifier/compare,verifier/compare/many,"
      "verifier/inject,verifier/corpus,verifier/store,verifier/plugins,verifier/programs");
}

inline bool may_include(std::string_view from, std::string_view to) {
  for (const Room& room : rooms) {
    if (room.folder != from) continue;
    if (room.may_include == all_but_tests) return !source_tree::starts_with(to, "tests");
    return source_tree::is_one_of(to, room.may_include) ||
           (source_tree::is_one_of("below", room.may_include) && is_below_tool(to));
  }
  return false;
}

// The sources of libticktrue, and the files that may use words of a single compiler. These files are the header for all
// compilers, and the units that choose the instructions of kernels.
inline constexpr std::string_view library_sources =
    "base/,replay/,capi/,verifier/report/,verifier/locate/,verifier/peers/,verifier/verify/";
inline constexpr std::string_view compiler_words_in =
    "base/compiler/compiler.h,base/bytes.h,base/hash.cpp,base/row_kernels.cpp,base/parallel/workers.cpp";
inline constexpr std::array<std::string_view, 9> compiler_words{"__builtin_", "__attribute__", "__asm",
                                                                "__declspec", "__atomic_",     "__sync_",
                                                                "__int128",   "_Interlocked",  "_ReturnAddress"};

}  // namespace ticktrue::tidy
