// Playing in a scene: each session is a recording; a restart or another scene begins the next one.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <filesystem>

#include "base/hash.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "replay/file/file.h"
#include "tool/play/display.h"
#include "tool/play/session.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::play {
namespace {

/// The scenes of the keys 1 to 9.
constexpr std::array<const char*, 9> key_scenes{
    "thesis",           "stack?boxes=12",           "pyramid?base=16",    "mixed_pile?bodies=200", "shapes?bodies=80",
    "bridge?planks=24", "chain?links=20&angle=1.2", "card_house?tents=4", "billiards?walls=1"};

/// Forwards to a simulation, and measures the last steps.
class TimedSimulation : public Simulation {
 public:
  explicit TimedSimulation(engine::Engine& engine) : engine_(engine) {}
  Status accept(const TickInput& input) const override { return engine_.accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override {
    const auto before = std::chrono::steady_clock::now();
    Status did = engine_.step(input, observer);
    const double ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    ms_per_tick_ = ms_per_tick_ == 0 ? ms : 0.95 * ms_per_tick_ + 0.05 * ms;
    return did;
  }
  const StateView& state() const override { return engine_.state(); }
  Status load(ByteView image) override { return engine_.load(image); }
  std::span<const std::string> stage_names() const override { return engine_.stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return engine_.row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return engine_.inputs_text(tick, inputs);
  }
  double ms_per_tick() const { return ms_per_tick_; }

 private:
  engine::Engine& engine_;
  double ms_per_tick_ = 0;
};

/// "OUT.ttr", "OUT-2.ttr", ... or "session-1.ttr", "session-2.ttr", ...: the first from `number` on that is free.
std::string file_name(const cli::PlayOptions& options, int& number) {
  if (!options.output.empty() && number == 1) return options.output;
  while (true) {
    std::string name = fmt::format("session-{}.ttr", number);
    if (!options.output.empty()) {
      const std::filesystem::path path(options.output);
      name = (path.parent_path() / fmt::format("{}-{}{}", path.stem().string(), number, path.extension().string()))
                 .string();
    }
    std::error_code ignored;
    if (!std::filesystem::exists(name, ignored)) return name;
    ++number;
  }
}

std::uint32_t row_count(const StateView& state, std::string_view table) {
  const auto index = state.schema->find_table(table);
  return index ? state.tables[*index].row_count : 0;
}

const std::vector<PanelLine>& scene_help() {
  static const std::vector<PanelLine> lines = [] {
    std::vector<PanelLine> list{{"left click", "a circle"},
                                {"right click", "a box"},
                                {"middle click", "a convex polygon"},
                                {"ctrl + click", "the same, static"},
                                {"press and drag", "pull a body"},
                                {"", ""},
                                {"space", "pause, go on"},
                                {".", "one tick"},
                                {"r", "restart"},
                                {"1 .. 9", "another scene"},
                                {"q, Esc", "end; the recording is closed"},
                                {"", ""},
                                {"wheel, + -", "zoom"},
                                {"middle drag, arrows", "pan; Home: as at first"},
                                {"", ""}};
    for (const LayerInfo& info : all_layers) list.push_back({std::string(info.key), std::string(info.summary)});
    return list;
  }();
  return lines;
}

/// What one recording became.
struct Recorded {
  std::string file;
  std::string scene;
  replay::RecordResult result;
  std::uint64_t input_count = 0;
  std::uint64_t body_count = 0;
};

/// Runs session after session until the person quits.
class SceneMode {
 public:
  SceneMode(const cli::PlayOptions& options, Display& display, const LayerSet& layers)
      : options_(options), display_(display), layers_(layers) {
    size_.width = options.width;
    size_.height = options.height;
  }

  int run(engine::Scene scene) {
    while (true) {
      const Result<Request> request = run_session(scene);
      if (!request) return cli::fail_usage(request.error());
      if (*request == Request::quit || *request == Request::none) break;
      if (*request == Request::scene) {
        Result<engine::Scene> next = engine::make_builtin_scene(key_scenes[static_cast<std::size_t>(wished_ - 1)]);
        TICKTRUE_ASSERT(next.has_value());
        scene = std::move(*next);
      }
    }
    report();
    return non_finite_ ? cli::exit_finding : cli::exit_ok;
  }

 private:
  Result<Request> run_session(const engine::Scene& scene) {
    const Result<PlayScene> playable = make_playable(scene);
    if (!playable) return playable.error();
    if (!playable->can_touch)
      cli::print_warning(scene.name + ": only to look at: what a person adds would need contacts: " + playable->note);
    const auto made = engine::make_engine(playable->scene);
    if (!made) return made.error();
    engine::Engine& engine = **made;
    file_ = file_name(options_, number_);
    if (const Status status = replay::check_output(file_); !status) return status.error();
    if (const Status status = verifier::check_writable_target(file_, may_overwrite()); !status) return status.error();
    display_.set_title("ticktrue - " + scene.name + " - " + file_);

    WorldPicture picture(engine);
    TimedSimulation timed(engine);
    Session session(engine, *playable, first_view(engine, size_.width, size_.height), layers_, [&](const Session& now) {
      draw(engine, now, picture, timed);
      return display_.show();
    });
    replay::RecordOptions record_options;
    record_options.writer.overwrite = may_overwrite();
    tool::TraceChoices choices;
    choices.detail = replay::Detail::cells;
    auto result = replay::record(timed, session, file_, tool::make_trace_setup(engine, choices),
                                 tool::make_build_facts(), record_options);
    size_ = session.view();
    layers_ = session.layers();
    wished_ = session.requested_scene();
    draw(engine, session, picture, timed);
    if (session.request() == Request::quit || session.request() == Request::none)
      if (const Status status = display_.write_files(engine, picture, session.view()); !status) return status.error();
    if (!result) {
      if (engine.tick() == 0 && session.request() != Request::none)
        return session.request();  // no tick: there is no file
      return result.error();
    }
    non_finite_ = result->reason == replay::EndReason::non_finite;
    done_.push_back({file_, scene.name, std::move(*result), session.input_count(), picture.bodies().size()});
    ++number_;
    return session.request();
  }

  bool may_overwrite() const { return options_.force && number_ == 1 && !options_.output.empty(); }

  void draw(const engine::Engine& engine, const Session& session, WorldPicture& picture, const TimedSimulation& timed) {
    Canvas& canvas = display_.begin_picture(session.view());
    picture.draw(canvas, session.view(), session.layers());
    std::vector<PanelLine> lines{{"scene", engine.scene().name},
                                 {"tick", fmt::format("{}  {:.2f} s", engine.tick(), engine.time_s())},
                                 {"hash", hex64(root_hash(engine.state())), theme::accent},
                                 {"bodies", fmt::format("{}", picture.bodies().size())},
                                 {"contacts", fmt::format("{}", row_count(engine.state(), "contacts"))},
                                 {"tick takes", fmt::format("{:.3f} ms", timed.ms_per_tick())}};
    if (const std::string pace = display_.pace_text(); !pace.empty()) lines.push_back({"frames", pace});
    draw_panel(canvas, display_.fonts().normal, Corner::upper_left, lines);
    draw_layer_keys(canvas, display_.fonts().small, session.layers());
    std::vector<PanelLine> below{{session.is_paused() ? "paused" : "recording",
                                  fmt::format("{}   {} inputs", file_, session.input_count()),
                                  session.is_paused() ? theme::warning : theme::text}};
    draw_panel(canvas, display_.fonts().small, Corner::lower_left, below);
    draw_panel(canvas, display_.fonts().small, Corner::lower_right, {{"h", "help", theme::text}});
    if (session.shows_help()) draw_help(canvas, display_.fonts(), "Playing in a scene", scene_help());
  }

  void report() const {
    if (options_.json) {
      cli::Json object;
      object["schema"] = "ticktrue.play/1";
      object["mode"] = "scene";
      object["recordings"] = cli::Json::array();
      for (const Recorded& row : done_)
        object["recordings"].push_back({{"file", row.file},
                                        {"scene", row.scene},
                                        {"ticks", row.result.tick_count},
                                        {"inputs", row.input_count},
                                        {"bodies", row.body_count},
                                        {"note", row.result.note},
                                        {"hash", hex64(row.result.root_hash)}});
      object["display"] = display_.frames_json();
      return cli::print_json(object);
    }
    for (const Recorded& row : done_) {
      cli::print(fmt::format("recorded  {}  {}, {} ticks, {} inputs, hash {}\n", row.file, row.scene,
                             row.result.tick_count, row.input_count, hex64(row.result.root_hash)));
      if (!row.result.note.empty()) cli::print(fmt::format("  ended   {}\n", row.result.note));
    }
    if (done_.empty()) cli::print("nothing was recorded: no tick was run\n");
    cli::print("  display " + display_.frames_text() + "\n");
  }

  const cli::PlayOptions& options_;
  Display& display_;
  LayerSet layers_;
  View size_;       // of the picture
  int number_ = 1;  // of the recording
  int wished_ = 0;
  std::string file_;
  bool non_finite_ = false;
  std::vector<Recorded> done_;
};

}  // namespace

int play_in_scene(const cli::PlayOptions& options) {
  Result<engine::Scene> scene = cli::load_scene_argument(options.what);
  if (!scene) return cli::fail_usage(scene.error());
  const Result<LayerSet> layers = parse_layers(options.layers);
  if (!layers) return cli::fail_usage(layers.error());
  if (!options.output.empty()) {
    if (const Status status = replay::check_output(options.output); !status) return cli::fail_usage(status.error());
    if (const Status status = verifier::check_writable_target(options.output, options.force); !status)
      return cli::fail_usage(status.error());
  }
  if (const Status status = verifier::check_not_read(options.output, {options.what, options.script}); !status)
    return cli::fail_usage(status.error());
  const auto display = Display::open(options);
  if (!display) return cli::fail_usage(display.error());
  return SceneMode(options, **display, *layers).run(std::move(*scene));
}

}  // namespace ticktrue::play
