// Writes what the fuzzers begin with: fuzz_seeds FOLDER makes FOLDER/NAME/* for each harness, and NAME.dict for text.
// SPDX-License-Identifier: MIT
//
// All of it comes from the repository's own scenes, sessions and traces; what no other file holds lies in
// tests/fuzz/seeds, with everything that a fuzzer once found.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "base/state/gathered_state.h"
#include "base/state/stage_hashes.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "replay/box/box_writer.h"
#include "replay/format/identity.h"
#include "replay/format/mark_log.h"
#include "replay/format/peer.h"
#include "replay/recorder.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/peers_world.h"
#include "tests/fuzz/support/saving_toy.h"
#include "tests/fuzz/support/worlds.h"
#include "tests/support/toy_simulation.h"
#include "tool/corpus/run/shard_plan.h"
#include "tool/session/input_source.h"
#include "verifier/peers/peer_rows.h"
#include "verifier/report/report_transfer.h"
#include "verifier/store/verdict_entry.h"

namespace {

using namespace ticktrue;
namespace fs = std::filesystem;

constexpr std::size_t trace_size_max = 10'000;  // a fuzzer changes small files sooner to the point
constexpr std::size_t text_size_max = 4'096;

fs::path out_folder;
const fs::path root = TICKTRUE_SOURCE_DIR;

Bytes read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

void seed(const std::string& harness, ByteView bytes) {
  static std::map<std::string, int> counts;
  const fs::path folder = out_folder / harness;
  fs::create_directories(folder);
  std::ofstream out(folder / ("seed_" + std::to_string(counts[harness]++)), std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  fuzz::require(out.good(), "a seed can be written");
}
void seed_text(const std::string& harness, std::string_view text) {
  seed(harness, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// All that stands in quotes in the text seeds of a harness, as words to insert.
void write_texts(const std::string& harness) {
  std::set<std::string> words;
  for (const fs::directory_entry& entry : fs::directory_iterator(out_folder / harness)) {
    const Bytes bytes = read_file(entry.path());
    const std::string text(bytes.begin(), bytes.end());
    for (std::size_t open = text.find('"'); open != std::string::npos;) {
      const std::size_t close = text.find('"', open + 1);
      if (close == std::string::npos) break;
      const std::string word = text.substr(open + 1, close - open - 1);
      bool is_plain = !word.empty() && word.size() < 30;
      for (const char c : word) is_plain = is_plain && c >= ' ' && c < 0x7f && c != '\\';
      if (is_plain) words.insert(word);
      open = text.find('"', close + 1);
    }
  }
  std::ofstream out(out_folder / (harness + ".dict"));
  for (const std::string& word : words) out << "\"\\\"" << word << "\\\"\"\n";
  for (const char* number : {"1e308", "-1e308", "5e-324", "1e-9", "-0.0", "4294967295", "9007199254740993", "1e400"})
    out << '"' << number << "\"\n";
}

class ToySession : public replay::InputSource {
 public:
  Result<std::optional<TickInput>> next(std::uint64_t tick) override {
    test::ToyInputs inputs;
    if (tick % 3 == 1) inputs.push(0, 0.5);
    if (tick == 4) inputs.spawn(2).gravity(-3);
    if (tick == 6) inputs.remove(1);
    bytes_ = inputs.take();
    return std::optional<TickInput>(TickInput{tick % 5 == 4 ? 0.0078125 : 0.015625, bytes_});
  }
  bool repeatable() const override { return true; }

 private:
  Bytes bytes_;
};

/// `has_saves`: of a simulation that has them, which loads them.
void seed_toy_trace(std::uint32_t body_count, bool is_full, bool compress, std::uint64_t tick_count,
                    bool has_saves = false) {
  test::ToySimulation plain(body_count);
  fuzz::SavingToy saving(body_count);
  test::ToySimulation& toy = has_saves ? saving : plain;
  replay::TraceSetup setup;
  setup.simulation = "ticktrue.toy";
  setup.physics_version = 1;
  setup.title = "toy";
  setup.dt = 0.015625;
  setup.detail = is_full ? replay::Detail::full : replay::Detail::root;
  if (is_full) setup.full_first = 2, setup.full_last = 4;
  setup.checkpoint_interval = 4;
  setup.schema = test::ToySimulation::schema();
  setup.stages = test::ToySimulation::stages();
  setup.setup = test::ToySimulation::setup(body_count);
  if (has_saves) setup.features = static_cast<std::uint32_t>(replay::Feature::saves);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer.compress = compress;
  options.writer.sync = false;
  options.writer.overwrite = true;
  ToySession session;
  const fs::path path = out_folder / "toy.ttr";
  const auto result = replay::record(toy, session, path.string(), setup, {{"compiler", "x"}}, options);
  fuzz::require(result.has_value(), "the toy is recorded");
  const Bytes trace = read_file(path);
  fs::remove(path);
  seed("trace", trace);
  seed("trace_forged", trace);
}

replay::TraceSetup toy_setup(replay::Detail detail) {
  replay::TraceSetup setup;
  setup.simulation = "ticktrue.toy";
  setup.physics_version = 1;
  setup.title = "toy";
  setup.dt = 0.015625;
  setup.detail = detail;
  setup.schema = test::ToySimulation::schema();
  return setup;
}

/// Format version 3: begins late where it may, with a shown column, saves, notes and marks.
void seed_third_trace(replay::Detail detail, std::uint64_t first_tick) {
  constexpr std::uint32_t body_count = 2;
  constexpr std::uint64_t tick_count = 9;
  test::ToySimulation toy(body_count);
  replay::TraceSetup setup = toy_setup(detail);
  if (detail == replay::Detail::full) setup.full_first = first_tick + 2, setup.full_last = first_tick + 5;
  setup.checkpoint_interval = 4;
  setup.features = replay::feature_mask;
  setup.stage_interval = 2;
  setup.whole_schema = setup.schema;
  Column glow;
  glow.name = "glow";
  glow.type = ScalarType::i16;
  glow.is_shown = true;
  setup.whole_schema->tables[1].columns.push_back(glow);
  setup.whole_schema->tables[1].shown_row_size = 2;
  setup.stages = test::ToySimulation::stages();
  setup.setup = test::ToySimulation::setup(body_count);
  replay::WriterOptions options;
  options.compress = false;
  options.sync = false;
  options.allow_third = true;
  const fs::path path = out_folder / "third.ttr";
  auto writer = replay::TraceWriter::create(path.string(), setup, {{"compiler", "x"}}, options);
  fuzz::require(writer.has_value(), "a trace of version 3 can be written");
  if (first_tick > 0) writer->begin_at(first_tick, 1);
  ToySession session;
  const Bytes content{1, 2, 3, 4};
  const replay::TickMarks marks{0x0807060504030201, {{"rand", 2, 0x09090909}, {"sin", 1, 0x08080808}}};
  const replay::MarkList list{{"rand", "sin"}, {{0, 1}, {1, 2}, {0, 3}}, false};
  bool is_written = true;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    if (writer->wants_checkpoint())
      is_written = is_written && writer->checkpoint(toy.state(), root_hash(toy.state())) && writer->shown(content) &&
                   writer->save(content);
    const auto input = session.next(tick);
    is_written = is_written && writer->begin_tick(**input) && writer->note({"log", "hi"}) && writer->marks(marks) &&
                 (!writer->wants_full() || writer->mark_list(list));
    StageHashes stages;
    is_written = is_written && toy.step(**input, &stages);
    is_written = is_written && writer->end_tick(root_hash(toy.state()), stages.hashes(), &toy.state());
  }
  // Another player differs in the last tick.
  replay::PeerRecord peer;
  peer.player = 1;
  peer.session_identity = replay::session_identity(setup);
  peer.facts = {{"compiler", "y"}};
  peer.tick = first_tick + tick_count - 1;
  peer.roots = {{peer.tick - 1, 7}, {peer.tick, 8}};
  peer.inputs = replay::inputs_of(0.5, content);
  peer.has_state = true;
  peer.tables = {{0, {0}, {0}, Bytes(setup.schema.tables[0].row_size, 1)}};
  is_written = is_written && writer->checkpoint(toy.state(), root_hash(toy.state())) && writer->peer(peer);
  peer.player = 3;
  peer.has_state = false;
  peer.lost_state = true;
  peer.tables.clear();
  is_written = is_written && writer->peer(peer);
  fuzz::require(is_written && writer->finish(replay::EndReason::complete, ""), "and is");
  const Bytes trace = read_file(path);
  fs::remove(path);
  seed("trace", trace);
  seed("trace_forged", trace);
}

/// Format version 3 with child tables: texts of each row, a list of each row, and a text of each element. `is_bundle`:
/// another player has another list in the last tick.
void seed_child_trace(replay::Detail detail, bool is_bundle) {
  constexpr std::uint64_t tick_count = 6;
  using Words = std::vector<std::string>;
  const std::vector<std::uint32_t> ids{3, 8};
  std::vector<Words> lists{{"axe", "a rope of twenty metres"}, {}};
  const ElementReader word_count = [](void* user, const void*, std::uint32_t row, std::size_t* count) -> const void* {
    const Words& words = (*static_cast<std::vector<Words>*>(user))[row];
    *count = words.size();
    return words.data();
  };
  const ElementReader word = [](void*, const void* owner, std::uint32_t, std::size_t* count) -> const void* {
    *count = static_cast<const std::string*>(owner)->size();
    return static_cast<const std::string*>(owner)->data();
  };
  GatheredState state;
  bool is_written =
      static_cast<bool>(state.column("units", "id", {ids.data(), ScalarType::u32, 1, 2})) && state.key("units", 1) &&
      state.child("words", "units", {TableForm::rows, word_count, &lists, sizeof(std::string)}, {}) &&
      state.child("words.text", "words", {TableForm::text, word, nullptr, 1}, {}) &&
      state.child("words.bytes", "words", {TableForm::bytes, word, nullptr, 1}, {}) && state.freeze() && state.gather();
  fuzz::require(is_written, "a state with texts can be gathered");
  replay::TraceSetup setup = toy_setup(detail);
  setup.schema = state.schema();
  if (detail == replay::Detail::full) setup.full_last = tick_count;
  setup.checkpoint_interval = 3;
  if (is_bundle)
    setup.features =
        static_cast<std::uint32_t>(replay::Feature::tail) | static_cast<std::uint32_t>(replay::Feature::peers);
  replay::WriterOptions options;
  options.compress = false;
  options.sync = false;
  options.allow_third = true;
  const fs::path path = out_folder / "children.ttr";
  auto writer = replay::TraceWriter::create(path.string(), setup, {{"compiler", "x"}}, options);
  fuzz::require(writer.has_value(), "a trace with child tables can be written");
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    if (writer->wants_checkpoint())
      is_written = is_written && writer->checkpoint(state.view(), root_hash(state.view()));
    is_written = is_written && writer->begin_tick({setup.dt, {}});
    lists[tick % 2].push_back("tick " + std::to_string(tick));
    if (tick == 3) lists[0].clear();
    is_written = is_written && state.gather() && writer->end_tick(root_hash(state.view()), {}, &state.view());
  }
  if (is_bundle) {
    is_written = is_written && writer->checkpoint(state.view(), root_hash(state.view()));
    Bytes own_buffer, other_buffer;
    encode_image(state.view(), own_buffer);
    const auto own = split_image(state.schema(), own_buffer);
    lists[0].push_back("a rope of thirty metres");
    is_written = is_written && own && state.gather();
    replay::PeerRecord peer;
    peer.player = 1;
    peer.session_identity = replay::session_identity(setup);
    peer.tick = tick_count - 1;
    peer.roots = {{peer.tick, root_hash(state.view())}};
    peer.inputs = replay::inputs_of(setup.dt, {});
    verifier::set_peer_rows(state.schema(), *own, canonical_tables(state.view(), other_buffer), peer);
    is_written = is_written && writer->peer(peer);
  }
  fuzz::require(is_written && writer->finish(replay::EndReason::complete, ""), "and is");
  const Bytes trace = read_file(path);
  fs::remove(path);
  seed("trace", trace);
  seed("trace_forged", trace);
}

/// A box as box_fuzz.cpp takes it: without the space between its parts.
Bytes packed_box(const Bytes& file) {
  const auto layout = replay::decode_box_header(ByteView(file).first(replay::box_header_size), "seed");
  fuzz::require(layout.has_value(), "the header of a box is read");
  Bytes packed;
  const auto add = [&](std::uint64_t offset, std::uint64_t size) {
    const ByteView part = ByteView(file).subspan(offset, size);
    packed.insert(packed.end(), part.begin(), part.end());
  };
  add(0, replay::box_header_size);
  packed.resize(packed.size() + 4);
  add(replay::box_page_size, layout->head_size);
  for (std::size_t i = 0; i < layout->slot_count; ++i) {
    const std::uint64_t offset = layout->slot_offset(i);
    const std::uint32_t committed = ByteReader(ByteView(file).subspan(offset + replay::box_committed_offset)).u32();
    add(offset, replay::box_slot_header_size + committed);
  }
  return packed;
}

/// A black box whose slots have `slot_ticks` ticks each: more slots than it holds were begun. The last is cut short
/// where the session did not close it.
void seed_box(replay::Detail detail, bool has_saves, bool is_closed, std::size_t slot_ticks) {
  constexpr std::uint32_t body_count = 2;
  constexpr std::uint64_t slots_begun = 5;
  test::ToySimulation toy(body_count);
  replay::TraceSetup setup = toy_setup(detail);
  setup.features =
      static_cast<std::uint32_t>(replay::Feature::tail) | static_cast<std::uint32_t>(replay::Feature::notes);
  if (has_saves) setup.features |= static_cast<std::uint32_t>(replay::Feature::saves);
  setup.stages = test::ToySimulation::stages();
  setup.setup = test::ToySimulation::setup(body_count);
  const fs::path path = out_folder / "box.ttb";
  const auto layout = replay::divide_box(3 * replay::box_slot_size_min);
  fuzz::require(layout.has_value(), "a small box is divided");
  replay::BoxWriter box(path.string(), *layout);
  ToySession session;
  const Bytes save{1, 2, 3, 4};
  bool is_written = true;
  for (std::uint64_t slot = 0; slot < slots_begun; ++slot) {
    const bool is_last = slot + 1 == slots_begun;
    auto writer = box.begin_slot(setup, {{"compiler", "x"}}, slot * slot_ticks, 1);
    fuzz::require(writer.has_value(), "a slot begins");
    is_written =
        is_written && writer->checkpoint(toy.state(), root_hash(toy.state())) && (!has_saves || writer->save(save));
    box.publish();
    for (std::uint64_t i = 0; i < slot_ticks; ++i) {
      const auto input = session.next(slot * slot_ticks + i);
      is_written = is_written && writer->begin_tick(**input) && (i != 0 || writer->note({"log", "hi"}));
      if (is_last && !is_closed && i + 1 == slot_ticks) break;
      StageHashes stages;
      is_written = is_written && toy.step(**input, &stages);
      is_written = is_written && writer->end_tick(root_hash(toy.state()), stages.hashes(), &toy.state());
    }
    if (is_last && is_closed) {
      is_written = is_written && writer->finish(replay::EndReason::complete, "");
      box.close();
    }
  }
  fuzz::require(is_written, "a box is written");
  seed("box", packed_box(read_file(path)));
  fs::remove(path);
}

void seed_boxes() {
  for (const replay::Detail detail : {replay::Detail::root, replay::Detail::cells})
    for (const bool has_saves : {false, true})
      for (const bool is_closed : {false, true}) seed_box(detail, has_saves, is_closed, has_saves ? 3 : 7);
}

void seed_traces() {
  for (const replay::Detail detail : {replay::Detail::root, replay::Detail::cells, replay::Detail::full})
    for (const std::uint64_t first_tick : {0, 7}) seed_third_trace(detail, first_tick);
  for (const replay::Detail detail : {replay::Detail::cells, replay::Detail::full})
    for (const bool is_bundle : {false, true}) seed_child_trace(detail, is_bundle);
  for (const bool is_full : {false, true})
    for (const bool compress : {false, true}) seed_toy_trace(compress ? 20 : 2, is_full, compress, 9);
  seed_toy_trace(1, false, false, 1);
  for (const bool is_full : {false, true}) seed_toy_trace(2, is_full, false, 9, true);
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "traces"))
    if (entry.path().extension() == ".ttr" && entry.file_size() < trace_size_max)
      for (const char* harness : {"trace", "trace_forged"}) seed(harness, read_file(entry.path()));
}

void seed_scenes() {
  std::vector<engine::Scene> scenes;
  for (const std::string_view text : fuzz::worlds) scenes.push_back(*engine::make_builtin_scene(text));
  for (const engine::BuiltinScene& builtin : engine::builtin_scenes()) {
    const auto scene = engine::make_builtin_scene(builtin.name);
    if (scene && scene->bodies.size() <= 40) scenes.push_back(*scene);
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Bytes text = read_file(entry.path());
    const auto scene = engine::parse_scene(fuzz::text_of(text), "scene");
    if (!scene) continue;  // the schema
    seed("scene", text);
    scenes.push_back(*scene);
  }
  for (const engine::Scene& scene : scenes) {
    seed("setup", engine::encode_scene(scene));
    seed_text("scene", engine::print_scene(scene));
  }
}

void seed_states() {
  for (std::size_t world = 0; world < fuzz::worlds.size(); ++world) {
    const auto scene = engine::make_builtin_scene(fuzz::worlds[world]);
    const auto engine = engine::make_engine(*scene);
    for (int tick = 0; tick < 200; ++tick) {
      if (tick == 0 || tick == 20 || tick == 90 || tick == 199) {
        Bytes image{static_cast<std::uint8_t>(world)};
        encode_image((*engine)->state(), image);
        seed("state", image);
      }
      fuzz::require((*engine)->step({scene->settings.dt, {}}, nullptr).has_value(), "a small world does its ticks");
    }
    for (const engine::InputInfo& info : engine::input_kinds) {
      engine::Input input;
      input.kind = info.kind;
      for (std::size_t i = 0; i < info.value_count; ++i) input.values[i] = 0.5;
      Bytes bytes{static_cast<std::uint8_t>(world)};
      engine::encode_inputs({input}, bytes);
      seed("inputs", bytes);
    }
  }
}

void seed_sessions() {
  for (const char* folder : {"scenes", "traces"})
    for (const fs::directory_entry& entry : fs::directory_iterator(root / folder)) {
      if (entry.path().extension() != ".jsonl") continue;
      const Bytes bytes = read_file(entry.path());
      std::string_view text = fuzz::text_of(bytes);
      text = text.substr(0, text.rfind('\n', text_size_max) + 1);
      seed_text("input_lines", text);
    }
  const engine::Scene thesis = *engine::make_builtin_scene("thesis");
  auto source = tool::JsonLinesInputs::open(thesis, (root / "scenes/thesis_session.jsonl").string(), {});
  for (std::uint64_t tick = 0; source && tick < 300; ++tick) {
    const auto input = (*source)->next(tick);
    if (!input || !input->has_value()) break;
    if ((*input)->inputs.empty()) continue;
    Bytes bytes{4};  // the thesis among the worlds
    bytes.insert(bytes.end(), (*input)->inputs.begin(), (*input)->inputs.end());
    seed("inputs", bytes);
  }
}

/// Entries of a store of verdicts, and the reports in them alone.
void seed_verdicts() {
  verifier::Report report;
  report.verdict = verifier::Verdict::match;
  report.ticks_recorded = 600;
  report.notes = {"a note"};
  report.recorded_build = {{"version", "1"}};
  for (const bool is_match : {true, false}) {
    if (!is_match) {
      report.verdict = verifier::Verdict::diverged;
      report.divergence.emplace();
      report.divergence->tables = {{"bodies", {"position"}}};
      report.divergence->rows.resize(2);
      for (verifier::LaneReport& row : report.divergence->rows) row.type = ScalarType::f32;
      report.divergence->candidates.resize(1);
      report.divergence->contents.resize(1);
      report.divergence->spread.resize(1);
      report.non_finite.emplace();
      report.end.emplace();
    }
    verifier::VerdictEntry entry;
    entry.key = std::string(32, 'a');
    entry.content = verifier::encode_report(report);
    seed("verdict", verifier::encode_entry(entry));
    seed("verdict", entry.content);
  }
  seed("verdict", tool::encode_plan({{{1, 2}, {3}, {1}, {2}}}));
}

/// The messages of two players whose states differ, in order.
void seed_peers() {
  const fuzz::PeersWorld one(0, 0), other(1, 9);
  const auto with_kind = [](std::uint8_t kind, ByteView bytes) {
    ByteWriter all;
    all.u8(kind);
    all.bytes(bytes);
    return all.take();
  };
  seed("peers", with_kind(0, one.peers->hello()));
  other.peers->add_root(0, 0, root_hash(one.view()));
  ByteWriter session;
  for (int i = 0; i < 6; ++i) {
    const Bytes message = other.peers->next_message(0, 1'200);
    if (message.empty()) break;
    session.u16(static_cast<std::uint16_t>(message.size()));
    session.bytes(message);
    if (const auto read = capi::decode_message(message)) seed("peers", with_kind(1, read->part));
    if (!one.peers->receive(1, message)) break;
    const Bytes answer = one.peers->next_message(1, 1'200);
    if (answer.empty() || !other.peers->receive(0, answer)) break;
  }
  seed("peers", with_kind(2, session.view()));
}

/// The begin of this program: its headers and, as linkers put them in front, its notes.
void seed_own_program() {
  Bytes program = read_file("/proc/self/exe");
  program.resize(std::min<std::size_t>(program.size(), 2'048));
  seed("elf", program);
}

/// The headers of a program with an interpreter, for 64 and for 32 bits, and the list of its libraries.
void seed_programs() {
  for (const bool is_wide : {true, false}) {
    const auto word = [&](ByteWriter& out, std::uint32_t value) {
      if (is_wide)
        out.u64(value);
      else
        out.u32(value);
    };
    ByteWriter out;
    for (const int byte : {0x7f, 0x45, 0x4c, 0x46, is_wide ? 2 : 1, 1, 1}) out.u8(static_cast<std::uint8_t>(byte));
    out.bytes(Bytes(17, 0));  // up to the entry point
    for (const std::uint32_t value : {0x1000u, is_wide ? 64u : 52u, 0u}) word(out, value);
    out.u32(0);  // flags
    for (const int value : {is_wide ? 64 : 52, is_wide ? 56 : 32, 1, 0, 0, 0})
      out.u16(static_cast<std::uint16_t>(value));
    out.u32(3);  // PT_INTERP
    if (is_wide) out.u32(4);
    for (const std::uint32_t value : {200u, 0u, 0u, 20u, 20u}) word(out, value);
    seed("elf", out.view());
  }
  seed_text(
      "program",
      "\tlinux-vdso.so.1 (0x1)\n\tlibm.so.6 => /lib/libm.so.6 (0x2)\n\tlibx.so => not found\n\t/lib64/ld.so (0x3)\n");
}

/// Logs that a session writes for `ticktrue trail`: one of ticks alone, one with the list of a tick.
void seed_mark_logs() {
  const replay::TickMarks marks{7, {{"rand", 3, 9}, {"libm.sin", 1, 8}}};
  replay::LoggedList list;
  list.tick = 1;
  list.list = {{"rand", "libm.sin"}, {{0, 1}, {1, 2}, {0, 3}}, false};
  for (const bool has_stacks : {false, true}) {
    if (has_stacks) list.stacks = {{{"/usr/bin/game", 4'096}, {"", 0}}, {{{0, 10}, {1, 20}}, {}}, {0, 1, 1}};
    ByteWriter out;
    replay::encode_logged_tick({0, {}}, out);
    replay::encode_logged_tick({1, marks}, out);
    if (!has_stacks) seed("mark_log", out.view());
    replay::encode_logged_list(list, out);
    seed("mark_log", out.view());
  }
}

void seed_stored() {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / "tests/fuzz/seeds"))
    if (entry.is_regular_file()) seed(entry.path().parent_path().filename().string(), read_file(entry.path()));
}

}  // namespace

int main(int argument_count, char** arguments) {
  fuzz::require(argument_count == 2, "one argument, the folder to write to");
  out_folder = arguments[1];
  fs::remove_all(out_folder);
  fs::create_directories(out_folder);
  seed_traces();
  seed_boxes();
  seed_scenes();
  seed_states();
  seed_sessions();
  seed_verdicts();
  seed_peers();
  seed_own_program();
  seed_programs();
  seed_mark_logs();
  seed_stored();
  for (const char* harness : {"scene", "input_lines", "rube", "box2d3"}) write_texts(harness);
  return 0;
}
