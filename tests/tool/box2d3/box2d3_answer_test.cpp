// The answer of the child process that runs Box2D 3: damage of every kind is an error and never a result.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_answer.h"

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/box2d3.h"
#include "tests/support/scenes.h"
#include "tool/crosscheck/crosscheck.h"
#include "verifier/runs/run_folder.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

using Catch::Matchers::Contains;

// Of a scene with a ground and one box, two ticks, contacts after the last.
const std::string good_head = R"({"schema":"ticktrue.box2d3/1","package":"5.2.0"})";
const std::string good_first = R"({"tick":1,"bodies":[1,0,0.5,1,0,0,0,0]})";
const std::string good_second =
    R"({"tick":2,"bodies":[1,0,0.5,1,0,0,0,0],"contacts":[0,1,0,1,2,-0.5,0,-0.1,5,0.5,0,0,5]})";
const std::string good_end = R"({"done":true,"clamped_tick":0,"ms_per_tick":0.5})";

tool::Box2d3Plan two_ticks() {
  tool::Box2d3Plan plan;
  plan.tick_count = 2;
  plan.contact_window = 1;
  return plan;
}

std::string lines_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string damage_found(const std::string& text) {
  const auto answer = tool::read_box2d3_answer(text, stack_scene(1), two_ticks());
  if (answer) return {};
  CHECK(answer.error().code == ErrorCode::corrupt);
  return answer.error().message;
}

// A folder with a program `node` that is a shell script, and with a package that has only its description.
class FakeNode {
 public:
  explicit FakeNode(const std::string& script) : folder_(*verifier::RunFolder::make("ticktrue-fake-node", "")) {
    namespace fs = std::filesystem;
    fs::create_directories(path() / "node_modules" / "box2d3-wasm");
    std::ofstream(path() / "node_modules" / "box2d3-wasm" / "package.json") << R"({"version": "1.2.3"})";
    std::ofstream(path() / "node") << "#!/bin/sh\nif [ \"$1\" = --version ]; then exit 0; fi\n" << script << "\n";
    fs::permissions(path() / "node", fs::perms::owner_all);
  }
  std::filesystem::path path() const { return folder_.path(); }

 private:
  verifier::RunFolder folder_;
};

Error failure_with(const std::string& script, const tool::Box2d3Options& options = {}) {
  const FakeNode fake(script);
  const Variable folder(tool::box2d3_variable, fake.path().string());
  const Variable path("PATH", fake.path().string() + ":/usr/bin:/bin");
  const auto peer = tool::make_box2d3_peer(stack_scene(1), options, two_ticks());
  if (peer) FAIL("a damaged answer made a peer");
  return peer.error();
}

}  // namespace

TEST_CASE("a good answer of Box2D 3 is read whole", "[verifier][crosscheck][box2d3]") {
  const auto answer =
      tool::read_box2d3_answer(lines_of({good_head, good_first, good_second, good_end}), stack_scene(1), two_ticks());
  if (!answer) FAIL(answer.error().message);
  CHECK(answer->package == "5.2.0");
  REQUIRE(answer->ticks.size() == 2);
  REQUIRE(answer->ticks[1].contacts.size() == 1);
  CHECK(answer->ticks[1].contacts[0].separation[0] == -0.1);
  CHECK(answer->ticks[1].contacts[0].force[1] == 5);
  CHECK(answer->ms_per_tick == 0.5);
}

TEST_CASE("an answer of Box2D 3 with any line damaged is refused with its place",
          "[verifier][crosscheck][box2d3][corruption]") {
  CHECK(damage_found(lines_of({good_head, good_first, good_second, good_end})).empty());
  CHECK_THAT(damage_found(""), Contains("line 1"));
  CHECK_THAT(damage_found("hello\n"),
             Contains("box2d3: the answer of node: line 1: not an object of known keys: found \"hello\""));
  CHECK_THAT(damage_found(lines_of({"{}", good_first, good_second, good_end})), Contains("the head"));
  CHECK_THAT(damage_found(lines_of({good_head, good_second, good_first, good_end})), Contains("expected tick 1"));
  CHECK_THAT(damage_found(lines_of({good_head, good_first, good_end})), Contains("expected tick 2"));
  CHECK_THAT(damage_found(lines_of({good_head, good_first, good_second})), Contains("expected the end"));
  CHECK_THAT(damage_found(lines_of({good_head, good_first, good_second, good_end, "x"})), Contains("expected nothing"));
  CHECK_THAT(damage_found(lines_of({good_head, good_first, good_second, good_end}) + "x"),
             Contains("expected nothing"));
  const std::string whole = lines_of({good_head, good_first, good_second, good_end});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    INFO(size << " bytes");
    CHECK_FALSE(damage_found(whole.substr(0, size)).empty());
  }
  const auto first_with = [&](const std::string& bodies) {
    return damage_found(lines_of({good_head, R"({"tick":1,"bodies":)" + bodies + "}", good_second, good_end}));
  };
  CHECK(first_with("[]").empty());                         // the box was removed
  CHECK_FALSE(first_with("[1,0,0.5,1,0,0,0]").empty());    // a number is missing
  CHECK_FALSE(first_with("[0,0,0.5,1,0,0,0,0]").empty());  // the ground is static
  CHECK_FALSE(first_with("[2,0,0.5,1,0,0,0,0]").empty());  // no such body
  CHECK_FALSE(first_with("[-1,0,0.5,1,0,0,0,0]").empty());
  CHECK_FALSE(first_with("[1.5,0,0.5,1,0,0,0,0]").empty());
  CHECK_FALSE(first_with("[1,null,0.5,1,0,0,0,0]").empty());  // as JSON writes what is not finite
  CHECK_FALSE(first_with("[1,1e999,0.5,1,0,0,0,0]").empty());
  CHECK_FALSE(first_with("[1,0,0,1,0,0,0,0,1,0,0,1,0,0,0,0]").empty());  // the same body twice
  CHECK_FALSE(first_with("{}").empty());
  // A list ends at its limit, and nothing but lists of numbers is stored: two bodies have sixteen numbers.
  const std::string sixteen = "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0";
  CHECK_THAT(first_with("[" + sixteen + "]"), Contains("the tick"));
  for (const std::string& line :
       {"[" + sixteen + ",0]", std::string("[[0]]"), std::string("{\"a\":0}"), std::string("[0,\"a\"]"),
        std::string("[true]"), std::string("[],\"bodies\":[]"), std::string("[],\"else\":[]")}) {
    INFO(line);
    CHECK_THAT(first_with(line), Contains("not an object of known keys"));
  }
  const auto contacts_with = [&](const std::string& contacts) {
    const std::string second = R"({"tick":2,"bodies":[],"contacts":)" + contacts + "}";
    return damage_found(lines_of({good_head, good_first, second, good_end}));
  };
  CHECK(contacts_with("[]").empty());
  CHECK_FALSE(contacts_with("[0,1,0,1,3,0,0,0,0,0,0,0,0]").empty());  // three points
  CHECK_FALSE(contacts_with("[0,7,0,1,1,0,0,0,0,0,0,0,0]").empty());
  CHECK_FALSE(contacts_with("[0,1,0,1,1,0,0,0]").empty());
  CHECK_FALSE(contacts_with("null").empty());
  CHECK_THAT(damage_found(
                 lines_of({good_head, good_first, good_second, R"({"done":true,"clamped_tick":3,"ms_per_tick":0.5})"})),
             Contains("the end"));
}

TEST_CASE("a child that fails, hangs, prints too much or is killed gives an error line",
          "[verifier][crosscheck][box2d3][corruption]") {
  const Error status = failure_with("echo 'box2d3: no wasm' >&2; exit 3");
  CHECK(status.code == ErrorCode::io);
  CHECK(status.message == "box2d3: node ended with status 3, expected 0");
  CHECK(status.hint == "box2d3: no wasm");
  CHECK_THAT(failure_with("kill -9 $$").message, Contains("was killed by signal 9"));
  tool::Box2d3Options quick;
  quick.time_max_s = 1;
  CHECK_THAT(failure_with("exec sleep 60", quick).message, Contains("did not end within 1 s"));
  tool::Box2d3Options small;
  small.answer_size_max = 10000;
  const Error too_long = failure_with("exec yes", small);
  CHECK(too_long.code == ErrorCode::io);
  CHECK_THAT(too_long.message, Contains("printed more than"));
  const Error not_json = failure_with("echo 'Segmentation fault'");
  CHECK(not_json.code == ErrorCode::corrupt);
  CHECK_THAT(not_json.message, Contains("not an object of known keys"));

  // The cross-check of such a child ends with the error: it has no report, and so no verdict.
  const FakeNode fake("echo nonsense");
  const Variable folder(tool::box2d3_variable, fake.path().string());
  const Variable path("PATH", fake.path().string() + ":/usr/bin:/bin");
  tool::CrosscheckOptions options;
  options.peer = tool::PeerKind::box2d3;
  options.seed_count = 1;
  options.seconds = 1;
  const auto report = tool::crosscheck(stack_scene(1), options);
  REQUIRE_FALSE(report);
  CHECK(report.error().code == ErrorCode::corrupt);
}

TEST_CASE("an answer that would be too large is refused before node starts", "[verifier][crosscheck][box2d3]") {
  const FakeNode fake("exit 3");
  const Variable folder(tool::box2d3_variable, fake.path().string());
  tool::Box2d3Plan plan;
  plan.tick_count = 100'000'000;
  const auto peer = tool::make_box2d3_peer(stack_scene(1), {}, plan);
  REQUIRE_FALSE(peer);
  CHECK(peer.error().code == ErrorCode::limit);
  CHECK_THAT(peer.error().message, Contains("expected at most 256 MiB"));
}

TEST_CASE("without node or package, the message says how to get them", "[verifier][crosscheck][box2d3]") {
  const FakeNode fake("exit 0");
  {
    const Variable folder(tool::box2d3_variable, "/nowhere");
    const auto version = tool::box2d3_version();
    REQUIRE_FALSE(version);
    CHECK(version.error().message ==
          "box2d3 needs node and npm's box2d3-wasm: TICKTRUE_BOX2D3: found no node_modules/box2d3-wasm in "
          "\"/nowhere\", expected one");
    CHECK_THAT(version.error().hint, Contains("./dev setup box2d3"));
  }
  const Variable folder(tool::box2d3_variable, fake.path().string());
  {
    const Variable path("PATH", fake.path().string());
    CHECK(*tool::box2d3_version() == "3 (box2d3-wasm 1.2.3)");
  }
  const Variable path("PATH", "/nowhere");
  const auto version = tool::box2d3_version();
  REQUIRE_FALSE(version);
  CHECK_THAT(version.error().message, Contains("box2d3 needs node and npm's box2d3-wasm: node cannot be started"));
  CHECK_FALSE(tool::make_box2d3_peer(stack_scene(1), {}, two_ticks()));
}

TEST_CASE("a program that the variable names answers in place of node", "[verifier][crosscheck][box2d3]") {
  const FakeNode fake("exit 3");
  const std::string program = (fake.path() / "own_box2d3").string();
  std::ofstream(program) << "#!/bin/sh\nif [ \"$1\" = --version ]; then echo 3.9.9; exit; fi\ncat << 'END'\n"
                         << lines_of({good_head, good_first, good_second, good_end}) << "END\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  {
    const Variable folder(tool::box2d3_variable, fake.path().string());
    CHECK(tool::box2d3_runs_in_node());
  }
  const Variable named(tool::box2d3_variable, program);
  CHECK_FALSE(tool::box2d3_runs_in_node());
  CHECK(*tool::box2d3_version() == "3 (native 3.9.9)");
  auto peer = tool::make_box2d3_peer(stack_scene(1), {}, two_ticks());
  if (!peer) FAIL(peer.error().message);
  (*peer)->step();
  CHECK((*peer)->bodies()[1].center.y == 0.5);
  CHECK((*peer)->ms_per_tick() == 0.5);
  std::ofstream(program) << "#!/bin/sh\necho nonsense\n";
  const auto damaged = tool::make_box2d3_peer(stack_scene(1), {}, two_ticks());
  REQUIRE_FALSE(damaged);
  CHECK_THAT(damaged.error().message, Contains("box2d3: the answer of own_box2d3: line 1"));
}
