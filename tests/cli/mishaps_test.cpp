// A killed recording, a full disk and a read-only folder: each is reported plainly, and earlier ticks are safe.
// SPDX-License-Identifier: MIT
//
// Verified: every input and hash before a kill or a full disk equals that of an undisturbed recording, including the
// inputs of the current tick.
// Not verified: loss of power (the operating system keeps data that was written).
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "tests/cli/tool_run.h"

namespace ticktrue::test {
namespace {

/// Inputs for `tick_count` ticks. Every third tick has an input that could be lost.
void write_inputs(const std::string& path, std::uint64_t tick_count) {
  std::ofstream out(path);
  for (std::uint64_t tick = 1; tick < tick_count; tick += 3)
    out << R"({"tick":)" << tick << R"(,"kind":"impulse","body":)" << 1 + tick % 3 << R"(,"ix":)" << tick % 5 << "}\n";
  out << R"({"tick":)" << tick_count << R"(,"kind":"end"})"
      << "\n";
}

/// Checks that the partial recording holds ticks of the undisturbed recording, and the inputs of the next tick.
void require_part_of(const ReadTrace& part, const ReadTrace& whole) {
  REQUIRE(part.ticks.size() <= whole.ticks.size());
  for (std::size_t i = 0; i < part.ticks.size(); ++i) REQUIRE(part.ticks[i] == whole.ticks[i]);
  for (std::size_t i = 0; i < part.checkpoints.size(); ++i) REQUIRE(part.checkpoints[i] == whole.checkpoints[i]);
  if (part.tail.has_pending_inputs && part.ticks.size() < whole.ticks.size())
    REQUIRE(part.tail.pending_inputs == whole.ticks[part.ticks.size()].inputs);
}

/// A session on disk, and its undisturbed recording.
struct RecordedSession {
  static constexpr std::uint64_t tick_count = 6'000;
  TemporaryFolder folder;
  std::string scene_path = folder.file("three.json");
  std::string inputs_path = folder.file("inputs.jsonl");
  std::string output = folder.file("disturbed.ttr");
  std::string messages = folder.file("messages");
  ReadTrace whole;
  std::size_t whole_size = 0;

  RecordedSession() {
    std::ofstream(scene_path) << pushed_scene;
    write_inputs(inputs_path, tick_count);
    const std::string path = folder.file("whole.ttr");
    const int code = ToolRun(words(path), messages, {}).wait();
    INFO(text_of(messages));
    REQUIRE(code == 0);
    const Bytes bytes = read_file(path);
    whole_size = bytes.size();
    whole = read_all(bytes);
    REQUIRE(whole.ticks.size() == tick_count);
  }
  std::vector<std::string> words(const std::string& path) const {
    return {"record", scene_path, "--inputs", inputs_path, "--checkpoint-interval", "500", "-o", path, "--force"};
  }
};

}  // namespace

TEST_CASE("a recording killed at any moment keeps every earlier input and hash", "[cli][mishaps][corruption]") {
  const RecordedSession session;
  std::uint64_t state = 1;
  int killed_count = 0;
  for (int round = 0; round < 20; ++round) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::size_t size = (state >> 33) % session.whole_size;
    CAPTURE(round, size);
    ::unlink(session.output.c_str());
    const ToolRun run(session.words(session.output), session.messages, {});
    // Kills the recording when the file has this size: within a tick, a checkpoint or the setup.
    struct stat now {};
    for (int wait = 0; wait < 100'000; ++wait) {
      if (::stat(session.output.c_str(), &now) == 0 && static_cast<std::size_t>(now.st_size) >= size) break;
      ::usleep(100);
    }
    run.kill();
    killed_count += run.wait() == -1 ? 1 : 0;
    const Bytes left = read_file(session.output);
    const auto reader = replay::TraceReader::open_bytes(left, "left.ttr");
    if (!reader) {
      REQUIRE(reader.error().code == ErrorCode::truncated);
      continue;
    }
    const ReadTrace part = read_all(left);
    REQUIRE(part.tail.condition != replay::TraceCondition::damaged);
    require_part_of(part, session.whole);

    const std::string saved = session.folder.file("saved.ttr");
    const auto result = replay::recover_trace(session.output, saved, true);
    REQUIRE(result);
    REQUIRE(result->ticks_written == part.ticks.size());
    if (part.ticks.empty()) continue;
    REQUIRE(ToolRun({"verify", saved}, session.messages, {}).wait() == 0);
  }
  CHECK(killed_count >= 15);
}

TEST_CASE("a full disk ends a recording with one line, and every earlier tick is safe", "[cli][mishaps][corruption]") {
  const RecordedSession session;
  for (const std::size_t size : {std::size_t{300}, std::size_t{700}, session.whole_size / 3, session.whole_size - 1}) {
    CAPTURE(size);
    ::unlink(session.output.c_str());
    const int code = ToolRun(session.words(session.output), session.messages, [size] {
                       // Simulates a disk with this much space: a write beyond the limit fails.
                       std::signal(SIGXFSZ, SIG_IGN);
                       const rlimit limit{size, size};
                       ::setrlimit(RLIMIT_FSIZE, &limit);
                     }).wait();
    const std::string text = text_of(session.messages);
    CAPTURE(text);
    CHECK(code == 2);
    CHECK(text.find("ticktrue: error: " + session.output + ": ") != std::string::npos);
    CHECK(text.find("File too large") != std::string::npos);
    const Bytes left = read_file(session.output);
    CHECK(left.size() <= size);
    if (size < 1'000) continue;
    const ReadTrace part = read_all(left);
    CHECK(part.ticks.size() + 500 > session.tick_count * size / session.whole_size);
    require_part_of(part, session.whole);
  }
}

TEST_CASE("a place that may not be written to is told, and nothing there changes", "[cli][mishaps][analytic]") {
  const RecordedSession session;
  const std::string locked = session.folder.file("locked");
  REQUIRE(::mkdir(locked.c_str(), 0555) == 0);
  const std::string inside = locked + "/x.ttr";
  const std::string messages = session.folder.file("locked_messages");
  std::ofstream{messages};
  for (const std::string& path : {session.folder.file(""), messages}) REQUIRE(::chmod(path.c_str(), 0777) == 0);
  const int code = ToolRun(session.words(inside), messages, [] {
                     // root may write everywhere, so the tool runs as nobody.
                     if (::getuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(126);
                   }).wait();
  const std::string text = text_of(messages);
  CAPTURE(text);
  if (code == 126 || code == 127) {
    WARN("not run: the tool cannot be started as another user");
    return;
  }
  CHECK(code == 2);
  CHECK(text.find("ticktrue: error: " + inside + ": cannot create: Permission denied") != std::string::npos);
  CHECK(text.find("choose a place you may write to") != std::string::npos);
  struct stat found {};
  CHECK(::stat(inside.c_str(), &found) != 0);
}

}  // namespace ticktrue::test
