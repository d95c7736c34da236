// `replay` of a plug-in's trace: its tables as text or JSON Lines.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "base/hash.h"
#include "base/plain_text.h"
#include "base/state/child_tables.h"
#include "base/state/state_view.h"
#include "tool/output/cli.h"
#include "tool/output/json_output.h"
#include "tool/output/trace_text.h"
#include "tool/session/plugin_session.h"
#include "verifier/locate/locate_contents.h"
#include "verifier/plugins/plugin.h"
#include "verifier/report/content_text.h"

namespace ticktrue::cli {
namespace {

const SimulationInfo* plugin_of(const replay::TraceSetup& setup) {
  for (const SimulationInfo* info : verifier::plugin_simulations())
    if (info->name == setup.simulation) return info;
  return nullptr;
}

/// The lanes of one value, "0.5" or "0.5 1".
std::string value_text(const TableSchema& table, ByteView rows, std::size_t row, std::size_t column) {
  std::string text;
  for (std::size_t lane = 0; lane < table.columns[column].lane_count; ++lane)
    text += (lane > 0 ? " " : "") +
            lane_text(table.columns[column].type, lane_bits(table, rows, StatePlace{0, row, column, lane}));
  return text;
}

/// Calls `row` for each row of each table: table, index, its little-endian rows. Texts and strings of bytes are put
/// together: calls `content` for each.
template <typename Row, typename Content>
void for_each_row(const StateView& state, Row row, Content content) {
  Bytes buffer;
  const std::vector<ImageTable> tables = canonical_tables(state, buffer);
  for (std::size_t t = 0; t < tables.size(); ++t) {
    if (has_pieces(state.schema->tables[t])) {
      for (const verifier::Content& one : verifier::contents_of(*state.schema, tables, t)) content(t, one);
      continue;
    }
    for (std::size_t r = 0; r < tables[t].row_count; ++r) row(t, r, tables[t].rows);
  }
}

bool holds_text(const TableSchema& table) {
  return table.form == TableForm::text;
}

std::string state_text(const Simulation& simulation, std::uint64_t tick, double time_s) {
  const StateView& state = simulation.state();
  std::string text = fmt::format("tick {}  {:.4f} s  {}\n", tick, time_s, hex64(root_hash(state)));
  for_each_row(
      state,
      [&](std::size_t t, std::size_t r, ByteView rows) {
        const TableSchema& table = state.schema->tables[t];
        const std::string name = simulation.row_name(t, r);
        text += fmt::format("  {} {}{}", table.name, r, name.empty() ? "" : " (" + plain_line(name) + ")");
        for (std::size_t c = 0; c < table.columns.size(); ++c)
          text += fmt::format("  {} {}", table.columns[c].name, value_text(table, rows, r, c));
        text += "\n";
      },
      [&](std::size_t t, const verifier::Content& content) {
        const bool is_cut = content.bytes.size() > verifier::hex_bytes_max;
        text += fmt::format("  {}  {}\n", plain_line(content.place),
                            holds_text(state.schema->tables[t])
                                ? plain_line(verifier::quoted(content.bytes))
                                : verifier::hex_bytes(content.bytes) + (is_cut ? " ..." : ""));
      });
  return text;
}

Json state_json(const Simulation& simulation, std::uint64_t tick, double time_s) {
  const StateView& state = simulation.state();
  Json line;
  line["tick"] = tick;
  line["time_s"] = time_s;
  line["hash"] = hex64(root_hash(state));
  line["tables"] = Json::object();
  for (const TableSchema& table : state.schema->tables) line["tables"][table.name] = Json::array();
  for_each_row(
      state,
      [&](std::size_t t, std::size_t r, ByteView rows) {
        const TableSchema& table = state.schema->tables[t];
        Json row;
        if (const std::string name = simulation.row_name(t, r); !name.empty()) row["name"] = name;
        // As text: exact, also where a number of JSON would be rounded.
        for (std::size_t c = 0; c < table.columns.size(); ++c)
          row[table.columns[c].name] = value_text(table, rows, r, c);
        line["tables"][table.name].push_back(std::move(row));
      },
      [&](std::size_t t, const verifier::Content& content) {
        const TableSchema& table = state.schema->tables[t];
        Json object;
        object["place"] = content.place;
        if (holds_text(table))
          object["text"] = content.bytes;
        else
          object["bytes"] = verifier::hex_text(content.bytes);
        line["tables"][table.name].push_back(std::move(object));
      });
  return line;
}

/// Reads the last checkpoint with a save at or before `tick`; null where there is none.
const replay::CheckpointRecord* seek_save(replay::TraceReader& reader, std::uint64_t tick) {
  while (tick > 0 && reader.seek(tick)) {
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&reader.next());
    if (checkpoint == nullptr || checkpoint->tick == 0 || checkpoint->tick > tick) return nullptr;
    if (checkpoint->save) return checkpoint;
    tick = checkpoint->tick - 1;
  }
  return nullptr;
}

/// Brings the simulation into the state of that save; the reader is positioned behind it. Gives the simulated time
/// there. Errors: the plug-in refuses the save, or the state is not the recorded one.
Result<double> begin_at_save(Simulation& simulation, const replay::CheckpointRecord& checkpoint) {
  if (const Status loaded = simulation.load_saved(checkpoint.tick, *checkpoint.save); !loaded) return loaded.error();
  if (root_hash(simulation.state()) == checkpoint.root_hash) return checkpoint.time_s.value_or(0);
  return Error{ErrorCode::usage, "load does not bring back the state of tick " + std::to_string(checkpoint.tick), ""};
}

}  // namespace

bool is_plugin_trace(const replay::TraceSetup& setup) {
  return plugin_of(setup) != nullptr;
}

int replay_plugin(replay::TraceReader& reader, std::uint64_t first, std::uint64_t last, std::uint64_t every,
                  bool json) {
  const SimulationInfo& info = *plugin_of(reader.setup());
  auto made = info.make(reader.setup().setup);
  if (!made) return fail(made.error());
  double time_s = 0;
  if (info.has_saves && reader.setup().has(replay::Feature::saves)) {
    const replay::CheckpointRecord* checkpoint = seek_save(reader, first);
    const Result<double> begun = checkpoint != nullptr ? begin_at_save(**made, *checkpoint) : Result<double>(0.0);
    if (begun) time_s = *begun;
    if (checkpoint == nullptr || !begun) reader.rewind();
    if (!begun) {
      print_warning(reader.name() + ": " + begun.error().message + "; played from tick 0");
      made = info.make(reader.setup().setup);
      if (!made) return fail(made.error());
    }
  }
  return replay_with(**made, reader, first, last, every, json, time_s);
}

int replay_with(Simulation& simulation, replay::TraceReader& reader, std::uint64_t first, std::uint64_t last,
                std::uint64_t every, bool json, double time_s) {
  const std::string file = reader.name();
  bool agrees = true;
  while (output_is_open() && !stop_requested()) {
    const replay::TraceReader::Item& item = reader.next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* record = std::get_if<replay::TickRecord>(&item);
    if (record == nullptr) continue;
    if (record->tick > last) return agrees ? exit_ok : exit_finding;
    const TickInput input{record->dt, record->inputs};
    if (const Status accepted = simulation.accept(input); !accepted) {
      print_warning(file + ": " + accepted.error().message + "; played up to there");
      return exit_not_comparable;
    }
    if (const Status did = simulation.step(input, nullptr); !did) {
      print_warning(file + ": " + did.error().message + "; played up to there");
      return agrees ? exit_not_comparable : exit_finding;
    }
    time_s += record->dt;
    if (agrees && root_hash(simulation.state()) != record->root_hash) {
      agrees = false;
      print_warning(file + ": tick " + std::to_string(record->tick) +
                    ": the state here is not the recorded one; from there on the states shown are this plug-in's");
    }
    if (record->tick < first || (record->tick - first) % every != 0) continue;
    if (json)
      print_json(state_json(simulation, record->tick, time_s), -1);
    else
      print(state_text(simulation, record->tick, time_s));
  }
  if (!output_is_open() || stop_requested()) return agrees ? exit_ok : exit_finding;
  const replay::TraceTail& tail = reader.tail();
  if (tail.condition != replay::TraceCondition::complete) print_warning(file + ": " + tail.message);
  return agrees ? exit_code_of_condition(tail.condition) : exit_finding;
}

}  // namespace ticktrue::cli
