// Runs one fuzz harness for some seconds on changed seeds: for every compiler, without knowledge of coverage.
// SPDX-License-Identifier: MIT
//
//   fuzz_short SECONDS SEED NAME LONGEST SEEDS FOUND    the harness NAME on SEEDS/NAME/*, at most LONGEST bytes
//
// libFuzzer searches by coverage, this program by chance alone: it is for builds that have sanitizers and no clang.
// Every input is made in a page shared with the parent process, which stores the input that killed its child as
// FOUND/NAME-short.
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "base/random.h"
#include "tests/fuzz/support/fuzz.h"

// Each harness is compiled under its own name (CMakeLists.txt, the list of all).
extern "C" {
int fuzz_trace(const std::uint8_t*, std::size_t);
int fuzz_trace_forged(const std::uint8_t*, std::size_t);
int fuzz_state(const std::uint8_t*, std::size_t);
int fuzz_scene(const std::uint8_t*, std::size_t);
int fuzz_setup(const std::uint8_t*, std::size_t);
int fuzz_input_lines(const std::uint8_t*, std::size_t);
int fuzz_inputs(const std::uint8_t*, std::size_t);
int fuzz_rube(const std::uint8_t*, std::size_t);
int fuzz_mouse(const std::uint8_t*, std::size_t);
int fuzz_host(const std::uint8_t*, std::size_t);
int fuzz_verdict(const std::uint8_t*, std::size_t);
int fuzz_peers(const std::uint8_t*, std::size_t);
int fuzz_box(const std::uint8_t*, std::size_t);
int fuzz_elf(const std::uint8_t*, std::size_t);
int fuzz_program(const std::uint8_t*, std::size_t);
int fuzz_mark_log(const std::uint8_t*, std::size_t);
int fuzz_box2d3(const std::uint8_t*, std::size_t);
}

namespace ticktrue::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int hang_cpu_s = 5;
constexpr unsigned hang_wall_s = 60;  // a harness that waits longer has hung

using Harness = int (*)(const std::uint8_t*, std::size_t);
const std::map<std::string, Harness> harnesses{{"trace", fuzz_trace},     {"trace_forged", fuzz_trace_forged},
                                               {"state", fuzz_state},     {"scene", fuzz_scene},
                                               {"setup", fuzz_setup},     {"input_lines", fuzz_input_lines},
                                               {"inputs", fuzz_inputs},   {"rube", fuzz_rube},
                                               {"mouse", fuzz_mouse},     {"host", fuzz_host},
                                               {"verdict", fuzz_verdict}, {"peers", fuzz_peers},
                                               {"box", fuzz_box},         {"elf", fuzz_elf},
                                               {"program", fuzz_program}, {"mark_log", fuzz_mark_log},
                                               {"box2d3", fuzz_box2d3}};

Bytes read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

/// Bytes that replace bytes of an input, or are inserted: limits of number types, and the words of the harness.
std::vector<Bytes> interesting(const fs::path& dictionary) {
  std::vector<Bytes> words;
  for (const std::size_t size : {1u, 2u, 4u, 8u})
    for (const std::uint64_t value :
         {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}, std::uint64_t{1} << (8 * size - 1),
          (std::uint64_t{1} << (8 * size - 1)) - 1, bits_of(1e308), std::uint64_t{bits_of(1e38f)}}) {
      Bytes word;
      for (std::size_t i = 0; i < size; ++i) word.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
      words.push_back(word);
    }
  std::ifstream in(dictionary);
  for (std::string line; std::getline(in, line);) {
    Bytes word;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      if (line[i] == '\\' && i + 2 < line.size()) ++i;
      word.push_back(static_cast<std::uint8_t>(line[i]));
    }
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

class Mutator {
 public:
  Mutator(const std::vector<Bytes>& seeds, const std::vector<Bytes>& words, std::size_t longest, std::uint64_t seed)
      : seeds_(seeds), words_(words), longest_(longest), random_(seed) {}

  Bytes next() {
    Bytes bytes = one_of(seeds_);
    for (std::size_t left = 1 + random_.below(4); left > 0; --left) change(bytes);
    bytes.resize(std::min(bytes.size(), longest_));
    return bytes;
  }

 private:
  const Bytes& one_of(const std::vector<Bytes>& list) { return list[random_.below(list.size())]; }

  void change(Bytes& bytes) {
    const std::size_t at = random_.below(bytes.size() + 1);
    const auto place = [&](std::size_t offset) { return bytes.begin() + static_cast<std::ptrdiff_t>(offset); };
    const std::size_t size = std::min(bytes.size() - at, std::size_t{1} << random_.below(8));
    switch (random_.below(7)) {
      case 0:
        if (at < bytes.size()) bytes[at] ^= static_cast<std::uint8_t>(1u << random_.below(8));
        break;
      case 1:
        if (at < bytes.size()) bytes[at] = static_cast<std::uint8_t>(random_.below(256));
        break;
      case 2: {
        const Bytes& word = one_of(words_);
        for (std::size_t i = 0; i < word.size() && at + i < bytes.size(); ++i) bytes[at + i] = word[i];
        break;
      }
      case 3: {
        const Bytes& word = one_of(words_);
        bytes.insert(place(at), word.begin(), word.end());
        break;
      }
      case 4:
        bytes.erase(place(at), place(at + size));
        break;
      case 5: {
        const Bytes again(place(at), place(at + size));
        bytes.insert(place(random_.below(bytes.size() + 1)), again.begin(), again.end());
        break;
      }
      default: {
        const Bytes& other = one_of(seeds_);
        const std::size_t from = random_.below(other.size() + 1);
        bytes.resize(at);
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
      }
    }
  }

  const std::vector<Bytes>& seeds_;
  const std::vector<Bytes>& words_;
  std::size_t longest_;
  Random random_;
};

/// The input that runs, in memory of both processes.
struct Shared {
  std::uint64_t run_count;
  std::uint64_t size;
  std::uint8_t bytes[1 << 16];
};

[[noreturn]] void run_child(Harness harness, std::size_t longest, const std::vector<Bytes>& seeds,
                            const std::vector<Bytes>& words, double seconds, std::uint64_t seed, Shared& shared) {
  const auto run = [&](const Bytes& bytes) {
    shared.size = std::min(bytes.size(), sizeof shared.bytes);
    std::copy_n(bytes.begin(), shared.size, shared.bytes);
    const itimerval cpu{{0, 0}, {hang_cpu_s, 0}};
    ::setitimer(ITIMER_PROF, &cpu, nullptr);
    ::alarm(hang_wall_s);
    // A copy of its own, so that a read behind its end is seen.
    const Bytes input(shared.bytes, shared.bytes + shared.size);
    harness(input.data(), input.size());
    ++shared.run_count;
  };
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (const Bytes& bytes : seeds) run(bytes);
  Mutator mutator(seeds, words, std::min(longest, sizeof shared.bytes), seed);
  while (std::chrono::steady_clock::now() < end) run(mutator.next());
  std::exit(0);
}

int run(double seconds, std::uint64_t seed, const std::string& name, std::size_t longest, const fs::path& folder,
        const fs::path& found) {
  const auto harness = harnesses.find(name);
  if (harness == harnesses.end()) {
    std::fprintf(stderr, "fuzz_short: error: unknown harness: found %s\n", name.c_str());
    return 2;
  }
  std::vector<Bytes> seeds;
  std::vector<fs::path> files(fs::directory_iterator(folder / name), fs::directory_iterator{});
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) seeds.push_back(read_file(file));
  require(!seeds.empty(), "there are seeds");
  const std::vector<Bytes> words = interesting(folder / (name + ".dict"));
  void* page = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  require(page != MAP_FAILED, "mmap works");
  auto& shared = *static_cast<Shared*>(page);
  const pid_t child = ::fork();
  require(child >= 0, "fork works");
  if (child == 0) run_child(harness->second, longest, seeds, words, seconds, seed, shared);
  int status = 0;
  require(::waitpid(child, &status, 0) == child, "waitpid works");
  const bool is_hang = WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM);
  std::string verdict = "nothing";
  if (status != 0) {
    fs::create_directories(found);
    const fs::path file = found / (name + "-short");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(shared.bytes), static_cast<std::streamsize>(shared.size));
    verdict = (is_hang ? "a hang: " : "a crash: ") + file.string();
  }
  std::printf("%-14s %10llu runs in %4.0f s, found %s\n", name.c_str(),
              static_cast<unsigned long long>(shared.run_count), seconds, verdict.c_str());
  return status == 0 ? 0 : 1;
}

}  // namespace
}  // namespace ticktrue::fuzz

int main(int argument_count, char** arguments) {
  if (argument_count != 7) {
    std::fprintf(stderr, "usage: fuzz_short SECONDS SEED NAME LONGEST SEEDS FOUND\n");
    return 2;
  }
  return ticktrue::fuzz::run(std::atof(arguments[1]), std::strtoull(arguments[2], nullptr, 10), arguments[3],
                             std::strtoull(arguments[4], nullptr, 10), arguments[5], arguments[6]);
}
