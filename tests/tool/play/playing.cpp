// Scripted sessions and traces that diverge.
// SPDX-License-Identifier: MIT
#include "tests/tool/play/playing.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/state/stage_hashes.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tool/play/script.h"

namespace ticktrue::test {

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "ticktrue_play_XXXXXX").string();
  REQUIRE(mkdtemp(name.data()) != nullptr);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

engine::Scene builtin_scene(const char* text) {
  auto scene = engine::make_builtin_scene(text);
  REQUIRE(scene);
  return std::move(*scene);
}

std::string file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

PlayedSession play_script(const engine::Scene& scene, const std::string& script, double hz, const std::string& path,
                          const std::function<void(const engine::Engine&, const play::Session&)>& look) {
  Result<play::PlayScene> playable = play::make_playable(scene);
  REQUIRE(playable);
  const auto events = play::parse_script(script, "script");
  if (!events) FAIL(events.error().message);
  PlayedSession played;
  played.playable = std::make_unique<play::PlayScene>(std::move(*playable));
  played.engine = make_engine_or_fail(played.playable->scene);
  engine::Engine& engine = *played.engine;
  const auto host = play::no_display(hz);
  play::ScriptedHost scripted(*host, *events, 0);
  const play::Canvas picture(1, 1);
  play::Session session(engine, *played.playable, play::first_view(engine, 800, 600), {},
                        [&](const play::Session& now) {
                          if (look) look(engine, now);
                          return scripted.next(picture);
                        });
  tool::TraceChoices choices;
  choices.detail = replay::Detail::cells;
  replay::RecordOptions options;
  options.writer.sync = false;
  options.tick_count = 10'000;  // limit for a script that never quits
  const auto result =
      replay::record(engine, session, path, tool::make_trace_setup(engine, choices), tool::make_build_facts(), options);
  if (!result) FAIL(result.error().message);
  played.trace = file_bytes(path);
  played.tick_count = result->tick_count;
  played.view = session.view();
  return played;
}

void record_flipped(const engine::Scene& scene, std::uint64_t tick_count, std::uint64_t flip_tick, std::uint32_t body,
                    const tool::TraceChoices& choices, const std::string& path) {
  const auto made = make_engine_or_fail(scene);
  engine::Engine& engine = *made;
  replay::WriterOptions options;
  options.sync = false;
  auto writer =
      replay::TraceWriter::create(path, tool::make_trace_setup(engine, choices), tool::make_build_facts(), options);
  REQUIRE(writer);
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    if (writer->wants_checkpoint()) REQUIRE(writer->checkpoint(engine.state(), root_hash(engine.state())));
    const TickInput input{scene.settings.dt, {}};
    REQUIRE(writer->begin_tick(input));
    StageHashes stages;
    REQUIRE(engine.step(input, writer->wants_full() ? &stages : nullptr));
    if (tick == flip_tick) {
      const StateView& state = engine.state();
      const std::size_t table = *state.schema->find_table("bodies");
      const auto& columns = state.schema->tables[table].columns;
      std::size_t column = 0;
      while (columns[column].name != "velocity") ++column;
      std::size_t offset = columns[column].offset + body * state.schema->tables[table].row_size;
      for (std::size_t t = 0; t < table; ++t)
        offset += 4 + state.tables[t].row_count * state.schema->tables[t].row_size;
      Bytes image;
      encode_image(state, image);
      image[offset + 4] ^= 1;  // after the table's row count
      REQUIRE(engine.load(image));
    }
    REQUIRE(writer->end_tick(root_hash(engine.state()), stages.hashes(),
                             writer->wants_state() ? &engine.state() : nullptr));
  }
  if (writer->wants_checkpoint()) REQUIRE(writer->checkpoint(engine.state(), root_hash(engine.state())));
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
}

}  // namespace ticktrue::test
