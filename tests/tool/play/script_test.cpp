// Scripts of a person: accepted lines, and refused lines with their number.
// SPDX-License-Identifier: MIT
#include "tool/play/script.h"

#include "tests/support/catch.h"

namespace ticktrue {
namespace {

TEST_CASE("a script gives its events in order, a click as press and release", "[play][script]") {
  const auto events = play::parse_script(R"({"t":0.5,"event":"click","button":"right","x":1,"y":2,"ctrl":true}

{"t":1,"event":"wheel","x":3,"y":4,"steps":-2}
{"t":1,"event":"key","key":"space"}
{"t":2,"event":"quit"}
)",
                                         "s");
  REQUIRE(events);
  REQUIRE(events->size() == 5);
  CHECK((*events)[0].kind == play::EventKind::press);
  CHECK((*events)[0].button == play::Button::right);
  CHECK((*events)[0].ctrl);
  CHECK((*events)[1].kind == play::EventKind::release);
  CHECK((*events)[2].steps == -2);
  CHECK((*events)[3].key == "space");
  CHECK((*events)[4].at_s == 2);
}

TEST_CASE("a wrong line of a script is told with its place", "[play][script][corruption]") {
  const std::pair<const char*, const char*> rows[] = {
      {"{\"t\":1,\"event\":\"key\"}", "s:1: key: found none, expected a text"},
      {"nonsense", "s:1: found a line that is no JSON"},
      {"[1]", "s:1: line: found something else, expected one JSON object"},
      {"{\"event\":\"quit\"}", "s:1: t: found none, expected a number"},
      {"{\"t\":-1,\"event\":\"quit\"}", "s:1: t: found -1, expected a number in 0.0..1000000.0"},
      {"{\"t\":1,\"event\":\"jump\"}", "s:1: event: found \"jump\""},
      {"{\"t\":1,\"event\":\"move\",\"x\":1}", "s:1: y: found none"},
      {"{\"t\":1,\"event\":\"move\",\"x\":\"a\",\"y\":1}", "s:1: x: found \"a\", expected a number"},
      {"{\"t\":1,\"event\":\"move\",\"x\":1,\"y\":1,\"z\":1}", "s:1: z: found a key that move has not"},
      {"{\"t\":1,\"event\":\"press\",\"x\":1,\"y\":1,\"button\":\"fourth\"}", "s:1: button: found \"fourth\""},
      {"{\"t\":2,\"event\":\"quit\"}\n{\"t\":1,\"event\":\"quit\"}", "s:2: t: found a time before"},
  };
  for (const auto& [text, message] : rows) {
    const auto events = play::parse_script(text, "s");
    CAPTURE(text);
    REQUIRE_FALSE(events);
    CHECK(events.error().code == ErrorCode::invalid_input);
    CAPTURE(events.error().message);
    CHECK(events.error().message.rfind(message, 0) == 0);
  }
}

TEST_CASE("every event of a script is given once, in the frame in which its time lies", "[play][script]") {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "{\"t\":" + std::to_string(i * 0.0123) + ",\"event\":\"key\",\"key\":\"x\"}\n";
  const auto events = play::parse_script(text, "s");
  REQUIRE(events);
  const auto host = play::no_display(60);
  play::ScriptedHost scripted(*host, *events, 90);
  const play::Canvas picture(1, 1);
  double begin = 0;
  std::size_t count = 0;
  while (true) {
    const auto frame = scripted.next(picture);
    REQUIRE(frame);
    for (const play::Event& event : frame->events) {
      if (event.kind == play::EventKind::quit) continue;
      CHECK(begin + event.at_s == Approx(static_cast<double>(count) * 0.0123).margin(1e-6));
      ++count;
    }
    begin += frame->seconds;
    if (!frame->events.empty() && frame->events.back().kind == play::EventKind::quit) break;
  }
  CHECK(count == 100);
  CHECK(scripted.frames_done() == 90);
}

}  // namespace
}  // namespace ticktrue
