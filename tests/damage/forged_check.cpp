// Forges traces with valid checksums and runs the tool on each. No run may crash, or take much time or memory.
// SPDX-License-Identifier: MIT
//
//   forged_check TOOL TRACE... [--files N] [--seed S] [--memory MB] [--keep DIR] [--only RECIPE]
//
// Each forged file goes to `verify` in one of its modes, and to one of show, replay, diff, recover and report.
// Verified: exit codes are documented ones, and no signal ends a run; each run ends within 2 s of processor time and
// stays below 300 MB of resident memory (--memory; 0: no limit, for builds with sanitizers). Failing files go to
// --keep.
// Not verified: the output of the commands.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "base/random.h"
#include "tests/damage/forger.h"
#include "tests/damage/run_tool.h"

namespace {

namespace fs = std::filesystem;
using ticktrue::Bytes;
using ticktrue::damage::Outcome;

using Arguments = std::vector<std::string>;

struct Options {
  std::string tool;
  Arguments traces;
  std::uint64_t files = 100;
  std::uint64_t seed = 1;
  double memory_max_mb = 300;
  std::string keep;
  std::string only;
};

struct Count {
  int files = 0;
  int crashes = 0;
  int slow = 0;
  int large = 0;
  int misjudged = 0;  // an exit code that no command has
  std::size_t longest = 0;
  double slowest_s = 0;
  double largest_mb = 0;
  std::string slowest, largest;
  std::map<int, int> exit_codes;  // of verify
};

/// The commands for the i-th file. The lists have 7 and 11 entries, so each mode meets each command.
std::vector<Arguments> commands(std::uint64_t i, const std::string& file, const std::string& other,
                                const std::string& saved) {
  const std::vector<Arguments> verify{{"verify", file},
                                      {"verify", "--mode", "restore", file},
                                      {"verify", "--mode", "twice", file},
                                      {"verify", "--mode", "threads", file},
                                      {"verify", "--mode", "restore", "--to-end", file},
                                      {"verify", "-j", "2", "--json", file},
                                      {"verify", "--from", "30", file}};
  const std::vector<Arguments> others{{"show", file},
                                      {"show", "--json", file},
                                      {"show", "--ticks", "0..", file},
                                      {"replay", "--every", "10", file},
                                      {"replay", "--format", "jsonl", "--ticks", "0..50", file, "-o", saved, "--force"},
                                      {"diff", file, other},
                                      {"diff", other, file},
                                      {"diff", file, file},
                                      {"diff", other, file, other},
                                      {"recover", file, "-o", saved, "--force"},
                                      {"report", file, "-o", saved, "--force"},
                                      {"report", file, "--against", other, "-o", saved, "--force"}};
  return {verify[i % verify.size()], others[i % others.size()]};
}

class Checker {
 public:
  explicit Checker(const Options& options) : options_(options) {}

  void judge(Arguments arguments, const std::string& what, const Bytes& bytes, Count& count) {
    arguments.insert(arguments.begin(), options_.tool);
    const Outcome outcome = ticktrue::damage::run_tool(arguments);
    const std::string command = arguments[1] + (arguments.size() > 3 ? " " + arguments[2] + " " + arguments[3] : "");
    const std::string name = what + ": " + command;
    if (outcome.cpu_s > count.slowest_s) count.slowest_s = outcome.cpu_s, count.slowest = command;
    if (outcome.memory_mb > count.largest_mb) count.largest_mb = outcome.memory_mb, count.largest = command;
    if (arguments[1] == "verify") ++count.exit_codes[outcome.exit_code];
    const bool is_large = options_.memory_max_mb > 0 && outcome.memory_mb > options_.memory_max_mb;
    const bool is_misjudged =
        !outcome.is_hang() && !outcome.is_crash() && (outcome.exit_code < 0 || outcome.exit_code > 6);
    count.slow += outcome.is_hang();
    count.crashes += outcome.is_crash();
    count.large += is_large;
    count.misjudged += is_misjudged;
    if (!outcome.is_hang() && !outcome.is_crash() && !is_large && !is_misjudged) return;
    std::printf("%s: exit code %d, signal %d, %.2f s, %.0f MB\n", name.c_str(), outcome.exit_code, outcome.signal,
                outcome.cpu_s, outcome.memory_mb);
    std::fflush(stdout);
    if (options_.keep.empty()) return;
    std::ofstream(options_.keep + "/" + what + ".ttr", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  const Options& options_;
};

Options parse(int argument_count, char** arguments) {
  Options options;
  Arguments files;
  for (int i = 1; i < argument_count; ++i) {
    const std::string word = arguments[i];
    const char* value = i + 1 < argument_count ? arguments[i + 1] : "";
    if (word.rfind("--", 0) != 0) {
      files.push_back(word);
      continue;
    }
    ++i;
    if (word == "--files")
      options.files = std::strtoull(value, nullptr, 10);
    else if (word == "--seed")
      options.seed = std::strtoull(value, nullptr, 10);
    else if (word == "--memory")
      options.memory_max_mb = std::strtod(value, nullptr);
    else if (word == "--keep")
      options.keep = value;
    else if (word == "--only")
      options.only = value;
    else
      ticktrue::damage::fail("forged_check: unknown option " + word);
  }
  if (files.size() < 2)
    ticktrue::damage::fail(
        "usage: forged_check TOOL TRACE... [--files N] [--seed S] [--memory MB] [--keep DIR] [--only RECIPE]");
  options.tool = files.front();
  options.traces.assign(files.begin() + 1, files.end());
  return options;
}

int print(const std::map<std::string, Count>& counts) {
  int failed = 0;
  for (const auto& [name, count] : counts) {
    std::string codes;
    for (const auto& [code, runs] : count.exit_codes)
      codes += (codes.empty() ? "" : ", ") + std::to_string(runs) + " x " + std::to_string(code);
    std::printf(
        "%-12s %5d files to %4zu KB: %d crashes, %d slow, %d large, %d misjudged; at most %.2f s (%s), %.0f MB (%s); "
        "exit codes of verify %s\n",
        name.c_str(), count.files, count.longest / 1000, count.crashes, count.slow, count.large, count.misjudged,
        count.slowest_s, count.slowest.c_str(), count.largest_mb, count.largest.c_str(), codes.c_str());
    failed += count.crashes + count.slow + count.large + count.misjudged;
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argument_count, char** arguments) {
  const Options options = parse(argument_count, arguments);
  ticktrue::damage::set_sanitizer_options();
  std::vector<ticktrue::damage::Recording> recordings;
  for (const std::string& path : options.traces) recordings.push_back(ticktrue::damage::read_recording(path));
  std::string folder = (fs::temp_directory_path() / "ticktrue_forged_XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) ticktrue::damage::fail("no temporary folder");
  const std::string file = folder + "/forged.ttr", saved = folder + "/saved";

  Checker checker(options);
  std::map<std::string, Count> counts;
  ticktrue::Random random(options.seed);
  const auto& recipes = ticktrue::damage::recipes();
  for (std::uint64_t i = 0; i < options.files; ++i) {
    const std::uint64_t seed = random.bits();
    const auto& recipe = recipes[i % recipes.size()];
    const auto& from = recordings[random.below(recordings.size())];
    if (!options.only.empty() && options.only != recipe.name) continue;
    const Bytes bytes = recipe.forge(from, seed);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    Count& count = counts[std::string(recipe.name)];
    ++count.files;
    count.longest = std::max(count.longest, bytes.size());
    const std::string what = std::string(recipe.name) + "_" + std::to_string(i);
    for (const Arguments& command : commands(i / recipes.size() + i, file, from.path, saved))
      checker.judge(command, what, bytes, count);
    fs::remove_all(saved);
  }
  fs::remove_all(folder);
  return print(counts);
}
