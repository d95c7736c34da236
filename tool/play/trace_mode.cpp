// Plays a trace while re-simulating it; stops at a divergence and shows it.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "base/hash.h"
#include "tool/output/trace_text.h"
#include "tool/play/display.h"
#include "tool/play/playback.h"
#include "tool/play/timeline_picture.h"
#include "verifier/locate/locate_cells.h"
#include "verifier/report/report.h"

namespace ticktrue::play {
namespace {

constexpr int timeline_px = 66;
constexpr int layer_keys_px = 34;
constexpr std::size_t row_count_max = 10;  // lanes and bodies that are listed

std::vector<PanelLine> trace_help() {
  std::vector<PanelLine> list{{"space", "play, pause"},
                              {". ,", "one tick on, one back"},
                              {"right, left", "a second on, a second back"},
                              {"page down, up", "the next checkpoint, the one before"},
                              {"home, end", "first and last tick"},
                              {"timeline", "click or drag: go there"},
                              {"d", "go to the first difference"},
                              {"g", "ghosts: the other or the recorded state"},
                              {"[ ]", "slower, faster"},
                              {"q, Esc", "end"},
                              {"", ""},
                              {"wheel, + -", "zoom"},
                              {"drag", "pan; f: as at first"},
                              {"", ""}};
  for (const LayerInfo& info : all_layers) list.push_back({std::string(info.key), std::string(info.summary)});
  return list;
}

/// A line for a lane that differs: "column", "expected", "got".
std::string side_by_side(const std::string& what, const std::string& expected, const std::string& got) {
  return fmt::format("{:<30.30} {:>17.17} {:>17.17}", what, expected, got);
}

std::string lane_value_text(const verifier::LaneReport& row, const std::optional<std::uint64_t>& bits) {
  return bits ? lane_text(row.type, *bits) : "no such row";
}

std::vector<PanelLine> divergence_lines(const verifier::Report& report) {
  std::vector<PanelLine> lines;
  if (!report.divergence) return {{"diverged: " + report.reason, "", theme::bad}};
  const verifier::Divergence& found = *report.divergence;
  lines.push_back({fmt::format("diverged at tick {}  ({:.3f} s)", found.tick, found.time_s), "", theme::bad});
  if (found.stage) lines.push_back({"stage " + *found.stage, "", theme::text});
  std::string columns;
  for (const verifier::TableDifference& table : found.tables)
    for (const std::string& column : table.columns) {
      if (columns.size() > 56) continue;
      columns += (columns.empty() ? "" : ", ") + table.table + "." + column;
    }
  if (!columns.empty()) lines.push_back({columns.substr(0, 66), "", theme::text});
  if (!found.rows.empty()) {
    lines.push_back({side_by_side("", "expected", "got"), "", theme::faint});
    for (std::size_t i = 0; i < found.rows.size() && i < row_count_max; ++i) {
      const verifier::LaneReport& row = found.rows[i];
      std::string what = (row.name.empty() ? row.table + " " + std::to_string(row.row) : row.name) + " " + row.column;
      if (row.lane_count > 1) what += "[" + std::to_string(row.lane) + "]";
      lines.push_back(
          {side_by_side(what, lane_value_text(row, row.expected), lane_value_text(row, row.got)), "", theme::text});
    }
    if (found.lane_count > row_count_max)
      lines.push_back({fmt::format("and {} more", found.lane_count - row_count_max), "", theme::faint});
  } else {
    lines.push_back({side_by_side("", "expected", "got"), "", theme::faint});
    lines.push_back({side_by_side("root hash", hex64(found.expected_root), hex64(found.got_root)), "", theme::text});
    for (std::size_t i = 0; i < found.candidates.size() && i < row_count_max; ++i)
      lines.push_back({"can have differed: " + found.candidates[i].name, "", theme::text});
  }
  return lines;
}

/// One trace, optionally with a second one for comparison.
class TraceMode {
 public:
  TraceMode(const cli::PlayOptions& options, Display& display, Player& player, Player* other, const LayerSet& layers)
      : options_(options),
        display_(display),
        player_(player),
        other_(other),
        picture_(player.engine()),
        playback_(player, other, first_view(player.engine(), options.width, options.height), layers) {
    if (other != nullptr) other_drawing_.emplace(other->engine().scene(), *other->engine().state().schema);
  }

  int run() {
    display_.set_title("ticktrue - " + player_.path());
    while (true) {
      draw();
      const Result<HostFrame> frame = display_.show();
      if (!frame) return cli::fail_usage(frame.error());
      playback_.take(*frame, [this] { return display_.is_late(); });
      if (playback_.wants_quit()) break;
    }
    draw();
    if (const Status status = display_.write_files(player_.engine(), picture_, playback_.view()); !status)
      return cli::fail_usage(status.error());
    return report();
  }

 private:
  void draw() {
    const View& view = playback_.view();
    Canvas& canvas = display_.begin_picture(view);
    picture_.draw(canvas, view, playback_.layers());
    const bool at_difference = player_.difference() && player_.position() > *player_.difference();
    if (at_difference) {
      if (playback_.shows_ghosts()) draw_recorded(canvas, view);
      picture_.draw_rings(canvas, view, player_.named_bodies());
    }
    if (other_drawing_ && playback_.shows_ghosts() && other_->position() == player_.position())
      picture_.draw_ghosts(canvas, view, *other_drawing_, other_->engine().state());
    draw_state(canvas);
    draw_layer_keys(canvas, display_.fonts().small, playback_.layers());
    draw_timeline(canvas, display_.fonts().small, player_, other_, view);
    if (at_difference)
      if (const verifier::Report* found = player_.report())
        draw_panel(canvas, display_.fonts().small, Corner::upper_right, divergence_lines(*found), layer_keys_px);
    if (player_.refused())
      draw_panel(canvas, display_.fonts().normal, Corner::lower_left,
                 {{"cannot go on: " + *player_.refused(), "", theme::bad}}, timeline_px);
    if (playback_.shows_help()) draw_help(canvas, display_.fonts(), "Looking at a trace", trace_help());
  }

  /// The state that was recorded of the tick that differs, where the trace has it.
  void draw_recorded(Canvas& canvas, const View& view) {
    const Bytes* image = player_.recorded_image();
    if (image == nullptr || player_.position() != *player_.difference() + 1) return;
    const auto state = verifier::ImageState::of(player_.setup().schema, *image);
    if (state) picture_.draw_ghosts(canvas, view, picture_.drawing(), state->view());
  }

  void draw_state(Canvas& canvas) {
    const engine::Engine& engine = player_.engine();
    const std::uint64_t position = player_.position();
    PanelLine verdict{"so far", "as recorded, bit for bit", theme::good};
    if (player_.difference())
      verdict = {"so far", fmt::format("differs from tick {} on", *player_.difference()), theme::bad};
    else if (position > 0 && player_.match(position - 1) == Match::unknown)
      verdict = {"so far", "a recorded state", theme::faint};
    std::vector<PanelLine> lines{
        {"trace", player_.path().substr(player_.path().find_last_of('/') + 1)},
        {"scene", engine.scene().name},
        {"tick", fmt::format("{}  {:.2f} s", position, engine.time_s())},
        {"hash", hex64(root_hash(engine.state())), theme::accent},
        verdict,
        {"bodies", fmt::format("{}", picture_.bodies().size())},
        {"tick takes", fmt::format("{:.3f} ms", player_.ms_per_tick())},
        {playback_.is_playing() ? "playing" : "paused",
         playback_.is_seeking() ? "seeking" : fmt::format("{:g}x   h: help", playback_.speed()),
         playback_.is_playing() ? theme::text : theme::warning}};
    if (const std::string pace = display_.pace_text(); !pace.empty()) lines.push_back({"frames", pace});
    if (position > 0 && player_.has_inputs(position - 1)) {
      std::string text = engine.inputs_text(position - 1, player_.inputs(position - 1));
      text = text.substr(0, text.find('\n'));
      lines.push_back({"input", text.substr(0, 60), theme::text});
    }
    if (other_ != nullptr) {
      lines.push_back({"ghosts", other_->path().substr(other_->path().find_last_of('/') + 1), theme::ghost});
      if (const auto first = first_recorded_difference())
        lines.push_back({"", fmt::format("recordings differ from tick {} on", *first), theme::ghost});
    }
    draw_panel(canvas, display_.fonts().normal, Corner::upper_left, lines);
  }

  /// The first tick of which the two traces hold other states.
  std::optional<std::uint64_t> first_recorded_difference() {
    const std::uint64_t common = std::min(player_.tick_count(), other_->tick_count());
    while (compared_ < common && player_.recorded_hash(compared_) == other_->recorded_hash(compared_)) ++compared_;
    if (compared_ < std::max(player_.tick_count(), other_->tick_count())) return compared_;
    return std::nullopt;
  }

  int report() {
    int code = cli::exit_ok;
    const replay::TraceTail& tail = player_.tail();
    if (tail.condition != replay::TraceCondition::complete) {
      code = cli::exit_code_of_condition(tail.condition);
      cli::print_warning(player_.path() + ": " + (tail.message.empty() ? "ends early" : tail.message) +
                         "; played the " + std::to_string(player_.tick_count()) + " ticks that are intact");
    }
    if (player_.refused()) code = cli::exit_not_comparable;
    if (player_.setup().physics_version != engine::physics_version)
      code = cli::exit_not_comparable;
    else if (player_.difference())
      code = cli::exit_finding;
    std::uint64_t same = 0;
    for (std::uint64_t tick = 0; tick < player_.tick_count(); ++tick)
      if (player_.match(tick) == Match::same) ++same;
    if (options_.json) {
      cli::Json object;
      object["schema"] = "ticktrue.play/1";
      object["mode"] = "trace";
      object["file"] = player_.path();
      object["ticks"] = player_.tick_count();
      object["position"] = player_.position();
      object["ticks_as_recorded"] = same;
      object["first_difference"] = player_.difference() ? cli::Json(*player_.difference()) : cli::Json(nullptr);
      object["named_bodies"] = player_.named_bodies();
      object["hash"] = hex64(root_hash(player_.engine().state()));
      object["display"] = display_.frames_json();
      cli::print_json(object);
      return code;
    }
    cli::print(fmt::format("played  {}  {} of {} ticks as recorded\n", player_.path(), same, player_.tick_count()));
    if (player_.difference())
      cli::print(fmt::format("  differs  first at tick {}; ticktrue verify {} says more\n", *player_.difference(),
                             verifier::shell_word(player_.path())));
    cli::print("  display  " + display_.frames_text() + "\n");
    return code;
  }

  const cli::PlayOptions& options_;
  Display& display_;
  Player& player_;
  Player* other_;
  WorldPicture picture_;
  std::optional<tool::Drawing> other_drawing_;
  Playback playback_;
  std::uint64_t compared_ = 0;  // ticks of both traces that are alike
};

}  // namespace

int play_trace_file(const cli::PlayOptions& options) {
  const Result<LayerSet> layers = parse_layers(options.layers);
  if (!layers) return cli::fail_usage(layers.error());
  const auto player = Player::open(options.what);
  if (!player) return cli::fail(player.error());
  if (const Status known = cli::check_tick("--from", options.from, (*player)->tick_count() + 1); !known)
    return cli::fail_usage(known.error());
  if ((*player)->setup().physics_version != engine::physics_version)
    cli::print_warning(options.what + ": physics version: found " + std::to_string((*player)->setup().physics_version) +
                       ", expected " + std::to_string(engine::physics_version) + "; the states shown are this build's");
  std::unique_ptr<Player> other;
  if (!options.against.empty()) {
    auto opened = Player::open(options.against);
    if (!opened) return cli::fail(opened.error());
    other = std::move(*opened);
  }
  const auto display = Display::open(options);
  if (!display) return cli::fail_usage(display.error());
  const auto never_late = [] { return cli::stop_requested(); };
  (*player)->go_to(options.from, true, never_late);
  if (other) other->go_to((*player)->position(), false, never_late);
  return TraceMode(options, **display, **player, other.get(), *layers).run();
}

}  // namespace ticktrue::play
