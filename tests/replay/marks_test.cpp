// Marks and notes in a trace: what was written comes back, whatever the chunks, and what does not fit is said to miss.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "base/hash.h"
#include "base/random.h"
#include "replay/format/chunk.h"
#include "replay/format/mark_log.h"
#include "replay/format/mark_tally.h"
#include "tests/replay/third_sessions.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using replay::Feature;
using replay::MarkList;
using replay::MarkTally;
using replay::Note;
using replay::TickMarks;

constexpr std::uint32_t marks_and_notes =
    static_cast<std::uint32_t>(Feature::marks) | static_cast<std::uint32_t>(Feature::notes);

std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  const std::uint64_t x = (hash ^ word) * 0xd6e8feb86659fd93;
  return x ^ x >> 32;
}

/// As the page of the format says, from a list.
TickMarks marks_of(const std::vector<std::pair<std::string, std::uint64_t>>& list) {
  TickMarks marks;
  marks.trail = 0x9e3779b9;
  std::map<std::string, std::uint64_t> hashes;
  for (const auto& [name, value] : list) {
    const std::uint64_t key = hash64({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()});
    marks.trail = mix(mix(marks.trail, key), value);
    auto found = std::find_if(marks.names.begin(), marks.names.end(), [&](const auto& n) { return n.name == name; });
    if (found == marks.names.end()) {
      marks.names.push_back({name, 0, 0});
      found = marks.names.end() - 1;
      hashes[name] = key;
    }
    ++found->count;
    hashes[name] = mix(hashes[name], value);
    found->hash = static_cast<std::uint32_t>(mix(hashes[name], found->count));
  }
  return marks;
}

/// Names in the order of their ids: that of a reader.
void sort_names(TickMarks& marks) {
  std::sort(marks.names.begin(), marks.names.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
}

struct WrittenTick {
  std::optional<TickMarks> marks;
  std::optional<MarkList> list;
  std::vector<Note> notes;
};

WrittenTick random_tick(Random& random, std::size_t name_count, std::size_t mark_count_max) {
  WrittenTick tick;
  std::vector<std::pair<std::string, std::uint64_t>> all;
  for (std::uint64_t i = random.below(mark_count_max + 1); i > 0; --i)
    all.emplace_back("name" + std::to_string(random.below(name_count)), random.bits() >> random.below(64));
  for (std::uint64_t i = random.below(3); i > 0; --i)
    tick.notes.push_back({"topic" + std::to_string(i), std::string(random.below(40), 'n')});
  if (all.empty()) return tick;
  tick.marks = marks_of(all);
  tick.list.emplace();
  for (const auto& [name, value] : all) {
    auto found = std::find(tick.list->names.begin(), tick.list->names.end(), name);
    if (found == tick.list->names.end()) found = tick.list->names.insert(found, name);
    tick.list->marks.push_back({static_cast<std::uint32_t>(found - tick.list->names.begin()), value});
  }
  return tick;
}

Bytes write(const std::vector<WrittenTick>& ticks, std::uint32_t features, std::uint64_t full_first,
            std::uint64_t full_last, const std::vector<Note>& pending = {}) {
  const TemporaryFolder folder;
  SessionPlan plan;
  plan.features = features;
  plan.detail = replay::Detail::full;
  plan.full_first = full_first;
  plan.full_last = full_last;
  plan.checkpoint_interval = 37;
  plan.stage_interval = 5;  // so that both are of version 3
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  auto writer = replay::TraceWriter::create(folder.file("marks.ttr"), setup_of(plan), toy_facts, options);
  REQUIRE(writer);
  RandomTables state(plan.table_count, plan.seed);
  const bool has_marks = features != 0;
  for (const WrittenTick& tick : ticks) {
    if (writer->wants_checkpoint()) REQUIRE(writer->checkpoint(state.view(), root_hash(state.view())));
    REQUIRE(writer->begin_tick({0.015625, Bytes{1}}));
    state.change(1);
    if (has_marks) {
      for (const Note& note : tick.notes) REQUIRE(writer->note(note));
      if (tick.marks) REQUIRE(writer->marks(*tick.marks));
      if (tick.list && writer->wants_full()) REQUIRE(writer->mark_list(*tick.list));
    }
    const std::uint64_t root = root_hash(state.view());
    REQUIRE(writer->end_tick(root, std::vector<std::uint64_t>{root + 1, root}, &state.view()));
  }
  if (!pending.empty()) REQUIRE(writer->begin_tick({0.015625, {}}));
  for (const Note& note : pending) REQUIRE(writer->note(note));
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return read_file(folder.file("marks.ttr"));
}

struct ReadMarks {
  std::vector<WrittenTick> ticks;
  replay::TraceTail tail;
};

ReadMarks read_marks(ByteView bytes) {
  auto reader = replay::TraceReader::open_bytes(bytes, "marks.ttr");
  REQUIRE(reader);
  ReadMarks read;
  for (;;) {
    const auto& item = reader->next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item))
      read.ticks.push_back({tick->marks, tick->mark_list, tick->notes});
    if (std::holds_alternative<std::monostate>(item)) break;
  }
  read.tail = reader->tail();
  return read;
}

std::vector<std::pair<std::string, std::uint64_t>> named(const MarkList& list) {
  std::vector<std::pair<std::string, std::uint64_t>> marks;
  for (const replay::Mark& mark : list.marks) marks.emplace_back(list.names[mark.name], mark.value);
  return marks;
}

void require_same_marks(const ReadMarks& read, const std::vector<WrittenTick>& written, std::uint64_t full_first,
                        std::uint64_t full_last) {
  REQUIRE(read.ticks.size() == written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    CAPTURE(i);
    REQUIRE(read.ticks[i].notes == written[i].notes);
    REQUIRE(read.ticks[i].marks.has_value() == written[i].marks.has_value());
    const bool is_full = full_first <= i && i <= full_last;
    REQUIRE(read.ticks[i].list.has_value() == (is_full && written[i].list.has_value()));
    if (!written[i].marks) continue;
    TickMarks got = *read.ticks[i].marks, expected = *written[i].marks;
    sort_names(got);
    sort_names(expected);
    REQUIRE(got == expected);
    if (!is_full) continue;
    REQUIRE(named(*read.ticks[i].list) == named(*written[i].list));
    REQUIRE_FALSE(read.ticks[i].list->is_cut);
  }
}

}  // namespace

TEST_CASE("a tally is what the format says of the list of its marks", "[replay][marks][equivalence]") {
  const std::uint64_t seed = 20'251'125;
  CAPTURE(seed);
  Random random(seed);
  MarkTally tally([](const char* name) { return std::strlen(name) == 1; });  // "a" alone
  // Literals, and one buffer whose text changes behind the same address.
  const char* const literals[] = {"rand", "sin", "libm.cos", "a"};
  char buffer[16] = {};
  for (int tick = 0; tick < 300; ++tick) {
    std::vector<std::pair<std::string, std::uint64_t>> list;
    for (std::uint64_t i = random.below(30); i > 0; --i) {
      const char* name = literals[random.below(4)];
      if (random.below(3) == 0) {
        std::snprintf(buffer, sizeof buffer, "n%u", static_cast<unsigned>(random.below(200)));
        name = buffer;
      }
      const std::uint64_t value = random.bits();
      list.emplace_back(name, value);
      const std::uint32_t entry = tally.find(name);
      REQUIRE(entry < MarkTally::name_count_max);
      REQUIRE(tally.name(entry) == name);
      tally.add(entry, value);
    }
    const std::optional<TickMarks> marks = tally.take();
    REQUIRE(marks.has_value() == !list.empty());
    if (marks) REQUIRE(*marks == marks_of(list));
  }
  CHECK(tally.find("") == MarkTally::name_count_max);
  CHECK(tally.find(std::string(256, 'n').c_str()) < MarkTally::name_count_max);
  CHECK(tally.find(std::string(257, 'n').c_str()) == MarkTally::name_count_max);
  tally.add(tally.find("rand"), 1);
  tally.leave_out();
  const std::optional<TickMarks> left_out = tally.take();
  REQUIRE(left_out);
  CHECK(left_out->is_left_out());
  CHECK_FALSE(tally.take());
}

TEST_CASE("marks, lists and notes come back, from a copy too, and move no content id", "[replay][marks][equivalence]") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    Random random(seed);
    std::vector<WrittenTick> ticks;
    for (int i = 0; i < 120; ++i) ticks.push_back(random_tick(random, 12, seed == 3 ? 400 : 9));
    const Bytes trace = write(ticks, marks_and_notes, 40, 60);
    require_same_marks(read_marks(trace), ticks, 40, 60);
    require_same_marks(read_marks(recovered(trace)), ticks, 40, 60);
    CHECK(recovered(trace) == trace);
    std::vector<WrittenTick> others;
    for (int i = 0; i < 120; ++i) others.push_back(random_tick(random, 300, 40));
    CHECK(content_id(write(others, marks_and_notes, 40, 60)) == content_id(trace));
  }
}

TEST_CASE("marks that pass a limit are left out, and that is said", "[replay][marks][limits]") {
  std::vector<WrittenTick> ticks(8);
  std::vector<std::pair<std::string, std::uint64_t>> few{{"rand", 1}}, many;
  for (int i = 0; i < 1'100; ++i) many.emplace_back("n" + std::to_string(i), 1);
  ticks[2].marks = marks_of(few);
  ticks[3].marks = marks_of(many);  // more names than a chunk has
  ticks[4].marks = marks_of(few);
  const ReadMarks read = read_marks(write(ticks, marks_and_notes, 1'000, 1'000));
  CHECK(read.tail.message.empty());
  CHECK(read.ticks[2].marks == ticks[2].marks);
  REQUIRE(read.ticks[3].marks);
  CHECK(read.ticks[3].marks->is_left_out());
  REQUIRE(read.ticks[3].notes.size() == 1);
  CHECK(read.ticks[3].notes[0] == Note{"ticktrue.left_out", "marks of this tick, of 1100 names"});
  CHECK(read.ticks[4].marks == ticks[4].marks);

  // 4 MiB of notes in one chunk: later notes are left out, and the ticks are whole.
  std::vector<WrittenTick> noted(30);
  for (WrittenTick& tick : noted) {
    for (int i = 0; i < 64; ++i) tick.notes.push_back({"log", std::string(4'096, 'x')});
    tick.marks = marks_of(few);
  }
  const ReadMarks full = read_marks(write(noted, marks_and_notes, 1'000, 1'000));
  CHECK(full.tail.message.empty());
  REQUIRE(full.ticks.size() == 30);
  CHECK(full.ticks[14].notes == noted[14].notes);
  std::size_t told = 0;
  for (const WrittenTick& tick : full.ticks)
    for (const Note& note : tick.notes) told += note.topic == "ticktrue.left_out" && note.text == "notes from here on";
  CHECK(told == 1);
  REQUIRE(full.ticks[29].marks);
  CHECK(full.ticks[29].marks->is_left_out());
  CHECK(full.ticks[29].notes == std::vector<Note>{{"ticktrue.left_out", "marks of this tick, of 1 name"}});

  // A list of more than 1 MiB is cut.
  std::vector<WrittenTick> listed(3);
  listed[1].list.emplace();
  listed[1].list->names = {"unused", "rand"};
  listed[1].list->marks.assign(200'000, {1, 7});
  listed[1].marks = marks_of(few);
  const ReadMarks cut = read_marks(write(listed, marks_and_notes, 0, 2));
  CHECK(cut.tail.message.empty());
  REQUIRE(cut.ticks[1].list);
  CHECK(cut.ticks[1].list->is_cut);
  CHECK(cut.ticks[1].list->marks.size() == (replay::mark_list_size_max - 1) / 9);
}

TEST_CASE("notes of a tick that did not end are read, and a copy has them", "[replay][marks][recovery]") {
  Random random(7);
  std::vector<WrittenTick> ticks;
  for (int i = 0; i < 20; ++i) ticks.push_back(random_tick(random, 3, 3));
  const std::vector<Note> pending{{"game", "about to divide by the count of units"}, {"game", ""}};
  const Bytes trace = write(ticks, marks_and_notes, 1'000, 1'000, pending);
  CHECK(read_marks(trace).tail.pending_notes == pending);
  CHECK(read_marks(recovered(trace)).tail.pending_notes == pending);
  CHECK(recovered(trace) == trace);
  // The file of a program that died in that tick.
  std::size_t end = 0;
  for (const ChunkPlace& place : chunk_places(trace))
    if (place.kind == static_cast<std::uint8_t>(replay::ChunkKind::ticks)) end = place.offset + place.size;
  const ByteView cut = ByteView(trace).first(end - 1);
  const ReadMarks read = read_marks(cut);
  CHECK(read.tail.condition == replay::TraceCondition::truncated);
  CHECK(read.tail.pending_notes == pending);
  require_same_marks(read, ticks, 1'000, 1'000);
  CHECK(read_marks(recovered(cut)).tail.pending_notes == pending);
}

TEST_CASE("of a log of marks, what is whole at its start is read, and no bytes do harm",
          "[replay][marks][corruption]") {
  ByteWriter out;
  Random random(13);
  std::vector<WrittenTick> ticks;
  for (std::uint64_t t = 0; t < 20; ++t) {
    ticks.push_back(random_tick(random, 5, 9));
    replay::encode_logged_tick({t, ticks.back().marks}, out);
  }
  replay::LoggedList list;
  list.tick = 7;
  list.list = {{"rand", "sin"}, {{0, 1}, {1, 2}, {0, 3}}, false};
  list.stacks = {{{"/usr/bin/game", 4'096}, {"", 0}}, {{{0, 10}, {1, 20}}, {{0, 30}}}, {0, 1, 1}};
  replay::encode_logged_list(list, out);
  const Bytes bytes = out.take();
  const replay::MarkLog whole = replay::decode_mark_log(bytes);
  REQUIRE(whole.ticks.size() == 20);
  for (std::size_t t = 0; t < 20; ++t) CHECK(whole.ticks[t].marks == ticks[t].marks);
  REQUIRE(whole.list);
  CHECK(whole.list->tick == 7);
  CHECK(whole.list->list == list.list);
  CHECK(whole.list->stacks == list.stacks);
  std::size_t before = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const replay::MarkLog part = replay::decode_mark_log(ByteView(bytes).first(size));
    REQUIRE_FALSE(part.list);
    REQUIRE(part.ticks.size() >= before);
    before = part.ticks.size();
  }
  CHECK(before == 20);
  for (int i = 0; i < 20'000; ++i) {
    Bytes changed = bytes;
    for (std::uint64_t k = 1 + random.below(4); k > 0; --k)
      changed[random.below(changed.size())] = static_cast<std::uint8_t>(random.bits());
    const replay::MarkLog log = replay::decode_mark_log(changed);
    if (!log.list) continue;
    for (const replay::Mark& mark : log.list->list.marks) REQUIRE(mark.name < log.list->list.names.size());
    for (const std::uint32_t stack : log.list->stacks.of_marks) REQUIRE(stack < log.list->stacks.stacks.size());
  }
}

TEST_CASE("of a chunk whose marks are damaged, ticks come without marks and say so", "[replay][marks][corruption]") {
  Random random(11);
  std::vector<WrittenTick> ticks;
  for (int i = 0; i < 10; ++i) ticks.push_back(random_tick(random, 3, 3));
  ticks[4].notes = {{"find", "me"}};
  Bytes trace = write(ticks, marks_and_notes, 1'000, 1'000);
  const std::string text = "findme";
  const auto at = std::search(trace.begin(), trace.end(), text.begin(), text.end());
  REQUIRE(at != trace.end());
  *at ^= 1;
  auto reader = replay::TraceReader::open_bytes(trace, "marks.ttr");
  REQUIRE(reader);
  std::size_t count = 0;
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* tick = std::get_if<replay::TickRecord>(&item);
    if (tick == nullptr) continue;
    ++count;
    CHECK_FALSE(tick->has_bound);
    CHECK_FALSE(tick->marks);
    CHECK(tick->notes.empty());
  }
  CHECK(count == 10);
  CHECK(reader->tail().condition == replay::TraceCondition::damaged);
}

}  // namespace ticktrue::test
