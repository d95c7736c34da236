// A trace plays forwards and backwards, is compared tick by tick, and stops where it diverges.
// SPDX-License-Identifier: MIT
#include "tool/play/player.h"

#include <fstream>

#include "tests/support/catch.h"
#include "tests/tool/play/playing.h"
#include "tool/play/playback.h"

namespace ticktrue {
namespace {

const auto never = [] { return false; };

std::unique_ptr<play::Player> open_player(const std::string& path) {
  auto player = play::Player::open(path);
  if (!player) FAIL(player.error().message);
  return std::move(*player);
}

tool::TraceChoices choices_of(replay::Detail detail, std::uint32_t interval) {
  tool::TraceChoices choices;
  choices.detail = detail;
  choices.full_last = detail == replay::Detail::full ? UINT64_MAX : 0;
  choices.checkpoint_interval = interval;
  return choices;
}

constexpr std::uint64_t no_flip = UINT64_MAX;

TEST_CASE("wherever a trace is sought, the state is the recorded one", "[play][player]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("a.ttr");
  test::record_flipped(test::builtin_scene("pyramid?base=5"), 400, no_flip, 0, choices_of(replay::Detail::root, 90),
                       path);
  const auto player = open_player(path);
  REQUIRE(player->tick_count() == 400);
  CHECK(player->checkpoints() == std::vector<std::uint64_t>{0, 90, 180, 270, 360});
  for (const std::uint64_t target : {1, 37, 36, 0, 399, 400, 200, 199, 198, 90, 271, 5, 400, 360, 0}) {
    player->go_to(target, true, never);
    CAPTURE(target);
    REQUIRE(player->position() == target);
    CHECK(player->engine().tick() == target);
    if (target > 0) CHECK(root_hash(player->engine().state()) == player->recorded_hash(target - 1));
  }
  CHECK_FALSE(player->difference());
}

TEST_CASE("a seek to a far tick begins at a checkpoint and leaves what lies between unknown", "[play][player]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("a.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=3"), 400, no_flip, 0, choices_of(replay::Detail::root, 100),
                       path);
  const auto player = open_player(path);
  player->go_to(310, true, never);
  CHECK(player->match(0) == play::Match::unknown);
  CHECK(player->match(299) == play::Match::unknown);
  CHECK(player->match(300) == play::Match::same);
  CHECK(player->match(309) == play::Match::same);
  CHECK(player->match(310) == play::Match::unknown);
}

TEST_CASE("a long way is run in pieces", "[play][player]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("a.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=3"), 200, no_flip, 0, choices_of(replay::Detail::root, 0),
                       path);
  const auto player = open_player(path);
  int ticks = 0;
  for (int piece = 1; piece <= 4; ++piece) {
    player->go_to(200, true, [&] { return ++ticks % 50 == 0; });
    CHECK(player->position() == 50u * static_cast<unsigned>(piece));
  }
}

TEST_CASE("a divergence stops the player, and the verifier names the body whose bit was flipped",
          "[play][divergence]") {
  const test::TemporaryDirectory directory;
  for (const replay::Detail detail : {replay::Detail::full, replay::Detail::cells}) {
    const std::string path = directory.file("bad.ttr");
    test::record_flipped(test::builtin_scene("pyramid?base=4"), 240, 130, 5, choices_of(detail, 50), path);
    const auto player = open_player(path);
    CHECK(player->report() == nullptr);
    CHECK(player->search(never));
    REQUIRE(player->difference());
    CHECK(*player->difference() == 130);
    CHECK(player->position() == 131);
    CHECK(player->named_bodies() == std::vector<std::uint32_t>{5});
    REQUIRE(player->report()->divergence);
    CHECK(player->report()->divergence->tick == 130);
    CHECK((player->recorded_image() != nullptr) == (detail == replay::Detail::full));
    // If the state is not stored, a search finds the single bit that explains the recorded hash.
    REQUIRE(player->report()->divergence->rows.size() == 1);
    const verifier::LaneReport& row = player->report()->divergence->rows[0];
    CHECK(row.column == "velocity");
    CHECK(*row.expected != *row.got);
    // After the divergence, this run continues. No checkpoint of the other run is loaded.
    player->go_to(240, true, never);
    CHECK(player->position() == 240);
    const std::uint64_t end = root_hash(player->engine().state());
    player->go_to(100, true, never);
    player->go_to(240, true, never);
    CHECK(root_hash(player->engine().state()) == end);
    std::filesystem::remove(path);
  }
}

TEST_CASE("of a cut trace what is intact plays; what is no trace is refused", "[play][player][corruption]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("a.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=3"), 200, no_flip, 0, choices_of(replay::Detail::root, 50),
                       path);
  const std::string bytes = test::file_bytes(path);
  const auto write = [&](const std::string& text) { std::ofstream(directory.file("b.ttr"), std::ios::binary) << text; };
  write(bytes.substr(0, bytes.size() * 3 / 4));
  const auto cut = open_player(directory.file("b.ttr"));
  CHECK(cut->tail().condition == replay::TraceCondition::truncated);
  REQUIRE(cut->tick_count() > 20);
  cut->go_to(cut->tick_count(), true, never);
  CHECK(cut->position() == cut->tick_count());
  CHECK_FALSE(cut->difference());
  write("no trace at all");
  const auto refused = play::Player::open(directory.file("b.ttr"));
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::corrupt);
  const auto missing = play::Player::open(directory.file("c.ttr"));
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == ErrorCode::io);
}

// --- the person -----------------------------------------------------------------------------------------------------

play::HostFrame frame_with(const std::vector<play::Event>& events, double seconds = 1.0 / 60) {
  play::HostFrame frame;
  frame.seconds = seconds;
  frame.events = events;
  return frame;
}
play::Event key(const std::string& name) {
  play::Event event;
  event.kind = play::EventKind::key;
  event.key = name;
  return event;
}
play::Event mouse(play::EventKind kind, double x, double y) {
  play::Event event;
  event.kind = kind;
  event.x = x;
  event.y = y;
  return event;
}

TEST_CASE("keys and timeline lead where they say", "[play][playback]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("a.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=3"), 300, no_flip, 0, choices_of(replay::Detail::root, 100),
                       path);
  const auto player = open_player(path);
  play::Playback playback(*player, nullptr, play::first_view(player->engine(), 800, 600), {});
  const auto press = [&](const std::string& name) {
    playback.take(frame_with({key(name)}), never);
    return player->position();
  };
  for (int i = 0; i < 30; ++i) playback.take(frame_with({}), never);
  CHECK(player->position() == Approx(30).margin(1));  // plays at the speed of time
  press("space");
  const std::uint64_t here = player->position();
  CHECK(press("space") >= here);
  CHECK(press("home") == 0);
  CHECK(press(".") == 1);
  CHECK(press(".") == 2);
  CHECK(press(",") == 1);
  CHECK(press("right") == 61);
  CHECK(press("left") == 1);
  CHECK(press("page down") == 100);
  CHECK(press("page down") == 200);
  CHECK(press("page up") == 100);
  CHECK(press("end") == 300);
  CHECK_FALSE(playback.is_playing());

  const play::Timeline timeline = play::Timeline::of(playback.view());
  const double y = (timeline.top + timeline.bottom) / 2;
  playback.take(frame_with({mouse(play::EventKind::press, (timeline.left + timeline.right) / 2, y)}), never);
  CHECK(player->position() == 150);
  playback.take(frame_with({mouse(play::EventKind::move, timeline.left - 50, y)}), never);
  CHECK(player->position() == 0);
  playback.take(frame_with({mouse(play::EventKind::release, timeline.left, y)}), never);
  playback.take(frame_with({mouse(play::EventKind::move, timeline.right, y)}), never);
  CHECK(player->position() == 0);
  CHECK_FALSE(playback.wants_quit());
  press("q");
  CHECK(playback.wants_quit());
}

TEST_CASE("playing stops at the divergence, goes on when asked, and d leads back to it", "[play][playback]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("bad.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=4"), 120, 60, 2, choices_of(replay::Detail::cells, 50), path);
  const auto player = open_player(path);
  play::Playback playback(*player, nullptr, play::first_view(player->engine(), 800, 600), {});
  for (int i = 0; i < 200; ++i) playback.take(frame_with({}), never);
  CHECK(player->position() == 61);
  CHECK_FALSE(playback.is_playing());
  playback.take(frame_with({key("space")}), never);
  for (int i = 0; i < 200; ++i) playback.take(frame_with({}), never);
  CHECK(player->position() == 120);
  playback.take(frame_with({key("d")}), never);
  CHECK(player->position() == 61);
}

TEST_CASE("d finds the first difference from anywhere, also behind it", "[play][playback]") {
  const test::TemporaryDirectory directory;
  const std::string path = directory.file("bad.ttr");
  test::record_flipped(test::builtin_scene("stack?boxes=4"), 400, 130, 2, choices_of(replay::Detail::cells, 50), path);
  const auto player = open_player(path);
  play::Playback playback(*player, nullptr, play::first_view(player->engine(), 800, 600), {});
  playback.take(frame_with({key("end")}), never);
  CHECK(player->position() == 400);
  CHECK_FALSE(player->difference());  // it was skipped
  int calls = 0;
  const auto late = [&] { return ++calls % 20 == 0; };
  playback.take(frame_with({key("d")}), late);
  CHECK(playback.is_seeking());
  for (int i = 0; i < 20; ++i) playback.take(frame_with({}), late);
  CHECK_FALSE(playback.is_seeking());
  REQUIRE(player->difference());
  CHECK(*player->difference() == 130);
  CHECK(player->position() == 131);
}

TEST_CASE("a second trace is kept at the same tick", "[play][playback]") {
  const test::TemporaryDirectory directory;
  test::record_flipped(test::builtin_scene("stack?boxes=3"), 100, no_flip, 0, choices_of(replay::Detail::root, 0),
                       directory.file("a.ttr"));
  test::record_flipped(test::builtin_scene("stack?boxes=3&substeps=8"), 80, no_flip, 0,
                       choices_of(replay::Detail::root, 0), directory.file("b.ttr"));
  const auto one = open_player(directory.file("a.ttr"));
  const auto other = open_player(directory.file("b.ttr"));
  play::Playback playback(*one, other.get(), play::first_view(one->engine(), 800, 600), {});
  playback.take(frame_with({key("right")}), never);
  CHECK(one->position() == 60);
  CHECK(other->position() == 60);
  playback.take(frame_with({key("end")}), never);
  CHECK(one->position() == 100);
  CHECK(other->position() == 80);  // the end of the trace
}

}  // namespace
}  // namespace ticktrue
