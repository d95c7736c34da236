// The display: window, frame times and files.
// SPDX-License-Identifier: MIT
#include "tool/play/display.h"

#include <fmt/format.h>

#include "base/hash.h"
#include "tool/play/picture/png.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::play {
namespace {

constexpr double ticks_share = 0.75;  // of a picture's time; the rest is for drawing it
constexpr double forget_share = 0.05;
constexpr std::size_t script_size_max = 16u << 20;  // bytes

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

Status write_file(const std::string& path, bool overwrite, std::string_view content) {
  auto file = verifier::DataFile::create(path, overwrite);
  if (!file) return file.error();
  if (const Status status = file->write(content); !status) return status;
  return file->close();
}

/// What was drawn, and the state from which it was.
cli::Json frame_json(const engine::Engine& engine, const WorldPicture& picture, const View& view,
                     const Canvas& canvas) {
  cli::Json object;
  object["schema"] = "ticktrue.play_frame/1";
  object["tick"] = engine.tick();
  object["time_s"] = engine.time_s();
  object["hash"] = hex64(root_hash(engine.state()));
  object["width"] = canvas.width();
  object["height"] = canvas.height();
  object["px_per_m"] = view.scale;
  object["center"] = {view.center.x, view.center.y};
  object["bodies"] = cli::Json::array();
  for (const tool::DrawnBody& body : picture.bodies()) {
    const Pixel at = view.to_pixel(body.center);
    const bool is_seen = body.is_finite && at.x >= 0 && at.y >= 0 && at.x < canvas.width() && at.y < canvas.height();
    cli::Json row{{"id", body.id},      {"name", picture.drawing().name(body)},
                  {"x", body.center.x}, {"y", body.center.y},
                  {"px", at.x},         {"py", at.y}};
    if (is_seen) {
      const Color color = canvas.at(static_cast<int>(at.x), static_cast<int>(at.y));
      row["color"] = fmt::format("{:02x}{:02x}{:02x}", color.red, color.green, color.blue);
    }
    object["bodies"].push_back(std::move(row));
  }
  return object;
}

}  // namespace

Display::Display(const cli::PlayOptions& options, std::unique_ptr<Host> host, std::vector<Event> script)
    : options_(options),
      host_(std::move(host)),
      scripted_(*host_, std::move(script), options.frame_count),
      canvas_(options.width, options.height) {}

Result<std::unique_ptr<Display>> Display::open(const cli::PlayOptions& options) {
  if (!options.screenshot.empty() && !ends_with(options.screenshot, ".png"))
    return Error{ErrorCode::usage, "--screenshot: found " + options.screenshot + ", expected a name that ends in .png",
                 ""};
  for (const std::string& path : {options.screenshot, options.dump})
    if (!path.empty())
      if (const Status status = verifier::check_writable_target(path, options.force); !status) return status.error();
  if (options.headless && options.frame_count == 0 && options.script.empty())
    return Error{ErrorCode::usage,
                 "--headless: found neither --frames nor --script, expected one that ends the session",
                 "add --frames N"};
  std::vector<Event> script;
  if (!options.script.empty()) {
    const Result<std::string> text = cli::read_text_file(options.script, script_size_max);
    if (!text) return text.error();
    Result<std::vector<Event>> events = parse_script(*text, options.script);
    if (!events) return events.error();
    script = std::move(*events);
    const bool ends = !script.empty() && script.back().kind == EventKind::quit;
    if (options.headless && options.frame_count == 0 && !ends)
      return Error{ErrorCode::usage, options.script + ": found no quit at its end, expected one that ends the session",
                   "append {\"t\":10,\"event\":\"quit\"}, or add --frames N"};
  }
  Result<std::unique_ptr<Host>> host = options.headless
                                           ? Result<std::unique_ptr<Host>>(no_display(options.hz))
                                           : open_window("ticktrue", WindowSize{options.width, options.height});
  if (!host) return host.error();
  return std::unique_ptr<Display>(new Display(options, std::move(*host), std::move(script)));
}

Canvas& Display::begin_picture(const View& view) {
  if (canvas_.width() != view.width || canvas_.height() != view.height) canvas_.resize(view.width, view.height);
  return canvas_;
}

Result<HostFrame> Display::show() {
  const double drawn_s = std::chrono::duration<double>(Clock::now() - last_).count();
  Result<HostFrame> frame = scripted_.next(canvas_);
  const Clock::time_point now = Clock::now();
  if (!frame) return frame;
  const bool is_first = scripted_.frames_done() == 1;
  const auto mean = [is_first](double& value, double latest) {
    value += (is_first ? 1 : forget_share) * (latest - value);
  };
  mean(recent_work_s_, drawn_s + frame->show_s);
  mean(recent_frame_s_, is_first ? picture_s : std::chrono::duration<double>(now - last_).count());
  work_.add(drawn_s + frame->show_s);
  shown_.add(frame->show_s);
  if (is_first) first_ = now;
  last_ = now;
  if (cli::stop_requested()) {
    Event quit;
    quit.at_s = frame->seconds;
    frame->events.push_back(quit);
  }
  return frame;
}

bool Display::is_late() const {
  const bool is_over = std::chrono::duration<double>(Clock::now() - last_).count() > ticks_share * picture_s;
  return (is_over && !options_.headless) || cli::stop_requested();
}

Status Display::write_files(const engine::Engine& engine, const WorldPicture& picture, const View& view) {
  if (!options_.screenshot.empty()) {
    const Bytes png = png_of(canvas_);
    const std::string_view content(reinterpret_cast<const char*>(png.data()), png.size());
    if (const Status status = write_file(options_.screenshot, options_.force, content); !status) return status;
  }
  if (options_.dump.empty()) return {};
  return write_file(options_.dump, options_.force, frame_json(engine, picture, view, canvas_).dump(1) + "\n");
}

double Display::frames_per_second() const {
  const double seconds = std::chrono::duration<double>(last_ - first_).count();
  return seconds > 0 ? static_cast<double>(scripted_.frames_done() - 1) / seconds : 0;
}

cli::Json Display::frames_json() const {
  const auto spread = [](const tool::TickTimes& times) {
    return cli::Json{{"median", 1e3 * times.median_s()}, {"p99", 1e3 * times.quantile_s(0.99)}};
  };
  return {{"frames", scripted_.frames_done()},
          {"frames_per_second", frames_per_second()},
          {"work_ms", spread(work_)},
          {"show_ms", spread(shown_)}};
}

std::string Display::frames_text() const {
  return fmt::format(
      "{} frames, {:.1f} a second; {:.2f} ms of work in each (median), {:.2f} ms in the slowest hundredth",
      scripted_.frames_done(), frames_per_second(), 1e3 * work_.median_s(), 1e3 * work_.quantile_s(0.99));
}

std::string Display::pace_text() const {
  if (options_.headless || recent_frame_s_ <= 0) return "";
  return fmt::format("{:.1f} a second, {:.1f} ms of work", 1 / recent_frame_s_, 1e3 * recent_work_s_);
}

Result<LayerSet> parse_layers(const std::string& keys) {
  LayerSet set;
  for (const char key : keys)
    if (!set.toggle_key(std::string(1, key))) {
      std::string known;
      for (const LayerInfo& info : all_layers) known += info.key;
      return Error{ErrorCode::usage, "--layers: found \"" + std::string(1, key) + "\", expected keys out of " + known,
                   ""};
    }
  return set;
}

}  // namespace ticktrue::play
