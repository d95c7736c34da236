// Reads a mouse session line by line: one pass finds the size of the screen, one pass makes the inputs.
// SPDX-License-Identifier: MIT
// Source: Fülöp, Kovács, Kurics, Windhager-Pokol, "Balabit Mouse Dynamics Challenge data set", 2016 (the format).
#include "tool/import/import_mouse.h"

#include <array>

#include "base/limits.h"
#include "engine/json/number_text.h"

namespace ticktrue::tool {
namespace {

using engine::Bounds;
using engine::Input;
using engine::InputKind;
using engine::Point;
using engine::Scene;

constexpr std::string_view header = "record timestamp,client timestamp,button,state,x,y";
constexpr std::array<std::string_view, 6> columns{"record timestamp", "client timestamp", "button", "state", "x", "y"};
constexpr std::array<std::string_view, 6> buttons{"NoButton", "Left", "Right", "Middle", "Scroll", "XButton"};
constexpr std::array<std::string_view, 6> states{"Move", "Pressed", "Released", "Drag", "Down", "Up"};
constexpr double unknown_position = 65535;
constexpr double screen_max = 65535;  // px; the limit of the format
constexpr std::size_t line_size_max = 1024;

struct Row {
  double time_s = 0;  // time of the event by the client's clock, not the time of its recording
  std::string_view button;
  std::string_view state;
  double x = 0;  // px, from the left
  double y = 0;  // px, from the top
  bool has_position() const { return x != unknown_position && y != unknown_position; }
};

/// At most 40 bytes of the text, with unprintable characters replaced.
std::string found_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, 40)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out + (text.size() > 40 ? "...\"" : "\"");
}

template <std::size_t count>
std::string listed(const std::array<std::string_view, count>& names) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : i + 1 == count ? " or " : ", ") + std::string(names[i]);
  return text;
}

template <std::size_t count>
bool contains(const std::array<std::string_view, count>& names, std::string_view name) {
  for (const std::string_view candidate : names)
    if (candidate == name) return true;
  return false;
}

/// Reads the rows of a session in order.
class SessionReader {
 public:
  SessionReader(std::string_view csv, const std::string& source) : rest_(csv), source_(source) {}

  Status read_header() {
    if (rest_.substr(0, 3) == "\xef\xbb\xbf") rest_.remove_prefix(3);
    if (rest_.empty()) return refused("the session is empty", "");
    const std::string_view line = next_line();
    if (line != header)
      return refused(
          "not a mouse session: found " + found_text(line) + ", expected the header \"" + std::string(header) + "\"",
          "sessions are in the format of the Balabit Mouse Dynamics Challenge");
    return {};
  }

  /// False at the end. Errors: invalid_input.
  Result<bool> next(Row& row) {
    std::string_view line;
    do {
      if (rest_.empty()) return false;
      line = next_line();
    } while (line.empty());
    if (line.size() > line_size_max)
      return refused("line too long: found " + std::to_string(line.size()) + " bytes, expected at most " +
                         std::to_string(line_size_max),
                     "");

    std::array<std::string_view, columns.size()> fields;
    std::size_t count = 0;
    for (;;) {
      const std::size_t comma = line.find(',');
      if (count < fields.size()) fields[count] = line.substr(0, comma);
      ++count;
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
    if (count != fields.size())
      return refused(
          "wrong number of columns: found " + std::to_string(count) + ", expected " + std::to_string(fields.size()),
          "");

    double recorded_s = 0;
    if (Status status = number(fields, 0, 0, time_max_s, recorded_s); !status) return status.error();
    if (Status status = number(fields, 1, 0, time_max_s, row.time_s); !status) return status.error();
    if (row.time_s < last_s_)
      return refused("client timestamp: time runs backwards: found " + engine::number_text(row.time_s) + " after " +
                         engine::number_text(last_s_) + ", expected ascending",
                     "sort the rows by their time");
    last_s_ = row.time_s;
    row.button = fields[2];
    row.state = fields[3];
    if (!contains(buttons, row.button))
      return refused("button: unknown: found " + found_text(row.button) + ", expected " + listed(buttons), "");
    if (!contains(states, row.state))
      return refused("state: unknown: found " + found_text(row.state) + ", expected " + listed(states), "");
    if (Status status = number(fields, 4, 0, screen_max, row.x); !status) return status.error();
    if (Status status = number(fields, 5, 0, screen_max, row.y); !status) return status.error();
    return true;
  }

 private:
  static constexpr double time_max_s = 1e9;  // 30 years

  Error refused(const std::string& what, std::string hint) const {
    return Error{ErrorCode::invalid_input, source_ + ":" + std::to_string(line_number_) + ": " + what, std::move(hint)};
  }

  Status number(const std::array<std::string_view, columns.size()>& fields, std::size_t column, double min, double max,
                double& out) const {
    const std::optional<double> value = engine::parse_number(fields[column]);
    if (!value)
      return refused(std::string(columns[column]) + ": not a number: found " + found_text(fields[column]), "");
    if (!(*value >= min && *value <= max))
      return refused(std::string(columns[column]) + ": out of range: found " + engine::number_text(*value) +
                         ", expected " + engine::number_text(min) + ".." + engine::number_text(max),
                     "");
    out = *value;
    return {};
  }

  std::string_view next_line() {
    ++line_number_;
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

  std::string_view rest_;
  const std::string& source_;
  std::uint64_t line_number_ = 0;
  double last_s_ = 0;
};

/// Turns rows into inputs, in the order of the rows.
class InputCollector {
 public:
  InputCollector(double dt, bool right_presses, Point screen, const Bounds& window)
      : dt_(dt), right_presses_(right_presses), screen_(screen), window_(window) {}

  void take(const Row& row) {
    tick_ = static_cast<std::uint64_t>(row.time_s / dt_);
    const bool presses = row.button == "Left" || (right_presses_ && row.button == "Right");
    if (presses && row.state == "Pressed" && row.has_position()) {
      // If a release is missing, one is inserted, so that presses and releases alternate.
      if (!held_button_.empty()) add(InputKind::release, nullptr);
      held_button_ = row.button == "Left" ? "Left" : "Right";
      add(InputKind::press, &row);
    } else if (row.state == "Released" && !held_button_.empty() && row.button == held_button_) {
      held_button_ = {};
      add(InputKind::release, nullptr);
    } else if (row.state == "Drag" && !held_button_.empty() && row.has_position()) {
      // A tick keeps only its last drag, because later drags override earlier ones.
      const bool replaces = !inputs_.empty() && inputs_.back().tick == tick_ && inputs_.back().kind == InputKind::drag;
      if (replaces)
        place(inputs_.back(), row);
      else
        add(InputKind::drag, &row);
    }
  }

  std::vector<Input> finish() {
    ++tick_;  // the tick of the last row still runs
    add(InputKind::end, nullptr);
    return std::move(inputs_);
  }

 private:
  void place(Input& input, const Row& row) const {
    // The centre of the pixel. The y axis of a screen points down.
    input.values[0] = window_.lower.x + (row.x + 0.5) / screen_.x * (window_.upper.x - window_.lower.x);
    input.values[1] = window_.upper.y - (row.y + 0.5) / screen_.y * (window_.upper.y - window_.lower.y);
  }

  void add(InputKind kind, const Row* row) {
    Input input;
    input.tick = tick_;
    input.kind = kind;
    if (!inputs_.empty() && inputs_.back().tick == tick_) input.sequence = inputs_.back().sequence + 1;
    if (row != nullptr) place(input, *row);
    inputs_.push_back(input);
  }

  double dt_;
  bool right_presses_;
  Point screen_;  // px, size of the screen
  Bounds window_;
  std::uint64_t tick_ = 0;
  std::string_view held_button_;  // empty: no button is held
  std::vector<Input> inputs_;
};

}  // namespace

Result<Bounds> pointer_window(const Scene& scene) {
  if (!scene.pointer)
    return Error{ErrorCode::incompatible, "scene " + scene.name + ": takes no mouse: found no pointer, expected one",
                 "add \"pointer\" and the inputs press, drag and release"};
  if (scene.pointer->window) return *scene.pointer->window;
  if (scene.bounds) return *scene.bounds;
  return Error{ErrorCode::usage,
               "scene " + scene.name + ": cannot tell where the screen is: found neither pointer.window nor bounds",
               "add one of them to the scene"};
}

Result<std::vector<Input>> import_mouse(std::string_view csv, const std::string& source, const Scene& scene,
                                        const MouseImportOptions& options) {
  Result<Bounds> window = pointer_window(scene);
  if (options.window && scene.pointer) window = *options.window;
  if (!window) return window.error();

  // The format does not state the size of the screen, so the largest coordinates stand for it.
  Point screen{1, 1};
  {
    SessionReader reader(csv, source);
    if (Status status = reader.read_header(); !status) return status.error();
    Row row;
    bool has_row = false;
    for (;;) {
      const Result<bool> more = reader.next(row);
      if (!more) return more.error();
      if (!*more) break;
      has_row = true;
      if (!row.has_position()) continue;
      screen.x = row.x + 1 > screen.x ? row.x + 1 : screen.x;
      screen.y = row.y + 1 > screen.y ? row.y + 1 : screen.y;
    }
    if (!has_row)
      return Error{ErrorCode::invalid_input, source + ":1: the session is empty: found no row after the header", ""};
    if (row.time_s / scene.settings.dt >= static_cast<double>(limits::tick_count_max - 1))
      return Error{ErrorCode::limit,
                   source + ": the session is too long for ticks of " + engine::number_text(scene.settings.dt) +
                       " s: found " + engine::number_text(row.time_s) + " s, expected at most " +
                       std::to_string(limits::tick_count_max) + " ticks",
                   ""};
  }

  SessionReader reader(csv, source);
  if (Status status = reader.read_header(); !status) return status.error();
  InputCollector collector(scene.settings.dt, options.right_presses, screen, *window);
  Row row;
  for (;;) {
    const Result<bool> more = reader.next(row);
    if (!more) return more.error();
    if (!*more) break;
    collector.take(row);
  }
  return collector.finish();
}

}  // namespace ticktrue::tool
