// `ticktrue show`: prints the contents of a trace without simulating.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "replay/format/shown_image.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/output/trace_text.h"
#include "tool/session/trace_summary.h"
#include "verifier/peers/bundle.h"
#include "verifier/report/fact_differences.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::cli {
namespace {

struct ShowOptions {
  std::string file;
  bool inputs = false;
  std::string ticks;
  bool checkpoints = false;
  bool shown = false;
  bool marks = false;
  bool notes = false;
  bool json = false;
};

std::string detail_text(const replay::TraceSetup& setup) {
  for (const replay::DetailInfo& info : replay::details) {
    if (info.detail != setup.detail) continue;
    if (setup.detail != replay::Detail::full) return std::string(info.name);
    if (setup.full_first == 0 && setup.full_last == std::numeric_limits<std::uint64_t>::max()) return "full";
    return fmt::format("full:{}..{}", setup.full_first, setup.full_last);
  }
  return "unknown";
}

void print_listing_end(const ShowOptions& options, const replay::TraceTail& tail) {
  if (tail.condition == replay::TraceCondition::complete) return;
  print_warning(options.file + ": " + std::string(condition_name(tail.condition)) + ": " + tail.message +
                "; listed up to tick " + std::to_string(tail.ticks_intact));
}

int list_inputs(verifier::TraceSource& reader, const ShowOptions& options, const TickRange& range) {
  tool::InputListing listing(reader.setup());
  std::uint64_t tick_count = 0;
  bool has_own_dt = false;
  while (output_is_open()) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (record->tick > range.last) return exit_ok;
    tick_count = record->tick + 1;
    has_own_dt = has_own_dt || record->dt != reader.setup().dt;
    if (range.contains(record->tick)) print(listing.text(record->tick, record->inputs));
  }
  if (!output_is_open()) return exit_ok;
  const replay::TraceTail& tail = reader.tail();
  const bool is_non_finite = tail.end && tail.end->reason == replay::EndReason::non_finite;
  if (is_non_finite) {
    // The tick that was not recorded runs again too, and ends the session the same way.
    if (range.contains(tick_count)) print(listing.text(tick_count, tail.pending_inputs));
    ++tick_count;
  }
  print(listing.end_text(tick_count));
  print_listing_end(options, tail);
  if (tail.has_pending_inputs && !is_non_finite)
    print_note(options.file + ": inputs of tick " + std::to_string(tail.ticks_intact) +
               " were written, its result was not; they are not listed");
  if (has_own_dt) print_note(options.file + ": some ticks have a dt of their own, which these lines do not say");
  return exit_code_of_condition(tail.condition);
}

/// "units.glow, units.sprite"
std::string shown_columns_text(const StateSchema& whole) {
  std::string text;
  for (const TableSchema& table : whole.tables)
    for (const Column& column : table.columns)
      if (column.is_shown) text += (text.empty() ? "" : ", ") + table.name + "." + column.name;
  return text;
}

/// The rows of a shown image, a line each. `when`: of the state.
void print_shown(const StateSchema& whole, ByteView shown, const std::string& when) {
  const auto tables = replay::decode_shown(whole, shown);
  if (!tables) return print_warning(when + ": " + tables.error().message);
  for (const ShownRows& rows : *tables)
    for (std::size_t row = 0; row < rows.rows.row_count && output_is_open(); ++row)
      print(fmt::format("{}  {} row {}  {}\n", when, plain_line(whole.tables[rows.table].name), row,
                        plain_line(replay::shown_row_text(whole.tables[rows.table], rows, row))));
}

/// The shown values of checkpoints and of ticks stored in full.
int list_shown(verifier::TraceSource& reader, const ShowOptions& options, const TickRange& range) {
  if (!reader.setup().whole_schema) {
    print_note(options.file + ": has no shown columns");
    return exit_ok;
  }
  const StateSchema& whole = *reader.setup().whole_schema;
  while (output_is_open()) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item)) {
      if (checkpoint->shown && range.contains(checkpoint->tick))
        print_shown(whole, *checkpoint->shown, fmt::format("before tick {}", checkpoint->tick));
    } else if (const auto& record = std::get<replay::TickRecord>(item); record.shown && range.contains(record.tick)) {
      print_shown(whole, *record.shown, fmt::format("after tick {}", record.tick));
    } else if (record.tick > range.last) {
      return exit_ok;
    }
  }
  if (!output_is_open()) return exit_ok;
  print_listing_end(options, reader.tail());
  return exit_code_of_condition(reader.tail().condition);
}

/// "rand 12 times, sin 3 times"
std::string marks_line(const replay::TickRecord& record) {
  if (!record.has_bound) return "damaged";
  if (!record.marks) return "none";
  if (record.marks->is_left_out()) return "left out: too many for the trace";
  std::string text;
  for (const replay::NameMarks& name : record.marks->names)
    text += (text.empty() ? "" : ", ") + name.name + " " + count_text(name.count, "time");
  return plain_line(text);
}

void print_marks(const replay::TickRecord& record) {
  print(fmt::format("{:8}  {}\n", record.tick, marks_line(record)));
  if (!record.mark_list) return;
  for (std::size_t i = 0; i < record.mark_list->marks.size() && output_is_open(); ++i) {
    const replay::Mark& mark = record.mark_list->marks[i];
    print(fmt::format("{:8}  {:5}  {} {}\n", "", i + 1, plain_line(record.mark_list->names[mark.name]),
                      lane_hex(ScalarType::u64, mark.value)));
  }
  if (record.mark_list->is_cut) print(fmt::format("{:8}         and more\n", ""));
}

void print_notes(std::uint64_t tick, const std::vector<replay::Note>& notes) {
  for (const replay::Note& note : notes)
    print(fmt::format("{:8}  {}: {}\n", tick, plain_line(note.topic), plain_line(note.text)));
}

/// Marks or notes of each tick, or both.
int list_bound(verifier::TraceSource& reader, const ShowOptions& options, const TickRange& range) {
  const bool has_marks = reader.setup().has(replay::Feature::marks);
  if (options.marks && !has_marks) print_note(options.file + ": has no marks");
  if (!options.notes && !has_marks) return exit_ok;
  while (output_is_open()) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (record->tick > range.last) return exit_ok;
    if (!range.contains(record->tick)) continue;
    if (options.marks && has_marks) print_marks(*record);
    if (options.notes) print_notes(record->tick, record->notes);
  }
  if (!output_is_open()) return exit_ok;
  const replay::TraceTail& tail = reader.tail();
  if (options.notes && range.contains(tail.ticks_intact)) print_notes(tail.ticks_intact, tail.pending_notes);
  print_listing_end(options, tail);
  return exit_code_of_condition(tail.condition);
}

int list_ticks(verifier::TraceSource& reader, const ShowOptions& options, const TickRange& range) {
  tool::InputListing listing(reader.setup());
  double time_s = 0;
  if (!options.json) print("    tick      time_s  hash              inputs\n");
  while (output_is_open()) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (record->tick > range.last) return exit_ok;
    time_s += record->dt;
    if (!range.contains(record->tick)) continue;
    if (options.json) {
      Json line;
      line["tick"] = record->tick;
      line["time_s"] = time_s;
      line["dt"] = record->dt;
      line["hash"] = hex64(record->root_hash);
      line["input_size"] = record->inputs.size();
      line["full"] = record->image.has_value();
      line["cells"] = record->cells != nullptr;
      print_json(line, -1);
      continue;
    }
    std::string inputs = listing.text(record->tick, record->inputs);
    if (!inputs.empty()) inputs.pop_back();
    for (std::size_t at = inputs.find('\n'); at != std::string::npos; at = inputs.find('\n', at + 1))
      inputs.replace(at, 1, "\n" + std::string(40, ' '));
    print(fmt::format("{:8}  {:10.4f}  {}  {}\n", record->tick, time_s, hex64(record->root_hash),
                      inputs.empty() ? "-" : inputs));
  }
  if (!output_is_open()) return exit_ok;
  print_listing_end(options, reader.tail());
  return exit_code_of_condition(reader.tail().condition);
}

Json inputs_json(const tool::TraceSummary& summary) {
  Json object;
  object["ticks"] = summary.input_tick_count;
  object["size"] = summary.input_size;
  object["by_kind"] = nullptr;
  if (summary.inputs) {
    object["by_kind"] = Json::object();
    for (std::size_t i = 0; i < engine::input_kinds.size(); ++i)
      if ((*summary.inputs)[i] > 0) object["by_kind"][std::string(engine::input_kinds[i].name)] = (*summary.inputs)[i];
  }
  return object;
}

/// Of a bundle: who differs. An error is told, and the rest is shown.
std::optional<verifier::Bundle> read_bundle(replay::TraceReader& reader) {
  Result<std::optional<verifier::Bundle>> bundle = verifier::Bundle::read(reader);
  if (bundle) return std::move(*bundle);
  print_warning(bundle.error().message);
  return std::nullopt;
}

Json peers_json(const replay::TraceReader& reader, const verifier::Bundle& bundle) {
  Json object = Json::parse(verifier::desync_json(reader.setup().schema, bundle.finding()));
  object["recorded_by"] = bundle.recorder();
  object["warnings"] = bundle.warnings();
  return object;
}

void print_summary_json(replay::TraceReader& reader, const ShowOptions& options, const tool::TraceSummary& summary) {
  const replay::TraceSetup& setup = reader.setup();
  Json object;
  object["schema"] = "ticktrue.show/1";
  object["file"] = options.file;
  object["size"] = reader.size();
  object["condition"] = condition_name(summary.tail.condition);
  object["message"] = summary.tail.message;
  object["title"] = setup.title;
  object["simulation"] = setup.simulation;
  object["physics_version"] = setup.physics_version;
  object["dt"] = setup.dt;
  object["detail"] = detail_text(setup);
  object["ticks"] = summary.tick_count;
  object["time_s"] = summary.time_s;
  object["hash"] = hex64(summary.last_root_hash);
  object["checkpoint_interval"] = setup.checkpoint_interval;
  object["checkpoints"] = Json::array();
  for (const tool::CheckpointSummary& checkpoint : summary.checkpoints)
    object["checkpoints"].push_back({{"tick", checkpoint.tick},
                                     {"hash", hex64(checkpoint.root_hash)},
                                     {"image_size", checkpoint.image_size},
                                     {"stored_size", checkpoint.stored_size}});
  if (setup.has(replay::Feature::saves)) {
    object["saves"] = Json::array();
    for (const tool::CheckpointSummary& checkpoint : summary.checkpoints)
      if (checkpoint.save_size) object["saves"].push_back({{"tick", checkpoint.tick}, {"size", *checkpoint.save_size}});
  }
  object["inputs"] = inputs_json(summary);
  object["sizes"] = {{"setup", summary.setup_size},
                     {"checkpoints", summary.checkpoint_size},
                     {"ticks", summary.tick_size},
                     {"rest", summary.rest_size}};
  object["stages"] = setup.stages;
  object["tables"] = Json::array();
  for (const TableSchema& table : setup.schema.tables) {
    Json columns = Json::array();
    for (const Column& column : table.columns) columns.push_back(column.name);
    object["tables"].push_back({{"name", table.name}, {"row_size", table.row_size}, {"columns", std::move(columns)}});
  }
  if (setup.whole_schema) {
    object["shown"] = Json::array();
    for (const TableSchema& table : setup.whole_schema->tables)
      for (const Column& column : table.columns)
        if (column.is_shown) object["shown"].push_back(table.name + "." + column.name);
  }
  object["build"] = Json::object();
  for (const auto& [name, value] : reader.facts()) object["build"][name] = value;
  object["end"] = nullptr;
  if (summary.tail.end)
    object["end"] = {{"reason", end_reason_name(summary.tail.end->reason)},
                     {"ticks", summary.tail.end->tick_count},
                     {"note", summary.tail.end->note}};
  if (const auto bundle = read_bundle(reader)) object["peers"] = peers_json(reader, *bundle);
  object["pending_inputs"] = summary.tail.has_pending_inputs;
  if (summary.salvaged_from) object["salvaged_from"] = *summary.salvaged_from;
  object["intact_after"] = Json::array();
  for (const replay::IntactRange& range : summary.tail.intact_after)
    object["intact_after"].push_back(
        {{"first_tick", range.first_tick}, {"last_tick", range.last_tick}, {"has_checkpoint", range.has_checkpoint}});
  print_json(object);
}

std::string inputs_line(const tool::TraceSummary& summary) {
  if (summary.input_tick_count == 0) return "none";
  if (!summary.inputs)
    return fmt::format("{} bytes in {} ticks, of a simulation this build cannot read", summary.input_size,
                       summary.input_tick_count);
  std::uint64_t count = 0;
  std::string kinds;
  for (std::size_t i = 0; i < engine::input_kinds.size(); ++i) {
    const std::uint64_t of_kind = (*summary.inputs)[i];
    count += of_kind;
    if (of_kind > 0) kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", of_kind, engine::input_kinds[i].name);
  }
  return fmt::format("{} in {} ticks: {}", count, summary.input_tick_count, kinds);
}

/// Facts of ticktrue on one line; those of the plug-in or program below, a line for each of its units.
void print_build(const replay::BuildFacts& facts) {
  std::string build, plugin;
  std::map<std::string, std::string> units;
  for (const auto& [name, value] : facts) {
    const bool is_of_program = verifier::is_program_fact(name);
    const std::string unit = is_of_program ? verifier::fact_unit(name) : "";
    std::string& text = !is_of_program ? build : name.substr(0, 7) == "plugin." ? plugin : units[unit];
    const std::string label = is_of_program ? name.substr(name.rfind('.') + 1) : name;
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", plain_line(label), value.empty() ? "-" : plain_line(value));
  }
  print(fmt::format("  build       {}\n", build.empty() ? "not known" : build));
  if (!plugin.empty()) print(fmt::format("  plug-in     {}\n", plugin));
  for (const auto& [unit, text] : units)
    print(fmt::format("  {:<11} {}\n", unit.empty() ? "program" : "unit",
                      (unit.empty() ? "" : plain_line(unit) + ": ") + text));
}

std::string saves_line(const tool::TraceSummary& summary) {
  std::uint64_t count = 0, size = 0;
  for (const tool::CheckpointSummary& checkpoint : summary.checkpoints) {
    count += checkpoint.save_size ? 1 : 0;
    size += checkpoint.save_size.value_or(0);
  }
  return fmt::format("  saves       {}, {} bytes\n", count, size);
}

/// "300"; of a trace that is not whole "106 of 300", if its end is known.
std::string ticks_line(const replay::TraceReader& reader, const tool::TraceSummary& summary) {
  const std::string count = std::to_string(summary.tick_count);
  const std::uint64_t recorded = reader.tick_count_hint().value_or(0);
  if (summary.tail.condition == replay::TraceCondition::complete || recorded <= reader.first_tick()) return count;
  return count + " of " + std::to_string(recorded - reader.first_tick());
}

std::string hash_line(const replay::TraceReader& reader, const tool::TraceSummary& summary) {
  if (summary.tick_count == 0 && summary.checkpoints.empty()) return "not known: no state can be read";
  const std::string hash = hex64(summary.last_root_hash);
  if (summary.tick_count == 0) return hash + " before the first tick";
  if (summary.tail.condition == replay::TraceCondition::complete) return hash + " after the last tick";
  return hash + " after tick " + std::to_string(reader.first_tick() + summary.tick_count - 1) +
         ", the last that can be read";
}

void print_summary_text(replay::TraceReader& reader, const ShowOptions& options, const tool::TraceSummary& summary) {
  const replay::TraceSetup& setup = reader.setup();
  print(fmt::format("{}  {}  {} ticks ({:.3f} s)\n", plain_line(options.file), plain_line(setup.title),
                    ticks_line(reader, summary), summary.time_s));
  if (reader.first_tick() > 0) print(fmt::format("  begins at   tick {}\n", reader.first_tick()));
  std::string condition(condition_name(summary.tail.condition));
  if (summary.tail.end) {
    const replay::EndReason reason = summary.tail.end->reason;
    if (reason != replay::EndReason::complete) condition += fmt::format(", ended: {}", end_reason_name(reason));
    if (!summary.tail.end->note.empty()) condition += fmt::format(" ({})", plain_line(summary.tail.end->note));
  }
  if (!summary.tail.message.empty()) condition += ": " + summary.tail.message;
  print(fmt::format("  condition   {}\n", condition));
  if (summary.tail.has_pending_inputs)
    print(fmt::format("              inputs of tick {} were written, its result was not\n", summary.tail.ticks_intact));
  if (summary.salvaged_from)
    print(fmt::format("              ticks {}..{} by the checks of their records alone: their chunk is damaged\n",
                      *summary.salvaged_from, summary.tail.ticks_intact - 1));
  for (const replay::IntactRange& range : summary.tail.intact_after)
    print(fmt::format("              behind the damage intact: {}\n", intact_range_text(range)));
  print(fmt::format("  simulation  {}, physics version {}\n", plain_line(setup.simulation), setup.physics_version));
  print(fmt::format("  dt          {} s\n", setup.dt));
  print(fmt::format("  detail      {}\n", detail_text(setup)));
  print(fmt::format("  inputs      {}\n", inputs_line(summary)));
  print(fmt::format("  hash        {}\n", hash_line(reader, summary)));
  const bool is_read_whole = summary.tail.condition == replay::TraceCondition::complete;
  print(fmt::format("  bytes       {}: setup {}, checkpoints {}, ticks {}, {} {}\n", reader.size(), summary.setup_size,
                    summary.checkpoint_size, summary.tick_size, is_read_whole ? "rest" : "rest or not readable",
                    summary.rest_size));
  print_build(reader.facts());
  print(fmt::format("  checkpoints {}", summary.checkpoints.size()));
  print(setup.checkpoint_interval > 0 ? fmt::format(", every {} ticks\n", setup.checkpoint_interval) : "\n");
  if (setup.has(replay::Feature::saves)) print(saves_line(summary));
  if (setup.whole_schema)
    print(fmt::format("  shown       {} (--shown lists the values)\n",
                      plain_line(shown_columns_text(*setup.whole_schema))));
  if (setup.has(replay::Feature::marks)) print("  marks       stored (--marks lists them, --notes lists notes)\n");
  if (options.checkpoints)
    for (const tool::CheckpointSummary& checkpoint : summary.checkpoints)
      print(fmt::format("    tick {:8}  {}  {} bytes of state, {} stored{}\n", checkpoint.tick,
                        hex64(checkpoint.root_hash), checkpoint.image_size, checkpoint.stored_size,
                        checkpoint.save_size ? fmt::format(", a save of {}", *checkpoint.save_size) : ""));
  const auto bundle = read_bundle(reader);
  if (!bundle) return;
  print(fmt::format("  players     {}\n", bundle->players_text().substr(8)));
  print(bundle->text(setup.schema));
}

int run_show(const ShowOptions& options) {
  TickRange range;
  if (!options.ticks.empty()) {
    const Result<TickRange> parsed = parse_tick_range(options.ticks, "--ticks");
    if (!parsed) return fail_usage(parsed.error());
    range = *parsed;
  }
  auto reader = replay::TraceReader::open(options.file);
  if (!reader) return fail(reader.error());
  const std::uint64_t last_asked = range.last == TickRange{}.last ? range.first : range.last;
  if (!options.ticks.empty())
    if (const Status known = check_tick("--ticks", last_asked, reader->tick_count_hint()); !known)
      return fail_usage(known.error());
  verifier::ReaderSource source(*reader);
  if (options.inputs) return list_inputs(source, options, range);
  if (options.shown) return list_shown(source, options, range);
  if (options.marks || options.notes) return list_bound(source, options, range);
  if (!options.ticks.empty()) return list_ticks(source, options, range);

  Progress progress("read " + options.file, 0, "bytes");
  const tool::TraceSummary summary =
      tool::summarize(*reader, [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); });
  progress.finish();
  if (options.json)
    print_summary_json(*reader, options, summary);
  else
    print_summary_text(*reader, options, summary);
  return exit_code_of_condition(summary.tail.condition);
}

}  // namespace

void add_show(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* command = app.add_subcommand("show", "Say what is in a trace; runs nothing")->group(group_session);
  command->add_option("FILE", options->file, "Trace")->required();
  command->add_flag("--inputs", options->inputs,
                    "The inputs as JSON Lines, `end` included: they record the session again");
  command
      ->add_option("--ticks", options->ticks,
                   "List ticks A to B, both included, with their hashes; with --inputs: "
                   "the inputs of these only")
      ->type_name("A..B");
  command->add_flag("--checkpoints", options->checkpoints, "List the checkpoints");
  command->add_flag("--shown", options->shown,
                    "List the values of shown columns, where they are stored; with --ticks of these ticks only");
  command->add_flag("--marks", options->marks, "List the marks of each tick; with --ticks of these ticks only");
  command->add_flag("--notes", options->notes, "List the notes; with --ticks of these ticks only");
  command->add_flag("--json", options->json, "One JSON object; with --ticks one a line");
  set_examples(*command,
               "ticktrue import mouse --model 1 --seconds 20 --scene thesis -o session.jsonl\n"
               "ticktrue record thesis --inputs session.jsonl -o session.ttr\n"
               "ticktrue show session.ttr\n"
               "ticktrue show session.ttr --inputs > again.jsonl\n"
               "ticktrue show session.ttr --ticks 130..140");
  command->callback([options, &context] { context.exit_code = run_show(*options); });
}

}  // namespace ticktrue::cli
