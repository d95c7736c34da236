// `ticktrue compare`: what integrators, clocks, solvers, substeps, precisions, steps and threads change on a scene.
// SPDX-License-Identifier: MIT
#include "tool/study/compare.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "base/hash.h"
#include "base/limits.h"
#include "base/parallel/jobs.h"
#include "base/parallel/workers.h"
#include "tool/cli/commands.h"
#include "tool/cli/study/study_output.h"
#include "tool/expression/csv_columns.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/session/host_frames.h"

namespace ticktrue::cli {
namespace {

using tool::CompareReport;
using tool::CompareRow;
using tool::CompareSession;
using tool::CompareVerdict;
using tool::full_number;
using tool::short_number;
using tool::TextTable;

struct CompareCommand {
  std::string subject;
  std::vector<std::string> integrators, clocks, solvers, substeps, precisions, dts, broad_phases, threads;
  std::optional<std::uint64_t> tick_count;
  std::optional<double> seconds;
  std::uint64_t twin_count = 3;
  std::vector<std::string> hosts{"jitter_60"};
  std::vector<std::string> varied;
  std::vector<std::string> columns;
  std::uint64_t host_seed = 1;
  bool explains = false;
  std::uint64_t job_count = 0;  // 0: as many as there are cores, or one where threads of a tick are compared
  StudyFiles files;
};

constexpr std::size_t variant_count_max = 10'000;

/// A word of the tables, and what --explain says of it.
struct ExplainedWord {
  std::string_view word;
  std::string_view meaning;
};
constexpr std::array<ExplainedWord, 9> drift_columns{{
    {"against the base",
     "the variant; a twin is the base with every moving body shifted by one unit in the last place"},
    {"bits", "the tick after which the bodies have other bits; -: ticks or precision differ"},
    {"ticks", "how many the variant made"},
    {"max m", "farthest that a body is from that of the base, at any of 120 times"},
    {"RMS m", "root of the mean square over the bodies, at the end"},
    {"angle rad", "largest difference of angles"},
    {"growth 1/s", "how fast runs part: slope of log RMS while it is below a tenth of its largest"},
    {"beyond s", "from when on the RMS is beyond 4 times the largest of the twins; before, it proves nothing"},
    {"verdict", "what the variant changes:"},
}};
constexpr std::array<ExplainedWord, 10> outcome_columns{{
    {"variant", "as above"},
    {"energy J", "at the end less at the start, kinetic and of gravity; springs and motors are not counted"},
    {"momentum", "kg m/s, its length at the end"},
    {"overlap mm", "deepest overlap of two shapes"},
    {"gap mm", "largest distance of a joint from what it holds"},
    {"stands", "placed bodies that stand at the end; placed: at rest on something at the start"},
    {"order", "share of them that is still upon what carried it"},
    {"rests", "bodies at rest in the last second"},
    {"elsewhere", "of these, those that rest farther from the base's place than half their size"},
    {"ms/s", "time of computing for a second of the scene"},
}};

std::string_view verdict_name(CompareVerdict verdict) {
  return tool::compare_verdict_names[static_cast<std::size_t>(verdict)];
}

template <std::size_t count>
std::vector<std::string> heads_of(const std::array<ExplainedWord, count>& columns) {
  std::vector<std::string> heads;
  for (const ExplainedWord& column : columns) heads.emplace_back(column.word);
  return heads;
}

/// The words of both tables.
std::string explanation() {
  std::string text = "\n";
  const auto add = [&](std::string_view word, std::string_view meaning, int indent) {
    text += fmt::format("{:{}}{:<{}}  {}\n", "", indent, word, 18 - indent, meaning);
  };
  for (const ExplainedWord& column : drift_columns) add(column.word, column.meaning, 2);
  for (std::size_t i = 0; i < tool::compare_verdict_names.size(); ++i)
    add(tool::compare_verdict_names[i], tool::compare_verdict_meanings[i], 4);
  for (const ExplainedWord& column : outcome_columns) add(column.word, column.meaning, 2);
  return text;
}

// As much of a name as the table has room for. Of varied keys all: the end tells variants apart.
std::string name_text(const CompareRow& row) {
  constexpr std::size_t size_max = 36;
  const std::string& name = row.variant.name;
  const bool is_whole = name.size() <= size_max || !row.variant.varied_values.empty();
  return is_whole ? name : name.substr(0, size_max - 3) + "...";
}

std::string bits_text(const CompareRow& row) {
  if (row.verdict == CompareVerdict::same_bits) return "equal";
  if (row.first_different) return fmt::format("tick {}", *row.first_different);
  return "-";
}

std::string brief_verdict(const CompareRow& row) {
  return row.verdict == CompareVerdict::not_applicable ? "n/a" : std::string(verdict_name(row.verdict));
}

void add_drift(TextTable& table, const CompareRow& row) {
  if (row.verdict == CompareVerdict::not_applicable) {
    table.add({name_text(row), "-", "-", "-", "-", "-", "-", "-", "n/a"});
    return;
  }
  table.add({name_text(row), bits_text(row), std::to_string(row.tick_count), short_number(row.position_max),
             short_number(row.position_rms), short_number(row.angle_max),
             row.growth && row.position_max > 0 ? fmt::format("{:.2f}", *row.growth) : "-",
             row.beyond_s ? fmt::format("{:.3f}", *row.beyond_s) : "-", brief_verdict(row)});
}

void add_outcome(TextTable& table, const CompareRow& row) {
  if (row.verdict == CompareVerdict::not_applicable) return;
  table.add({name_text(row), short_number(row.energy), short_number(row.momentum), short_number(row.overlap_max * 1e3),
             short_number(row.joint_gap_max * 1e3), fmt::format("{} of {}", row.standing_count, row.placed_count),
             fmt::format("{:.2f}", row.order), std::to_string(row.resting_count), std::to_string(row.elsewhere_count),
             fmt::format("{:.3g}", row.ms_per_s)});
}

// Whole states at the end, where threads were compared: what they must not change.
std::string hashes_text(const CompareReport& report) {
  const auto has_threads = [](const CompareRow& row) { return row.variant.threads.has_value(); };
  if (std::none_of(report.rows.begin(), report.rows.end(), has_threads)) return "";
  TextTable table({"root hash at the end", "whole state"});
  table.add({name_text(report.base), hex64(report.base.root_hash)});
  for (const CompareRow& row : report.rows)
    if (row.verdict != CompareVerdict::not_applicable) table.add({name_text(row), hex64(row.root_hash)});
  return "\n" + table.text();
}

/// The values of --columns at the end; empty without any.
std::string columns_text(const CompareReport& report, const std::vector<std::string>& columns) {
  if (columns.empty()) return "";
  std::vector<std::string> heads{"at the end"};
  heads.insert(heads.end(), columns.begin(), columns.end());
  TextTable table(heads);
  const auto add = [&](const CompareRow& row) {
    if (row.samples.empty()) return;
    std::vector<std::string> cells{name_text(row)};
    for (const double value : row.samples.back().values)
      cells.push_back(std::isfinite(value) ? fmt::format("{:.6g}", value) : "-");
    table.add(cells);
  };
  add(report.base);
  for (const CompareRow& row : report.twins) add(row);
  for (const CompareRow& row : report.rows) add(row);
  return "\n" + table.text();
}

std::string report_text(const CompareReport& report, const CompareSession& session,
                        const std::vector<std::string>& columns, const std::string& command_line) {
  std::string text =
      fmt::format("compare  {}  {:g} s, {} bodies\n", session.scene.name, session.seconds, session.scene.bodies.size());
  text += tool::wrapped(command_line, 2);
  text += tool::wrapped("base: " + tool::base_text(session.scene.settings), 2);
  TextTable drift(heads_of(drift_columns));
  TextTable outcome(heads_of(outcome_columns));
  add_outcome(outcome, report.base);
  for (const CompareRow& row : report.twins) add_drift(drift, row);
  for (const CompareRow& row : report.twins) add_outcome(outcome, row);
  for (const CompareRow& row : report.rows) add_drift(drift, row);
  for (const CompareRow& row : report.rows) add_outcome(outcome, row);
  text += "\n" + drift.text() + "\n" + outcome.text() + columns_text(report, columns) + hashes_text(report);
  for (const CompareRow& row : report.rows)
    if (!row.reason.empty())
      text += tool::wrapped(fmt::format("{}: {}: {}", row.variant.name, brief_verdict(row), row.reason), 4);
  return text;
}

Json columns_json(const std::vector<std::string>& columns, const std::vector<double>& values) {
  Json object = Json::object();
  for (std::size_t i = 0; i < columns.size() && i < values.size(); ++i) object[columns[i]] = number_json(values[i]);
  return object;
}

Json row_json(const CompareRow& row, bool is_twin, const std::vector<std::string>& columns) {
  Json entry;
  entry["variant"] = row.variant.name;
  entry["twin"] = is_twin;
  entry["verdict"] = verdict_name(row.verdict);
  entry["reason"] = row.reason;
  entry["same_ticks"] = row.same_ticks;
  entry["bits_of"] = !row.same_ticks ? Json(nullptr) : Json(row.whole_state ? "state" : "bodies");
  entry["root_hash"] = hex64(row.root_hash);
  entry["first_different_tick"] = row.first_different ? Json(*row.first_different) : Json(nullptr);
  entry["ticks"] = row.tick_count;
  entry["position_max_m"] = number_json(row.position_max);
  entry["position_rms_m"] = number_json(row.position_rms);
  entry["angle_max_rad"] = number_json(row.angle_max);
  entry["growth_per_s"] = optional_json(row.growth);
  entry["beyond_twins_s"] = optional_json(row.beyond_s);
  entry["energy_j"] = number_json(row.energy);
  entry["momentum"] = number_json(row.momentum);
  entry["overlap_max_m"] = number_json(row.overlap_max);
  entry["joint_gap_max_m"] = number_json(row.joint_gap_max);
  entry["placed"] = row.placed_count;
  entry["standing"] = row.standing_count;
  entry["order"] = number_json(row.order);
  entry["resting"] = row.resting_count;
  entry["elsewhere"] = row.elsewhere_count;
  entry["ms_per_s"] = row.ms_per_s;
  entry["samples"] = Json::array();
  for (const auto& sample : row.samples)
    entry["samples"].push_back({{"time_s", sample.time_s},
                                {"position_max_m", number_json(sample.position_max)},
                                {"position_rms_m", number_json(sample.position_rms)},
                                {"angle_max_rad", number_json(sample.angle_max)},
                                {"twins_rms_m", number_json(sample.twin_rms)},
                                {"energy_j", number_json(sample.energy)},
                                {"momentum", number_json(sample.momentum)},
                                {"overlap_m", number_json(sample.overlap)},
                                {"joint_gap_m", number_json(sample.joint_gap)}});
  if (columns.empty() || row.samples.empty()) return entry;
  for (std::size_t i = 0; i < row.samples.size(); ++i) {
    entry["samples"][i]["columns"] = columns_json(columns, row.samples[i].values);
    entry["samples"][i]["columns_time_s"] = number_json(row.samples[i].values_time_s);
  }
  entry["columns"] = columns_json(columns, row.samples.back().values);
  return entry;
}

Json report_json(const CompareReport& report, const CompareSession& session, const std::vector<std::string>& columns,
                 const std::string& command_line) {
  Json object;
  object["schema"] = "ticktrue.compare/1";
  object["command"] = command_line;
  object["scene"] = session.scene.name;
  object["seconds"] = session.seconds;
  object["beyond_factor"] = tool::beyond_factor;
  object["base_settings"] = tool::base_text(session.scene.settings);
  Json counts;
  for (const std::string_view name : tool::compare_verdict_names) counts[std::string(name)] = 0;
  for (const CompareRow& row : report.rows)
    counts[std::string(verdict_name(row.verdict))] = counts[std::string(verdict_name(row.verdict))].get<int>() + 1;
  object["verdicts"] = std::move(counts);
  object["base"] = row_json(report.base, false, columns);
  object["rows"] = Json::array();
  for (const CompareRow& row : report.twins) object["rows"].push_back(row_json(row, true, columns));
  for (const CompareRow& row : report.rows) object["rows"].push_back(row_json(row, false, columns));
  return object;
}

/// With a column for each varied key, empty for the base and its twins, and for each value of --columns.
std::string csv_of(const CompareReport& report, const std::vector<tool::VariedKey>& varied,
                   const std::vector<std::string>& columns) {
  std::string text;
  const auto add_line = [&](const std::string& name, const std::vector<std::string>& values,
                            const std::vector<std::string>& cells) {
    std::vector<std::string> line{name};
    line.insert(line.end(), values.begin(), values.end());
    line.resize(1 + varied.size());
    line.insert(line.end(), cells.begin(), cells.end());
    text += tool::csv_line(line);
  };
  std::vector<std::string> keys;
  for (const tool::VariedKey& key : varied) keys.push_back(key.key);
  std::vector<std::string> heads{"verdict",     "time_s",   "position_max_m", "position_rms_m", "angle_max_rad",
                                 "twins_rms_m", "energy_j", "momentum",       "overlap_m",      "joint_gap_m"};
  if (!columns.empty()) heads.emplace_back("columns_time_s");
  heads.insert(heads.end(), columns.begin(), columns.end());
  add_line("variant", keys, heads);
  const auto add = [&](const CompareRow& row) {
    for (const auto& sample : row.samples) {
      std::vector<std::string> cells{std::string(verdict_name(row.verdict)),
                                     full_number(sample.time_s),
                                     full_number(sample.position_max),
                                     full_number(sample.position_rms),
                                     full_number(sample.angle_max),
                                     full_number(sample.twin_rms),
                                     full_number(sample.energy),
                                     full_number(sample.momentum),
                                     full_number(sample.overlap),
                                     full_number(sample.joint_gap)};
      if (!columns.empty()) cells.push_back(full_number(sample.values_time_s));
      for (const double value : sample.values) cells.push_back(std::isfinite(value) ? full_number(value) : "");
      add_line(row.variant.name, row.variant.varied_values, cells);
    }
  };
  add(report.base);
  for (const CompareRow& row : report.twins) add(row);
  for (const CompareRow& row : report.rows) add(row);
  return text;
}

std::vector<tool::Plot> plots_of(const CompareReport& report, const CompareSession& session) {
  tool::Plot plot{session.scene.name + ": drift from the base", "s", "m (RMS over bodies)", false, true, {}};
  const auto add = [&](const CompareRow& row, bool dashed) {
    tool::PlotCurve curve{row.variant.name, {}, {}, dashed};
    for (const auto& sample : row.samples) {
      curve.x.push_back(sample.time_s);
      curve.y.push_back(sample.position_rms);
    }
    plot.curves.push_back(std::move(curve));
  };
  for (const CompareRow& row : report.twins) add(row, true);
  for (const CompareRow& row : report.rows) add(row, false);
  return {plot};
}

template <typename Table, typename Kind>
void choose(const Table& table, const std::vector<std::string>& names, std::vector<Kind>& out) {
  for (const std::string& name : names)
    if (const auto* row = engine::find_choice(table, name)) out.push_back(row->kind);
}

// "1/120" or "0.005". Errors: usage.
Result<double> parse_dt(const std::string& text) {
  const std::size_t slash = text.find('/');
  char* end = nullptr;
  double value = std::strtod(text.c_str(), &end);
  bool whole = end != text.c_str();
  if (slash != std::string::npos && whole && static_cast<std::size_t>(end - text.c_str()) == slash) {
    const char* start = text.c_str() + slash + 1;
    value /= std::strtod(start, &end);
    whole = end != start;
  }
  if (!whole || *end != '\0' || !(value >= limits::dt_min_s && value <= limits::dt_max_s))
    return Error{ErrorCode::usage, "--dt: found " + text + ", expected seconds such as 1/120 or 0.005", {}};
  return value;
}

Result<tool::CompareAxes> axes_of(const CompareCommand& command) {
  tool::CompareAxes axes;
  choose(engine::integrators, command.integrators, axes.integrators);
  choose(engine::clock_kinds, command.clocks, axes.clocks);
  choose(engine::solvers, command.solvers, axes.solvers);
  choose(engine::precisions, command.precisions, axes.precisions);
  choose(engine::broad_phases, command.broad_phases, axes.broad_phases);
  axes.hosts = command.hosts;
  for (const std::string& text : command.dts) {
    const Result<double> dt = parse_dt(text);
    if (!dt) return dt.error();
    axes.dts.push_back(*dt);
  }
  for (const std::string& text : command.substeps) {
    const int count = text == "auto" ? 0 : std::atoi(text.c_str());
    if (text != "auto" && (count < 1 || count > limits::substep_count_max || std::to_string(count) != text))
      return Error{ErrorCode::usage, "--substeps: found " + text + ", expected 1..256 or auto", {}};
    axes.substeps.push_back(count);
  }
  for (const std::string& text : command.threads) {
    const unsigned count = text.size() <= 2 ? static_cast<unsigned>(std::max(0, std::atoi(text.c_str()))) : 0;
    if (count < 1 || count > thread_count_max || std::to_string(count) != text)
      return Error{ErrorCode::usage,
                   "--threads: found " + text + ", expected 1.." + std::to_string(thread_count_max) + ", such as 1,2,4",
                   {}};
    axes.threads.push_back(count);
  }
  return axes;
}

std::string command_line_of(const CompareCommand& command, const CompareSession& session) {
  std::string line = "ticktrue compare '" + command.subject + "'";
  const auto add = [&](const char* name, const std::vector<std::string>& values) {
    if (values.empty()) return;
    line += std::string(" ") + name;
    for (std::size_t i = 0; i < values.size(); ++i) line += (i == 0 ? " " : ",") + values[i];
  };
  add("--integrator", command.integrators);
  add("--clock", command.clocks);
  add("--solver", command.solvers);
  add("--substeps", command.substeps);
  add("--precision", command.precisions);
  add("--dt", command.dts);
  add("--broad-phase", command.broad_phases);
  add("--threads", command.threads);
  for (const std::string& varied : command.varied) line += " --vary '" + varied + "'";
  add("--columns", command.columns);
  if (session.dts.empty()) line += " --seconds " + full_number(session.seconds);
  line += " --twins " + std::to_string(command.twin_count);
  if (command.clocks.empty()) return line;
  add("--host", command.hosts);
  line += " --host-seed " + std::to_string(command.host_seed);
  return line;
}

bool is_trace(const std::string& path) {
  return path.size() > 4 && path.compare(path.size() - 4, 4, ".ttr") == 0;
}

/// Errors: usage.
Result<std::vector<tool::VariedKey>> varied_keys_of(const CompareCommand& command) {
  std::vector<tool::VariedKey> keys;
  for (const std::string& text : command.varied) {
    auto varied = tool::parse_varied(text, "--vary");
    if (!varied) return varied.error();
    keys.push_back(*std::move(varied));
  }
  tool::label_keys(keys);
  return keys;
}

/// Refuses a key that an option sets as well: the option would win. Refuses clocks without --clock, which makes their
/// frames. Errors: usage.
Status check_varied(const CompareCommand& command, const std::string& key, const std::string& place) {
  struct Axis {
    std::string_view option;
    std::string_view key;
    bool is_given;
  };
  const std::array<Axis, 7> axes{{
      {"--integrator", "settings.integrator", !command.integrators.empty()},
      {"--clock", "settings.clock.type", !command.clocks.empty()},
      {"--solver", "settings.solver", !command.solvers.empty()},
      {"--substeps", "settings.substeps", !command.substeps.empty()},
      {"--precision", "settings.precision", !command.precisions.empty()},
      {"--dt", "settings.dt", !command.dts.empty()},
      {"--broad-phase", "settings.broad_phase", !command.broad_phases.empty()},
  }};
  const auto is_within = [](std::string_view inner, std::string_view outer) {
    return inner == outer ||
           (inner.size() > outer.size() && inner.substr(0, outer.size()) == outer && inner[outer.size()] == '.');
  };
  for (const Axis& axis : axes)
    if (axis.is_given && (is_within(key, axis.key) || is_within(axis.key, key)))
      return Error{
          ErrorCode::usage,
          fmt::format("{}: found {}, which sets {} as well, expected one of the two", place, axis.option, axis.key),
          {}};
  if (is_within(key, "settings.clock") && command.clocks.empty())
    return Error{ErrorCode::usage, place + ": found no --clock, expected the clock that makes the ticks",
                 "ticktrue compare pendulum --clock variable,adaptive --host steady_30"};
  return {};
}

/// Errors: usage; what --vary makes of the scene.
Result<std::vector<tool::Variant>> variants_of(const CompareCommand& command, const engine::Scene& scene,
                                               const std::vector<tool::VariedKey>& varied) {
  const auto axes = axes_of(command);
  if (!axes) return axes.error();
  if (const Status are_apart = tool::check_apart(varied, scene, "--vary"); !are_apart) return are_apart.error();
  std::vector<tool::Variant> variants = tool::product_of(*axes);
  for (std::size_t i = 0; i < varied.size(); ++i) {
    const std::string place = "--vary " + command.varied[i];
    if (const Status status = check_varied(command, varied[i].key, place); !status) return status.error();
    auto more = tool::with_varied(variants, scene, varied[i], place);
    if (!more) return more.error();
    variants = *std::move(more);
    if (variants.size() > variant_count_max)
      return Error{ErrorCode::usage,
                   fmt::format("compare: found {} variants, expected at most {}", variants.size(), variant_count_max),
                   ""};
  }
  if (!variants.empty()) return variants;
  return Error{ErrorCode::usage,
               "compare: found nothing to compare with, expected at least one of --integrator, --clock, --solver, "
               "--substeps, --precision, --dt, --broad-phase, --threads, --vary",
               "ticktrue compare pyramid --integrator velocity_verlet,rk4"};
}

/// Errors: io, usage.
Status check_targets(const CompareCommand& command) {
  std::vector<std::string> read = command.hosts;
  read.push_back(command.subject);
  return check_study_files(command.files, read);
}

int run_compare(const CompareCommand& command) {
  if (const Status status = check_targets(command); !status) return fail_usage(status.error());
  CompareSession session;
  if (is_trace(command.subject)) {
    if (command.seconds || command.tick_count)
      return fail_usage({ErrorCode::usage,
                         fmt::format("{}: found {} with a trace, expected neither --seconds nor --ticks",
                                     command.subject, command.seconds ? "--seconds" : "--ticks"),
                         "a trace runs for its own ticks; a scene runs as long as you say"});
    auto read = tool::session_of_trace(command.subject);
    if (!read) return fail(read.error());
    session = std::move(*read);
  } else {
    const auto scene = load_scene_argument(command.subject);
    if (!scene) return fail_usage(scene.error());
    session.scene = *scene;
    session.seconds = command.tick_count ? static_cast<double>(*command.tick_count) * scene->settings.dt
                                         : command.seconds.value_or(10);
  }
  for (const std::string& host : command.hosts)
    if (const Status known = tool::check_host(host, command.host_seed); !known) return fail_usage(known.error());
  const auto varied = varied_keys_of(command);
  if (!varied) return fail_usage(varied.error());
  const auto variants = variants_of(command, session.scene, *varied);
  if (!variants) return fail_usage(variants.error());
  tool::CompareOptions options;
  options.twin_count = static_cast<int>(command.twin_count);
  options.host_seed = command.host_seed;
  options.wall_clock = !command.threads.empty();
  tool::CsvColumns columns;
  if (!command.columns.empty()) {
    for (const std::string& name : command.columns)
      if (name == "tick" || name == "time")
        return fail_usage(
            {ErrorCode::usage,
             "--columns: found " + name + ", expected a value of the world; each run ends at the same time",
             {}});
    auto made = tool::CsvColumns::make(command.columns, session.scene, "--columns");
    if (!made) return fail_usage(made.error());
    columns = *std::move(made);
  }
  options.measure = [&](const engine::Engine& engine) { return columns.values(engine); };
  const unsigned job_count = options.wall_clock ? 1 : core_count();
  options.thread_count = command.job_count > 0 ? static_cast<unsigned>(command.job_count) : job_count;
  Progress progress("compare " + session.scene.name, 1, "runs");
  options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  const auto report = tool::compare_variants(session, *variants, options);
  progress.finish();
  if (!report) return fail_usage(report.error());
  const std::string command_line = command_line_of(command, session);
  if (command.files.json)
    print_json(report_json(*report, session, columns.names(), command_line));
  else
    print(report_text(*report, session, columns.names(), command_line) + (command.explains ? explanation() : ""));
  if (const int code =
          write_study_files(command.files, csv_of(*report, *varied, columns.names()), plots_of(*report, session));
      code != exit_ok)
    return code;
  return report->base.verdict == CompareVerdict::not_finite ||
                 std::any_of(report->rows.begin(), report->rows.end(),
                             [](const CompareRow& row) { return row.verdict == CompareVerdict::not_finite; })
             ? exit_finding
             : exit_ok;
}

template <typename Table>
CLI::Option* add_axis(CLI::App& command, const std::string& name, std::vector<std::string>& target, const Table& table,
                      const std::string& what) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return command.add_option(name, target, what)->delimiter(',')->allow_extra_args(false)->check(CLI::IsMember(names));
}

}  // namespace

void add_compare(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<CompareCommand>();
  CLI::App* command =
      app.add_subcommand("compare", "Run a scene in several ways and say what that changes")->group(group_study);
  command
      ->add_option("SCENE|TRACE", options->subject,
                   "Scene file (.json), built-in scene, or a trace (.ttr) with its inputs")
      ->required();
  add_axis(*command, "--integrator", options->integrators, engine::integrators, "Integrators");
  CLI::Option* clock =
      add_axis(*command, "--clock", options->clocks, engine::clock_kinds, "Clocks, on the frames of --host");
  add_axis(*command, "--solver", options->solvers, engine::solvers, "Solvers");
  command->add_option("--substeps", options->substeps, "Substeps, 1..256 or auto")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_axis(*command, "--precision", options->precisions, engine::precisions, "Precisions");
  command->add_option("--dt", options->dts, "Lengths of a tick, s, such as 1/120")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_axis(*command, "--broad-phase", options->broad_phases, engine::broad_phases, "Broad phases");
  command
      ->add_option("--vary", options->varied,
                   "A key of the scene and its values: bodies.3.shapes.0.friction=0.1:0.9:9, settings.substeps=1,4, "
                   "gravity=[0,-10],[0,-2]")
      ->type_name("KEY=VALUES")
      ->allow_extra_args(false);
  command
      ->add_option("--columns", options->columns,
                   "Values to show at the end of each run, and to write with --csv: energy, bodies.3.x, "
                   "joints.2.force, ...; a wrong name lists them all")
      ->type_name("NAMES")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--threads", options->threads, "Threads of a tick, 1..64")
      ->delimiter(',')
      ->allow_extra_args(false);
  auto* seconds = command->add_option("--seconds", options->seconds, "Simulated time, default: 10; of a trace: its own")
                      ->check(CLI::Range(1e-3, 1e6));
  add_number(*command, "--ticks", options->tick_count, "The same in ticks of the base", {1, limits::tick_count_max})
      ->excludes(seconds);
  add_number(*command, "--twins", options->twin_count, "Runs of the base shifted by 1 ULP; default: 3", {1, 100});
  command
      ->add_option("--host", options->hosts,
                   "Frames for --clock: models of `ticktrue run --help`, or files; default: jitter_60")
      ->delimiter(',')
      ->needs(clock)
      ->allow_extra_args(false);
  add_number(*command, "--host-seed", options->host_seed, "Of the model; default: 1");
  add_number(*command, "-j,--jobs", options->job_count, "Runs at once; default: one a core, with --threads one",
             {1, 1024});
  command->add_flag("--explain", options->explains, "Below the tables: what each word in them means");
  add_study_files(*command, options->files);
  set_examples(
      *command,
      "ticktrue compare 'stack?boxes=10' --solver tgs_soft,pgs --substeps 4,16 --explain\n"
      "ticktrue compare pendulum --integrator velocity_verlet,rk4 --precision f32,f64 --plot drift.svg\n"
      "ticktrue compare slide --vary bodies.1.shapes.0.friction=0.1:0.9:9 --columns bodies.1.x --csv slide.csv\n"
      "ticktrue record 'stack?boxes=3' --ticks 60 -o stack.ttr\n"
      "ticktrue compare stack.ttr --broad-phase aabb_tree,uniform_grid --threads 1,2");
  command->callback([options, &context] { context.exit_code = run_compare(*options); });
}

}  // namespace ticktrue::cli
