// Sync test and restore on programs with one variable that their save forgets, and on the same programs without fault.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "include/ticktrue.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

constexpr std::uint64_t unsaved_tick_count = 120;

/// The values that every program registers and saves, and the others, which belong to one mechanism of the table each.
struct Arena {
  std::uint32_t tick = 0;
  double heat = 0;
  std::vector<std::int32_t> x{10, 20, 30, 40};

  // Of one mechanism each.
  std::mt19937 twister{7};
  bool has_spare = false;
  std::int32_t spare = 0;
  std::int32_t cached_sum = 0;
  bool is_cached = false;
  std::unique_ptr<std::int32_t> cooldown = std::make_unique<std::int32_t>(0);
  std::int32_t next_id = 100;
  std::vector<std::size_t> order{0, 1, 2, 3};
  double time_left = 0;
  std::uint8_t last_button = 0;
  std::uint32_t deadline = 5;
  std::size_t target = 0;
  std::vector<std::size_t> free_slots{3, 1, 2};
  std::deque<std::pair<std::uint32_t, std::int32_t>> events;
  bool is_paused = false;
  std::int32_t direction = 1;
  std::int32_t buffers[2] = {0, 0};
  std::size_t front = 0;
  std::map<std::int32_t, std::int32_t> visits;
  std::int32_t streak = 0;
  std::int32_t path[3] = {0, 0, 0};
  std::string log;
};

// Variables outside of any object.
std::uint32_t global_generator = 1;
std::int32_t calls_of_spawn = 0;
std::int32_t level_of_module = 0;

struct Packer {
  Bytes out;
  template <typename T>
  void operator()(T& value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof value);
  }
  template <typename T>
  void list(std::vector<T>& values) {
    auto size = static_cast<std::uint32_t>(values.size());
    (*this)(size);
    for (T& value : values) (*this)(value);
  }
};
struct Unpacker {
  ByteView in;
  template <typename T>
  void operator()(T& value) {
    REQUIRE(in.size() >= sizeof value);
    std::memcpy(&value, in.data(), sizeof value);
    in = in.subspan(sizeof value);
  }
  template <typename T>
  void list(std::vector<T>& values) {
    std::uint32_t size = 0;
    (*this)(size);
    values.resize(size);
    for (T& value : values) (*this)(value);
  }
};

using Step = void (*)(Arena&, std::uint8_t button);

/// A mechanism that keeps a value between ticks. `pack` and `unpack` belong into save and load.
struct Mechanism {
  const char* name;
  Step step;
  void (*pack)(Arena&, Packer&);
  void (*unpack)(Arena&, Unpacker&);
};

#define ON_BOTH(body) [](Arena& a, Packer& pass) { (void)a, body; }, [](Arena& a, Unpacker& pass) { (void)a, body; }

const Mechanism mechanisms[] = {
    {"a global generator",
     [](Arena& a, std::uint8_t) {
       a.x[0] += static_cast<int>((global_generator = global_generator * 1664525u + 1013904223u) >> 28);
     },
     ON_BOTH(pass(global_generator))},
    {"a generator of the standard library", [](Arena& a, std::uint8_t) { a.x[1] += static_cast<int>(a.twister() % 9); },
     ON_BOTH(pass(a.twister))},
    {"the second value of a pair of random numbers",
     [](Arena& a, std::uint8_t) {
       if (!a.has_spare)
         a.spare = static_cast<int>(a.tick * 77 % 13), a.x[0] += 3;
       else
         a.x[0] += a.spare;
       a.has_spare = !a.has_spare;
     },
     ON_BOTH((pass(a.has_spare), pass(a.spare)))},
    {"a static counter of calls", [](Arena& a, std::uint8_t) { a.x[2] += ++calls_of_spawn % 7 == 0 ? 5 : 1; },
     ON_BOTH(pass(calls_of_spawn))},
    {"a cache that nobody empties",
     [](Arena& a, std::uint8_t button) {
       if (!a.is_cached) a.cached_sum = a.x[0] + a.x[1];
       a.is_cached = button != 0;
       a.x[3] += a.cached_sum % 5;
       ++a.x[0];
     },
     ON_BOTH((pass(a.is_cached), pass(a.cached_sum)))},
    {"a member on the heap, of which the pointer is saved",
     [](Arena& a, std::uint8_t button) {
       if (*a.cooldown > 0)
         --*a.cooldown;
       else if (button != 0)
         *a.cooldown = 4, ++a.x[1];
     },
     ON_BOTH(pass(*a.cooldown))},
    {"the next id",
     [](Arena& a, std::uint8_t button) {
       if (button != 0) a.x[3] = a.next_id++;
     },
     ON_BOTH(pass(a.next_id))},
    {"the order of a list",
     [](Arena& a, std::uint8_t) {
       for (const std::size_t i : a.order) a.x[i] = (a.x[i] + a.x[(i + 1) % 4]) % 1'000;
       std::rotate(a.order.begin(), a.order.begin() + 1, a.order.end());
     },
     ON_BOTH(pass.list(a.order))},
    {"time that is left over",
     [](Arena& a, std::uint8_t) {
       for (a.time_left += 0.75; a.time_left >= 1; a.time_left -= 1) ++a.x[0];
     },
     ON_BOTH(pass(a.time_left))},
    {"the button of the tick before",
     [](Arena& a, std::uint8_t button) {
       if (button != 0 && a.last_button == 0) a.x[1] += 9;
       a.last_button = button;
     },
     ON_BOTH(pass(a.last_button))},
    {"a deadline",
     [](Arena& a, std::uint8_t) {
       if (a.tick >= a.deadline) a.deadline += 11, a.x[2] += 8;
     },
     ON_BOTH(pass(a.deadline))},
    {"who is aimed at",
     [](Arena& a, std::uint8_t button) {
       a.x[a.target] -= 2;
       if (button != 0) a.target = (a.target + 1) % 4;
     },
     ON_BOTH(pass(a.target))},
    {"a list of free places",
     [](Arena& a, std::uint8_t) {
       const std::size_t slot = a.free_slots.back();
       a.x[slot] += 6;
       a.free_slots.pop_back();
       a.free_slots.insert(a.free_slots.begin(), slot);
     },
     ON_BOTH(pass.list(a.free_slots))},
    {"events that come later",
     [](Arena& a, std::uint8_t button) {
       if (button != 0) a.events.emplace_back(a.tick + 1, 4);
       while (!a.events.empty() && a.events.front().first <= a.tick)
         a.x[0] += a.events.front().second, a.events.pop_front();
     },
     [](Arena& a, Packer& pass) {
       auto size = static_cast<std::uint32_t>(a.events.size());
       pass(size);
       for (auto& event : a.events) pass(event.first), pass(event.second);
     },
     [](Arena& a, Unpacker& pass) {
       std::uint32_t size = 0;
       pass(size);
       a.events.assign(size, {});
       for (auto& event : a.events) pass(event.first), pass(event.second);
     }},
    {"whether it is paused",
     [](Arena& a, std::uint8_t button) {
       if (button != 0) a.is_paused = !a.is_paused;
       if (!a.is_paused) ++a.x[3];
     },
     ON_BOTH(pass(a.is_paused))},
    {"a direction that turns around",
     [](Arena& a, std::uint8_t) {
       a.x[1] += a.direction;
       if (a.tick % 6 == 0) a.direction = -a.direction;
     },
     ON_BOTH(pass(a.direction))},
    {"which of two buffers is in front",
     [](Arena& a, std::uint8_t) {
       a.buffers[a.front] += a.x[0]++;
       a.front = 1 - a.front;
       a.x[2] += a.buffers[a.front] % 7;
     },
     ON_BOTH((pass(a.buffers), pass(a.front)))},
    {"a map of visits",
     [](Arena& a, std::uint8_t) {
       a.x[0] += ++a.visits[a.x[1] % 3] % 4;
       ++a.x[1];
     },
     [](Arena& a, Packer& pass) {
       auto size = static_cast<std::uint32_t>(a.visits.size());
       pass(size);
       for (auto& [key, count] : a.visits) {
         std::int32_t copy = key;
         pass(copy), pass(count);
       }
     },
     [](Arena& a, Unpacker& pass) {
       std::uint32_t size = 0;
       pass(size);
       a.visits.clear();
       for (; size > 0; --size) {
         std::int32_t key = 0, count = 0;
         pass(key), pass(count);
         a.visits[key] = count;
       }
     }},
    {"a streak",
     [](Arena& a, std::uint8_t button) {
       a.streak = button != 0 ? a.streak + 1 : 0;
       a.x[2] += a.streak;
     },
     ON_BOTH(pass(a.streak))},
    {"the last places on a path",
     [](Arena& a, std::uint8_t) {
       a.x[0] += a.path[2] % 3 + 1;
       a.path[2] = a.path[1], a.path[1] = a.path[0], a.path[0] = a.x[0];
     },
     ON_BOTH(pass(a.path))},
    {"a static of another module",
     [](Arena& a, std::uint8_t button) {
       level_of_module += button;
       a.heat += 0.5 * level_of_module;
     },
     ON_BOTH(pass(level_of_module))},
    {"the length of a text",
     [](Arena& a, std::uint8_t) {
       a.log += '.';
       if (a.log.size() > 9) a.log.clear(), a.x[3] += 2;
     },
     [](Arena& a, Packer& pass) {
       auto size = static_cast<std::uint32_t>(a.log.size());
       pass(size);
     },
     [](Arena& a, Unpacker& pass) {
       std::uint32_t size = 0;
       pass(size);
       a.log.assign(size, '.');
     }},
};
#undef ON_BOTH

/// Mistakes in save and load of registered values.
enum class SaveMistake { none, forgets_a_value, forgets_new_rows, rounds };

struct Program {
  Arena arena;
  const Mechanism* mechanism = nullptr;
  bool saves_it = true;
  SaveMistake mistake = SaveMistake::none;
  ticktrue_session* session = nullptr;

  void show() {
    ticktrue_column(session, "world", "tick", &arena.tick, TICKTRUE_U32, 1, 1, 0);
    ticktrue_column(session, "world", "heat", &arena.heat, TICKTRUE_F64, 1, 1, 0);
    ticktrue_column(session, "units", "x", arena.x.data(), TICKTRUE_I32, 1, static_cast<std::uint32_t>(arena.x.size()),
                    0);
  }
  void step(std::uint8_t button) {
    mechanism->step(arena, button);
    arena.heat += 1.0 / 3;
    if (arena.tick % 40 == 20) arena.x.push_back(static_cast<int>(arena.tick));
    ++arena.tick;
  }
  Bytes pack() {
    Packer pass;
    pass(arena.tick);
    float rounded = static_cast<float>(arena.heat);
    if (mistake == SaveMistake::rounds)
      pass(rounded);
    else if (mistake != SaveMistake::forgets_a_value)
      pass(arena.heat);
    std::vector<std::int32_t> x = arena.x;
    if (mistake == SaveMistake::forgets_new_rows) x.resize(4);
    pass.list(x);
    if (saves_it) mechanism->pack(arena, pass);
    return std::move(pass.out);
  }
  void unpack(ByteView bytes) {
    Unpacker pass{bytes};
    pass(arena.tick);
    float rounded = 0;
    if (mistake == SaveMistake::rounds)
      pass(rounded), arena.heat = static_cast<double>(rounded);
    else if (mistake != SaveMistake::forgets_a_value)
      pass(arena.heat);
    std::vector<std::int32_t> x;  // other memory: load says where the rows are now
    pass.list(x);
    arena.x = std::move(x);
    if (saves_it) mechanism->unpack(arena, pass);
    CHECK(pass.in.empty());
    show();
  }
};

std::size_t save_program(void* user, void* buffer, std::size_t size) {
  const Bytes bytes = static_cast<Program*>(user)->pack();
  if (bytes.size() <= size) std::memcpy(buffer, bytes.data(), bytes.size());
  return bytes.size();
}
int load_program(void* user, const void* bytes, std::size_t size) {
  static_cast<Program*>(user)->unpack({static_cast<const std::uint8_t*>(bytes), size});
  return 0;
}

struct Ran {
  int exit_code = 0;
  std::string report;
};

Ran run_program(Program& program, int mode, const std::string& path, std::uint32_t sync_test, std::uint32_t flags = 0) {
  global_generator = 1;
  calls_of_spawn = level_of_module = 0;
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = path.c_str();
  options.name = "unsaved";
  options.detail = TICKTRUE_DETAIL_CELLS;
  options.checkpoint_interval = 16;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC | TICKTRUE_OVERWRITE | flags;
  options.save = save_program;
  options.load = load_program;
  options.user = &program;
  options.sync_test = sync_test;
  program.session = ticktrue_open(&options);
  program.show();
  while (program.arena.tick < unsaved_tick_count) {
    std::uint8_t button = program.arena.tick / 3 % 2;
    ticktrue_input(program.session, &button, 1);
    if (ticktrue_begin_tick(program.session, nullptr) != TICKTRUE_OK) break;
    program.step(button);
    program.show();
    if (ticktrue_end_tick(program.session) != TICKTRUE_OK) break;
  }
  Ran ran;
  ran.exit_code = ticktrue_finish(program.session);
  ran.report = std::string(ticktrue_report(program.session)) + ticktrue_message(program.session);
  ticktrue_close(program.session);
  return ran;
}

TEST_CASE("a variable that save forgets is found by the sync test, and by restore", "[capi][saves][injection]") {
  const TracePath path;
  REQUIRE(std::size(mechanisms) >= 20);
  for (const Mechanism& mechanism : mechanisms) {
    CAPTURE(mechanism.name);
    Program recorded;
    recorded.mechanism = &mechanism;
    recorded.saves_it = false;
    REQUIRE(run_program(recorded, TICKTRUE_RECORD, path("plain.ttr"), 0).exit_code == 0);
    for (const std::uint32_t length : {1u, 5u}) {
      Program program;
      program.mechanism = &mechanism;
      program.saves_it = false;
      const Ran ran = run_program(program, TICKTRUE_RECORD, path("sync.ttr"), length);
      CAPTURE(length, ran.report);
      CHECK(ran.exit_code == 1);
      CHECK(contains(ran.report, "state_incomplete  "));
      CHECK(contains(ran.report, "ended in two states"));
      CHECK((contains(ran.report, "units.x") || contains(ran.report, "world.heat")));
      CHECK(contains(ran.report, "value   expected "));
    }
    Program program;
    program.mechanism = &mechanism;
    program.saves_it = false;
    const Ran ran = run_program(program, TICKTRUE_VERIFY, path("plain.ttr"), 0, TICKTRUE_RESTORE);
    CAPTURE(ran.report);
    CHECK(ran.exit_code == 1);
    CHECK(contains(ran.report, "state_incomplete  "));
  }
}

TEST_CASE("a program that saves all raises no alarm", "[capi][saves][equivalence]") {
  const TracePath path;
  for (const Mechanism& mechanism : mechanisms) {
    CAPTURE(mechanism.name);
    const auto run = [&](int mode, const char* file, std::uint32_t sync_test, std::uint32_t flags) {
      Program program;
      program.mechanism = &mechanism;
      const Ran ran = run_program(program, mode, path(file), sync_test, flags);
      CAPTURE(ran.report);
      CHECK(ran.exit_code == 0);
      CHECK(contains(ran.report, std::to_string(unsaved_tick_count)));
      if (sync_test > 0 || flags != 0) CHECK(contains(ran.report, "120 ticks ran twice with the same state"));
      CHECK_FALSE(contains(ran.report, "warning"));
    };
    run(TICKTRUE_RECORD, "plain.ttr", 0, 0);
    for (const std::uint32_t length : {1u, 5u}) {
      run(TICKTRUE_RECORD, "sync.ttr", length, 0);
      run(TICKTRUE_VERIFY, "sync.ttr", length, 0);
    }
    run(TICKTRUE_VERIFY, "sync.ttr", 0, TICKTRUE_RESTORE);
    run(TICKTRUE_VERIFY, "plain.ttr", 0, TICKTRUE_RESTORE);
    CHECK(path.bytes("plain.ttr") == path.bytes("sync.ttr"));
  }
}

TEST_CASE("a registered value that save or load forgets is named behind load", "[capi][saves][injection]") {
  const TracePath path;
  const struct {
    SaveMistake mistake;
    const char* column;
  } cases[] = {{SaveMistake::forgets_a_value, "world.heat"},
               {SaveMistake::forgets_new_rows, "units.x"},
               {SaveMistake::rounds, "world.heat"}};
  for (const auto& one : cases) {
    for (const int mode : {TICKTRUE_RECORD, TICKTRUE_VERIFY}) {
      Program clean;
      clean.mechanism = &mechanisms[0];
      REQUIRE(run_program(clean, TICKTRUE_RECORD, path("clean.ttr"), 0).exit_code == 0);
      Program program;
      program.mechanism = &mechanisms[0];
      program.mistake = one.mistake;
      const Ran ran = run_program(program, mode, path(mode == TICKTRUE_RECORD ? "x.ttr" : "clean.ttr"), 3);
      CAPTURE(one.column, mode, ran.report);
      CHECK(ran.exit_code == 1);
      CHECK(contains(ran.report, "stage   load "));
      CHECK(contains(ran.report, "the load callback does not bring back the state at tick"));
      CHECK(contains(ran.report, one.column));
    }
  }
}

}  // namespace
}  // namespace ticktrue::test
