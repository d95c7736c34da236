// Damages traces in many ways and runs the tool on each. No damaged trace may be accepted, and no run may crash or
// hang.
// SPDX-License-Identifier: MIT
//
//   damage_check TOOL TRACE TRACE TRACE [--changes N] [--cuts N] [--splices N] [--seed S]
//   damage_check TOOL TRACE... --every
//
// The second form changes every byte with three masks and cuts at every length. It only runs `verify`.
// Each damaged file goes to `verify`, and then to one of show, recover, diff and replay.
// Verified: `verify` gives exit code 3 or 4 and nothing else; no other command dies; each ends within 2 s of processor
// time; output of `recover` verifies with exit code 0.
// Not verified: the messages (traces/bad/EXPECTED.tsv checks them).
// With sanitizers, exit code 99 distinguishes their findings from exit codes of the tool.
#include <algorithm>
#include <cstdint>
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
#include "tests/damage/run_tool.h"

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<char>;
using ticktrue::Random;
using ticktrue::damage::fail;
using ticktrue::damage::Outcome;
using ticktrue::damage::run_tool;

struct Trace {
  std::string path;
  Bytes bytes;
  std::vector<std::size_t> chunks;  // offsets; the last is the end
};

Bytes read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path + ": cannot be read");
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

Trace read_trace(const std::string& path) {
  Trace trace{path, read_file(path), {}};
  const Bytes marker{'\xf5', 'T', 'T', 'C'};
  for (auto at = trace.bytes.begin();; ++at) {
    at = std::search(at, trace.bytes.end(), marker.begin(), marker.end());
    trace.chunks.push_back(static_cast<std::size_t>(at - trace.bytes.begin()));
    if (at == trace.bytes.end()) break;
  }
  if (trace.chunks.size() < 6) fail(path + ": found fewer chunks than a trace has");
  return trace;
}

struct Count {
  int files = 0;
  int accepted = 0;
  int crashes = 0;
  int hangs = 0;
  int misjudged = 0;  // an exit code of verify other than 3 or 4, or a recovered trace that does not verify
  double slowest_s = 0;
  std::map<int, int> exit_codes;  // of verify
};

class Checker {
 public:
  Checker(std::string tool, const fs::path& folder)
      : tool_(std::move(tool)), damaged_((folder / "damaged.ttr").string()), saved_((folder / "saved.ttr").string()) {}

  /// Runs `verify` only.
  void verify(const Trace& from, const Bytes& bytes, const std::string& what, Count& count) {
    std::ofstream(damaged_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    ++count.files;
    const int code = judge({"verify", damaged_}, what, count);
    ++count.exit_codes[code];
    if (code == 0) tell(from, "accepted", what, ++count.accepted);
    if (code != 0 && code != 3 && code != 4)
      tell(from, "verify: exit " + std::to_string(code), what, ++count.misjudged);
  }

  /// Runs `verify` and one other command that reads traces.
  void check(const Trace& from, const Bytes& bytes, const std::string& what, Count& count) {
    if (bytes == from.bytes) return;
    verify(from, bytes, what, count);
    switch (count.files % 4) {
      case 0:
        judge({"show", damaged_}, what, count);
        break;
      case 1:
        judge({"diff", damaged_, from.path}, what, count);
        break;
      case 2:
        judge({"replay", damaged_, "-o", saved_, "--force"}, what, count);
        break;
      default:
        if (judge({"recover", damaged_, "-o", saved_, "--force"}, what, count) == 0 &&
            judge({"verify", saved_}, what, count) != 0)
          tell(from, "what was recovered does not verify", what, ++count.misjudged);
    }
    fs::remove(saved_);
  }

 private:
  int judge(std::vector<std::string> words, const std::string& what, Count& count) {
    words.insert(words.begin(), tool_);
    const Outcome outcome = run_tool(words);
    count.slowest_s = std::max(count.slowest_s, outcome.cpu_s);
    const bool is_hang = outcome.is_hang();
    const bool is_crash = outcome.is_crash();
    if (is_hang) ++count.hangs;
    if (is_crash) ++count.crashes;
    if (is_hang || is_crash)
      std::printf("%s: %s of `%s`: signal %d, exit code %d, %.1f s\n", is_hang ? "hang" : "crash", what.c_str(),
                  words[1].c_str(), outcome.signal, outcome.exit_code, outcome.cpu_s);
    return outcome.exit_code;
  }
  static void tell(const Trace& from, const std::string& verdict, const std::string& what, int) {
    std::printf("%s: %s: %s\n", from.path.c_str(), verdict.c_str(), what.c_str());
  }

  std::string tool_;
  std::string damaged_;
  std::string saved_;
};

Bytes part(const Bytes& bytes, std::size_t from, std::size_t to) {
  return {bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.begin() + static_cast<std::ptrdiff_t>(to)};
}
void append(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

/// Splices traces in one of these ways. The start of one trace is joined to the end of another, at any bytes or at
/// chunks. Or a chunk is doubled, omitted, moved, or taken from another trace.
Bytes spliced(const Trace& trace, const Trace& other, Random& random, std::string& what) {
  const std::size_t kind = random.below(6);
  if (kind < 2) {
    const bool at_chunks = kind == 1;
    const auto place = [&](const Trace& t) {
      return at_chunks ? t.chunks[random.below(t.chunks.size())] : random.below(t.bytes.size() + 1);
    };
    const std::size_t from = place(trace);
    const std::size_t to = place(other);
    what = "start to " + std::to_string(from) + ", then " + other.path + " from " + std::to_string(to);
    Bytes made = part(trace.bytes, 0, from);
    append(made, part(other.bytes, to, other.bytes.size()));
    return made;
  }
  std::vector<Bytes> chunks;
  for (std::size_t i = 0; i + 1 < trace.chunks.size(); ++i)
    chunks.push_back(part(trace.bytes, trace.chunks[i], trace.chunks[i + 1]));
  const std::size_t i = random.below(chunks.size());
  const std::size_t j = random.below(chunks.size());
  const auto at = [&](std::size_t index) { return chunks.begin() + static_cast<std::ptrdiff_t>(index); };
  if (kind == 2) {
    what = "chunk " + std::to_string(i) + " again before chunk " + std::to_string(j);
    chunks.insert(at(j), Bytes(chunks[i]));
  } else if (kind == 3) {
    what = "without chunk " + std::to_string(i);
    chunks.erase(at(i));
  } else if (kind == 4) {
    what = "chunks " + std::to_string(i) + " and " + std::to_string(j) + " swapped";
    std::swap(chunks[i], chunks[j]);
  } else {
    const std::size_t k = random.below(other.chunks.size() - 1);
    what = "chunk " + std::to_string(i) + " from " + other.path + ", chunk " + std::to_string(k);
    chunks[i] = part(other.bytes, other.chunks[k], other.chunks[k + 1]);
  }
  Bytes made = part(trace.bytes, 0, trace.chunks[0]);
  for (const Bytes& chunk : chunks) append(made, chunk);
  return made;
}

void verify_every(Checker& checker, const Trace& trace, Count& changes, Count& cuts) {
  for (std::size_t at = 0; at < trace.bytes.size(); ++at) {
    for (const int mask : {0x01, 0x80, 0xff}) {
      Bytes bytes = trace.bytes;
      bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(mask));
      checker.verify(trace, bytes, "byte " + std::to_string(at) + " ^ " + std::to_string(mask), changes);
    }
    checker.verify(trace, part(trace.bytes, 0, at), "cut at " + std::to_string(at), cuts);
  }
}

void print(const char* name, const Count& count) {
  std::string codes;
  for (const auto& [code, files] : count.exit_codes)
    codes += (codes.empty() ? "" : ", ") + std::to_string(files) + " x " + std::to_string(code);
  std::printf("%-8s %5d files: %d accepted, %d crashes, %d hangs, %d misjudged; slowest %.2f s; exit codes %s\n", name,
              count.files, count.accepted, count.crashes, count.hangs, count.misjudged, count.slowest_s, codes.c_str());
}

}  // namespace

int main(int argument_count, char** arguments) {
  std::vector<std::string> words(arguments + 1, arguments + argument_count);
  std::map<std::string, std::size_t> options{{"--changes", 1000}, {"--cuts", 200}, {"--splices", 200}, {"--seed", 1}};
  bool every = false;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto option = options.find(words[i]);
    if (words[i] == "--every")
      every = true;
    else if (option == options.end())
      files.push_back(words[i]);
    else if (++i < words.size())
      option->second = std::stoul(words[i]);
  }
  if (files.size() < (every ? 2 : 3))
    fail(
        "usage: damage_check TOOL TRACE TRACE... [--changes N] [--cuts N] [--splices N] [--seed S], or TOOL TRACE... "
        "--every");
  ticktrue::damage::set_sanitizer_options();
  std::vector<Trace> traces;
  for (std::size_t i = 1; i < files.size(); ++i) traces.push_back(read_trace(files[i]));
  std::string folder = (fs::temp_directory_path() / "ticktrue_damage_XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) fail("no temporary folder");

  Checker checker(files[0], folder);
  Random random(options["--seed"]);
  Count changes, cuts, splices;
  if (every) {
    for (const Trace& trace : traces) verify_every(checker, trace, changes, cuts);
    for (auto& [name, count] : options) count = 0;
  }
  for (std::size_t i = 0; i < options["--changes"]; ++i) {
    const Trace& trace = traces[i % traces.size()];
    Bytes bytes = trace.bytes;
    const std::size_t at = random.below(bytes.size());
    const std::size_t mask = 1 + random.below(255);
    bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(mask));
    checker.check(trace, bytes, "byte " + std::to_string(at) + " ^ " + std::to_string(mask), changes);
  }
  for (std::size_t i = 0; i < options["--cuts"]; ++i) {
    const Trace& trace = traces[i % traces.size()];
    const std::size_t size = random.below(trace.bytes.size());
    checker.check(trace, part(trace.bytes, 0, size), "cut at " + std::to_string(size), cuts);
  }
  while (static_cast<std::size_t>(splices.files) < options["--splices"]) {
    const Trace& trace = traces[random.below(traces.size())];
    const Trace& other = traces[random.below(traces.size())];
    std::string what;
    const Bytes bytes = spliced(trace, other, random, what);
    if (bytes != other.bytes) checker.check(trace, bytes, what, splices);
  }
  fs::remove_all(folder);
  print("changes", changes);
  print("cuts", cuts);
  print("splices", splices);
  for (const Count* count : {&changes, &cuts, &splices})
    if (count->accepted + count->crashes + count->hangs + count->misjudged > 0) return 1;
  return 0;
}
