// Runs peer.mjs in node and plays its answer back.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_peer.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/json/json_tree.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/box2d/length_scale.h"
#include "tool/box2d3/box2d3_answer.h"
#include "tool/box2d3/box2d3_script.h"
#include "verifier/runs/child.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

using engine::BodyReport;
using engine::BodyType;
using engine::ContactReport;
using engine::Point;

constexpr double body_size_estimate = 90;  // bytes of a body in the answer of a tick

constexpr std::string_view setup_hint =
    "run ./dev setup box2d3, and set TICKTRUE_BOX2D3 to its folder build/box2d3 (docs/crosscheck.md)";

Error no_box2d3(const std::string& what) {
  return Error{ErrorCode::usage, "box2d3 needs node and npm's box2d3-wasm: " + what, std::string(setup_hint)};
}

// What a program wrote last to its standard error: its first line, for people.
std::string first_message_line(const std::string& text) {
  return engine::shortened(std::string_view(text).substr(0, text.find('\n')));
}

Result<std::string> package_folder() {
  const char* folder = std::getenv(box2d3_variable);
  if (folder == nullptr || *folder == '\0') return no_box2d3("TICKTRUE_BOX2D3 is not set");
  std::error_code failed;
  if (!fs::exists(fs::path(folder) / "node_modules" / "box2d3-wasm" / "package.json", failed))
    return no_box2d3(fmt::format("TICKTRUE_BOX2D3: found no node_modules/box2d3-wasm in {}, expected one",
                                 engine::in_quotes(engine::shortened(folder))));
  return std::string(folder);
}

// The version that package.json says: at most 64 KiB are read.
Result<std::string> package_version(const std::string& folder) {
  std::ifstream file(fs::path(folder) / "node_modules" / "box2d3-wasm" / "package.json", std::ios::binary);
  std::string text(std::size_t{64} << 10, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  const nlohmann::json description = nlohmann::json::parse(text, nullptr, false);
  if (!description.is_object() || !description.value("version", nlohmann::json()).is_string())
    return no_box2d3("package.json of box2d3-wasm: found no version, expected one");
  return engine::shortened(description.at("version").get<std::string>());
}

class Box2d3Playback final : public Box2d3Peer {
 public:
  Box2d3Playback(engine::Scene scene, const Box2d3Plan& plan, double scale, Box2d3Answer answer)
      : scene_(std::move(scene)), plan_(plan), scale_(scale), answer_(std::move(answer)) {
    for (const engine::Body& body : scene_.bodies) masses_.push_back(engine::body_mass(body));
  }

  void step() override {
    TICKTRUE_ASSERT(tick_ < plan_.tick_count);
    ++tick_;
  }

  std::vector<BodyReport> bodies() const override {
    const Box2d3Tick& tick = reported();
    std::vector<BodyReport> reports;
    reports.reserve(scene_.bodies.size());
    std::size_t next = 0;
    for (std::size_t id = 0; id < scene_.bodies.size(); ++id) {
      const engine::Body& body = scene_.bodies[id];
      if (body.type == BodyType::static_body) {
        const engine::SinCos turn = engine::sin_cos(body.angle);
        reports.push_back(report_of(id, body.position, turn.cos, turn.sin));
      } else if (next < tick.bodies.size() && tick.bodies[next].id == id) {
        const Box2d3Body& moved = tick.bodies[next++];
        BodyReport report = report_of(id, unscaled(moved.origin), moved.cosine, moved.sine);
        report.velocity = unscaled(moved.velocity);
        report.angular_velocity = moved.spin;
        if (body.type == BodyType::kinematic_body) {
          report.velocity.x -= moved.spin * (report.center.y - report.origin.y);
          report.velocity.y += moved.spin * (report.center.x - report.origin.x);
        }
        reports.push_back(std::move(report));
      }
    }
    return reports;
  }

  std::vector<ContactReport> contacts() const override {
    std::vector<ContactReport> reports;
    for (const Box2d3Contact& contact : reported().contacts) {
      ContactReport report;
      report.body_a = contact.body_a;
      report.body_b = contact.body_b;
      report.normal = contact.normal;
      report.point_count = contact.point_count;
      for (int i = 0; i < contact.point_count; ++i) {
        report.point[i] = unscaled(contact.point[i]);
        report.separation[i] = contact.separation[i] / scale_;
        report.normal_force[i] = contact.force[i] / scale_;
      }
      reports.push_back(report);
    }
    return reports;
  }

  std::size_t body_count() const override { return bodies().size(); }
  std::size_t contact_count() const override { return reported().contacts.size(); }
  double length_scale() const override { return scale_; }
  double skin() const override { return 0; }
  std::size_t thin_shape_count() const override { return 0; }
  std::size_t clamped_tick() const override {
    return answer_.clamped_tick <= tick_ ? static_cast<std::size_t>(answer_.clamped_tick) : 0;
  }
  double ms_per_tick() const override { return answer_.ms_per_tick; }

 private:
  Point unscaled(const Point& p) const { return {p.x / scale_, p.y / scale_}; }

  const Box2d3Tick& reported() const {
    TICKTRUE_ASSERT(tick_ > 0 && tick_ % plan_.body_interval == 0);
    return answer_.ticks[static_cast<std::size_t>(tick_ / plan_.body_interval - 1)];
  }

  BodyReport report_of(std::size_t id, const Point& origin, double cosine, double sine) const {
    const engine::Body& body = scene_.bodies[id];
    const Point& center = masses_[id].center;
    BodyReport report;
    report.id = static_cast<std::uint32_t>(id);
    report.name = body.name;
    report.type = body.type;
    report.origin = origin;
    report.center = {origin.x + cosine * center.x - sine * center.y, origin.y + sine * center.x + cosine * center.y};
    report.angle = std::atan2(sine, cosine);
    report.mass = masses_[id].mass;
    report.inertia = masses_[id].inertia;
    report.shapes = &body.shapes;
    return report;
  }

  engine::Scene scene_;
  Box2d3Plan plan_;
  double scale_;
  Box2d3Answer answer_;
  std::vector<engine::MassProperties> masses_;  // by id
  std::uint64_t tick_ = 0;
};

// Errors: limit.
Status check_answer_size(const engine::Scene& scene, const Box2d3Options& options, const Box2d3Plan& plan) {
  const double report_count = static_cast<double>(plan.tick_count) / static_cast<double>(plan.body_interval) + 1;
  const double size = report_count * body_size_estimate * static_cast<double>(scene.bodies.size());
  if (size <= static_cast<double>(options.answer_size_max)) return {};
  return Error{ErrorCode::limit,
               fmt::format("box2d3: the answer of node would be too large: found {} bodies for {} ticks ({:.0f} MiB), "
                           "expected at most {} MiB",
                           scene.bodies.size(), plan.tick_count, size / 0x1p20, options.answer_size_max >> 20),
               "fewer seconds"};
}

}  // namespace

Result<std::unique_ptr<Box2d3Peer>> make_box2d3_peer(const engine::Scene& scene, const Box2d3Options& options,
                                                     const Box2d3Plan& plan) {
  const Result<std::string> folder = package_folder();
  if (!folder) return folder.error();
  const double scale = choose_length_scale(scene);
  const Result<std::string> text = box2d3_scene_text(scene, options, plan, scale);
  if (!text) return text.error();
  if (const Status fits = check_answer_size(scene, options, plan); !fits) return fits.error();

  const Result<RunFolder> files = RunFolder::make("ticktrue-box2d3", "");
  if (!files) return files.error();
  const std::string script_path = files->path() + "/peer.mjs";
  const std::string scene_path = files->path() + "/scene.json";
  if (const Status written = write_data_file(script_path, box2d3_script); !written) return written.error();
  if (const Status written = write_data_file(scene_path, *text); !written) return written.error();

  ChildCommand command;
  command.argv = {"node", script_path, *folder, scene_path};
  command.environment = {{"NODE_OPTIONS", std::nullopt}};
  command.limits.time_s = options.time_max_s;
  command.limits.output_size_max = options.answer_size_max;
  command.limits.printed_size_max = options.answer_size_max + command.limits.message_size_max;
  const ChildResult ran = run_child(command);
  if (ran.end.how == ChildEnd::How::not_started) return no_box2d3("node " + child_failure(ran, command.limits));
  if (const std::string failure = child_failure(ran, command.limits); !failure.empty())
    return Error{ErrorCode::io, "box2d3: node " + failure, first_message_line(ran.message)};
  if (ran.end.exit_status != 0)
    return Error{ErrorCode::io, fmt::format("box2d3: node ended with status {}, expected 0", ran.end.exit_status),
                 first_message_line(ran.message)};
  Result<Box2d3Answer> answer = read_box2d3_answer(ran.output, scene, plan);
  if (!answer) return answer.error();
  return std::unique_ptr<Box2d3Peer>(std::make_unique<Box2d3Playback>(scene, plan, scale, *std::move(answer)));
}

Result<std::string> box2d3_version() {
  const Result<std::string> folder = package_folder();
  if (!folder) return folder.error();
  const Result<std::string> package = package_version(*folder);
  if (!package) return package.error();
  ChildCommand command;
  command.argv = {"node", "--version"};
  command.environment = {{"NODE_OPTIONS", std::nullopt}};
  command.limits.time_s = 60;
  command.limits.output_size_max = 4096;
  const ChildResult ran = run_child(command);
  if (const std::string failure = child_failure(ran, command.limits); !failure.empty())
    return no_box2d3("node " + failure);
  if (ran.end.exit_status != 0)
    return no_box2d3(fmt::format("node --version ended with status {}, expected 0", ran.end.exit_status));
  return fmt::format("3 (box2d3-wasm {})", *package);
}

}  // namespace ticktrue::verifier
