// Makes the page: facts from the report and frames from the animation, as JSON inside the HTML.
// SPDX-License-Identifier: MIT
#include "tool/report_page/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/build_info.h"
#include "base/plain_text.h"
#include "replay/trace_reader.h"
#include "tool/output/compression.h"
#include "tool/output/scene_differences.h"
#include "tool/report_page/animation.h"
#include "tool/report_page/frame_coding.h"
#include "tool/report_page/page_parts.h"
#include "tool/session/simulations.h"
#include "verifier/compare/diff.h"
#include "verifier/peers/bundle.h"
#include "verifier/report/json_parts.h"
#include "verifier/report/report_ci.h"

namespace ticktrue::tool {
namespace {

using Json = nlohmann::ordered_json;
using engine::Point;

constexpr std::size_t input_marks_max = 4'000;
constexpr std::size_t checkpoint_marks_max = 4'000;
constexpr std::size_t others_max = 500;

std::string_view match_name(TickMatch match) {
  switch (match) {
    case TickMatch::same:
      return "same";
    case TickMatch::differs:
      return "differs";
    case TickMatch::differs_known:
      return "differs_known";
    case TickMatch::not_compared:
      return "not_compared";
    case TickMatch::unread:
      return "unread";
    case TickMatch::unread_intact:
      return "unread_intact";
  }
  return "";
}

/// A number with as many digits as a picture needs.
Json rounded_number(double value) {
  return Json::parse(fmt::format("{:.6g}", value));
}

std::string base64_of_floats(const std::vector<float>& values) {
  ByteWriter out;
  for (const float value : values) out.u32(__builtin_bit_cast(std::uint32_t, value));
  return base64(out.view());
}
std::string base64_of_doubles(const std::vector<double>& values) {
  ByteWriter out;
  for (const double value : values) out.f64(value);
  return base64(out.view());
}

// --- where two traces differ, and whom that concerns ----------------------------------------------------------------

std::vector<RowQuestion> questions_of(const verifier::Divergence& divergence) {
  std::vector<RowQuestion> questions;
  for (const verifier::LaneReport& row : divergence.rows) questions.push_back({row.table, row.row, row.id, row.name});
  for (const verifier::Candidate& row : divergence.candidates)
    questions.push_back({row.table, row.row, row.id, row.name});
  return questions;
}

/// Ticks done in the state that the divergence is about: those of its tick, or the ones before it.
std::uint64_t ticks_done_at(const verifier::Divergence& divergence) {
  const bool is_before = divergence.stage == verifier::stage_setup || divergence.stage == verifier::stage_load ||
                         divergence.stage == std::string_view("checkpoint");
  return divergence.tick + (is_before ? 0 : 1);
}

// --- frames ---------------------------------------------------------------------------------------------------------

/// Frames whose bodies are drawn as ghosts over an animation.
struct Ghosts {
  const Animation* animation = nullptr;  // whose bodies and figures the poses refer to
  std::vector<Frame> frames;
};

bool same_poses(const Frame& a, const Frame& b) {
  return std::equal(a.poses.begin(), a.poses.end(), b.poses.begin(), b.poses.end(), [](const Pose& p, const Pose& q) {
    return p.body == q.body && p.x == q.x && p.y == q.y && p.angle == q.angle;
  });
}

const Frame* find_frame(const std::vector<Frame>& frames, std::uint64_t ticks_done) {
  const auto at = std::lower_bound(frames.begin(), frames.end(), ticks_done,
                                   [](const Frame& frame, std::uint64_t done) { return frame.ticks_done < done; });
  return at != frames.end() && at->ticks_done == ticks_done ? &*at : nullptr;
}

/// Replaces frames of this build by recorded frames, where these are known.
void prefer_recorded(Animation& animation) {
  for (Frame& frame : animation.frames)
    if (const Frame* recorded = find_frame(animation.recorded, frame.ticks_done)) frame = *recorded;
  animation.recorded.clear();
}

/// What the trace's own recording was, where it is known and differs.
Ghosts ghosts_of(const Animation& animation) {
  Ghosts ghosts{&animation, {}};
  for (const Frame& frame : animation.recorded)
    if (find_frame(animation.frames, frame.ticks_done) != nullptr) ghosts.frames.push_back(frame);
  return ghosts;
}

/// The other trace, from where it begins to differ.
Ghosts ghosts_of(const Animation& animation, const Animation& other) {
  Ghosts ghosts{&other, {}};
  bool differs = false;
  for (const Frame& frame : animation.frames) {
    const Frame* ghost = find_frame(other.frames, frame.ticks_done);
    if (ghost == nullptr) continue;
    differs = differs || !same_poses(frame, *ghost);
    if (differs) ghosts.frames.push_back(*ghost);
  }
  return ghosts;
}

/// The largest distance between a body and its ghost at each frame of the animation.
struct Drift {
  std::vector<float> distance;  // m; NaN where there is no ghost
  std::vector<float> body;      // index in the animation of the body with that distance; -1: none
};

Drift measure_drift(const Animation& animation, const Ghosts& ghosts, bool same_before) {
  std::map<std::uint32_t, std::uint32_t> ghost_of_id;
  for (std::size_t g = 0; g < ghosts.animation->bodies.size(); ++g)
    ghost_of_id[ghosts.animation->bodies[g].id] = static_cast<std::uint32_t>(g);
  Drift drift;
  for (const Frame& frame : animation.frames) {
    const Frame* ghost = find_frame(ghosts.frames, frame.ticks_done);
    double furthest = 0;
    float body = -1;
    if (ghost == nullptr) {
      const bool is_before =
          same_before && (ghosts.frames.empty() || frame.ticks_done < ghosts.frames.front().ticks_done);
      drift.distance.push_back(is_before ? 0.0F : std::numeric_limits<float>::quiet_NaN());
      drift.body.push_back(-1);
      continue;
    }
    for (const Pose& pose : frame.poses) {
      const auto of = ghost_of_id.find(animation.bodies[pose.body].id);
      if (of == ghost_of_id.end()) continue;
      const auto at = std::lower_bound(ghost->poses.begin(), ghost->poses.end(), of->second,
                                       [](const Pose& p, std::uint32_t index) { return p.body < index; });
      if (at == ghost->poses.end() || at->body != of->second) continue;
      const double distance = std::sqrt((pose.x - at->x) * (pose.x - at->x) + (pose.y - at->y) * (pose.y - at->y));
      if (distance <= furthest) continue;
      furthest = distance;
      body = static_cast<float>(pose.body);
    }
    drift.distance.push_back(static_cast<float>(furthest));
    drift.body.push_back(body);
  }
  return drift;
}

// --- JSON -----------------------------------------------------------------------------------------------------------

Json outline_json(const Outline& outline, const Point& center) {
  Json points = Json::array();
  for (const Point& point : outline.points) {
    points.push_back(rounded_number(point.x - center.x));
    points.push_back(rounded_number(point.y - center.y));
  }
  Json object = {{"points", std::move(points)}};
  if (outline.radius > 0) object["radius"] = rounded_number(outline.radius);
  if (outline.is_line) object["line"] = true;
  if (outline.is_closed) object["closed"] = true;
  if (outline.is_sensor) object["sensor"] = true;
  return object;
}

/// The figures in use, each once.
class FigureList {
 public:
  std::size_t index_of(const Figure& figure) {
    Json outlines = Json::array();
    for (const Outline& outline : figure.outlines) outlines.push_back(outline_json(outline, figure.center));
    Json object = {{"type", engine::info_of(engine::body_types, figure.type).name}, {"outlines", std::move(outlines)}};
    const auto [at, is_new] = index_of_text_.try_emplace(object.dump(), list_.size());
    if (is_new) list_.push_back(std::move(object));
    return at->second;
  }
  const Json& json() const { return list_; }

 private:
  std::map<std::string, std::size_t> index_of_text_;
  Json list_ = Json::array();
};

Json frames_json(const std::vector<Frame>& frames, const Animation& animation, const PoseGrid& grid,
                 FigureList& figures) {
  const CodedFrames coded = code_frames(frames, animation.bodies.size(), grid);
  Json ticks = Json::array(), presence = Json::array(), ids = Json::array(), names = Json::array(),
       shapes = Json::array();
  for (const Frame& frame : frames) ticks.push_back(frame.ticks_done);
  for (const std::vector<BodyFrames>& rows : coded.presence) {
    Json parts = Json::array();
    for (const BodyFrames& part : rows) {
      parts.push_back(part.first);
      parts.push_back(part.count);
    }
    presence.push_back(std::move(parts));
  }
  for (const AnimatedBody& body : animation.bodies) {
    ids.push_back(body.id);
    names.push_back(body.name);
    shapes.push_back(figures.index_of(animation.figures[body.figure]));
  }
  return {{"ticks", std::move(ticks)},       {"ids", std::move(ids)},
          {"names", std::move(names)},       {"figure", std::move(shapes)},
          {"presence", std::move(presence)}, {"numbers", base64(zlib_of(coded.numbers))}};
}

Json sums_json(const Animation& animation) {
  std::vector<float> kinetic, potential, momentum_x, momentum_y, penetration, contacts;
  for (const Frame& frame : animation.frames) {
    const FrameSums& sums = frame.sums;
    kinetic.push_back(static_cast<float>(sums.kinetic));
    potential.push_back(static_cast<float>(sums.potential - animation.frames.front().sums.potential));
    momentum_x.push_back(static_cast<float>(sums.momentum_x));
    momentum_y.push_back(static_cast<float>(sums.momentum_y));
    penetration.push_back(static_cast<float>(sums.penetration));
    contacts.push_back(static_cast<float>(sums.contact_count));
  }
  return {{"kinetic", base64_of_floats(kinetic)},         {"potential", base64_of_floats(potential)},
          {"momentum_x", base64_of_floats(momentum_x)},   {"momentum_y", base64_of_floats(momentum_y)},
          {"penetration", base64_of_floats(penetration)}, {"contacts", base64_of_floats(contacts)}};
}

Json match_ranges_json(const Animation& animation) {
  Json list = Json::array();
  for (const MatchRange& part : animation.match_ranges) list.push_back({part.first, part.last, match_name(part.match)});
  return list;
}

/// [tick, count]; of many ticks, those that fall together on a screen as one.
Json ranges_json(const std::vector<verifier::TickRange>& ranges) {
  Json list = Json::array();
  for (const verifier::TickRange& range : ranges) list.push_back({range.first, range.last});
  return list;
}

Json input_ticks_json(const Animation& animation) {
  Json list = Json::array();
  const std::uint64_t width =
      animation.input_ticks.size() <= input_marks_max ? 1 : animation.tick_count / input_marks_max + 1;
  for (std::size_t i = 0; i < animation.input_ticks.size();) {
    const std::uint64_t first = animation.input_ticks[i].tick;
    std::uint64_t count = 0;
    for (; i < animation.input_ticks.size() && animation.input_ticks[i].tick / width == first / width; ++i)
      count += animation.input_ticks[i].count;
    list.push_back({first, count});
  }
  return list;
}

Json checkpoints_json(const Animation& animation) {
  Json list = Json::array();
  const std::size_t step = animation.checkpoints.size() / checkpoint_marks_max + 1;
  for (std::size_t i = 0; i < animation.checkpoints.size(); i += step) list.push_back(animation.checkpoints[i]);
  return list;
}

Json animation_json(const Animation& animation) {
  Json lines = Json::array();
  for (const auto& [tick, line] : animation.input_lines) lines.push_back({tick, line});
  return {{"strip", match_ranges_json(animation)},
          {"tick_count", animation.tick_count},
          {"ticks_run", animation.ticks_run},
          {"time_s", animation.time_s},
          {"stopped", animation.stopped},
          {"checkpoints", checkpoints_json(animation)},
          {"checkpoint_count", animation.checkpoints.size()},
          {"input_ticks", input_ticks_json(animation)},
          {"input_tick_count", animation.input_ticks.size()},
          {"input_count", animation.input_count},
          {"input_lines", std::move(lines)},
          {"no_poses", animation.no_poses}};
}

Json playback_json(const Animation& animation, const Ghosts& ghosts, bool has_drift, bool same_before) {
  const PoseGrid grid = choose_grid(animation);
  FigureList figures;
  Json named = Json::array();
  for (const std::uint32_t body : animation.named) named.push_back(body);
  std::vector<double> times;
  for (const Frame& frame : animation.frames) times.push_back(frame.time_s);
  Json object = {
      {"grid", {{"length", grid.length}, {"angle_count", grid.angle_count}}},
      {"view", {animation.view[0].x, animation.view[0].y, animation.view[1].x, animation.view[1].y}},
      {"stride", animation.stride},
      {"exact", animation.exact_last > 0 ? Json({animation.exact_first, animation.exact_last}) : Json(nullptr)},
      {"named", std::move(named)},
      {"times", base64_of_doubles(times)},
      {"bodies", frames_json(animation.frames, animation, grid, figures)},
      {"sums", sums_json(animation)},
      {"ghosts", nullptr},
      {"drift", nullptr}};
  if (!ghosts.frames.empty()) object["ghosts"] = frames_json(ghosts.frames, *ghosts.animation, grid, figures);
  if (has_drift) {
    const Drift drift = measure_drift(animation, ghosts, same_before);
    object["drift"] = {{"distance", base64_of_floats(drift.distance)}, {"body", base64_of_floats(drift.body)}};
  }
  object["figures"] = figures.json();
  return object;
}

Json trace_json(const replay::TraceReader& reader) {
  const replay::TraceSetup& setup = reader.setup();
  std::string detail;
  for (const replay::DetailInfo& info : replay::details)
    if (info.detail == setup.detail) detail = info.name;
  if (setup.detail == replay::Detail::full && setup.full_last != std::numeric_limits<std::uint64_t>::max())
    detail += " (ticks " + std::to_string(setup.full_first) + ".." + std::to_string(setup.full_last) + ")";
  return {{"file", reader.name()},
          {"size", reader.size()},
          {"title", setup.title},
          {"simulation", setup.simulation},
          {"physics_version", setup.physics_version},
          {"dt", setup.dt},
          {"detail", detail},
          {"checkpoint_interval", setup.checkpoint_interval}};
}

std::string file_word(const std::string& path) {
  const std::size_t slash = path.find_last_of("/\\");
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

/// What differs between the trace of the page and the other one, in a sentence.
std::string difference_sentence(const verifier::DiffReport& difference) {
  const std::string both = "this trace and " + file_word(difference.b.file);
  if (!difference.divergence) return both + ": " + difference.reason;
  const verifier::Divergence& divergence = *difference.divergence;
  std::string text = both + " differ from tick " + std::to_string(divergence.tick) + " on";
  if (!divergence.contents.empty())
    text += ": " + divergence.contents.front().place;
  else if (!divergence.tables.empty())
    text += ": " + divergence.tables.front().table + "." + divergence.tables.front().columns.front();
  return text;
}

/// Replaces each {{name}} of the page; what is put in is not looked at again.
std::string fill_in(std::string_view page, std::span<const std::pair<std::string_view, std::string>> values) {
  std::string text;
  while (!page.empty()) {
    const std::size_t open = std::min(page.find("{{"), page.size());
    text += page.substr(0, open);
    page.remove_prefix(open);
    const std::size_t close = page.find("}}");
    if (page.empty() || close == std::string_view::npos) break;
    for (const auto& [name, value] : values)
      if (name == page.substr(2, close - 2)) text += value;
    page.remove_prefix(close + 2);
  }
  return text + std::string(page);
}

class PageMaker {
 public:
  PageMaker(const verifier::Report& report, const PageOptions& options) : report_(report), options_(options) {}

  Result<Page> run() {
    data_["schema"] = "ticktrue.page/2";
    data_["made_by"] = build_line();
    data_["verify"] = Json::parse(verifier::report_json({&report_, 1}, options_.allow_truncated));
    data_["command"] = options_.command;
    Page page;
    page.exit_code = report_.exit_code(options_.allow_truncated);
    if (const Status status = examine(page.exit_code); !status) return status.error();
    add_others();
    if (difference_) page.against = diff_verdict_info(difference_->verdict).name;
    set_headline();
    page.html = fit();
    return page;
  }

 private:
  /// The verdict on top of the page: that on the trace, or that of the comparison with the other one if it is worse.
  void set_headline() {
    title_ = verdict_info(report_.verdict).name;
    std::string sentence = report_sentence(report_);
    std::string_view summary = verdict_info(report_.verdict).summary;
    const int of_trace = report_.exit_code(options_.allow_truncated);
    const int of_both = difference_ ? difference_->exit_code(options_.allow_truncated) : verifier::exit_ok;
    const int codes[] = {of_trace, of_both};
    if (of_both != of_trace && verifier::worst_exit_code(codes) == of_both) {
      title_ = diff_verdict_info(difference_->verdict).name;
      summary = diff_verdict_info(difference_->verdict).summary;
      sentence = difference_sentence(*difference_);
    }
    data_["headline"] = {{"verdict", title_}, {"sentence", std::move(sentence)}, {"summary", summary}};
    title_ += ": " + file_word(report_.file) + " - ticktrue";
  }

  Status examine(int& exit_code) {
    data_["trace"] = data_["against"] = data_["film"] = nullptr;
    data_["focus"] = report_.divergence ? Json(ticks_done_at(*report_.divergence)) : Json(nullptr);
    auto reader = replay::TraceReader::open(report_.file);
    if (!options_.against.empty()) {
      auto other = replay::TraceReader::open(options_.against);
      if (!other) return other.error();
      if (reader) {
        compare(*reader, *other);
        const int codes[] = {exit_code, difference_->exit_code(options_.allow_truncated)};
        exit_code = verifier::worst_exit_code(codes);
      }
      if (reader) animate_both(*reader, *other);
      return {};
    }
    if (!reader) return {};
    add_players(*reader);
    data_["trace"] = trace_json(*reader);
    animation_ = make_animation(*reader, animation_options(*reader, 0, 1));
    mark_divergence();
    return {};
  }

  /// Of a bundle: who differs, as text.
  void add_players(replay::TraceReader& reader) {
    const Result<std::optional<verifier::Bundle>> bundle = verifier::Bundle::read(reader);
    if (bundle && !*bundle) return;
    const std::string text = bundle ? (**bundle).text(reader.setup().schema) : bundle.error().message;
    const std::string who = bundle ? (**bundle).players_text() : "this bundle cannot be read";
    players_ =
        "<section id=\"players\" aria-labelledby=\"players-title\">\n  <h2 id=\"players-title\">Players</h2>\n  <p>" +
        html_text(who) + "</p>\n  <pre class=\"scroll\" tabindex=\"0\">" + html_text(text) + "</pre>\n</section>\n\n";
  }

  void compare(replay::TraceReader& reader, replay::TraceReader& other) {
    verifier::DiffOptions options;
    options.simulation = find_simulation(reader.setup().simulation);
    options.setup_keys = scene_differences;
    difference_ = diff(reader, other, options);
    if (!report_.divergence && difference_->divergence) data_["focus"] = ticks_done_at(*difference_->divergence);
  }

  AnimationOptions animation_options(const replay::TraceReader& reader, std::uint64_t part, std::uint64_t parts) {
    AnimationOptions options;
    options.simulation = find_simulation(reader.setup().simulation);
    const std::uint64_t tick_count = reader.tick_count_hint().value_or(0);
    if (options_.progress)
      options.progress = [this, tick_count, part, parts](std::uint64_t done) {
        options_.progress(part * tick_count + done, parts * tick_count);
      };
    const verifier::Divergence* divergence = report_.divergence ? &*report_.divergence : nullptr;
    if (divergence == nullptr && difference_ && difference_->divergence) divergence = &*difference_->divergence;
    if (divergence != nullptr) {
      options.focus = ticks_done_at(*divergence);
      options.questions = questions_of(*divergence);
    } else if (report_.non_finite) {
      options.focus = report_.non_finite->tick;
    }
    return options;
  }

  void animate_both(replay::TraceReader& reader, replay::TraceReader& other) {
    data_["trace"] = trace_json(reader);
    animation_ = make_animation(reader, animation_options(reader, 0, 2));
    mark_divergence();
    other_ = make_animation(other, animation_options(other, 1, 2));
    prefer_recorded(*animation_);
    prefer_recorded(*other_);
    Json against = {{"trace", trace_json(other)}, {"diff", Json::parse(diff_json(*difference_))}};
    against["strip"] = match_ranges_json(*other_);
    against["differing"] = ranges_json(difference_->differing);
    against["tick_count"] = other_->tick_count;
    against["no_poses"] = other_->no_poses;
    data_["against"] = std::move(against);
  }

  /// A tick whose hash agrees, and another part of its record does not, is no tick as recorded.
  void mark_divergence() {
    if (report_.verdict != verifier::Verdict::diverged || !report_.divergence) return;
    const std::uint64_t ticks_done = ticks_done_at(*report_.divergence);
    if (ticks_done > 0) mark_differing(*animation_, ticks_done - 1);
  }

  void add_others() {
    Json list = Json::array();
    std::size_t count = 0;
    for (const verifier::Report& other : options_.others) {
      if (++count > others_max) break;
      list.push_back(
          {{"file", other.file}, {"verdict", verdict_info(other.verdict).name}, {"sentence", report_sentence(other)}});
    }
    data_["others"] = std::move(list);
    data_["other_count"] = options_.others.size();
  }

  std::string html() const {
    const std::pair<std::string_view, std::string> values[] = {
        {"title", html_text(title_)},
        {"css", std::string(page_css)},
        {"players", players_},
        {"text", html_text(report_text(report_) + (difference_ ? "\n" + diff_text(*difference_) : ""))},
        {"data", script_json(data_.dump(-1, ' ', false, Json::error_handler_t::replace))},
        {"js", std::string(page_js)}};
    return fill_in(page_html, values);
  }

  /// The page with as many frames as go into it.
  std::string fit() {
    if (!animation_) return html();
    for (;;) {
      put_animation();
      std::string page = html();
      if (page.size() <= options_.size_max || !animation_->no_poses.empty()) return page;
      const bool is_thinner = halve_frames(*animation_);
      if (other_) halve_frames(*other_);
      if (is_thinner) continue;
      animation_->no_poses = "The shapes alone would make this page larger than it may be.";
    }
  }

  void put_animation() {
    data_["film"] = animation_json(*animation_);
    data_["film"]["playback"] = nullptr;
    if (!animation_->no_poses.empty() || animation_->frames.empty() || animation_->view.size() != 2) return;
    if (other_) even_out();
    const bool has_other = other_ && other_->no_poses.empty();
    const Ghosts ghosts = has_other ? ghosts_of(*animation_, *other_) : ghosts_of(*animation_);
    data_["film"]["playback"] = playback_json(*animation_, ghosts, has_other || !ghosts.frames.empty(), has_other);
  }

  /// Gives both animations the same frames.
  void even_out() {
    while (other_->stride < animation_->stride && halve_frames(*other_)) {
    }
    while (animation_->stride < other_->stride && halve_frames(*animation_)) {
    }
  }

  const verifier::Report& report_;
  const PageOptions& options_;
  Json data_;
  std::string title_;
  std::string players_;  // HTML
  std::optional<verifier::DiffReport> difference_;
  std::optional<Animation> animation_;
  std::optional<Animation> other_;
};

}  // namespace

std::string html_text(std::string_view text) {
  std::string safe;
  for (const char c : plain_text(text)) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (c == '\'')
      safe += "&#39;";
    else
      safe += c;
  }
  return safe;
}

std::string script_json(std::string_view json) {
  // Inside of JSON these three stand in strings only.
  std::string safe;
  safe.reserve(json.size());
  for (const char c : plain_text(json)) {
    if (c == '<')
      safe += "\\u003c";
    else if (c == '>')
      safe += "\\u003e";
    else if (c == '&')
      safe += "\\u0026";
    else
      safe += c;
  }
  return safe;
}

Result<Page> make_report_page(const verifier::Report& report, const PageOptions& options) {
  return PageMaker(report, options).run();
}

}  // namespace ticktrue::tool
