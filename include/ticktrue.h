// The C interface of ticktrue: records and verifies any simulation, in a loop of its own or as a plug-in of the tool.
// SPDX-License-Identifier: MIT
//
// For C99 and C++. docs/any_simulation.md leads to the first run that matches and the first run that diverges. Rules:
// - Binary interface: functions and constants keep their meaning. Structs begin with struct_size and only grow at the
//   end. So a program that is built with an older header runs with a newer library.
// - No exception leaves the library, and no wrong call crashes it. After a failure, this call and all later calls
//   return it, and ticktrue_close reports it. A null session means "off": each call does nothing and succeeds.
// - Threads: only one thread at a time may use a session. Different sessions share nothing.
// - Text is UTF-8. Returned pointers are valid until the next call with the same session.
#pragma once

#include <float.h>
#include <limits.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#if defined(TICKTRUE_BUILD)
#define TICKTRUE_API __declspec(dllexport)
#else
#define TICKTRUE_API
#endif
#define TICKTRUE_PLUGIN_API __declspec(dllexport)
#elif defined(__GNUC__) || defined(__clang__)
#define TICKTRUE_API __attribute__((visibility("default")))
#define TICKTRUE_PLUGIN_API __attribute__((visibility("default")))
#else
#define TICKTRUE_API
#define TICKTRUE_PLUGIN_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. Each addition raises it; nothing is removed.
   2: caller_facts, ticktrue_build_facts, ticktrue_table, ticktrue_rows.
   3: save, load, from, to, sync_test, TICKTRUE_RESTORE, ticktrue_seek, TICKTRUE_SHOWN.
   4: TICKTRUE_MARKS, ticktrue_mark, ticktrue_note; TICKTRUE_LIVE, TICKTRUE_REFUSED, peer_bytes, player, ticktrue_root,
      ticktrue_hello, ticktrue_peer_root and the location of a desync.
   5: ticktrue_child, ticktrue_text, ticktrue_bytes; ticktrue_bundle, ticktrue_box_save; save, load and build of
      plug-ins; table, rows, child, text and bytes of ticktrue_host. */
#define TICKTRUE_API_VERSION 5u

/* The results of calls. */
enum {
  TICKTRUE_OK = 0,       /* continue */
  TICKTRUE_END = 1,      /* verify: every recorded tick was run; leave the loop */
  TICKTRUE_DIVERGED = 2, /* verify: this tick differs; record: a value is not finite; leave the loop */
  TICKTRUE_FAILED = 3,   /* a wrong call, or an error of the system; see ticktrue_message */
  TICKTRUE_REFUSED = 4   /* invalid bytes from another player, or a file that cannot be written;
                            nothing has changed: continue */
};

/* Types of values. Signed values of 8 and 16 bits are registered as U8 and U16: their bits are compared. */
enum {
  TICKTRUE_U8 = 1,
  TICKTRUE_U16 = 2,
  TICKTRUE_U32 = 3,
  TICKTRUE_U64 = 4,
  TICKTRUE_I32 = 5,
  TICKTRUE_I64 = 6,
  TICKTRUE_F32 = 7,
  TICKTRUE_F64 = 8,
  /* Added to a type, as in TICKTRUE_F32 | TICKTRUE_SHOWN: the column is stored and printed, and never compared. For
     values that people want to see in a report and that may differ: sprites, names of assets, costs, addresses. The
     table needs at least one column that is compared. Shown columns are stored in checkpoints, and with ticks in full
     detail. */
  TICKTRUE_SHOWN = 0x100
};

/* ---- sessions: a program that owns its loop ---------------------------------------------------------------------- */

typedef struct ticktrue_session ticktrue_session;

/* Live: nothing is written or verified. Ticks are hashed, and compared with those of other players. */
enum { TICKTRUE_RECORD = 1, TICKTRUE_VERIFY = 2, TICKTRUE_LIVE = 3 };

/* How much a trace stores of each tick. */
enum {
  TICKTRUE_DETAIL_DEFAULT = 0, /* the default of `ticktrue record` */
  TICKTRUE_DETAIL_ROOT = 1,    /* a hash, which finds the tick of a difference */
  TICKTRUE_DETAIL_CELLS = 2,   /* hashes that also find columns and rows */
  TICKTRUE_DETAIL_FULL = 3     /* the whole state of ticks full_first..full_last: also finds values */
};

enum {
  TICKTRUE_OVERWRITE = 1, /* record: replace an existing file */
  TICKTRUE_QUIET = 2,     /* ticktrue_close prints nothing */
  TICKTRUE_JSON = 4,      /* ticktrue_close prints the report as JSON */
  TICKTRUE_NO_SYNC = 8,   /* record: do not wait until the file is on the disk */
  TICKTRUE_RESTORE = 16,  /* verify: load each save of the trace and run the ticks after it a second time */
  TICKTRUE_MARKS = 32     /* record: store marks and notes, in a trace of format version 3 */
};

/* Optional, as in rollback games. Save writes the bytes that bring the program back to its present state: at most
   `size` bytes to `buffer`. It returns their number. If this is more than `size`, it is called again with enough
   capacity. TICKTRUE_SAVE_FAILED: no save at present. Save must not change the state. */
#define TICKTRUE_SAVE_FAILED ((size_t)-1)
typedef size_t (*ticktrue_saver)(void* user, void* buffer, size_t size);
/* Brings the program into the state of the bytes; returns 0 for success. A session calls both functions in begin_tick,
   input, end_tick and ticktrue_seek. They may call ticktrue_column and ticktrue_rows, for memory that has moved, and no
   other function. */
typedef int (*ticktrue_loader)(void* user, const void* bytes, size_t size);

/* Fields that are zero have a usable default; struct_size must be set. */
typedef struct ticktrue_options {
  size_t struct_size; /* sizeof(ticktrue_options) */
  int32_t mode;       /* TICKTRUE_RECORD, TICKTRUE_VERIFY or TICKTRUE_LIVE */
  int32_t detail;     /* record */
  const char* path;   /* path of the trace */
  const char* name;   /* name of the simulation, such as "mygame" */
  uint32_t version;   /* raise it when results change on purpose: older traces become "not comparable" */
  uint32_t flags;
  const void* setup; /* record: the bytes with which the program can begin again: level, seed, players */
  size_t setup_size;
  const char* title;            /* record: for people; null: the name */
  const char* build;            /* facts about the program's build, such as "r345 gcc 12 -O2"; may be null */
  double dt;                    /* length of a tick in s; 0: 1/60 */
  uint64_t full_first;          /* record, detail full: first tick stored in full */
  uint64_t full_last;           /* last tick stored in full; 0: all from full_first on */
  uint32_t checkpoint_interval; /* record: ticks between full states; 0: 600 */
  uint32_t rollback_max;        /* number of ticks that may wait for ticktrue_confirm; 0: no rollback */
  /* Since version 2 of this interface. */
  const char* caller_facts; /* how the program is compiled: TICKTRUE_CALLER_FACTS; null: unknown */
  /* Since version 3. */
  ticktrue_saver save;  /* both or none; with them, checkpoints of a recording have a save */
  ticktrue_loader load; /* needed by `from`, `sync_test`, TICKTRUE_RESTORE and ticktrue_seek */
  void* user;           /* passed to both */
  uint64_t from;        /* verify: first tick to compare; the run begins at the last save at or before it */
  uint64_t to;          /* verify: last tick to compare; 0: to the end */
  uint32_t sync_test;   /* k > 0: after each k ticks, load the save before them and run them again */
  uint32_t reserved;    /* 0 */
  /* Since version 4. */
  uint64_t peer_bytes; /* memory for states of confirmed ticks, to locate a desync; 0: 16 MiB */
  uint32_t player;     /* own player number, 0..254; all players must use the same numbers */
  uint32_t box_kib;    /* record: > 0: `path` is a black box of this size, with the last ticks of the session */
} ticktrue_options;

/* Opens a session. The result is never null: the next call and ticktrue_close report an error. All data are copied. */
TICKTRUE_API ticktrue_session* ticktrue_open(const ticktrue_options* options);

/* The same, with mode, path and overwriting from the program's words --record FILE, --verify FILE and --force. If
   neither of the first two occurs, the result is null, or with mode TICKTRUE_LIVE a live session. --blackbox FILE
   records into a black box of box_kib (0: 32 MiB) or of --box-kib N. With --record, also --detail root, cells, full or
   full:FIRST..LAST (for programs that are built with this header or a newer one). If `load` is set, also --sync-test K
   and, with --verify, --from N, --to N and --mode replay or restore. */
TICKTRUE_API ticktrue_session* ticktrue_open_arguments(const ticktrue_options* options, int argc, char* const* argv);

/* The setup. Verify: the recorded setup. Record and a null session: `setup` of the options (null: none). */
TICKTRUE_API const void* ticktrue_setup(ticktrue_session* session, size_t* size);

/* Facts about the build of another unit, such as a physics library, or a file with its own flags. To be called before
   the first tick. `unit`: its name in reports. `facts`: TICKTRUE_CALLER_FACTS in it, or lines "name=value". */
TICKTRUE_API int ticktrue_build_facts(ticktrue_session* session, const char* unit, const char* facts);

/* Registers a column of a table. The values of row r begin `stride` * r bytes after `data`: `lanes` adjacent values (2
   for x and y). Stride 0: packed. All columns must be registered before the first tick, and again when data, rows or
   stride have changed. The first begin_tick and each end_tick read the memory. */
TICKTRUE_API int ticktrue_column(ticktrue_session* session, const char* table, const char* name, const void* data,
                                 int type, uint32_t lanes, uint32_t rows, size_t stride);

/* A column of a table of structs: a member of the struct, such as TICKTRUE_MEMBER(Ball, position, TICKTRUE_F64). An
   array has a lane for each value. `position.x` is allowed as a member. */
typedef struct ticktrue_member {
  const char* name;
  int32_t type;
  uint32_t lanes; /* 0: computed from `size` */
  size_t offset;  /* bytes from the begin of the struct */
  size_t size;    /* bytes; 0: unknown */
} ticktrue_member;
#ifdef __cplusplus
#define TICKTRUE_MEMBER(row, member, type) \
  { #member, (type), 0, offsetof(row, member), sizeof(row::member) }
#else
#define TICKTRUE_MEMBER(row, member, type) \
  { #member, (type), 0, offsetof(row, member), sizeof(((row*)0)->member) }
#endif
#define TICKTRUE_NO_TABLE 0xffffffffu

/* Registers a table whose rows are structs of `stride` bytes: all its columns at once, without rows yet. Returns its
   number; TICKTRUE_NO_TABLE: it is refused; 0: no session. */
TICKTRUE_API uint32_t ticktrue_table(ticktrue_session* session, const char* name, size_t stride,
                                     const ticktrue_member* members, uint32_t member_count);
/* Sets the rows of the table: `rows` structs from `base` on. To be called again when base or rows have changed. It
   needs no search by name. */
TICKTRUE_API int ticktrue_rows(ticktrue_session* session, uint32_t table, const void* base, uint32_t rows);

/* Child tables have data with another length in each row: texts, byte strings, lists. A callback returns the first
   element of one row of `parent` and sets the number of elements. With 0 elements, the returned pointer is not read.
   `owner`: address of this row, from ticktrue_rows or a callback of ticktrue_child; null: the columns of the parent are
   registered one by one. `row`: row number in the parent. It is called for each row in order, in the first begin_tick,
   in stage and end_tick, and around save and load. It must not change the state. */
typedef const void* (*ticktrue_elements)(void* user, const void* owner, uint32_t row, size_t* count);
/* Registers the list that each row of `parent` has, such as "units.inventory" of "units". Its elements have `stride`
   bytes and these members (none: only the number of elements is compared). To be called before the first tick, and
   after the registration of the parent, which may be a child table. The columns "owner" and "index" come before the
   members and are the key. */
TICKTRUE_API int ticktrue_child(ticktrue_session* session, const char* table, const char* parent,
                                ticktrue_elements elements, void* user, size_t stride, const ticktrue_member* members,
                                uint32_t member_count);
/* The same for a text (UTF-8, which reports print) and for a byte string (which reports print in hexadecimal). `bytes`
   returns the first byte and sets the number of bytes. */
TICKTRUE_API int ticktrue_text(ticktrue_session* session, const char* table, const char* parent,
                               ticktrue_elements bytes, void* user);
TICKTRUE_API int ticktrue_bytes(ticktrue_session* session, const char* table, const char* parent,
                                ticktrue_elements bytes, void* user);

/* The first `columns` columns of the table are its key: unsigned integers, in ascending order of rows. Rows are
   compared by key, so a missing row is reported as missing. A table without a key is compared by position. */
TICKTRUE_API int ticktrue_key(ticktrue_session* session, const char* table, uint32_t columns);

/* The column (u32) has keys of rows in `target`, or 0xffffffff. A difference in such a row is also reported for the
   rows to which it refers. */
TICKTRUE_API int ticktrue_reference(ticktrue_session* session, const char* table, const char* column,
                                    const char* target);

/* Names of rows, such as "player 2". `text` has capacity for `size` bytes with the final zero. */
typedef void (*ticktrue_namer)(void* user, uint32_t row, char* text, size_t size);
TICKTRUE_API int ticktrue_row_names(ticktrue_session* session, const char* table, ticktrue_namer namer, void* user);

/* Adds a stage of the tick, in order, before the first tick. In a tick, ticktrue_stage reports the end of a stage. */
TICKTRUE_API int ticktrue_add_stage(ticktrue_session* session, const char* name);
TICKTRUE_API int ticktrue_stage(ticktrue_session* session, const char* name);

/* Inputs of the tick that begins next, in any number of pieces. Record: stores the bytes. Verify: replaces them by the
   recorded bytes, so both modes can use the same loop. TICKTRUE_END: the trace has no more ticks; the bytes are
   unchanged. */
TICKTRUE_API int ticktrue_input(ticktrue_session* session, void* data, size_t size);

/* Marks, for events in a tick that are not state: a random draw, a call, the size of a list. For each tick, the trace
   stores how often each name was marked, and hashes of the values and of the order. A verification compares them: they
   affect no verdict, and show where a run first differed. A mark takes a few nanoseconds. `name`: 1 to 256 bytes, such
   as "rand". Outside a tick, a mark does nothing. Only for the thread of the session. */
TICKTRUE_API int ticktrue_mark(ticktrue_session* session, const char* name, uint64_t value);
/* The same for the bits of a double. */
static inline int ticktrue_mark_f64(ticktrue_session* session, const char* name, double value) {
  union {
    double number;
    uint64_t bits;
  } both;
  both.number = value;
  return ticktrue_mark(session, name, both.bits);
}
/* A text about the running or next tick, for people who read the trace later. It is stored with TICKTRUE_MARKS and
   never compared; a verification ignores it. `topic`: 1 to 64 bytes, not beginning with "ticktrue.". `text`: at most
   4096 bytes; further bytes are dropped. Inside a tick, it is written to the file at once. */
TICKTRUE_API int ticktrue_note(ticktrue_session* session, const char* topic, const char* text);

/* Begins a tick. Its inputs are written to the file before it runs. `dt` (s; null: dt of the options) is recorded, or
   replaced by the recorded dt. Leave the loop if the result is not TICKTRUE_OK. */
TICKTRUE_API int ticktrue_begin_tick(ticktrue_session* session, double* dt);
/* Ends the tick: the state is hashed and written, or compared with the recorded state. */
TICKTRUE_API int ticktrue_end_tick(ticktrue_session* session);

/* Rollback: the program has returned to its state before tick `tick` and continues from there. */
TICKTRUE_API int ticktrue_rewind(ticktrue_session* session, uint64_t tick);
/* The first `tick` ticks are final. Only final ticks are written and compared. */
TICKTRUE_API int ticktrue_confirm(ticktrue_session* session, uint64_t tick);

/* Verify, between two ticks: loads the last save of the trace at or before `tick`. The program continues from there.
   ticktrue_tick returns the tick of the save. */
TICKTRUE_API int ticktrue_seek(ticktrue_session* session, uint64_t tick);

/* The number of ticks done. In a sync test and with TICKTRUE_RESTORE it decreases when a save is loaded: count ticks by
   it. */
TICKTRUE_API uint64_t ticktrue_tick(const ticktrue_session* session);
/* The result of the last call, which the next call would return again. */
TICKTRUE_API int ticktrue_status(const ticktrue_session* session);
/* The error, or why the last call was refused; empty: neither. */
TICKTRUE_API const char* ticktrue_message(const ticktrue_session* session);

/* ---- other players of a live game; the program transports the bytes ---- */

/* The root hash of the state after a confirmed tick (without rollback: after a finished tick). The last 4,096 are
   available. TICKTRUE_END: the tick is not confirmed yet or no longer available, or there is no session; `root` is
   unchanged. */
TICKTRUE_API int ticktrue_root(ticktrue_session* session, uint64_t tick, uint64_t* root);

/* The bytes that describe this game to the other players: setup, columns, version, build, floats. To be called before
   tick 0, after all registrations. Returns their number, at most 1 MiB, and writes them if they fit into `size`. 0: no
   session. */
TICKTRUE_API size_t ticktrue_hello(ticktrue_session* session, void* buffer, size_t size);
/* Compares the bytes of another player. TICKTRUE_OK: both play the same game. TICKTRUE_DIVERGED: they do not. `text`:
   the differences, one line each (with TICKTRUE_OK: facts that may matter, such as another build id); may be null. */
TICKTRUE_API int ticktrue_hello_check(ticktrue_session* session, uint32_t peer, const void* bytes, size_t size,
                                      char* text, size_t text_size);

/* The root hash of another player after a tick that this player has confirmed. In any order, repeatedly, and before the
   tick is confirmed here. TICKTRUE_DIVERGED: the roots of some tick differ. The session continues. */
TICKTRUE_API int ticktrue_peer_root(ticktrue_session* session, uint32_t peer, uint64_t tick, uint64_t root);

/* The next message to this player for the location of a desync, at most `size` bytes (256 or more); 0: none is due.
   Call it once for each packet, not in a loop: parts are sent again until the other player confirms them. */
TICKTRUE_API size_t ticktrue_desync_message(ticktrue_session* session, uint32_t peer, void* buffer, size_t size);
/* Receives such a message from another player. Results as for ticktrue_peer_root. */
TICKTRUE_API int ticktrue_desync_receive(ticktrue_session* session, uint32_t peer, const void* bytes, size_t size);
/* The known facts about a desync: tick, players, columns, rows, values. Empty: no desync. `complete` (may be null) is
   set to 1 when the states of all players were compared: then all players have the same report. ticktrue_report
   includes it. */
TICKTRUE_API const char* ticktrue_desync_report(ticktrue_session* session, int* complete);

/* Writes a file to send to others: a trace of this player's ticks, with the roots, build facts and differing rows of
   the other players. It begins at a save before the first difference; without saves, at tick 0. `ticktrue show` and
   `ticktrue report` print who differs. `ticktrue verify --command` runs this player's ticks again. Call it when
   ticktrue_desync_report is complete, or at the end of the match: it contains the facts known at this time. The ticks
   come from the recording or the black box of the session. Without either, they come from memory (peer_bytes), and have
   no save. TICKTRUE_REFUSED: no desync, or no file; see ticktrue_message. It takes as long as reading the recording. */
TICKTRUE_API int ticktrue_bundle(ticktrue_session* session, const char* path);
/* Record, with a black box: writes the present content of the box as a trace. The session continues. Results as for
   ticktrue_bundle. */
TICKTRUE_API int ticktrue_box_save(ticktrue_session* session, const char* path);

/* Closes the trace, or decides the verdict. Returns the exit code of the tool: 0 match or recorded, 1 diverged or not
   finite, 2 failed, 3 incomplete, 4 damaged, 5 not comparable. No tick may begin afterwards. */
TICKTRUE_API int ticktrue_finish(ticktrue_session* session);
/* After finish: the output of `ticktrue verify`. */
TICKTRUE_API const char* ticktrue_report(ticktrue_session* session);
TICKTRUE_API const char* ticktrue_report_json(ticktrue_session* session);
/* Finishes, prints the report (stdout) or the error (stderr), and frees the session; returns the exit code. If the disk
   is full, the recording ends and the session continues. Later calls succeed, ticktrue_message and ticktrue_close
   report the error, and the exit code is 2. */
TICKTRUE_API int ticktrue_close(ticktrue_session* session);

/* The version of the library, such as "0.1.0", and its TICKTRUE_API_VERSION. */
TICKTRUE_API const char* ticktrue_version(void);
TICKTRUE_API uint32_t ticktrue_api_version(void);

/* ---- plug-ins: a simulation that the tool drives (`--plugin lib.so`) --------------------------------------------- */

/* The functions of the tool for a plug-in. A plug-in need not be linked to the library. */
typedef struct ticktrue_columns ticktrue_columns;
typedef struct ticktrue_stages ticktrue_stages;
typedef struct ticktrue_host {
  size_t struct_size;
  uint32_t api_version;
  /* As ticktrue_column, ticktrue_key and ticktrue_reference. A refused call is reported when `columns` returns. */
  int (*column)(ticktrue_columns* columns, const char* table, const char* name, void* data, int type, uint32_t lanes,
                uint32_t rows, size_t stride);
  int (*key)(ticktrue_columns* columns, const char* table, uint32_t key_columns);
  int (*reference)(ticktrue_columns* columns, const char* table, const char* column, const char* target);
  /* To be called in step: the stage with this index has ended. */
  void (*stage_done)(ticktrue_stages* stages, uint32_t stage);
  /* Since version 5 of this interface. As ticktrue_table, ticktrue_rows, ticktrue_child, ticktrue_text and
     ticktrue_bytes, without shown columns. Values may be written to `base`, as to `data` of a column. Elements are
     asked for behind create, step, save and load, when `columns` has returned. A simulation with child tables is
     brought back by `load` of the plug-in alone. */
  uint32_t (*table)(ticktrue_columns* columns, const char* name, size_t stride, const ticktrue_member* members,
                    uint32_t member_count);
  int (*rows)(ticktrue_columns* columns, uint32_t table, void* base, uint32_t rows);
  int (*child)(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements elements, void* user,
               size_t stride, const ticktrue_member* members, uint32_t member_count);
  int (*text)(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements bytes, void* user);
  int (*bytes)(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements bytes, void* user);
} ticktrue_host;

/* Functions return 0 for success. `text` has capacity for `text_size` bytes with the final zero: for an error message,
   or for the requested text. Optional functions may be null. */
typedef struct ticktrue_plugin {
  size_t struct_size;        /* sizeof(ticktrue_plugin) */
  uint32_t api_version;      /* the version that it needs: TICKTRUE_API_VERSION; an older tool refuses the plug-in */
  uint32_t version;          /* as in ticktrue_options */
  const char* name;          /* as in ticktrue_options */
  const char* const* stages; /* names, in order; may be null */
  uint32_t stage_count;
  uint32_t flags; /* 0 */
  int (*create)(const ticktrue_host* host, const void* setup, size_t setup_size, void** simulation, char* text,
                size_t text_size);
  void (*destroy)(void* simulation);
  /* Registers all columns. Called after create, step and load: data, rows and stride may change, the rest must not. */
  int (*columns)(void* simulation, const ticktrue_host* host, ticktrue_columns* columns);
  /* Advances one tick. */
  int (*step)(void* simulation, double dt, const void* inputs, size_t inputs_size, const ticktrue_host* host,
              ticktrue_stages* stages, char* text, size_t text_size);
  /* Optional: whether step accepts these inputs. Without it, all inputs are accepted. */
  int (*accept)(void* simulation, double dt, const void* inputs, size_t inputs_size, char* text, size_t text_size);
  /* Optional: allocates this number of rows. Values are then written to the addresses from `columns`. Without it, a
     state with other row counts cannot be loaded. */
  int (*resize)(void* simulation, const char* table, uint32_t rows);
  /* Optional: called after all values were written, to rebuild derived data. Without it, the state can only be
     observed: a verification always begins at tick 0. */
  int (*loaded)(void* simulation, char* text, size_t text_size);
  /* Optional: a name of the row for people. */
  int (*row_name)(void* simulation, const char* table, uint32_t row, char* text, size_t text_size);
  /* Optional: the inputs of a tick for people, one JSON object per line. */
  int (*inputs_text)(void* simulation, uint64_t tick, const void* inputs, size_t inputs_size, char* text,
                     size_t text_size);
  /* Since version 5 of this interface. */
  /* Optional, both or none; `user` is the simulation. With them, checkpoints of a recording have a save, and a
     verification can begin at each of them. Then create makes a simulation from the same setup, load brings it into the
     state of the save, and `columns` is called. For a trace with saves, `loaded` is not called. */
  ticktrue_saver save;
  ticktrue_loader load;
  const char* build; /* facts about the build of the plug-in, as in ticktrue_options; may be null */
} ticktrue_plugin;

/* The only function that a plug-in exports: TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(uint32_t
   v). Its argument is the TICKTRUE_API_VERSION of the tool. It returns null if this version is too old for it. */
typedef const ticktrue_plugin* (*ticktrue_plugin_entry_function)(uint32_t api_version);
TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(uint32_t api_version);

/* ---- facts about the build of the program ------------------------------------------------------------------------ */

/* How the unit with this header is compiled: for caller_facts of the options, and for ticktrue_build_facts. One
   "name=value" per line. If TICKTRUE_UNIT_FLAGS is defined as a string, it is included as the flags of the compiler. */
#define TICKTRUE_CALLER_FACTS (ticktrue_unit_facts())

#define TICKTRUE_TEXT_OF(x) #x
#define TICKTRUE_TEXT(x) TICKTRUE_TEXT_OF(x)
#define TICKTRUE_TEXT3(a, b, c) TICKTRUE_TEXT(a) "." TICKTRUE_TEXT(b) "." TICKTRUE_TEXT(c)

#if defined(__INTEL_LLVM_COMPILER)
#define TICKTRUE_FACT_COMPILER "intel " TICKTRUE_TEXT(__INTEL_LLVM_COMPILER)
#elif defined(__INTEL_COMPILER)
#define TICKTRUE_FACT_COMPILER "intel classic " TICKTRUE_TEXT(__INTEL_COMPILER)
#elif defined(__apple_build_version__)
#define TICKTRUE_FACT_COMPILER "apple clang " TICKTRUE_TEXT3(__clang_major__, __clang_minor__, __clang_patchlevel__)
#elif defined(__clang__)
#define TICKTRUE_FACT_COMPILER "clang " TICKTRUE_TEXT3(__clang_major__, __clang_minor__, __clang_patchlevel__)
#elif defined(__GNUC__)
#define TICKTRUE_FACT_COMPILER "gcc " TICKTRUE_TEXT3(__GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__)
#elif defined(_MSC_VER)
#define TICKTRUE_FACT_COMPILER "msvc " TICKTRUE_TEXT(_MSC_FULL_VER)
#else
#define TICKTRUE_FACT_COMPILER "not known"
#endif

#if defined(_MSVC_LANG)
#define TICKTRUE_FACT_CXX _MSVC_LANG
#elif defined(__cplusplus)
#define TICKTRUE_FACT_CXX __cplusplus
#else
#define TICKTRUE_FACT_CXX 0
#endif
#if TICKTRUE_FACT_CXX > 202002L
#define TICKTRUE_FACT_LANGUAGE "c++23"
#elif TICKTRUE_FACT_CXX > 201703L
#define TICKTRUE_FACT_LANGUAGE "c++20"
#elif TICKTRUE_FACT_CXX > 201402L
#define TICKTRUE_FACT_LANGUAGE "c++17"
#elif TICKTRUE_FACT_CXX > 201103L
#define TICKTRUE_FACT_LANGUAGE "c++14"
#elif TICKTRUE_FACT_CXX > 199711L
#define TICKTRUE_FACT_LANGUAGE "c++11"
#elif TICKTRUE_FACT_CXX > 0
#define TICKTRUE_FACT_LANGUAGE "c++98"
#elif !defined(__STDC_VERSION__)
#define TICKTRUE_FACT_LANGUAGE "c"
#elif __STDC_VERSION__ > 201710L
#define TICKTRUE_FACT_LANGUAGE "c23"
#elif __STDC_VERSION__ > 201112L
#define TICKTRUE_FACT_LANGUAGE "c17"
#elif __STDC_VERSION__ > 199901L
#define TICKTRUE_FACT_LANGUAGE "c11"
#else
#define TICKTRUE_FACT_LANGUAGE "c99"
#endif

#if defined(__OPTIMIZE_SIZE__)
#define TICKTRUE_FACT_OPTIMIZE "size"
#elif defined(__OPTIMIZE__)
#define TICKTRUE_FACT_OPTIMIZE "speed"
#elif defined(__GNUC__) || defined(__clang__)
#define TICKTRUE_FACT_OPTIMIZE "no"
#else
#define TICKTRUE_FACT_OPTIMIZE "not known"
#endif

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#define TICKTRUE_FACT_FAST_MATH "yes"
#else
#define TICKTRUE_FACT_FAST_MATH "no"
#endif
#if defined(_M_FP_FAST)
#define TICKTRUE_FACT_FINITE_MATH "yes"
#elif !defined(__FINITE_MATH_ONLY__)
#define TICKTRUE_FACT_FINITE_MATH "no"
#elif __FINITE_MATH_ONLY__ > 0
#define TICKTRUE_FACT_FINITE_MATH "yes"
#else
#define TICKTRUE_FACT_FINITE_MATH "no"
#endif
/* Parts of fast_math that can be enabled alone. Not every compiler defines these macros. */
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#define TICKTRUE_FACT_UNSAFE_MATH "yes"
#else
#define TICKTRUE_FACT_UNSAFE_MATH TICKTRUE_FACT_FAST_MATH
#endif

/* Whether the unit may use instructions that round once for a product and a sum. */
#if defined(__FMA__) || defined(__FMA4__) || defined(__ARM_FEATURE_FMA) || defined(__aarch64__) || \
    defined(_M_ARM64) || defined(__powerpc__) || defined(__s390x__) || defined(__riscv_flen) ||    \
    (defined(_MSC_VER) && defined(__AVX2__))
#define TICKTRUE_FACT_FMA "yes"
#else
#define TICKTRUE_FACT_FMA "no"
#endif

#if !defined(FLT_EVAL_METHOD)
#define TICKTRUE_FACT_FLT_EVAL_METHOD "not known"
#elif FLT_EVAL_METHOD == 0
#define TICKTRUE_FACT_FLT_EVAL_METHOD "0"
#elif FLT_EVAL_METHOD == 1
#define TICKTRUE_FACT_FLT_EVAL_METHOD "1"
#elif FLT_EVAL_METHOD == 2
#define TICKTRUE_FACT_FLT_EVAL_METHOD "2"
#else
#define TICKTRUE_FACT_FLT_EVAL_METHOD "other"
#endif

#if defined(__AVX512F__)
#define TICKTRUE_FACT_SIMD "avx512f"
#elif defined(__AVX2__)
#define TICKTRUE_FACT_SIMD "avx2"
#elif defined(__AVX__)
#define TICKTRUE_FACT_SIMD "avx"
#elif defined(__SSE4_1__)
#define TICKTRUE_FACT_SIMD "sse4.1"
#elif defined(__SSE2__) || defined(_M_X64)
#define TICKTRUE_FACT_SIMD "sse2"
#elif defined(__ARM_FEATURE_SVE)
#define TICKTRUE_FACT_SIMD "sve"
#elif defined(__ARM_NEON) || defined(_M_ARM64)
#define TICKTRUE_FACT_SIMD "neon"
#elif defined(__VSX__)
#define TICKTRUE_FACT_SIMD "vsx"
#elif defined(__riscv_vector)
#define TICKTRUE_FACT_SIMD "v"
#elif defined(__wasm_simd128__)
#define TICKTRUE_FACT_SIMD "simd128"
#elif defined(_M_IX86_FP)
#if _M_IX86_FP > 1
#define TICKTRUE_FACT_SIMD "sse2"
#else
#define TICKTRUE_FACT_SIMD "none"
#endif
#else
#define TICKTRUE_FACT_SIMD "none"
#endif

#if CHAR_MIN < 0
#define TICKTRUE_FACT_CHAR "signed"
#else
#define TICKTRUE_FACT_CHAR "unsigned"
#endif
#if LONG_MAX > 2147483647L
#define TICKTRUE_FACT_LONG "64"
#else
#define TICKTRUE_FACT_LONG "32"
#endif
#if UINTPTR_MAX > 4294967295u
#define TICKTRUE_FACT_POINTER "64"
#else
#define TICKTRUE_FACT_POINTER "32"
#endif
#if defined(NDEBUG)
#define TICKTRUE_FACT_NDEBUG "yes"
#else
#define TICKTRUE_FACT_NDEBUG "no"
#endif

#if defined(__x86_64__) || defined(_M_X64)
#define TICKTRUE_FACT_MACHINE "x86_64"
#elif defined(__i386__) || defined(_M_IX86)
#define TICKTRUE_FACT_MACHINE "i386"
#elif defined(__aarch64__) || defined(_M_ARM64)
#define TICKTRUE_FACT_MACHINE "aarch64"
#elif defined(__arm__) || defined(_M_ARM)
#define TICKTRUE_FACT_MACHINE "arm"
#elif defined(__riscv)
#define TICKTRUE_FACT_MACHINE "riscv"
#elif defined(__s390x__)
#define TICKTRUE_FACT_MACHINE "s390x"
#elif defined(__powerpc__)
#define TICKTRUE_FACT_MACHINE "ppc"
#elif defined(__wasm__)
#define TICKTRUE_FACT_MACHINE "wasm"
#else
#define TICKTRUE_FACT_MACHINE "other"
#endif
#if defined(_WIN32)
#define TICKTRUE_FACT_SYSTEM "windows"
#elif defined(__APPLE__)
#define TICKTRUE_FACT_SYSTEM "apple"
#elif defined(__ANDROID__)
#define TICKTRUE_FACT_SYSTEM "android"
#elif defined(__linux__)
#define TICKTRUE_FACT_SYSTEM "linux"
#elif defined(__EMSCRIPTEN__)
#define TICKTRUE_FACT_SYSTEM "emscripten"
#else
#define TICKTRUE_FACT_SYSTEM "other"
#endif

#if defined(TICKTRUE_UNIT_FLAGS)
#define TICKTRUE_FACT_FLAGS "\nflags=" TICKTRUE_UNIT_FLAGS
#else
#define TICKTRUE_FACT_FLAGS ""
#endif

#define TICKTRUE_FACTS_HEAD                                                                                    \
  "compiler=" TICKTRUE_FACT_COMPILER "\nlanguage=" TICKTRUE_FACT_LANGUAGE "\noptimize=" TICKTRUE_FACT_OPTIMIZE \
  "\nfused="
#define TICKTRUE_FACTS_TAIL                                                                                         \
  "\nfast_math=" TICKTRUE_FACT_FAST_MATH "\nfinite_math=" TICKTRUE_FACT_FINITE_MATH                                 \
  "\nunsafe_math=" TICKTRUE_FACT_UNSAFE_MATH "\nflt_eval_method=" TICKTRUE_FACT_FLT_EVAL_METHOD                     \
  "\nfma=" TICKTRUE_FACT_FMA "\nsimd=" TICKTRUE_FACT_SIMD "\nchar=" TICKTRUE_FACT_CHAR "\nlong=" TICKTRUE_FACT_LONG \
  "\npointer=" TICKTRUE_FACT_POINTER "\nndebug=" TICKTRUE_FACT_NDEBUG "\ntarget=" TICKTRUE_FACT_MACHINE             \
  " " TICKTRUE_FACT_SYSTEM TICKTRUE_FACT_FLAGS

static inline const char* ticktrue_unit_facts(void) {
  /* The rounded product is 1 + 2^-39, also with the 64 bits of x87. The fused difference is 2^-80. */
  volatile double factor = 1.0 + 1.0 / 1099511627776.0;
  volatile double rounded = 1.0 + 2.0 / 1099511627776.0;
  volatile double rest = 0.0;
  const double a = factor;
  const double b = factor;
  const double c = rounded;
  rest = a * b - c;
  return rest > 0.0 ? TICKTRUE_FACTS_HEAD "yes" TICKTRUE_FACTS_TAIL : TICKTRUE_FACTS_HEAD "no" TICKTRUE_FACTS_TAIL;
}

#undef TICKTRUE_TEXT_OF
#undef TICKTRUE_TEXT
#undef TICKTRUE_TEXT3
#undef TICKTRUE_FACTS_HEAD
#undef TICKTRUE_FACTS_TAIL
#undef TICKTRUE_FACT_COMPILER
#undef TICKTRUE_FACT_CXX
#undef TICKTRUE_FACT_LANGUAGE
#undef TICKTRUE_FACT_OPTIMIZE
#undef TICKTRUE_FACT_FAST_MATH
#undef TICKTRUE_FACT_FINITE_MATH
#undef TICKTRUE_FACT_UNSAFE_MATH
#undef TICKTRUE_FACT_FMA
#undef TICKTRUE_FACT_FLT_EVAL_METHOD
#undef TICKTRUE_FACT_SIMD
#undef TICKTRUE_FACT_CHAR
#undef TICKTRUE_FACT_LONG
#undef TICKTRUE_FACT_POINTER
#undef TICKTRUE_FACT_NDEBUG
#undef TICKTRUE_FACT_MACHINE
#undef TICKTRUE_FACT_SYSTEM
#undef TICKTRUE_FACT_FLAGS

#ifdef __cplusplus
}
#endif
