// The C interface of ticktrue: records and verifies any simulation, in a loop of its own or as a plug-in of the tool.
// SPDX-License-Identifier: MIT
//
// docs/any_simulation.md leads from nothing to a red and a green run. C99 and C++. What holds:
// - Binary interface: functions and constants keep their meaning; structs begin with struct_size and only grow at the
//   end, so a program built against an older header runs with a newer library.
// - No exception leaves the library, and no wrong call crashes it: a call that fails says so, every later one too, and
//   ticktrue_close tells what it was. A null session means "off": every call does nothing and succeeds.
// - Threads: a session belongs to one thread at a time; different sessions, also of different threads, share nothing.
// - Text is UTF-8. Pointers handed out stay valid until the next call with that session.
#pragma once

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#if defined(TICKTRUE_BUILD)
#define TICKTRUE_API __declspec(dllexport)
#else
#define TICKTRUE_API
#endif
#define TICKTRUE_PLUGIN_API __declspec(dllexport)
#else
#define TICKTRUE_API __attribute__((visibility("default")))
#define TICKTRUE_PLUGIN_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. It rises when something is added; what was there stays. */
#define TICKTRUE_API_VERSION 1u

/* What calls return. */
enum {
  TICKTRUE_OK = 0,       /* go on */
  TICKTRUE_END = 1,      /* verify: every recorded tick was run; leave the loop */
  TICKTRUE_DIVERGED = 2, /* verify: this tick is not as recorded; record: a value is not finite; leave the loop */
  TICKTRUE_FAILED = 3    /* a wrong call, or the system refused; ticktrue_message says what */
};

/* Types of values. Signed 8 and 16 bit values are registered as U8 and U16: their bits are compared. */
enum {
  TICKTRUE_U8 = 1,
  TICKTRUE_U16 = 2,
  TICKTRUE_U32 = 3,
  TICKTRUE_U64 = 4,
  TICKTRUE_I32 = 5,
  TICKTRUE_I64 = 6,
  TICKTRUE_F32 = 7,
  TICKTRUE_F64 = 8
};

/* ---- sessions: a program that owns its loop ---------------------------------------------------------------------- */

typedef struct ticktrue_session ticktrue_session;

enum { TICKTRUE_RECORD = 1, TICKTRUE_VERIFY = 2 };

/* How much is stored of each tick. */
enum {
  TICKTRUE_DETAIL_DEFAULT = 0, /* what `ticktrue record` takes */
  TICKTRUE_DETAIL_ROOT = 1,    /* a hash: names the tick */
  TICKTRUE_DETAIL_CELLS = 2,   /* hashes that name columns and rows, too */
  TICKTRUE_DETAIL_FULL = 3     /* the whole state: names values; of the ticks full_first..full_last */
};

enum {
  TICKTRUE_OVERWRITE = 1, /* record: replace an existing file */
  TICKTRUE_QUIET = 2,     /* ticktrue_close prints nothing */
  TICKTRUE_JSON = 4,      /* ticktrue_close prints the report as JSON */
  TICKTRUE_NO_SYNC = 8    /* record: leave it to the system when the file reaches the disk */
};

/* All zero but struct_size is a good start. */
typedef struct ticktrue_options {
  size_t struct_size; /* sizeof(ticktrue_options) */
  int32_t mode;       /* TICKTRUE_RECORD or TICKTRUE_VERIFY */
  int32_t detail;     /* record */
  const char* path;   /* of the trace */
  const char* name;   /* of the simulation, as in "mygame" */
  uint32_t version;   /* raise it when results change on purpose: older traces are then "not comparable" */
  uint32_t flags;
  const void* setup; /* record: what the program needs to begin again: level, seed, players */
  size_t setup_size;
  const char* title;            /* record: for people; null: the name */
  const char* build;            /* facts about the program's build, as in "r345 gcc 12 -O2"; may be null */
  double dt;                    /* s, of a tick; 0: 1/60 */
  uint64_t full_first;          /* record, detail full: the ticks stored in full; */
  uint64_t full_last;           /* 0: all from full_first on */
  uint32_t checkpoint_interval; /* record: ticks between full states; 0: 600 */
  uint32_t rollback_max;        /* ticks that may wait for ticktrue_confirm; 0: the program never rolls back */
} ticktrue_options;

/* Opens a session. Never null: what went wrong, the next call and ticktrue_close tell. Everything is copied. */
TICKTRUE_API ticktrue_session* ticktrue_open(const ticktrue_options* options);

/* The same, with mode, path and overwriting from the program's words --record FILE, --verify FILE and --force; null if
   neither of the first two is there. */
TICKTRUE_API ticktrue_session* ticktrue_open_arguments(const ticktrue_options* options, int argc, char* const* argv);

/* The setup: verify gives the recorded one, record and a null session give `setup` of the options (null: nothing). */
TICKTRUE_API const void* ticktrue_setup(ticktrue_session* session, size_t* size);

/* Registers a column of a table: the values of row r begin at `data` + r * `stride` bytes; `lanes` of them lie side by
   side (2 for x and y). Stride 0: packed. Register all before the first tick, and again whenever data, rows or stride
   have changed. The memory is read in begin_tick (the first) and end_tick. */
TICKTRUE_API int ticktrue_column(ticktrue_session* session, const char* table, const char* name, const void* data,
                                 int type, uint32_t lanes, uint32_t rows, size_t stride);

/* The first `columns` columns of the table are its key (unsigned integers; rows ascend): rows are compared by key, so
   that one that is missing is told as such. A table without key is compared by position. */
TICKTRUE_API int ticktrue_key(ticktrue_session* session, const char* table, uint32_t columns);

/* The column (u32) holds keys of rows of `target`, or 0xffffffff. What differs in such a row is also told of the rows
   it refers to. */
TICKTRUE_API int ticktrue_reference(ticktrue_session* session, const char* table, const char* column,
                                    const char* target);

/* Names for rows, as in "player 2"; `text` has room for `size` bytes with the final zero. */
typedef void (*ticktrue_namer)(void* user, uint32_t row, char* text, size_t size);
TICKTRUE_API int ticktrue_row_names(ticktrue_session* session, const char* table, ticktrue_namer namer, void* user);

/* Before the first tick: the stages of a tick, in order. Inside a tick, ticktrue_stage says that one is done. */
TICKTRUE_API int ticktrue_add_stage(ticktrue_session* session, const char* name);
TICKTRUE_API int ticktrue_stage(ticktrue_session* session, const char* name);

/* Inputs of the tick that begins next, in any number of pieces. Record: keeps the bytes. Verify: replaces them by the
   recorded ones, so the same loop serves both; TICKTRUE_END (bytes untouched) when there are no more. */
TICKTRUE_API int ticktrue_input(ticktrue_session* session, void* data, size_t size);

/* Begins a tick: its inputs are in the file before it runs. `dt` (s; null: that of the options) is recorded, or
   replaced by the recorded one. Leave the loop when it does not return TICKTRUE_OK. */
TICKTRUE_API int ticktrue_begin_tick(ticktrue_session* session, double* dt);
/* Ends it: the state is hashed and written, or compared with the recorded one. */
TICKTRUE_API int ticktrue_end_tick(ticktrue_session* session);

/* Rollback: the program has gone back to its state with `tick` ticks done and runs on from there. */
TICKTRUE_API int ticktrue_rewind(ticktrue_session* session, uint64_t tick);
/* The first `tick` ticks are final: only such are written and compared. */
TICKTRUE_API int ticktrue_confirm(ticktrue_session* session, uint64_t tick);

/* Ticks done. */
TICKTRUE_API uint64_t ticktrue_tick(const ticktrue_session* session);
/* What the last call returned, and would return again. */
TICKTRUE_API int ticktrue_status(const ticktrue_session* session);
/* What went wrong; empty if nothing did. */
TICKTRUE_API const char* ticktrue_message(const ticktrue_session* session);

/* Closes the trace, or judges the run; returns the tool's exit code: 0 match or recorded, 1 diverged or not finite,
   2 failed, 3 incomplete, 4 damaged, 5 not comparable. No tick may begin after it. */
TICKTRUE_API int ticktrue_finish(ticktrue_session* session);
/* After finish: what `ticktrue verify` would print. */
TICKTRUE_API const char* ticktrue_report(ticktrue_session* session);
TICKTRUE_API const char* ticktrue_report_json(ticktrue_session* session);
/* Finishes, prints the report (stdout) or what went wrong (stderr), frees the session; returns the exit code. */
TICKTRUE_API int ticktrue_close(ticktrue_session* session);

/* Of the library: its version, as in "0.1.0", and its TICKTRUE_API_VERSION. */
TICKTRUE_API const char* ticktrue_version(void);
TICKTRUE_API uint32_t ticktrue_api_version(void);

/* ---- plug-ins: a simulation that the tool drives (`--plugin lib.so`) --------------------------------------------- */

/* What the tool offers a plug-in. A plug-in need not be linked to the library. */
typedef struct ticktrue_columns ticktrue_columns;
typedef struct ticktrue_stages ticktrue_stages;
typedef struct ticktrue_host {
  size_t struct_size;
  uint32_t api_version;
  /* As ticktrue_column, ticktrue_key and ticktrue_reference. What they refuse is told when `columns` returns. */
  int (*column)(ticktrue_columns* columns, const char* table, const char* name, void* data, int type, uint32_t lanes,
                uint32_t rows, size_t stride);
  int (*key)(ticktrue_columns* columns, const char* table, uint32_t key_columns);
  int (*reference)(ticktrue_columns* columns, const char* table, const char* column, const char* target);
  /* Inside step: the stage with this index is done. */
  void (*stage_done)(ticktrue_stages* stages, uint32_t stage);
} ticktrue_host;

/* Functions return 0 for success. `text` has room for `text_size` bytes with the final zero: why it failed, or what was
   asked for. Optional ones may be null. */
typedef struct ticktrue_plugin {
  size_t struct_size;        /* sizeof(ticktrue_plugin) */
  uint32_t api_version;      /* TICKTRUE_API_VERSION */
  uint32_t version;          /* as in ticktrue_options */
  const char* name;          /* as in ticktrue_options */
  const char* const* stages; /* names, in order; may be null */
  uint32_t stage_count;
  uint32_t flags; /* 0 */
  int (*create)(const ticktrue_host* host, const void* setup, size_t setup_size, void** simulation, char* text,
                size_t text_size);
  void (*destroy)(void* simulation);
  /* Registers every column. Called after create, step and load: data, rows and stride may differ, the rest may not. */
  int (*columns)(void* simulation, const ticktrue_host* host, ticktrue_columns* columns);
  /* Advances one tick. */
  int (*step)(void* simulation, double dt, const void* inputs, size_t inputs_size, const ticktrue_host* host,
              ticktrue_stages* stages, char* text, size_t text_size);
  /* Optional: whether step may be given these inputs. Without it, all are taken. */
  int (*accept)(void* simulation, double dt, const void* inputs, size_t inputs_size, char* text, size_t text_size);
  /* Optional: makes room for so many rows, since values will be written to where `columns` says. Without it, a state
     with other row counts cannot be loaded. */
  int (*resize)(void* simulation, const char* table, uint32_t rows);
  /* Optional: every value was written; rebuild what derives from it. Without it, the state can only be observed:
     verification then always starts at tick 0. */
  int (*loaded)(void* simulation, char* text, size_t text_size);
  /* Optional: what a person would call the row. */
  int (*row_name)(void* simulation, const char* table, uint32_t row, char* text, size_t text_size);
  /* Optional: the inputs of a tick for people, one JSON object a line. */
  int (*inputs_text)(void* simulation, uint64_t tick, const void* inputs, size_t inputs_size, char* text,
                     size_t text_size);
} ticktrue_plugin;

/* The one function a plug-in exports: TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(uint32_t v).
   It is told the tool's TICKTRUE_API_VERSION and returns null if that is too old for it. */
typedef const ticktrue_plugin* (*ticktrue_plugin_entry_function)(uint32_t api_version);
TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(uint32_t api_version);

#ifdef __cplusplus
}
#endif
