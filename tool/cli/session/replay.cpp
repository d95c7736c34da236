// `ticktrue replay`: plays a trace and writes its states as table, JSON Lines, CSV or pictures.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "base/hash.h"
#include "base/plain_text.h"
#include "tool/cli/commands.h"
#include "tool/drawing/svg.h"
#include "tool/expression/csv_columns.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/output/trace_text.h"
#include "tool/session/playback.h"
#include "tool/session/plugin_session.h"
#include "tool/session/simulations.h"
#include "verifier/compare/stage_states.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

struct ReplayOptions {
  std::string file;
  std::string ticks;
  std::uint64_t every = 1;
  std::string format = "table";
  std::vector<std::string> columns;  // of csv
  std::string output;
  bool force = false;
};

/// Where text goes: standard output or a file.
class TextTarget {
 public:
  static Result<TextTarget> open(const std::string& path, bool force) {
    TextTarget target;
    if (path.empty() || path == "-") return target;
    auto file = verifier::DataFile::create(path, force);
    if (!file) return file.error();
    target.file_ = std::make_unique<verifier::DataFile>(std::move(*file));
    return target;
  }
  Status write(std::string_view text) {
    if (file_) return file_->write(text);
    print(text);
    return {};
  }
  bool is_open() const { return file_ || output_is_open(); }
  Status close() { return file_ ? file_->close() : Status{}; }

 private:
  std::unique_ptr<verifier::DataFile> file_;
};

constexpr std::string_view table_head =
    "    tick      time_s  body                          x            y        angle           vx           vy         "
    "   "
    "w\n";

std::string table_rows(const engine::Engine& engine, std::uint64_t tick) {
  std::string text;
  for (const engine::BodyReport& body : engine.bodies()) {
    const std::string name = body.name.empty() ? "#" + std::to_string(body.id) : plain_line(body.name);
    text += fmt::format("{:8}  {:10.4f}  {:<18} {:12.6g} {:12.6g} {:12.6g} {:12.6g} {:12.6g} {:12.6g}\n", tick,
                        engine.time_s(), name, body.center.x, body.center.y, body.angle, body.velocity.x,
                        body.velocity.y, body.angular_velocity);
  }
  return text;
}

std::string json_line(const engine::Engine& engine, std::uint64_t tick) {
  Json line;
  line["tick"] = tick;
  line["time_s"] = engine.time_s();
  line["hash"] = hex64(root_hash(engine.state()));
  line["bodies"] = Json::array();
  for (const engine::BodyReport& body : engine.bodies())
    line["bodies"].push_back({{"id", body.id},
                              {"name", body.name},
                              {"x", body.center.x},
                              {"y", body.center.y},
                              {"angle", body.angle},
                              {"vx", body.velocity.x},
                              {"vy", body.velocity.y},
                              {"w", body.angular_velocity}});
  line["contacts"] = Json::array();
  for (const engine::ContactReport& contact : engine.contacts()) {
    Json points = Json::array();
    for (int i = 0; i < contact.point_count; ++i)
      points.push_back({{"x", contact.point[i].x},
                        {"y", contact.point[i].y},
                        {"separation", contact.separation[i]},
                        {"force", contact.normal_force[i]}});
    line["contacts"].push_back({{"a", contact.body_a},
                                {"b", contact.body_b},
                                {"normal", {contact.normal.x, contact.normal.y}},
                                {"points", std::move(points)}});
  }
  return plain_text(line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

/// Prints how the playback ended, and returns the exit code.
int report_end(const std::string& file, const tool::PlaybackResult& result) {
  int code = exit_ok;
  if (result.tail && result.tail->condition != replay::TraceCondition::complete) {
    code = exit_code_of_condition(result.tail->condition);
    print_warning(file + ": " + (result.tail->message.empty() ? "ends early" : result.tail->message) + "; played " +
                  std::to_string(result.tail->ticks_intact) + " ticks that are intact");
  }
  if (result.refused) {
    code = exit_not_comparable;
    print_warning(file + ": " + *result.refused + "; played up to there");
  }
  if (result.first_difference) {
    code = exit_finding;
    print_warning(file + ": tick " + std::to_string(*result.first_difference) +
                  ": the state here is not the recorded one; from there on the states shown are this build's");
  }
  return code;
}

using Emit = std::function<Status(const engine::Engine& engine, std::uint64_t tick)>;

/// Plays the trace and emits every n-th state.
Result<int> play(replay::TraceReader& reader, const ReplayOptions& options, const TickRange& range, bool with_progress,
                 const Emit& emit) {
  Status written;
  const std::uint64_t recorded = reader.tick_count_hint().value_or(0);
  const std::uint64_t total = recorded > range.first ? std::min(recorded, range.last) - range.first : 0;
  std::optional<Progress> progress;
  if (with_progress) progress.emplace("replay " + options.file, total);
  const auto result =
      tool::play_trace(reader, range.first, range.last, [&](const engine::Engine& engine, std::uint64_t tick) {
        if (progress) progress->update(tick - range.first);
        if ((tick - range.first) % options.every == 0) written = emit(engine, tick);
        return written.has_value() && output_is_open() && !stop_requested();
      });
  if (progress) progress->finish();
  if (!result) return Error{result.error().code, options.file + ": " + result.error().message, result.error().hint};
  if (!written) return written.error();
  return report_end(options.file, *result);
}

Result<tool::CsvColumns> columns_of(const replay::TraceReader& reader, const ReplayOptions& options) {
  if (options.format != "csv") return tool::CsvColumns{};
  const Result<engine::Scene> scene = tool::scene_of(reader.setup());
  if (!scene) return Error{scene.error().code, options.file + ": " + scene.error().message, scene.error().hint};
  return tool::CsvColumns::make(options.columns, *scene, "--columns");
}

int write_text(replay::TraceReader& reader, const ReplayOptions& options, const TickRange& range) {
  auto target = TextTarget::open(options.output, options.force);
  if (!target) return fail_usage(target.error());
  const auto columns = columns_of(reader, options);
  if (!columns) return fail_usage(columns.error());
  const bool is_table = options.format == "table";
  const bool is_csv = options.format == "csv";
  if (is_table || is_csv)
    if (const Status status = target->write(is_table ? std::string(table_head) : columns->head()); !status)
      return fail_usage(status.error());
  const auto code = play(reader, options, range, !options.output.empty() && options.output != "-",
                         [&](const engine::Engine& engine, std::uint64_t tick) {
                           if (is_csv) return target->write(columns->row(engine, tick));
                           return target->write(is_table ? table_rows(engine, tick) : json_line(engine, tick));
                         });
  if (!code) return fail(code.error());
  if (const Status status = target->close(); !status) return fail_usage(status.error());
  return *code;
}

int write_pictures(replay::TraceReader& reader, const ReplayOptions& options, const TickRange& range) {
  namespace fs = std::filesystem;
  if (options.output.empty() || options.output == "-")
    return fail_usage(Error{ErrorCode::usage, "--output: found none, expected a directory for the pictures",
                            "add -o frames: it is made if missing"});
  const Result<engine::Scene> scene = tool::scene_of(reader.setup());
  if (!scene) return fail(Error{scene.error().code, options.file + ": " + scene.error().message, scene.error().hint});
  const auto start = engine::make_engine(*scene);
  if (!start) return fail(start.error());
  std::error_code failure;
  fs::create_directories(options.output, failure);
  if (failure || !fs::is_directory(options.output))
    return fail_usage(Error{ErrorCode::io, options.output + ": cannot create the directory: " + failure.message(), ""});

  // Twice: the first time to see where things go, so that all pictures share one readable view.
  tool::WorldBox visited;
  const auto look = tool::play_trace(reader, range.first, range.last, [&](const engine::Engine& engine, std::uint64_t) {
    for (const engine::BodyReport& body : engine.bodies())
      if (body.type != engine::BodyType::static_body) visited.add(tool::box_of(body));
    return !stop_requested();
  });
  if (!look) return fail(Error{look.error().code, options.file + ": " + look.error().message, look.error().hint});
  const tool::WorldBox view = tool::choose_view(**start, visited);

  std::uint64_t picture_count = 0;
  const auto code = play(reader, options, range, true, [&](const engine::Engine& engine, std::uint64_t tick) -> Status {
    const std::string path = (fs::path(options.output) / fmt::format("frame_{:08}.svg", tick)).string();
    auto file = verifier::DataFile::create(path, options.force);
    if (!file) return file.error();
    if (const Status status = file->write(tool::svg_picture(engine, tick, view)); !status) return status;
    ++picture_count;
    return file->close();
  });
  if (!code) return fail(code.error());
  print_note(options.output + ": " + std::to_string(picture_count) + " pictures");
  return *code;
}

/// One tick in full detail, for comparison by another build (verify --against-build).
int write_stages(replay::TraceReader& reader, const ReplayOptions& options, const TickRange& range) {
  if (options.ticks.empty() || range.first != range.last)
    return fail_usage(Error{ErrorCode::usage,
                            "--ticks: found " + (options.ticks.empty() ? "none" : options.ticks) +
                                ", expected one tick with --format stages",
                            ""});
  const SimulationInfo* info = tool::find_simulation(reader.setup().simulation);
  if (info == nullptr)
    return fail(Error{
        ErrorCode::unsupported,
        options.file + ": simulation: found " + reader.setup().simulation + ", expected " + tool::simulation_names(),
        ""});
  verifier::ReaderSource source(reader);
  const auto states = verifier::stage_states(source, *info, range.first);
  if (!states) return fail(Error{states.error().code, options.file + ": " + states.error().message, ""});
  auto target = TextTarget::open(options.output, options.force);
  if (!target) return fail_usage(target.error());
  if (const Status status = target->write(verifier::stage_states_lines(*states)); !status)
    return fail_usage(status.error());
  if (const Status status = target->close(); !status) return fail_usage(status.error());
  return exit_ok;
}

int run_replay(const ReplayOptions& options) {
  TickRange range;
  if (!options.ticks.empty()) {
    const Result<TickRange> parsed = parse_tick_range(options.ticks, "--ticks");
    if (!parsed) return fail_usage(parsed.error());
    range = *parsed;
  }
  if (!options.columns.empty() && options.format != "csv")
    return fail_usage(Error{ErrorCode::usage, "--columns: found --format " + options.format + ", expected csv",
                            "--format csv --columns energy,bodies.3.y"});
  if (const Status status = verifier::check_not_read(options.output, {options.file}); !status)
    return fail_usage(status.error());
  auto reader = replay::TraceReader::open(options.file);
  if (!reader) return fail(reader.error());
  if (const Status whole = reader->check_from_start(); !whole) return fail(whole.error());
  const std::uint64_t last_asked = range.last == TickRange{}.last ? range.first : range.last;
  if (!options.ticks.empty())
    if (const Status known = check_tick("--ticks", last_asked, reader->tick_count_hint()); !known)
      return fail_usage(known.error());
  if (is_plugin_trace(reader->setup())) {
    if (options.format == "stages") return write_stages(*reader, options, range);
    if (!options.output.empty() || options.format == "svg" || options.format == "csv")
      return fail_usage(Error{ErrorCode::usage,
                              "replay of a plug-in: found " +
                                  (options.output.empty() ? "--format " + options.format : "-o") +
                                  ", expected table or jsonl",
                              "it goes to standard output"});
    return replay_plugin(*reader, range.first, range.last, options.every, options.format == "jsonl");
  }
  if (reader->setup().simulation != engine::simulation_name)
    return fail(Error{
        ErrorCode::unsupported,
        options.file + ": simulation: found " + reader->setup().simulation + ", expected " + tool::simulation_names(),
        "`ticktrue show " + verifier::shell_word(options.file) + " --ticks 0..9` lists hashes and inputs; " +
            tool::other_simulation_hint(options.file, reader->facts())});
  if (reader->setup().physics_version != engine::physics_version)
    print_warning(options.file + ": physics version: found " + std::to_string(reader->setup().physics_version) +
                  ", expected " + std::to_string(engine::physics_version) + "; the states shown are this build's");
  if (options.format == "stages") return write_stages(*reader, options, range);
  catch_stop_signals();
  return options.format == "svg" ? write_pictures(*reader, options, range) : write_text(*reader, options, range);
}

}  // namespace

void add_replay(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      app.add_subcommand("replay", "Play a trace, write its states as table, JSON Lines, CSV or pictures")
          ->group(group_session);
  command->add_option("FILE", options->file, "Trace; of a cut or damaged one, what is intact is played")->required();
  command->add_option("--ticks", options->ticks, "Ticks A to B, both included: the state at the end of each")
      ->type_name("A..B");
  add_number(*command, "--every", options->every, "Only every N-th of them (default 1)",
             {1, std::numeric_limits<std::uint64_t>::max()});
  command
      ->add_option(
          "--format", options->format,
          "table: centre of mass (m), angle (rad), velocities. jsonl: the same, hash and contacts. csv: a line "
          "per tick of the values of --columns. svg: a picture per tick. stages: of one tick, the whole state before "
          "it and after each stage, as JSON "
          "Lines")
      ->check(CLI::IsMember({"table", "jsonl", "csv", "svg", "stages"}))
      ->type_name("F");
  command
      ->add_option("--columns", options->columns,
                   "With csv: energy, overlap, joint_gap, ..., bodies.3.x, contacts.0.1.normal_force, joints.2.force, "
                   "bodies.*.y; a wrong name lists them all. Default: those of the whole world")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAMES");
  command
      ->add_option("-o,--output", options->output,
                   "File (table, jsonl, csv) or directory (svg); default: standard output")
      ->type_name("PATH");
  command->add_flag("--force", options->force, "Replace existing files");
  set_examples(
      *command,
      "ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr\n"
      "ticktrue replay stack.ttr --every 60\n"
      "ticktrue replay stack.ttr --format jsonl --ticks 100..200 -o states.jsonl\n"
      "ticktrue replay stack.ttr --format csv --columns energy,bodies.10.y,contacts.0.1.normal_force -o stack.csv\n"
      "ticktrue replay stack.ttr --format svg --every 10 -o frames");
  command->callback([options, &context] { context.exit_code = run_replay(*options); });
}

}  // namespace ticktrue::cli
