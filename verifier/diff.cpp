// Two traces side by side: setup, inputs, states.
// SPDX-License-Identifier: MIT
#include "verifier/diff.h"

#include <algorithm>
#include <cstdio>

#include "base/hash.h"
#include "replay/payload.h"
#include "verifier/json_parts.h"
#include "verifier/locate.h"
#include "verifier/locate_cells.h"
#include "verifier/schema_difference.h"

namespace ticktrue::verifier {
namespace {

using Json = nlohmann::ordered_json;
using replay::CheckpointRecord;
using replay::TickRecord;
using replay::TraceCondition;
using replay::TraceSetup;

/// One of the two traces, tick by tick.
class Side {
 public:
  explicit Side(replay::TraceReader& reader) : reader_(reader) { reader_.rewind(); }

  /// The next tick, or null at the end. Keeps the checkpoint it passes on the way.
  const TickRecord* advance() {
    checkpoint_.reset();
    if (ended_) return nullptr;
    for (;;) {
      const replay::TraceReader::Item& item = reader_.next();
      if (const auto* record = std::get_if<TickRecord>(&item)) {
        ++ticks_;
        return record;
      }
      if (std::holds_alternative<std::monostate>(item)) {
        ended_ = true;
        return nullptr;
      }
      const auto& checkpoint = std::get<CheckpointRecord>(item);
      checkpoint_ = Bytes(checkpoint.image.begin(), checkpoint.image.end());
      checkpoint_tick_ = checkpoint.tick;
      checkpoint_root_ = checkpoint.root_hash;
      if (!keeps_last_) continue;
      last_image_ = *checkpoint_;
      last_image_tick_ = checkpoint_tick_;
    }
  }

  const std::optional<Bytes>& checkpoint() const { return checkpoint_; }
  std::uint64_t checkpoint_tick() const { return checkpoint_tick_; }
  std::uint64_t checkpoint_root() const { return checkpoint_root_; }
  std::uint64_t ticks() const { return ticks_; }
  /// The last state passed, until keep_last_image.
  const std::optional<Bytes>& last_image() const { return last_image_; }
  std::uint64_t last_image_tick() const { return last_image_tick_; }
  void keep_last_image() { keeps_last_ = false; }
  const replay::TraceTail& tail() const { return reader_.tail(); }

 private:
  replay::TraceReader& reader_;
  std::optional<Bytes> checkpoint_;
  std::uint64_t checkpoint_tick_ = 0;
  std::uint64_t checkpoint_root_ = 0;
  std::optional<Bytes> last_image_;
  std::uint64_t last_image_tick_ = 0;
  bool keeps_last_ = true;
  std::uint64_t ticks_ = 0;
  bool ended_ = false;
};

constexpr std::uint64_t spread_ticks = 64;

/// What to run, each with the build that recorded it, for the values behind a difference of two traces.
std::string more_detail_commands(const std::string& a, const std::string& b, std::uint64_t tick,
                                 const std::string& tool) {
  const std::string number = std::to_string(tick);
  if (tool.empty())
    return "record both again with detail full:" + number + ".." + number +
           ", each with the program that recorded it; then ticktrue diff a.ttr b.ttr";
  const auto record = [&](const std::string& file, const char* out) {
    return tool + " record " + shell_word(file) + " --ticks " + std::to_string(tick + 1) + " --detail full:" + number +
           ".." + number + " -o " + out;
  };
  return record(a, "a.ttr") + " and " + record(b, "b.ttr") +
         ", each with the build that recorded it; then ticktrue diff a.ttr b.ttr";
}

std::string number_text(double value) {
  return lane_text(ScalarType::f64, bits_of(value));
}

std::string bytes_summary(const Bytes& bytes) {
  return std::to_string(bytes.size()) + " bytes, hash " + hex64(hash64(bytes));
}

std::string stages_summary(const std::vector<std::string>& stages) {
  std::string text;
  for (const std::string& stage : stages) text += (text.empty() ? "" : ", ") + stage;
  return text;
}

/// Differences that keep the two from being compared at all come first; returns how many those are.
std::size_t compare_setups(const TraceSetup& a, const TraceSetup& b, std::vector<SetupDifference>& out) {
  if (a.simulation != b.simulation) out.push_back({"simulation", a.simulation, b.simulation});
  if (a.physics_version != b.physics_version)
    out.push_back({"physics version", std::to_string(a.physics_version), std::to_string(b.physics_version)});
  if (const auto precision = precision_difference(a.schema, b.schema))
    out.push_back({precision->place, precision->a, precision->b});
  else if (const auto difference = first_schema_difference(a.schema, b.schema))
    out.push_back({"schema: " + difference->place, difference->a, difference->b});
  const std::size_t blocking = out.size();
  if (a.stages != b.stages) out.push_back({"stages", stages_summary(a.stages), stages_summary(b.stages)});
  if (a.title != b.title) out.push_back({"title", a.title, b.title});
  if (bits_of(a.dt) != bits_of(b.dt)) out.push_back({"dt", number_text(a.dt), number_text(b.dt)});
  if (a.setup != b.setup) out.push_back({"setup", bytes_summary(a.setup), bytes_summary(b.setup)});
  return blocking;
}

/// What is stored of a tick, beyond the reader's next step.
struct Stored {
  std::uint64_t root_hash = 0;
  std::vector<std::uint64_t> stage_hashes;
  std::optional<Bytes> image;
  Bytes cells;
};

Stored store(const TickRecord& record) {
  Stored stored{record.root_hash, record.stage_hashes, std::nullopt, Bytes(record.cells.begin(), record.cells.end())};
  if (record.image) stored.image = Bytes(record.image->begin(), record.image->end());
  return stored;
}

class Differ {
 public:
  Differ(replay::TraceReader& a, replay::TraceReader& b, const DiffOptions& options)
      : setup_a_(a.setup()), setup_b_(b.setup()), a_(a), b_(b), options_(options) {
    report_.a.file = a.name();
    report_.b.file = b.name();
    report_.a.build = a.facts();
    report_.b.build = b.facts();
    if (options.simulation != nullptr && options.simulation->name == setup_a_.simulation)
      if (Result<std::unique_ptr<Simulation>> made = options.simulation->make(setup_a_.setup))
        words_ = std::move(*made);
  }

  DiffReport run() {
    comparable_ = compare_setups(setup_a_, setup_b_, report_.setup) == 0;
    walk();
    finish();
    return std::move(report_);
  }

 private:
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const {
    return words_ ? words_->inputs_text(tick, inputs) : "";
  }

  void walk() {
    const TickRecord* a = a_.advance();
    const TickRecord* b = b_.advance();
    if (comparable_ && a_.checkpoint() && b_.checkpoint() && a_.checkpoint_tick() == 0 && b_.checkpoint_tick() == 0 &&
        *a_.checkpoint() != *b_.checkpoint()) {
      Divergence divergence;
      divergence.stage = std::string(stage_setup);
      divergence.stage_note = "they begin with different states";
      divergence.expected_root = a_.checkpoint_root();
      divergence.got_root = b_.checkpoint_root();
      fill_lanes(*a_.checkpoint(), *b_.checkpoint(), divergence);
      report_.divergence = std::move(divergence);
    }
    double time_s = 0;
    std::uint64_t tick = 0;
    while (a != nullptr && b != nullptr) {
      compare_inputs(tick, *a, *b);
      // Hashes of different schemas say nothing about each other.
      const bool found = comparable_ && !report_.divergence && a->root_hash != b->root_hash;
      if (found) {
        Divergence divergence;
        divergence.tick = tick;
        divergence.time_s = time_s;
        divergence.expected_root = a->root_hash;
        divergence.got_root = b->root_hash;
        divergence.inputs = inputs_text(tick, a->inputs);
        report_.divergence = std::move(divergence);
        stored_a_ = store(*a);
        stored_b_ = store(*b);
        a_.keep_last_image();
        b_.keep_last_image();
      } else if (report_.divergence && comparable_) {
        follow_spread(*a, *b);
      }
      time_s += a->dt;
      ++tick;
      if (comparable_) ++report_.ticks_compared;
      if (options_.progress) options_.progress(tick);
      a = a_.advance();
      b = b_.advance();
      if (found) locate(tick);
    }
    while (a != nullptr) a = a_.advance();
    while (b != nullptr) b = b_.advance();
  }

  void compare_inputs(std::uint64_t tick, const TickRecord& a, const TickRecord& b) {
    if (report_.inputs) return;
    if (bits_of(a.dt) == bits_of(b.dt) &&
        std::equal(a.inputs.begin(), a.inputs.end(), b.inputs.begin(), b.inputs.end()))
      return;
    report_.inputs = InputDifference{tick, a.dt, b.dt, inputs_text(tick, a.inputs), inputs_text(tick, b.inputs)};
  }

  /// The sides stand behind the checkpoints, if any, that hold the states with `ticks_done` ticks done.
  void locate(std::uint64_t ticks_done) {
    Divergence& divergence = *report_.divergence;
    if (!stored_a_.image && a_.checkpoint() && a_.checkpoint_tick() == ticks_done) stored_a_.image = a_.checkpoint();
    if (!stored_b_.image && b_.checkpoint() && b_.checkpoint_tick() == ticks_done) stored_b_.image = b_.checkpoint();
    if (stored_a_.image && stored_b_.image)
      fill_lanes(*stored_a_.image, *stored_b_.image, divergence);
    else if (!stored_a_.cells.empty() && !stored_b_.cells.empty())
      fill_cells(divergence);
    if (!stored_a_.stage_hashes.empty() && !stored_b_.stage_hashes.empty() && setup_a_.stages == setup_b_.stages)
      locate_stage(setup_a_.stages, stored_a_.stage_hashes, stored_b_.stage_hashes, divergence);
    else
      divergence.stage_note = "not known: not both store a hash after each stage of this tick";
    stored_a_ = {};
    stored_b_ = {};
  }

  void fill_lanes(const Bytes& a, const Bytes& b, Divergence& divergence) {
    if (const Status located = locate_lanes(setup_a_.schema, a, b, {}, options_.row_count_max, divergence); !located)
      report_.notes.push_back("a stored state cannot be read: " + located.error().message);
  }

  /// Columns from the hashes of both; rows are tried among those of the last state both store before.
  void fill_cells(Divergence& divergence) {
    const StateSchema& schema = setup_a_.schema;
    const StateCells a = replay::decode_cells(schema, stored_a_.cells);
    const StateCells b = replay::decode_cells(schema, stored_b_.cells);
    std::optional<ImageState> rows;
    RowNamer row_name;
    if (a_.last_image()) {
      if (Result<ImageState> state = ImageState::of(schema, *a_.last_image())) rows.emplace(std::move(*state));
      if (words_ && words_->load(*a_.last_image()))
        row_name = [this](std::size_t table, std::size_t row) { return words_->row_name(table, row); };
      report_.notes.push_back("rows are those of the state stored before tick " + std::to_string(a_.last_image_tick()) +
                              ": later ones cannot be named");
    }
    locate_cells(schema, a, b, rows ? &rows->view() : nullptr, row_name, options_.row_count_max, divergence);
    if (a.partition_cells != b.partition_cells)
      report_.notes.push_back("rows cannot be named: the traces have another number of cells for this tick");
  }

  /// At 1, 2, 4, 8, ... ticks behind the divergence.
  void follow_spread(const TickRecord& a, const TickRecord& b) {
    Divergence& divergence = *report_.divergence;
    const std::uint64_t behind = a.tick - divergence.tick;
    if (behind == 0 || (behind & (behind - 1)) != 0 || behind > spread_ticks) return;
    if (!a.cells.empty() && !b.cells.empty()) {
      const StateCells cells_a = replay::decode_cells(setup_a_.schema, a.cells);
      const StateCells cells_b = replay::decode_cells(setup_a_.schema, b.cells);
      if (cells_a.partition_cells == cells_b.partition_cells)
        divergence.spread.push_back(spread_of_cells(setup_a_.schema, cells_a, cells_b, a.tick));
    } else if (a.image && b.image) {
      if (const auto spread = spread_of_images(setup_a_.schema, *a.image, *b.image, a.tick))
        divergence.spread.push_back(*spread);
    }
  }

  void finish() {
    for (const auto& [side, out] : {std::pair<Side*, DiffSide*>{&a_, &report_.a}, {&b_, &report_.b}}) {
      out->ticks = side->ticks();
      out->end.tail = side->tail();
      const replay::TraceTail& tail = out->end.tail;
      if (tail.has_pending_inputs) out->end.pending_inputs = inputs_text(tail.ticks_intact, tail.pending_inputs);
    }
    const auto either = [&](TraceCondition condition) {
      return a_.tail().condition == condition || b_.tail().condition == condition;
    };
    const bool whole = !either(TraceCondition::damaged) && !either(TraceCondition::truncated);
    if (!comparable_) {
      report_.verdict = DiffVerdict::not_comparable;
      report_.reason = report_.setup.front().what + ": " + report_.setup.front().a + " and " + report_.setup.front().b;
    } else if (report_.divergence || report_.inputs || !report_.setup.empty()) {
      report_.verdict = DiffVerdict::different;
      if (!report_.divergence && report_.ticks_compared > 0) report_.reason = "states equal; " + what_differs();
    } else if (whole && ended_early(shorter())) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "equal as far as both go; " + (&shorter() == &a_ ? report_.a.file : report_.b.file) +
                       " ended early, after " + std::to_string(shorter().ticks()) + " ticks";
    } else if (whole && a_.ticks() != b_.ticks()) {
      report_.verdict = DiffVerdict::different;
      report_.reason = "lengths: " + std::to_string(a_.ticks()) + " and " + std::to_string(b_.ticks()) +
                       " ticks; equal as far as both go";
    } else if (either(TraceCondition::damaged)) {
      report_.verdict = DiffVerdict::damaged;
      report_.reason = "equal as far as both are intact";
    } else if (either(TraceCondition::truncated)) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "equal as far as both go";
    } else if (report_.ticks_compared == 0) {
      report_.verdict = DiffVerdict::incomplete;
      report_.reason = "no tick was compared";
    }
    if (report_.divergence && report_.divergence->rows.empty() && comparable_)
      report_.again.push_back(
          more_detail_commands(report_.a.file, report_.b.file, report_.divergence->tick, options_.tool));
  }

  const Side& shorter() const { return b_.ticks() < a_.ticks() ? b_ : a_; }

  /// Whether the recorder of the side was stopped, or died, before the other one ended.
  bool ended_early(const Side& side) const {
    if (a_.ticks() == b_.ticks() || !side.tail().end) return false;
    const replay::EndReason reason = side.tail().end->reason;
    return reason == replay::EndReason::recovered || reason == replay::EndReason::interrupted;
  }

  /// Where the states do not.
  std::string what_differs() const {
    if (report_.setup.empty()) return "the inputs differ";
    return report_.inputs ? "the setups and the inputs differ" : "the setups differ";
  }

  const TraceSetup& setup_a_;
  const TraceSetup& setup_b_;
  Side a_;
  Side b_;
  const DiffOptions& options_;
  std::unique_ptr<Simulation> words_;  // only to put inputs into words
  DiffReport report_;
  bool comparable_ = true;
  Stored stored_a_;
  Stored stored_b_;
};

Json side_json(const DiffSide& side) {
  return {{"file", side.file},
          {"ticks", side.ticks ? Json(*side.ticks) : Json(nullptr)},
          {"end", end_json(side.end)},
          {"build", facts_json(side.build)}};
}

}  // namespace

const DiffVerdictInfo& diff_verdict_info(DiffVerdict verdict) {
  const auto found = std::find_if(diff_verdicts.begin(), diff_verdicts.end(),
                                  [&](const DiffVerdictInfo& info) { return info.verdict == verdict; });
  TICKTRUE_ASSERT(found != diff_verdicts.end());
  return *found;
}

int DiffReport::exit_code(bool allow_truncated) const {
  if (allow_truncated && verdict == DiffVerdict::incomplete && ticks_compared > 0) return exit_ok;
  return diff_verdict_info(verdict).exit_code;
}

DiffReport diff(replay::TraceReader& a, replay::TraceReader& b, const DiffOptions& options) {
  return Differ(a, b, options).run();
}

std::string diff_text(const DiffReport& report) {
  std::string text(diff_verdict_info(report.verdict).name);
  text += "  " + report.a.file + "  " + report.b.file + "  ";
  if (report.divergence) {
    char seconds[40];
    std::snprintf(seconds, sizeof seconds, "%.3f s", report.divergence->time_s);
    text += "tick " + std::to_string(report.divergence->tick) + " of " + std::to_string(report.ticks_compared) + " (" +
            seconds + ")\n";
  } else {
    text += std::to_string(report.ticks_compared) + " ticks compared\n";
  }
  const auto line = [&](std::string label, const std::string& content) {
    label.resize(7, ' ');
    text += "  " + label + " " + content + "\n";
  };
  if (!report.reason.empty()) line("reason", report.reason);
  for (const SetupDifference& difference : report.setup)
    line("setup", difference.what + ": " + difference.a + ".  other: " + difference.b);
  if (report.divergence) text += divergence_text(*report.divergence, "a", "b");
  if (report.inputs) {
    const InputDifference& inputs = *report.inputs;
    line("inputs", "differ first at tick " + std::to_string(inputs.tick));
    if (bits_of(inputs.dt_a) != bits_of(inputs.dt_b))
      line("dt", "a " + number_text(inputs.dt_a) + " s.  b " + number_text(inputs.dt_b) + " s");
    for (const auto& [label, lines] :
         {std::pair<const char*, const std::string*>{"a", &inputs.inputs_a}, {"b", &inputs.inputs_b}})
      for (const std::string& input : split_lines(*lines)) line(label, input);
  }
  for (const auto& [label, side] : {std::pair<const char*, const DiffSide*>{"a", &report.a}, {"b", &report.b}})
    if (side->end.tail.condition != TraceCondition::complete)
      line(label, side->end.tail.message + " (" + std::to_string(side->end.tail.ticks_intact) + " ticks are intact)");
  for (const std::string& note : report.notes) line("note", note);
  if (report.verdict != DiffVerdict::equal) {
    line("builds", "a " + facts_line(report.a.build));
    line("", "b " + facts_line(report.b.build));
  }
  for (const std::string& command : report.again) line("again", command);
  return text;
}

std::string diff_json(const DiffReport& report) {
  Json object = {{"schema", "ticktrue.diff/1"}, {"verdict", diff_verdict_info(report.verdict).name},
                 {"reason", report.reason},     {"ticks_compared", report.ticks_compared},
                 {"a", side_json(report.a)},    {"b", side_json(report.b)}};
  Json setup = Json::array();
  for (const SetupDifference& difference : report.setup)
    setup.push_back({{"what", difference.what}, {"a", difference.a}, {"b", difference.b}});
  object["setup"] = std::move(setup);
  object["inputs"] = nullptr;
  if (report.inputs)
    object["inputs"] = {{"tick", report.inputs->tick},
                        {"dt_a", hex64(bits_of(report.inputs->dt_a))},
                        {"dt_b", hex64(bits_of(report.inputs->dt_b))},
                        {"inputs_a", input_lines_json(report.inputs->inputs_a)},
                        {"inputs_b", input_lines_json(report.inputs->inputs_b)}};
  object["divergence"] = report.divergence ? divergence_json(*report.divergence) : Json(nullptr);
  object["notes"] = report.notes;
  object["again"] = report.again;
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ticktrue::verifier
