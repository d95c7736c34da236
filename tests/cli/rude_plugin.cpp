// A plug-in that misbehaves in its process. RUDE_PLUGIN=PLACE:ACT selects where and how.
// SPDX-License-Identifier: MIT
//
// Places: load, create, step (of the third tick), destroy, unload. Acts: see `acts`.
#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "include/ticktrue.h"

namespace {

double values[4];
int step_count = 0;

void print_line() {
  std::printf("{\"not\": \"ours\"}\n");
}

void print_flood() {
  static char block[1 << 20];
  std::memset(block, 'x', sizeof block);
  for (int i = 0; i < 1024; ++i) std::fwrite(block, 1, sizeof block, stdout);
}

/// Starts a child that would run for a minute. The child writes its id to the file that RUDE_PLUGIN_CHILD names.
void leave_child(bool in_own_session) {
  const pid_t child = ::fork();
  if (child != 0) return;
  if (in_own_session) ::setsid();
  if (const char* path = std::getenv("RUDE_PLUGIN_CHILD")) {
    std::FILE* file = std::fopen(path, "w");
    std::fprintf(file, "%ld\n", static_cast<long>(::getpid()));
    std::fclose(file);
  }
  ::sleep(60);
  ::_exit(0);
}

/// Waits for the file of leave_child. Otherwise the child could be ended before it leaves the group.
void wait_for_child() {
  const char* path = std::getenv("RUDE_PLUGIN_CHILD");
  for (int i = 0; i < 5'000; ++i) {
    std::FILE* file = path == nullptr ? nullptr : std::fopen(path, "r");
    long id = 0;
    const bool is_there = file != nullptr && std::fscanf(file, "%ld", &id) == 1;
    if (file != nullptr) std::fclose(file);
    if (is_there) return;
    ::usleep(1'000);
  }
}

void* pause_thread(void*) {
  ::sleep(60);
  return nullptr;
}

struct Act {
  const char* name;
  void (*run)();
};
const Act acts[] = {
    {"exit", [] { std::exit(0); }},
    {"exit3", [] { std::exit(3); }},
    {"_exit", [] { ::_exit(0); }},
    {"quick_exit", [] { std::quick_exit(0); }},
    {"abort", [] { std::abort(); }},
    {"signal", [] { ::raise(SIGUSR1); }},
    {"crash", [] { ::raise(SIGSEGV); }},
    {"thread_exit", [] { ::pthread_exit(nullptr); }},
    {"thread_stays",
     [] {
       pthread_t thread{};
       ::pthread_create(&thread, nullptr, pause_thread, nullptr);
       ::pthread_exit(nullptr);
     }},
    {"print", print_line},
    {"flood", print_flood},
    {"hang",
     [] {
       for (;;) ::pause();
     }},
    {"fork",
     [] {
       leave_child(false);
       wait_for_child();
     }},
    {"setsid",
     [] {
       leave_child(true);
       wait_for_child();
     }},
};

void act(const char* place) {
  const char* requested = std::getenv("RUDE_PLUGIN");
  if (requested == nullptr) return;
  for (const Act& each : acts)
    if (std::string(place) + ":" + each.name == requested) each.run();
}

int create(const ticktrue_host*, const void*, std::size_t, void** simulation, char*, std::size_t) {
  act("create");
  *simulation = values;
  return 0;
}

void destroy(void*) {
  act("destroy");
}

int columns(void*, const ticktrue_host* host, ticktrue_columns* out) {
  return host->column(out, "rows", "x", values, TICKTRUE_F64, 1, 4, 0);
}

int step(void*, double dt, const void*, std::size_t, const ticktrue_host*, ticktrue_stages*, char*, std::size_t) {
  values[0] += dt;
  if (++step_count == 3) act("step");
  return 0;
}

}  // namespace

extern "C" TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(std::uint32_t) {
  static ticktrue_plugin plugin;
  plugin.struct_size = sizeof plugin;
  plugin.api_version = TICKTRUE_API_VERSION;
  plugin.name = "rude-plugin";
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = step;
  act("load");
  std::atexit([] { act("unload"); });
  return &plugin;
}
