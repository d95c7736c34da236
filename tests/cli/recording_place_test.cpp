// Places for a recording: used by another recorder, replaced, full, or no regular file. No data is lost silently.
// SPDX-License-Identifier: MIT
//
// Not verified: file systems without locks (NFS without its lock service), and two machines that write one file.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "tests/cli/tool_run.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

/// A recording that waits for live inputs for as long as the test needs.
struct LiveRecording {
  TemporaryFolder folder;
  std::string scene_path = folder.file("three.json");
  std::string pipe_path = folder.file("pipe");
  std::string output = folder.file("live.ttr");
  std::string messages = folder.file("live_messages");
  std::string other_messages = folder.file("other_messages");
  int pipe = -1;
  std::optional<ToolRun> run;

  explicit LiveRecording(const std::function<void()>& prepare = {}, const std::vector<std::string>& options = {}) {
    std::ofstream(scene_path) << pushed_scene;
    REQUIRE(::mkfifo(pipe_path.c_str(), 0666) == 0);
    pipe = ::open(pipe_path.c_str(), O_RDWR | O_CLOEXEC);
    REQUIRE(pipe >= 0);
    std::vector<std::string> words{"record", scene_path, "--inputs", pipe_path, "-o", output};
    words.insert(words.end(), options.begin(), options.end());
    run.emplace(words, messages, prepare);
    send(R"({"tick":10,"kind":"impulse","body":1,"ix":1})");
    // The recording owns its place once the file holds the hashes of the first ticks.
    for (int wait = 0; wait < 100'000; ++wait) {
      const auto reader = replay::TraceReader::open(output);
      if (reader && read_all(read_file(output)).ticks.size() == 10) return;
      ::usleep(1'000);
    }
    FAIL("the recording did not begin");
  }
  LiveRecording(const LiveRecording&) = delete;
  LiveRecording& operator=(const LiveRecording&) = delete;
  ~LiveRecording() { ::close(pipe); }

  void send(const std::string& line) const {
    const std::string text = line + "\n";
    REQUIRE(::write(pipe, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  }
  /// Ends the recording and returns its exit code.
  int end() const {
    send(R"({"tick":20,"kind":"end"})");
    return run->wait();
  }
  std::string text() const { return text_of(messages); }
  /// Makes a second recording to the same place and returns its exit code.
  int record_again(const std::vector<std::string>& options) const {
    std::vector<std::string> words{"record", scene_path, "--ticks", "5", "-o", output};
    words.insert(words.end(), options.begin(), options.end());
    return ToolRun(words, other_messages, {}).wait();
  }
};

std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_CASE("two recordings to one file: the second is refused, with --force too", "[cli][mishaps][corruption]") {
  const LiveRecording live;
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--force"}}) {
    CHECK(live.record_again(options) == 2);
    const std::string text = text_of(live.other_messages);
    CAPTURE(text);
    CHECK(contains(text, "ticktrue: error: " + live.output + ": cannot write: "));
    CHECK(contains(text, " is recording to it"));
#ifdef __linux__
    CHECK(contains(text, "process " + std::to_string(live.run->id()) + " (ticktrue)"));
#endif
  }
  const int recovered = ToolRun({"recover", live.output, "--force", "-o", live.output}, live.other_messages, {}).wait();
  CHECK(recovered == 2);
  CHECK(live.end() == 0);
  const ReadTrace whole = read_all(read_file(live.output));
  CHECK(whole.ticks.size() == 20);
  CHECK(whole.tail.condition == replay::TraceCondition::complete);
  CHECK_FALSE(std::filesystem::exists(live.output + ".old"));
  CHECK(live.record_again({"--force"}) == 0);  // the place is now free
}

TEST_CASE("a file removed, replaced or cut while it is recorded gives an error", "[cli][mishaps][corruption]") {
  struct Row {
    std::function<void(const std::string&)> act;
    const char* text;
  };
  const Row rows[] = {
      {[](const std::string& path) { std::filesystem::remove(path); }, ": was removed while it was written"},
      {[](const std::string& path) { std::filesystem::rename(path, path + ".moved"); },
       ": was removed while it was written"},
      {[](const std::string& path) {
         write_file(path + ".new", Bytes{1, 2, 3});
         std::filesystem::rename(path + ".new", path);
       },
       ": was replaced by another file while it was written"},
      {[](const std::string& path) { std::filesystem::resize_file(path, 0); },
       ": was changed by another program while it was written"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const LiveRecording live;
    row.act(live.output);
    CHECK(live.end() == 2);
    const std::string text = live.text();
    CAPTURE(text);
    CHECK(contains(text, "ticktrue: error: " + live.output + row.text));
    CHECK(contains(text, "\n  record again, to a "));
    CHECK_FALSE(contains(text, "are whole in it"));
    CHECK_FALSE(contains(text, "recorded  "));
  }
  // The file of another program is kept.
  const LiveRecording live;
  write_file(live.output + ".new", Bytes{1, 2, 3});
  std::filesystem::rename(live.output + ".new", live.output);
  live.run->kill(SIGTERM);
  CHECK(live.run->wait() == 2);
  CHECK(read_file(live.output) == Bytes{1, 2, 3});
}

TEST_CASE("the end of the terminal closes a recording, unless nohup asked for more", "[cli][mishaps][analytic]") {
  {
    const LiveRecording live([] { std::signal(SIGHUP, SIG_DFL); });
    live.run->kill(SIGHUP);
    CHECK(live.run->wait() == 0);
    const std::string text = live.text();
    CAPTURE(text);
    CHECK(contains(text, "stopped as asked after 10 ticks; the trace is whole"));
    CHECK(read_all(read_file(live.output)).tail.condition == replay::TraceCondition::complete);
  }
  const LiveRecording live([] { std::signal(SIGHUP, SIG_IGN); });
  live.run->kill(SIGHUP);
  ::usleep(100'000);
  CHECK(live.end() == 0);
  CHECK(read_all(read_file(live.output)).ticks.size() == 20);
}

TEST_CASE("--force onto what is no file is refused, and it stays", "[cli][mishaps][analytic]") {
  const TemporaryFolder folder;
  const std::string messages = folder.file("messages");
  const std::string fifo = folder.file("fifo"), dangling = folder.file("dangling"), inside = folder.file("inside");
  REQUIRE(::mkfifo(fifo.c_str(), 0666) == 0);
  std::filesystem::create_symlink("nowhere", dangling);
  std::filesystem::create_directory(inside);
  const std::vector<std::string> before = files_of(folder.file(""));
  const std::vector<std::pair<std::string, std::string>> rows{
      {fifo, fifo + ": cannot write: found a pipe, expected a file name"},
      {dangling, dangling + ": cannot write: found a link to nowhere, which does not exist, expected a file name"},
      {inside, inside + ": cannot write: found a directory, expected a file name"},
      {"", "output: found an empty name, expected a file name"},
      {"/dev/null", "/dev/null: cannot write: found a device, expected a file name"}};
  const std::string source = folder.file("source.ttr");
  REQUIRE(ToolRun({"record", "stack", "--ticks", "3", "-o", source}, messages, {}).wait() == 0);
  for (const auto& [path, text] : rows) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"record", "stack", "--ticks", "3"}, {"recover", source}}) {
      std::vector<std::string> whole = words;
      whole.insert(whole.end(), {"--force", "-o", path});
      CAPTURE(path, words[0]);
      CHECK(ToolRun(whole, messages, {}).wait() == 2);
      INFO(text_of(messages));
      CHECK(contains(text_of(messages), "ticktrue: error: " + text));
    }
  }
  std::filesystem::remove(source);
  std::filesystem::remove(messages);
  CHECK(files_of(folder.file("")) == before);
  CHECK(std::filesystem::is_fifo(fifo));
}

TEST_CASE("a disk without room for one tick: no file is left, and an overwritten one is back",
          "[cli][mishaps][corruption]") {
  const TemporaryFolder folder;
  const std::string messages = folder.file("messages");
  const std::string path = folder.file("x.ttr");
  REQUIRE(ToolRun({"record", "stack", "--ticks", "1", "--detail", "root", "-o", path}, messages, {}).wait() == 0);
  const std::size_t tick_end = read_file(path).size();
  std::filesystem::remove(path);
  int left_count = 0;
  for (std::size_t size = 0; size < tick_end; size += 1 + tick_end / 40) {
    CAPTURE(size);
    const auto record = [&](const std::vector<std::string>& options) {
      std::vector<std::string> words{"record", "stack", "--ticks", "300", "--detail", "root", "-o", path};
      words.insert(words.end(), options.begin(), options.end());
      return ToolRun(words, messages,
                     [size] {
                       std::signal(SIGXFSZ, SIG_IGN);
                       const rlimit limit{size, size};
                       ::setrlimit(RLIMIT_FSIZE, &limit);
                     })
          .wait();
    };
    // Messages go to a file as well, so they may be truncated on a nearly full disk.
    CHECK(record({}) == 2);
    if (std::filesystem::exists(path)) {
      const ReadTrace part = read_all(read_file(path));
      CHECK(part.ticks.size() > 0);
      ++left_count;
    }
    std::filesystem::remove(path);
    write_file(path, Bytes{1, 2, 3});
    CHECK(record({"--force"}) == 2);
    if (!std::filesystem::exists(path + ".old")) CHECK(read_file(path) == Bytes{1, 2, 3});
    std::filesystem::remove(path);
    std::filesystem::remove(path + ".old");
  }
  CHECK(left_count < 10);
}

TEST_CASE("a full disk with no whole tick is told as that", "[cli][mishaps][corruption]") {
  const TemporaryFolder folder;
  const std::string disk = folder.file("disk");
  std::filesystem::create_directory(disk);
  const std::string mount = "mount -t tmpfs -o size=4k none " + disk + " 2> /dev/null";
  if (std::system(mount.c_str()) != 0) {
    WARN("not run: a small disk cannot be mounted here");
    return;
  }
  const std::string messages = folder.file("messages");
  // The state in its checkpoint does not fit on the disk.
  const int code =
      ToolRun({"record", "mixed_pile?bodies=1000", "--ticks", "10", "-o", disk + "/x.ttr"}, messages, {}).wait();
  const std::vector<std::string> left = files_of(disk);
  const std::string unmount = "umount " + disk;
  CHECK(std::system(unmount.c_str()) == 0);
  const std::string text = text_of(messages);
  CAPTURE(text);
  CHECK(code == 2);
  CHECK(left.empty());
  CHECK(contains(text, "ticktrue: error: " + disk + "/x.ttr: cannot write: No space left on device"));
  CHECK(contains(text, "make room or write to another disk; no tick was recorded: no file was left behind"));
}

TEST_CASE("recover of a file that changes meanwhile is an error, never an assertion", "[cli][mishaps][corruption]") {
  const TemporaryFolder folder;
  const std::string messages = folder.file("messages"), path = folder.file("x.ttr"), saved = folder.file("y.ttr");
  const auto recorded = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{"record", "stack?boxes=4", "--ticks", "4000", "--force", "-o", path};
    words.insert(words.end(), options.begin(), options.end());
    REQUIRE(ToolRun(words, messages, {}).wait() == 0);
    return read_file(path);
  };
  // Two damaged traces with different setups and checkpoints. A reader that mixes them must notice.
  Bytes one = recorded({"--detail", "full:0..3000"}),
        other = recorded({"--detail", "root", "--checkpoint-interval", "7"});
  const Bytes good = one;
  one[one.size() / 2] ^= 1;
  other[other.size() / 3] ^= 1;
  int changed_count = 0;
  std::atomic<bool> is_over{false};
  std::thread writer([&] {
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    for (bool first = true; !is_over; first = !first) {
      const Bytes& bytes = first ? one : other;
      // Written in one call, so that the reader mostly opens a file that begins like a trace.
      if (::pwrite(file, bytes.data(), bytes.size(), 0) < 0) break;
      if (::ftruncate(file, static_cast<off_t>(bytes.size())) != 0) break;
    }
    ::close(file);
  });
  for (int round = 0; round < 200 && changed_count < 20; ++round) {
    const int code = ToolRun({"recover", path, "--force", "-o", saved}, messages, {}).wait();
    const std::string text = text_of(messages);
    CAPTURE(round, code, text);
    const bool is_known = code == 0 || code == 2 || code == 3 || code == 4;
    if (!is_known || contains(text, "assertion")) FAIL_CHECK("recover of a file that changes");
    if (contains(text, ": changed while it was read: ")) {
      CHECK(code == 2);
      ++changed_count;
    }
  }
  is_over = true;
  writer.join();
  CHECK(changed_count > 0);
}

}  // namespace ticktrue::test
