// Reads the answer of peer.mjs line by line.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "engine/json/json_tree.h"

namespace ticktrue::tool {
namespace {

using nlohmann::json;

constexpr std::size_t body_number_count = 8;
constexpr std::size_t contact_number_count = 13;
constexpr std::size_t contact_count_max = std::size_t{1} << 16;  // of a tick
constexpr std::size_t answer_line_size_max = std::size_t{16} << 20;
constexpr std::size_t answer_text_size_max = 1024;  // bytes of a text that are kept

/// The lines of a text. Each line ends with a line break.
class AnswerLines {
 public:
  explicit AnswerLines(std::string_view text) : rest_(text) {}
  bool has_next() const { return rest_.find('\n') != std::string_view::npos; }
  /// Without has_next(): the rest.
  std::string_view next() {
    const std::size_t size = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = rest_.substr(0, size);
    rest_.remove_prefix(std::min(size + 1, rest_.size()));
    ++number_;
    return line;
  }
  std::string_view rest() const { return rest_; }
  std::size_t number() const { return number_; }  // of the line that next() gave last

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

/// One line: an object of flags, numbers, texts and lists of numbers under known keys. Nothing else is stored, and no
/// list grows beyond its limit.
class AnswerLine : public nlohmann::json_sax<json> {
 public:
  explicit AnswerLine(std::size_t body_count_max) : body_number_max_(body_count_max * body_number_count) {}

  /// Whether the text is such an object.
  bool read(std::string_view text) { return json::sax_parse(text, this) && is_closed_; }

  std::optional<std::string> schema, package, refused;
  std::optional<double> tick, clamped_tick, ms_per_tick;
  std::optional<bool> done;
  std::optional<std::vector<double>> bodies, contacts;

  bool null() override { return false; }
  bool boolean(bool flag) override { return !in_list_ && key_ == "done" && set(done, flag); }
  bool number_integer(std::int64_t value) override { return add(static_cast<double>(value), false); }  // below zero
  bool number_unsigned(std::uint64_t value) override { return add(static_cast<double>(value), true); }
  bool number_float(double value, const std::string&) override { return add(value, false); }
  bool string(std::string& text) override {
    if (in_list_) return false;
    std::string kept = text.substr(0, answer_text_size_max);
    if (key_ == "schema") return set(schema, std::move(kept));
    if (key_ == "package") return set(package, std::move(kept));
    return key_ == "refused" && set(refused, std::move(kept));
  }
  bool binary(json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return !std::exchange(is_open_, true); }
  bool key(std::string& key) override {
    key_ = key.substr(0, answer_text_size_max);
    return true;
  }
  bool end_object() override { return is_closed_ = true; }
  bool start_array(std::size_t) override {
    if (!is_open_ || in_list_) return false;
    in_list_ = true;
    if (key_ == "bodies") return set(bodies, {});
    return key_ == "contacts" && set(contacts, {});
  }
  bool end_array() override {
    in_list_ = false;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  // A key that is given twice is refused.
  template <typename Value>
  static bool set(std::optional<Value>& member, Value value) {
    if (member) return false;
    member = std::move(value);
    return true;
  }
  bool add(double value, bool is_count) {
    if (!in_list_) {
      if (key_ == "ms_per_tick") return set(ms_per_tick, value);
      if (!is_count) return false;
      if (key_ == "tick") return set(tick, value);
      return key_ == "clamped_tick" && set(clamped_tick, value);
    }
    const bool is_contact = key_ == "contacts";
    std::vector<double>& list = is_contact ? *contacts : *bodies;
    if (list.size() == (is_contact ? contact_count_max * contact_number_count : body_number_max_)) return false;
    list.push_back(value);
    return true;
  }

  std::size_t body_number_max_;
  std::string key_;
  bool is_open_ = false;
  bool is_closed_ = false;
  bool in_list_ = false;
};

/// The numbers of a list, if it is there and `stride` of them belong together.
bool has_groups(const std::optional<std::vector<double>>& numbers, std::size_t stride) {
  return numbers && numbers->size() % stride == 0;
}

/// The id of a body of the scene.
bool take_id(double number, std::size_t body_count, std::uint32_t& id) {
  if (!(number >= 0 && number < static_cast<double>(body_count)) || number != std::floor(number)) return false;
  id = static_cast<std::uint32_t>(number);
  return true;
}

bool take_bodies(const AnswerLine& line, const engine::Scene& scene, Box2d3Tick& tick) {
  if (!has_groups(line.bodies, body_number_count)) return false;
  for (std::size_t i = 0; i < line.bodies->size(); i += body_number_count) {
    const double* n = &(*line.bodies)[i];
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

bool take_contacts(const AnswerLine& line, const engine::Scene& scene, Box2d3Tick& tick) {
  if (!has_groups(line.contacts, contact_number_count)) return false;
  for (std::size_t i = 0; i < line.contacts->size(); i += contact_number_count) {
    const double* n = &(*line.contacts)[i];
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

}  // namespace

Result<Box2d3Answer> read_box2d3_answer(std::string_view text, const engine::Scene& scene, const Box2d3Plan& plan,
                                        const std::string& from) {
  AnswerLines lines(text);
  Box2d3Answer answer;
  std::string_view found;
  const auto damaged = [&](std::string_view what, std::string_view expected) {
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: line {}: {}: found {}, expected {}", from, lines.number(), what,
                             engine::in_quotes(engine::shortened(found)), expected),
                 {}};
  };
  const auto next_line = [&](AnswerLine& line, std::string_view expected) -> Status {
    const bool has_line = lines.has_next();
    found = lines.next();
    if (!has_line) return damaged("cut off", expected);
    if (found.size() > answer_line_size_max)
      return damaged("too long", fmt::format("at most {} bytes", answer_line_size_max));
    if (!line.read(found)) return damaged("not an object of known keys", expected);
    return {};
  };

  AnswerLine head(0);
  if (const Status read = next_line(head, "a head"); !read) return read.error();
  if (head.refused) return Error{ErrorCode::unsupported, scene.name + ": " + *head.refused, {}};
  if (head.schema != "ticktrue.box2d3/1" || !head.package)
    return damaged("the head", "schema ticktrue.box2d3/1 and the package");
  answer.package = engine::shortened(*head.package);

  for (std::uint64_t tick = plan.body_interval; tick <= plan.tick_count; tick += plan.body_interval) {
    const std::string expected = fmt::format("tick {} with its bodies", tick);
    AnswerLine line(scene.bodies.size());
    if (const Status read = next_line(line, expected); !read) return read.error();
    Box2d3Tick report;
    if (line.tick != static_cast<double>(tick) || !take_bodies(line, scene, report))
      return damaged("the tick", expected);
    const std::uint64_t left = plan.tick_count - tick;
    const bool has_contacts = left < plan.contact_window && left % plan.contact_interval == 0;
    if (has_contacts && !take_contacts(line, scene, report))
      return damaged("the contacts", "lists of 13 finite numbers");
    answer.ticks.push_back(std::move(report));
  }

  AnswerLine end(0);
  if (const Status read = next_line(end, "the end"); !read) return read.error();
  const double clamped_max = static_cast<double>(plan.tick_count);
  if (end.done != true || !end.clamped_tick || *end.clamped_tick > clamped_max || !end.ms_per_tick ||
      *end.ms_per_tick < 0)
    return damaged("the end", "done, clamped_tick and ms_per_tick");
  answer.clamped_tick = static_cast<std::uint64_t>(*end.clamped_tick);
  answer.ms_per_tick = *end.ms_per_tick;
  found = lines.rest();
  if (!found.empty()) return damaged("more lines than planned", "nothing");
  return answer;
}

}  // namespace ticktrue::tool
