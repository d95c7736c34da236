// Reading scripts, and playing them.
// SPDX-License-Identifier: MIT
#include "tool/play/script.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace ticktrue::play {
namespace {

using Json = nlohmann::json;

constexpr double time_s_max = 1e6;
constexpr double pixel_max = 1e5;
constexpr double steps_max = 100;

struct ButtonName {
  Button button;
  std::string_view name;
};
constexpr std::array<ButtonName, 3> buttons{
    {{Button::left, "left"}, {Button::middle, "middle"}, {Button::right, "right"}}};

struct EventName {
  std::string_view name;
  EventKind kind;
  std::string_view keys;  // that count, besides t and event
};
constexpr std::array<EventName, 7> events{{{"press", EventKind::press, "x,y,button,ctrl"},
                                           {"release", EventKind::release, "x,y,button"},
                                           {"click", EventKind::press, "x,y,button,ctrl"},
                                           {"move", EventKind::move, "x,y"},
                                           {"wheel", EventKind::wheel, "x,y,steps"},
                                           {"key", EventKind::key, "key"},
                                           {"quit", EventKind::quit, ""}}};

bool has_word(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::string_view first = list.substr(0, list.find(','));
    if (first == word) return true;
    list.remove_prefix(std::min(first.size() + 1, list.size()));
  }
  return false;
}

/// One line of a script.
class LineParser {
 public:
  LineParser(const Json& object, std::string place) : object_(object), place_(std::move(place)) {}

  Status parse(std::vector<Event>& out) {
    if (!object_.is_object()) return refuse("line", "something else", "one JSON object");
    Event event;
    std::string name, button = "left";
    if (const Status status = text("event", name); !status) return status;
    const auto row = std::find_if(events.begin(), events.end(), [&](const EventName& e) { return e.name == name; });
    if (row == events.end())
      return refuse("event", "\"" + name + "\"", "press, release, click, move, wheel, key or quit");
    event.kind = row->kind;
    for (const auto& [key, value] : object_.items())
      if (key != "t" && key != "event" && !has_word(row->keys, key))
        return refuse(key, "a key that " + name + " has not", "t, event, " + std::string(row->keys));
    if (const Status status = number("t", 0, time_s_max, event.at_s); !status) return status;
    if (const Status status = values(*row, event, button); !status) return status;
    const auto found =
        std::find_if(buttons.begin(), buttons.end(), [&](const ButtonName& b) { return b.name == button; });
    if (found == buttons.end()) return refuse("button", "\"" + button + "\"", "left, middle or right");
    event.button = found->button;
    out.push_back(event);
    if (name == "click") {
      event.kind = EventKind::release;
      out.push_back(event);
    }
    return {};
  }

 private:
  Status values(const EventName& row, Event& event, std::string& button) const {
    if (has_word(row.keys, "x")) {
      if (const Status status = number("x", -pixel_max, pixel_max, event.x); !status) return status;
      if (const Status status = number("y", -pixel_max, pixel_max, event.y); !status) return status;
    }
    if (has_word(row.keys, "steps"))
      if (const Status status = number("steps", -steps_max, steps_max, event.steps); !status) return status;
    if (has_word(row.keys, "key"))
      if (const Status status = text("key", event.key); !status) return status;
    if (object_.contains("button"))
      if (const Status status = text("button", button); !status) return status;
    if (object_.contains("ctrl")) {
      if (!object_["ctrl"].is_boolean()) return refuse("ctrl", object_["ctrl"].dump(), "true or false");
      event.ctrl = object_["ctrl"].get<bool>();
    }
    return {};
  }

  Error refuse(const std::string& key, const std::string& found, const std::string& expected) const {
    return {ErrorCode::invalid_input, place_ + ": " + key + ": found " + found + ", expected " + expected, ""};
  }
  Status number(const char* key, double min, double max, double& out) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return refuse(key, "none", "a number");
    if (!found->is_number()) return refuse(key, found->dump(), "a number");
    out = found->get<double>();
    if (!(out >= min && out <= max))
      return refuse(key, found->dump(), "a number in " + Json(min).dump() + ".." + Json(max).dump());
    return {};
  }
  Status text(const char* key, std::string& out) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return refuse(key, "none", "a text");
    if (!found->is_string()) return refuse(key, found->dump(), "a text");
    out = found->get<std::string>();
    return {};
  }

  const Json& object_;
  std::string place_;
};

}  // namespace

Result<std::vector<Event>> parse_script(std::string_view text, const std::string& place) {
  std::vector<Event> list;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const std::string here = place + ":" + std::to_string(number);
    const Json object = Json::parse(line.begin(), line.end(), nullptr, false);
    if (object.is_discarded())
      return Error{ErrorCode::invalid_input, here + ": found a line that is no JSON, expected one object",
                   R"(such as {"t":0.5,"event":"click","button":"left","x":400,"y":300})"};
    if (const Status status = LineParser(object, here).parse(list); !status) return status.error();
    if (list.size() > 1 && list.back().at_s < list[list.size() - 2].at_s)
      return Error{ErrorCode::invalid_input,
                   here + ": t: found a time before that of the line above, expected ascending", ""};
  }
  return list;
}

Result<HostFrame> ScriptedHost::next(const Canvas& picture) {
  Result<HostFrame> frame = host_.next(picture);
  if (!frame) return frame;
  const double end_s = time_s_ + frame->seconds;
  for (; next_event_ < script_.size() && script_[next_event_].at_s < end_s; ++next_event_) {
    Event event = script_[next_event_];
    event.at_s = std::max(0.0, event.at_s - time_s_);
    frame->events.push_back(event);
  }
  std::stable_sort(frame->events.begin(), frame->events.end(),
                   [](const Event& a, const Event& b) { return a.at_s < b.at_s; });
  time_s_ = end_s;
  ++frames_done_;
  if (frame_count_ != 0 && frames_done_ >= frame_count_) {
    Event quit;
    quit.at_s = frame->seconds;
    frame->events.push_back(quit);
  }
  return frame;
}

}  // namespace ticktrue::play
