// The page of a report: its content, escaping, and size.
// SPDX-License-Identifier: MIT
//
// Verified: escapes, coded frames, the strip, the ghosts, the named bodies, the size, and equal bytes for equal traces.
// Not verified: the view in a browser (tests/page/page_test.py tests it).
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/faulty_engine.h"
#include "tests/support/forging.h"
#include "tests/support/scenes.h"
#include "tool/report_page/animation.h"
#include "tool/report_page/frame_coding.h"
#include "tool/report_page/report_page.h"
#include "tool/session/session.h"
#include "tool/session/simulations.h"
#include "verifier/verify/trace_inputs.h"
#include "verifier/verify/verify.h"

namespace ticktrue::test {
namespace {

using Json = nlohmann::json;
using tool::Animation;
using tool::Frame;
using tool::Page;
using tool::TickMatch;
using verifier::Report;

constexpr const char* hostile_name = "</script><img src=x onerror=alert(1)><!--\"'&{{js}}";

/// Boxes that fall on each other. The name of the third body contains markup.
Scene falling_boxes(int count) {
  Scene scene = stack_scene(count, 0.5, Precision::f32);
  scene.name = hostile_name;
  for (int i = 1; i <= count; ++i) scene.bodies[static_cast<std::size_t>(i)].name = "box_" + std::to_string(i);
  scene.bodies[3].name = hostile_name;
  scene.bodies[3].velocity = {0.5, 0};
  return scene;
}

struct Recording {
  std::uint64_t tick_count = 60;
  std::uint32_t checkpoint_interval = 20;
  std::optional<Fault> fault = std::nullopt;
  replay::Detail detail = replay::Detail::cells;
};

void record_scene(const Scene& scene, const std::string& path, const Recording& recording) {
  const auto made = engine::make_engine(scene);
  INFO((made ? "" : made.error().message));
  REQUIRE(made.has_value());
  tool::TraceChoices choices;
  choices.detail = recording.detail;
  if (recording.detail == replay::Detail::full) choices.full_last = std::numeric_limits<std::uint64_t>::max();
  choices.checkpoint_interval = recording.checkpoint_interval;
  const replay::TraceSetup setup = tool::make_trace_setup(**made, choices);
  replay::NoInputs inputs(scene.settings.dt);
  replay::RecordOptions options;
  options.tick_count = recording.tick_count;
  options.writer = plain_writer();
  const Fault never{std::numeric_limits<std::uint64_t>::max() - 1, 0, 0};
  FaultyEngine engine(**made, recording.fault.value_or(never));
  const auto recorded = replay::record(engine, inputs, path, setup, {}, options);
  INFO((recorded ? "" : recorded.error().message));
  REQUIRE(recorded.has_value());
}

Report verify_file(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  if (!reader) return verifier::open_error_report(path, reader.error());
  verifier::VerifyOptions options;
  options.simulation = tool::find_simulation(reader->setup().simulation);
  return verifier::verify(*reader, options);
}

Page page_of(const std::string& path, const tool::PageOptions& options = {}) {
  const auto page = tool::make_report_page(verify_file(path), options);
  REQUIRE(page.has_value());
  return *page;
}

Json data_of(const Page& page) {
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.html.find(open) + open.size();
  return Json::parse(page.html.substr(begin, page.html.find("</script>", begin) - begin));
}

std::size_t occurrences_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

Animation animation_of(const std::string& path, const tool::AnimationOptions& options) {
  auto reader = replay::TraceReader::open(path);
  REQUIRE(reader.has_value());
  return tool::make_animation(*reader, options);
}

tool::AnimationOptions animation_options() {
  tool::AnimationOptions options;
  options.simulation = &engine::engine_info();
  return options;
}

TEST_CASE("report page: the facts in it are those of verify --json, whatever bodies are called",
          "[verifier][report_html][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("diverged.ttr");
  record_scene(falling_boxes(6), path, {60, 20, Fault{37, 3, 20}});
  const Report report = verify_file(path);
  REQUIRE(report.divergence);
  const Page page = page_of(path);
  const Json data = data_of(page);
  CHECK(data["verify"] == Json::parse(verifier::report_json({&report, 1}, false)));
  CHECK(data["verify"]["divergence"]["tick"] == 37);
  CHECK(data["focus"] == 38);
  CHECK(page.exit_code == 1);
  CHECK(data["film"]["playback"]["named"] == Json::array({3}));
  CHECK(data["film"]["playback"]["bodies"]["names"][3] == hostile_name);
  // Two scripts, one style, and no element from the name.
  CHECK(occurrences_of(page.html, "<script") == 2);
  CHECK(occurrences_of(page.html, "</script") == 2);
  CHECK(occurrences_of(page.html, "<img") == 0);
  CHECK(occurrences_of(page.html, "<!--") == 0);
}

TEST_CASE("report page: it asks the network for nothing", "[verifier][report_html][analytic]") {
  const TemporaryFolder folder;
  record_scene(stack_scene(3), folder.file("a.ttr"), {10});
  const std::string html = page_of(folder.file("a.ttr")).html;
  for (const char* part : {"http:", "https:", "//cdn", "url(", "@import", " src=", "import(", "fetch(", "XMLHttp"})
    CHECK(occurrences_of(html, part) == 0);
  CHECK(occurrences_of(html, "href=") == 1);  // the empty icon
  CHECK(occurrences_of(html, "default-src 'none'") == 1);
}

TEST_CASE("report page: the same trace gives the same bytes", "[verifier][report_html][determinism]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(5), folder.file("a.ttr"), {60, 20, Fault{30, 3, 22}});
  record_scene(falling_boxes(5), folder.file("b.ttr"), {60, 20});
  tool::PageOptions options;
  options.against = folder.file("b.ttr");
  CHECK(page_of(folder.file("a.ttr")).html == page_of(folder.file("a.ttr")).html);
  CHECK(page_of(folder.file("a.ttr"), options).html == page_of(folder.file("a.ttr"), options).html);
}

TEST_CASE("report page: text and JSON are escaped", "[verifier][report_html][analytic]") {
  CHECK(tool::html_text("<a href=\"x\">&'\x01\n") == "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\\u0001\n");
  const std::string safe = tool::script_json(R"(["</script>","<!--","a&b"])");
  CHECK(safe.find_first_of("<>&") == std::string::npos);
  CHECK(Json::parse(safe) == Json::array({"</script>", "<!--", "a&b"}));
}

/// Poses by [body][frame in which the body exists], coded as in tool/report_page/frame_coding.h.
std::vector<std::vector<tool::GridPose>> decode_frames(const tool::CodedFrames& coded,
                                                       const std::vector<std::uint64_t>& ticks_done) {
  ByteReader in(coded.numbers);
  std::vector<std::vector<tool::GridPose>> poses;
  for (const std::vector<tool::BodyFrames>& parts : coded.presence) {
    std::vector<double> ticks;
    for (const tool::BodyFrames& part : parts)
      for (std::uint32_t i = 0; i < part.count; ++i) ticks.push_back(static_cast<double>(ticks_done[part.first + i]));
    auto& of_body = poses.emplace_back(ticks.size());
    for (const auto lane : {&tool::GridPose::x, &tool::GridPose::y, &tool::GridPose::angle})
      for (std::size_t i = 0; i < ticks.size(); ++i) {
        const auto value = [&](std::size_t back) { return static_cast<double>(of_body[i - back].*lane); };
        double predicted = i == 0 ? 0 : value(1);
        if (i > 1)
          predicted +=
              std::floor((value(1) - value(2)) * (ticks[i] - ticks[i - 1]) / (ticks[i - 1] - ticks[i - 2]) + 0.5);
        predicted = std::max(-536870912.0, std::min(predicted, 536870912.0));
        const auto number = static_cast<std::int64_t>(in.varint());
        const std::int64_t rest = number % 2 == 0 ? number / 2 : -(number + 1) / 2;
        of_body[i].*lane = static_cast<std::int32_t>(static_cast<std::int64_t>(predicted) + rest);
      }
  }
  CHECK(in.at_end());
  return poses;
}

TEST_CASE("report page: frames come back from their codes as they were on the grid",
          "[verifier][report_html][equivalence]") {
  const tool::PoseGrid grid{1.0 / 1024, 4096};
  std::uint64_t state = 1;
  const auto random = [&](double range) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (static_cast<double>(state >> 40) / (1 << 24) - 0.5) * range;
  };
  constexpr std::size_t body_count = 5;
  std::vector<Frame> frames;
  std::vector<tool::Pose> poses(body_count);
  std::uint64_t tick = 0;
  for (int f = 0; f < 200; ++f, tick += f % 50 < 40 ? 1 : 7) {
    Frame frame;
    frame.ticks_done = tick;
    for (std::uint32_t b = 0; b < body_count; ++b) {
      poses[b].body = b;
      // Bodies at rest, drifting, shaking, jumping, and one that flies away. The second body is absent for a while.
      const double reach[] = {0, 0.01, 0.2, 500, 1e9};
      poses[b].x += b == 1 ? 0.02 : random(reach[b]);
      poses[b].y += random(reach[b]);
      poses[b].angle += random(b == 0 ? 0 : 6);
      if (b != 1 || f < 50 || (f > 60 && f != 70)) frame.poses.push_back(poses[b]);
    }
    frames.push_back(frame);
  }
  const tool::CodedFrames coded = tool::code_frames(frames, body_count, grid);
  CHECK(coded.presence[1].size() == 3);
  std::vector<std::uint64_t> ticks;
  for (const Frame& frame : frames) ticks.push_back(frame.ticks_done);
  const auto decoded = decode_frames(coded, ticks);
  REQUIRE(decoded.size() == body_count);
  std::vector<std::size_t> at(body_count, 0);
  bool same = true;
  for (const Frame& frame : frames)
    for (const tool::Pose& pose : frame.poses) {
      const tool::GridPose expected = to_grid(pose, grid);
      REQUIRE(at[pose.body] < decoded[pose.body].size());
      const tool::GridPose& got = decoded[pose.body][at[pose.body]++];
      same = same && got.x == expected.x && got.y == expected.y && got.angle == expected.angle;
    }
  CHECK(same);
  CHECK(tool::base64(Bytes{'M', 'a'}) == "TWE=");
  CHECK(tool::base64(Bytes{'M', 'a', 'n', 0xff}) == "TWFu/w==");
}

TEST_CASE("report animation: poses are the engine's, and the strip says which ticks are as recorded",
          "[verifier][report_html][equivalence]") {
  const TemporaryFolder folder;
  const Scene scene = falling_boxes(4);
  const std::string path = folder.file("film.ttr");
  record_scene(scene, path, {60, 20, Fault{33, 3, 22}});
  tool::AnimationOptions options = animation_options();
  options.focus = 34;
  options.questions = {{"bodies", 3, 3, ""}};
  const Animation animation = animation_of(path, options);
  REQUIRE(animation.frames.size() == 61);
  const auto engine = engine::make_engine(scene);
  REQUIRE(engine.has_value());
  for (const Frame& frame : animation.frames) {
    const auto bodies = (*engine)->bodies();
    REQUIRE(frame.poses.size() == bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      CHECK(frame.poses[i].x == bodies[i].center.x);
      CHECK(frame.poses[i].y == bodies[i].center.y);
      CHECK(std::fabs(std::sin(frame.poses[i].angle - bodies[i].angle)) < 1e-6);
    }
    REQUIRE((*engine)->step({scene.settings.dt, {}}, nullptr));
  }
  // The recorded states are unknown from the divergence to the next checkpoint, and known from there on.
  REQUIRE(animation.match_ranges.size() == 3);
  CHECK((animation.match_ranges[0].match == TickMatch::same && animation.match_ranges[0].last == 32));
  CHECK((animation.match_ranges[1].match == TickMatch::differs && animation.match_ranges[1].last == 39));
  CHECK((animation.match_ranges[2].match == TickMatch::differs_known && animation.match_ranges[2].last == 59));
  CHECK(animation.recorded.size() == 20);
  CHECK(animation.checkpoints == std::vector<std::uint64_t>{0, 20, 40, 60});
  CHECK(animation.named == std::vector<std::uint32_t>{3});
}

TEST_CASE("report animation: a trace in full detail shows what was recorded from the divergence on",
          "[verifier][report_html][equivalence]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(4), folder.file("full.ttr"), {40, 0, Fault{10, 3, 22}, replay::Detail::full});
  const Animation animation = animation_of(folder.file("full.ttr"), animation_options());
  REQUIRE(animation.match_ranges.size() == 2);
  CHECK((animation.match_ranges[1].match == TickMatch::differs_known && animation.match_ranges[1].first == 10));
  CHECK(animation.recorded.size() == 30);
}

TEST_CASE("report page: against another trace both are shown as they were recorded",
          "[verifier][report_html][equivalence]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(4), folder.file("a.ttr"), {60, 20});
  record_scene(falling_boxes(4), folder.file("b.ttr"), {60, 20, Fault{10, 3, 22}, replay::Detail::full});
  tool::PageOptions options;
  options.against = folder.file("b.ttr");
  const Page page = page_of(folder.file("a.ttr"), options);
  const Json data = data_of(page);
  CHECK(page.exit_code == 1);
  CHECK(data["verify"]["verdict"] == "match");
  CHECK(data["against"]["diff"]["verdict"] == "different");
  CHECK(data["against"]["diff"]["divergence"]["tick"] == 10);
  CHECK(data["focus"] == 11);
  // The top of the page and both strips show a difference, although each trace matches its own build.
  CHECK(data["headline"]["verdict"] == "different");
  CHECK(data["headline"]["sentence"] == "this trace and b.ttr differ from tick 10 on");
  CHECK(data["against"]["differing"] == Json::array({Json::array({10, 59})}));
  CHECK(occurrences_of(page.html, "<title>different: a.ttr - ticktrue</title>") == 1);
  CHECK(occurrences_of(page.html, "\ndifferent  ") == 1);
  const Json& playback = data["film"]["playback"];
  // The flipped bit is in a velocity, so positions differ from the next tick on.
  CHECK(playback["ghosts"]["ticks"].front() == 12);
  CHECK(playback["ghosts"]["ticks"].back() == 60);
  CHECK_FALSE(playback["drift"].is_null());
  const auto refused = tool::make_report_page(verify_file(folder.file("a.ttr")), [&] {
    tool::PageOptions none;
    none.against = folder.file("no.ttr");
    return none;
  }());
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::io);
}

TEST_CASE("report page: of two equal traces the headline is that of the trace", "[verifier][report_html][analytic]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(4), folder.file("a.ttr"), {30, 20});
  record_scene(falling_boxes(4), folder.file("b.ttr"), {30, 10, std::nullopt, replay::Detail::full});
  tool::PageOptions options;
  options.against = folder.file("b.ttr");
  const Json data = data_of(page_of(folder.file("a.ttr"), options));
  CHECK(data["headline"]["verdict"] == "match");
  CHECK(data["against"]["differing"].empty());
}

TEST_CASE("report page: a tick with a forged record is red in the strip", "[verifier][report_html][corruption]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(4), folder.file("a.ttr"), {30, 20});
  forge_trace(folder.file("a.ttr"), folder.file("b.ttr"), {[](verifier::StoredTick& tick) {
                if (tick.tick == 12) tick.cells->cells.back() ^= 0x100;
              }});
  const Json data = data_of(page_of(folder.file("b.ttr")));
  CHECK(data["headline"]["verdict"] == "diverged");
  CHECK(data["film"]["strip"] == Json::parse("[[0, 11, \"same\"], [12, 12, \"differs\"], [13, 29, \"same\"]]"));
}

TEST_CASE("report page: frames are left out until it fits, but for those around the divergence",
          "[verifier][report_html][analytic]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("long.ttr");
  record_scene(falling_boxes(12), path, {1200, 200, Fault{600, 4, 20}});
  const std::size_t whole = page_of(path).html.size();
  tool::PageOptions options;
  options.size_max = whole - 8'000;
  const Page page = page_of(path, options);
  CHECK(page.html.size() <= options.size_max);
  const Json playback = data_of(page)["film"]["playback"];
  REQUIRE_FALSE(playback.is_null());
  CHECK(playback["stride"].get<int>() >= 2);
  const auto ticks = playback["bodies"]["ticks"].get<std::vector<std::uint64_t>>();
  for (std::uint64_t tick = 580; tick < 640; ++tick) CHECK(std::find(ticks.begin(), ticks.end(), tick) != ticks.end());
  CHECK(ticks.back() == 1200);
  options.size_max = 100;  // impossible: the page without playback remains
  const Json least = data_of(page_of(path, options));
  CHECK(least["film"]["playback"].is_null());
  CHECK_FALSE(least["film"]["no_poses"].get<std::string>().empty());
  CHECK(least["verify"]["divergence"]["tick"] == 600);
}

TEST_CASE("report page: a minute of 200 bodies is below 5 MB, also twice", "[.slow][verifier][report_html][analytic]") {
  const TemporaryFolder folder;
  for (const char* name : {"tumbler?columns=14", "mixed_pile?bodies=200"}) {
    const auto scene = engine::make_builtin_scene(name);
    REQUIRE(scene.has_value());
    record_scene(*scene, folder.file("a.ttr"), {3600, 600});
    record_scene(*scene, folder.file("b.ttr"), {3600, 600, Fault{500, 30, 22}});
    const Page page = page_of(folder.file("a.ttr"));
    tool::PageOptions options;
    options.against = folder.file("b.ttr");
    const Page both = page_of(folder.file("a.ttr"), options);
    CAPTURE(name, page.html.size(), both.html.size());
    CHECK(page.html.size() < 5'000'000);
    CHECK(both.html.size() < 5'000'000);
    CHECK(data_of(page)["film"]["playback"]["stride"] == 1);
    CHECK_FALSE(data_of(both)["film"]["playback"].is_null());
    std::filesystem::remove(folder.file("a.ttr"));
    std::filesystem::remove(folder.file("b.ttr"));
  }
}

TEST_CASE("report page: a trace of another simulation has its facts and no playback",
          "[verifier][report_html][corruption]") {
  const TemporaryFolder folder;
  REQUIRE(record_toy(folder.file("toy.ttr"), toy_setup(4), 30).has_value());
  const Page page = page_of(folder.file("toy.ttr"));
  const Json data = data_of(page);
  CHECK(page.exit_code == 5);
  CHECK(data["verify"]["verdict"] == "not_comparable");
  CHECK(data["film"]["playback"].is_null());
  CHECK(data["film"]["no_poses"].get<std::string>().find("ticktrue.toy") != std::string::npos);
  CHECK(data["film"]["strip"] == Json::parse(R"([[0,29,"not_compared"]])"));
  CHECK(data["film"]["input_tick_count"].get<int>() > 0);
}

TEST_CASE("report page: of a cut or damaged trace it shows what is proven", "[verifier][report_html][corruption]") {
  const TemporaryFolder folder;
  record_scene(falling_boxes(3), folder.file("whole.ttr"), {60, 10});
  const Bytes whole = read_file(folder.file("whole.ttr"));
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 40) {
    write_file(folder.file("cut.ttr"), ByteView(whole).first(size));
    const Page page = page_of(folder.file("cut.ttr"));
    const Json data = data_of(page);
    CAPTURE(size);
    CHECK((page.exit_code == 3 || page.exit_code == 4));
    if (data["film"].is_null()) continue;
    CHECK(data["film"]["ticks_run"] == data["verify"]["ticks_compared"]);
  }
  Bytes damaged = whole;
  damaged[whole.size() / 2] ^= 4;
  write_file(folder.file("damaged.ttr"), damaged);
  const Page page = page_of(folder.file("damaged.ttr"));
  CHECK(page.exit_code == 4);
  CHECK(data_of(page)["verify"]["verdict"] == "damaged");
}

TEST_CASE("report page: a state that is not finite is said and does not stop the page",
          "[verifier][report_html][corruption]") {
  const TemporaryFolder folder;
  // Explicit Euler on a stiff spring grows without bound.
  Scene scene = flight_scene(Precision::f32, unit_box({1, 0}));
  scene.settings.integrator = engine::IntegratorKind::explicit_euler;
  engine::Force spring;
  spring.kind = engine::ForceKind::spring;
  spring.body = 0;
  spring.stiffness = 1e9;
  scene.forces.push_back(spring);
  record_scene(scene, folder.file("bang.ttr"), {200, 50});
  const Page page = page_of(folder.file("bang.ttr"));
  const Json data = data_of(page);
  CHECK_FALSE(data["verify"]["non_finite"].is_null());
  CHECK_FALSE(data["film"]["playback"].is_null());
}

}  // namespace
}  // namespace ticktrue::test
