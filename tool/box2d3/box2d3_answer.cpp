// Reads the answer of peer.mjs line by line.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_answer.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/json/json_tree.h"

namespace ticktrue::verifier {
namespace {

using nlohmann::json;

constexpr std::size_t body_number_count = 8;
constexpr std::size_t contact_number_count = 13;
constexpr std::size_t contact_count_max = std::size_t{1} << 16;  // of a tick
constexpr std::size_t answer_line_size_max = std::size_t{16} << 20;

Error damaged_answer(std::size_t line, std::string_view what, std::string_view found, std::string_view expected) {
  return Error{ErrorCode::corrupt,
               fmt::format("box2d3: line {} of the answer of node: {}: found {}, expected {}", line, what,
                           engine::in_quotes(engine::shortened(found)), expected),
               {}};
}

/// The lines of a text. Each line ends with a line break.
class AnswerLines {
 public:
  explicit AnswerLines(std::string_view text) : rest_(text) {}
  bool has_next() const { return rest_.find('\n') != std::string_view::npos; }
  /// Requires: has_next().
  std::string_view next() {
    const std::size_t size = rest_.find('\n');
    const std::string_view line = rest_.substr(0, size);
    rest_.remove_prefix(size + 1);
    ++number_;
    return line;
  }
  std::string_view rest() const { return rest_; }
  std::size_t number() const { return number_; }  // of the line that next() gave last

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

/// The numbers of a list, if all of them are finite, `stride` of them belong together, and there are at most
/// `count_max` groups.
bool take_numbers(const json& object, const char* key, std::size_t stride, std::size_t count_max,
                  std::vector<double>& numbers) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) return false;
  if (found->size() % stride != 0 || found->size() / stride > count_max) return false;
  numbers.clear();
  numbers.reserve(found->size());
  for (const json& each : *found) {
    if (!each.is_number() || !std::isfinite(each.get<double>())) return false;
    numbers.push_back(each.get<double>());
  }
  return true;
}

/// The id of a body of the scene.
bool take_id(double number, std::size_t body_count, std::uint32_t& id) {
  if (!(number >= 0 && number < static_cast<double>(body_count)) || number != std::floor(number)) return false;
  id = static_cast<std::uint32_t>(number);
  return true;
}

bool take_bodies(const json& object, const engine::Scene& scene, Box2d3Tick& tick) {
  std::vector<double> numbers;
  if (!take_numbers(object, "bodies", body_number_count, scene.bodies.size(), numbers)) return false;
  for (std::size_t i = 0; i < numbers.size(); i += body_number_count) {
    const double* n = &numbers[i];
    Box2d3Body body;
    if (!take_id(n[0], scene.bodies.size(), body.id)) return false;
    if (scene.bodies[body.id].type == engine::BodyType::static_body) return false;
    if (!tick.bodies.empty() && tick.bodies.back().id >= body.id) return false;
    body.origin = {n[1], n[2]};
    body.cosine = n[3];
    body.sine = n[4];
    body.velocity = {n[5], n[6]};
    body.spin = n[7];
    tick.bodies.push_back(body);
  }
  return true;
}

bool take_contacts(const json& object, const engine::Scene& scene, Box2d3Tick& tick) {
  std::vector<double> numbers;
  if (!take_numbers(object, "contacts", contact_number_count, contact_count_max, numbers)) return false;
  for (std::size_t i = 0; i < numbers.size(); i += contact_number_count) {
    const double* n = &numbers[i];
    Box2d3Contact contact;
    if (!take_id(n[0], scene.bodies.size(), contact.body_a) || !take_id(n[1], scene.bodies.size(), contact.body_b))
      return false;
    if (n[4] != 1 && n[4] != 2) return false;
    contact.normal = {n[2], n[3]};
    contact.point_count = static_cast<int>(n[4]);
    for (int p = 0; p < contact.point_count; ++p) {
      const double* at = n + 5 + 4 * p;
      contact.point[p] = {at[0], at[1]};
      contact.separation[p] = at[2];
      contact.force[p] = at[3];
    }
    tick.contacts.push_back(contact);
  }
  return true;
}

bool take_count(const json& object, const char* key, std::uint64_t max, std::uint64_t& value) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() > max) return false;
  value = found->get<std::uint64_t>();
  return true;
}

}  // namespace

Result<Box2d3Answer> read_box2d3_answer(std::string_view text, const engine::Scene& scene, const Box2d3Plan& plan) {
  AnswerLines lines(text);
  Box2d3Answer answer;
  const auto next_object = [&](std::string_view expected) -> Result<json> {
    if (!lines.has_next()) return damaged_answer(lines.number() + 1, "the line", lines.rest(), expected);
    const std::string_view line = lines.next();
    if (line.size() > answer_line_size_max)
      return damaged_answer(lines.number(), "too long", line, fmt::format("at most {} bytes", answer_line_size_max));
    json object = json::parse(line, nullptr, false);
    if (!object.is_object()) return damaged_answer(lines.number(), "not a JSON object", line, expected);
    return object;
  };

  const Result<json> head = next_object("a head");
  if (!head) return head.error();
  if (const auto why = head->find("refused"); why != head->end() && why->is_string())
    return Error{ErrorCode::unsupported, scene.name + ": " + why->get<std::string>(), {}};
  if (head->value("schema", json()) != "ticktrue.box2d3/1" || !head->value("package", json()).is_string())
    return damaged_answer(1, "the head", head->dump(), "schema ticktrue.box2d3/1 and the package");
  answer.package = engine::shortened(head->at("package").get<std::string>());

  for (std::uint64_t tick = plan.body_interval; tick <= plan.tick_count; tick += plan.body_interval) {
    const std::string expected = fmt::format("tick {} with its bodies", tick);
    const Result<json> object = next_object(expected);
    if (!object) return object.error();
    Box2d3Tick report;
    std::uint64_t number = 0;
    if (!take_count(*object, "tick", plan.tick_count, number) || number != tick || !take_bodies(*object, scene, report))
      return damaged_answer(lines.number(), "the tick", object->dump(), expected);
    const std::uint64_t left = plan.tick_count - tick;
    const bool has_contacts = left < plan.contact_window && left % plan.contact_interval == 0;
    if (has_contacts && !take_contacts(*object, scene, report))
      return damaged_answer(lines.number(), "the contacts", object->dump(), "lists of 13 finite numbers");
    answer.ticks.push_back(std::move(report));
  }

  const Result<json> end = next_object("the end");
  if (!end) return end.error();
  const json time = end->value("ms_per_tick", json());
  if (end->value("done", json()) != true || !take_count(*end, "clamped_tick", plan.tick_count, answer.clamped_tick) ||
      !time.is_number() || !std::isfinite(time.get<double>()) || time.get<double>() < 0)
    return damaged_answer(lines.number(), "the end", end->dump(), "done, clamped_tick and ms_per_tick");
  answer.ms_per_tick = time.get<double>();
  if (!lines.rest().empty()) return damaged_answer(lines.number() + 1, "the rest", lines.rest(), "nothing");
  return answer;
}

}  // namespace ticktrue::verifier
