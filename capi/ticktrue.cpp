// The functions of include/ticktrue.h over Session: null sessions, exceptions, printing.
// SPDX-License-Identifier: MIT
#include "include/ticktrue.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <string>

#include "base/build_info.h"
#include "base/compiler/compiler.h"
#include "base/plain_text.h"
#include "capi/marks/shake_page.h"
#include "capi/session.h"

using ticktrue::Error;
using ticktrue::ErrorCode;
using ticktrue::capi::InLibrary;
using ticktrue::capi::Session;

/// The handle of the C program. `session` is null if memory ran out while it was made.
struct ticktrue_session {
  std::unique_ptr<Session> session;
  std::string report;
};

namespace {

constexpr const char* no_memory = "memory: the system refused to give more";
/// Returned if there is no memory for a session; never freed.
ticktrue_session memory_failure;

/// Runs a call on a session. A null session means "off"; exceptions become error codes.
template <typename Call>
int without_exceptions(ticktrue_session* handle, Call&& call) {
  if (handle == nullptr) return TICKTRUE_OK;
  if (handle->session == nullptr) return TICKTRUE_FAILED;
  const InLibrary inside;
  try {
    return call(*handle->session);
  } catch (const std::bad_alloc&) {
    try {
      return handle->session->fail(Error{ErrorCode::limit, no_memory, ""});
    } catch (...) {
      handle->session.reset();
      return TICKTRUE_FAILED;
    }
  } catch (const std::exception& exception) {
    try {
      return handle->session->fail(Error{ErrorCode::usage, std::string("internal: ") + exception.what(), ""});
    } catch (...) {
      handle->session.reset();
      return TICKTRUE_FAILED;
    }
  }
}

/// The struct_size of each version of the header, in ascending order.
constexpr std::size_t option_sizes[] = {
    offsetof(ticktrue_options, caller_facts),  // version 1
    offsetof(ticktrue_options, save),          // version 2
    offsetof(ticktrue_options, peer_bytes),    // version 3
    sizeof(ticktrue_options),                  // version 4
};

std::string option_sizes_text() {
  std::string text;
  for (std::size_t i = 0; i < std::size(option_sizes); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(option_sizes[i]) + " (version " + std::to_string(i + 1) + ")";
  return text;
}

/// Copies the options into the struct of this version. Fields that an older program lacks are zero.
bool read_options(const ticktrue_options* given, ticktrue_options& options, std::string& error) {
  options = {};
  if (given == nullptr) {
    error = "options: found null";
    return false;
  }
  constexpr std::size_t size_max = 4096;
  const std::size_t size = given->struct_size;
  // A size between two versions would cut a field. A larger size can come from a newer header.
  const bool is_known = std::find(std::begin(option_sizes), std::end(option_sizes), size) != std::end(option_sizes);
  if (!is_known && (size < sizeof options || size > size_max)) {
    error = "options: struct_size: found " + std::to_string(size) +
            ", expected sizeof(ticktrue_options): " + option_sizes_text() + " or more";
    return false;
  }
  std::memcpy(&options, given, std::min(size, sizeof options));
  options.struct_size = sizeof options;
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::size_t i = sizeof options; i < size; ++i)
    if (bytes[i] != 0) {
      error = "options: found a setting that this library (" + ticktrue::build_info().version +
              ") does not know: it is older than the program's header";
      return false;
    }
  return true;
}

ticktrue_session* open_session(const ticktrue_options& options, const std::string& error) {
  const InLibrary inside;
  ticktrue::capi::tell_session();
  auto handle = std::make_unique<ticktrue_session>();
  handle->session = error.empty() ? std::make_unique<Session>(options)
                                  : std::make_unique<Session>(Error{ErrorCode::usage, error, ""});
  return handle.release();
}

/// Reads a number after a word of the command line.
bool read_number(const char* text, std::uint64_t max, std::uint64_t& number) {
  if (text == nullptr || text[0] < '0' || text[0] > '9') return false;
  errno = 0;
  char* end = nullptr;
  number = std::strtoull(text, &end, 10);
  return errno == 0 && *end == 0 && number <= max;
}

/// Reads a word about what runs and how often, for programs that can load. Other programs may use such words
/// themselves. Returns the number of words read; 0: another word.
int read_run_word(const char* word, const char* value, ticktrue_options& options, std::string& error) {
  const auto is = [&](const char* name) { return std::strcmp(word, name) == 0; };
  std::uint64_t number = 0;
  const auto wrong = [&](const char* expected) {
    if (error.empty())
      error = std::string("command line: ") + word + ": found " + (value == nullptr ? "nothing" : value) +
              " behind it, expected " + expected;
    return 2;
  };
  if (is("--mode")) {
    const bool restores = value != nullptr && std::strcmp(value, "restore") == 0;
    if (!restores && (value == nullptr || std::strcmp(value, "replay") != 0)) return wrong("replay or restore");
    if (restores) options.flags |= TICKTRUE_RESTORE;
    return 2;
  }
  if (!is("--from") && !is("--to") && !is("--sync-test")) return 0;
  if (!read_number(value, is("--sync-test") ? UINT32_MAX : UINT64_MAX, number)) return wrong("a number");
  if (is("--from")) options.from = number;
  if (is("--to")) options.to = number;
  if (is("--sync-test")) options.sync_test = static_cast<std::uint32_t>(number);
  return 2;
}

constexpr std::uint32_t box_kib_default = 32u << 10;

/// A separate function: its stack frame then costs nothing in calls that do not need it.
TICKTRUE_NO_INLINE int mark(ticktrue_session* session, const char* name, uint64_t value, const void* caller) {
  return without_exceptions(session, [&](Session& s) { return s.mark(name, value, caller); });
}

/// Reads "root", "cells", "full", "full:10" or "full:10..20" after --detail. Returns what is wrong; empty: nothing.
std::string read_detail(const char* value, ticktrue_options& options) {
  const std::string text = value == nullptr ? "" : value;
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string name = text.substr(0, colon);
  const bool is_full = name == "full";
  options.detail = is_full           ? TICKTRUE_DETAIL_FULL
                   : name == "cells" ? TICKTRUE_DETAIL_CELLS
                   : name == "root"  ? TICKTRUE_DETAIL_ROOT
                                     : -1;
  bool is_read = options.detail >= 0;
  options.full_first = options.full_last = 0;
  if (colon < text.size()) {
    const std::string range = text.substr(colon + 1);
    const std::size_t dots = range.find("..");
    const std::string last = dots == std::string::npos ? range : range.substr(dots + 2);
    is_read = is_full && read_number(range.substr(0, dots).c_str(), UINT64_MAX, options.full_first) &&
              read_number(last.c_str(), UINT64_MAX, options.full_last) && options.full_first <= options.full_last &&
              options.full_last > 0;  // 0 means all ticks from full_first on
  }
  if (is_read) return "";
  return "command line: --detail: found " + (text.empty() ? "nothing" : text) +
         " behind it, expected root, cells, full or full:FIRST..LAST";
}

/// Reads the words of the command line into the options. False: the words request no session.
bool read_words(int argc, char* const* argv, bool knows_new_words, ticktrue_options& options, std::string& error) {
  bool is_asked = false, has_detail = false, has_box = false;
  std::uint32_t box_kib = 0;
  std::string run_error;
  for (int i = 1; i < argc && argv != nullptr && argv[i] != nullptr; ++i) {
    const bool is_box = knows_new_words && std::strcmp(argv[i], "--blackbox") == 0;
    const bool record = is_box || std::strcmp(argv[i], "--record") == 0;
    const bool verify = std::strcmp(argv[i], "--verify") == 0;
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    if (std::strcmp(argv[i], "--force") == 0) options.flags |= TICKTRUE_OVERWRITE;
    if (is_box && options.box_kib == 0) options.box_kib = box_kib_default;
    has_box = has_box || is_box;
    if (knows_new_words && std::strcmp(argv[i], "--box-kib") == 0) {
      std::uint64_t size = 0;
      if (!read_number(value, UINT32_MAX, size) || size == 0)
        run_error = "command line: --box-kib: found " + std::string(value == nullptr ? "nothing" : value) +
                    " behind it, expected a number of KiB";
      box_kib = static_cast<std::uint32_t>(size);
      ++i;
    } else if (knows_new_words && std::strcmp(argv[i], "--detail") == 0) {
      has_detail = true;
      if (const std::string wrong = read_detail(value, options); run_error.empty()) run_error = wrong;
      ++i;
    } else if (!record && !verify && options.load != nullptr) {
      if (read_run_word(argv[i], value, options, run_error) > 1) ++i;
    }
    if (!record && !verify) continue;
    if (is_asked) error = "command line: found --record, --blackbox or --verify twice, expected one of them";
    is_asked = true;
    options.mode = record ? TICKTRUE_RECORD : TICKTRUE_VERIFY;
    options.path = value;
    ++i;
    if (value == nullptr) error = std::string("command line: ") + argv[i - 1] + ": found no file name behind it";
  }
  if (box_kib > 0) options.box_kib = box_kib;
  if (is_asked && !has_box) options.box_kib = 0;  // the words request a trace
  // A box has no capacity for ticks in full.
  if (has_box && !has_detail && options.detail == TICKTRUE_DETAIL_FULL) options.detail = TICKTRUE_DETAIL_CELLS;
  if (has_detail && is_asked && options.mode == TICKTRUE_VERIFY && run_error.empty())
    run_error = "command line: --detail: found it with --verify: what a trace holds was decided by its recording";
  if (error.empty() && is_asked) error = run_error;
  return is_asked || options.mode == TICKTRUE_LIVE;
}

}  // namespace

extern "C" {

ticktrue_session* ticktrue_open(const ticktrue_options* given) {
  try {
    ticktrue_options options;
    std::string error;
    read_options(given, options, error);
    return open_session(options, error);
  } catch (...) {
    return &memory_failure;
  }
}

ticktrue_session* ticktrue_open_arguments(const ticktrue_options* given, int argc, char* const* argv) {
  try {
    ticktrue_options options;
    std::string error;
    const bool is_read = read_options(given, options, error);
    // Older programs may use such words themselves.
    const bool knows_new_words = is_read && given->struct_size >= sizeof options;
    std::string words_error;
    if (!read_words(argc, argv, knows_new_words, options, words_error)) return nullptr;
    if (is_read) error = words_error;
    return open_session(options, error);
  } catch (...) {
    return &memory_failure;
  }
}

const void* ticktrue_setup(ticktrue_session* session, size_t* size) {
  if (size != nullptr) *size = 0;
  if (session == nullptr || session->session == nullptr) return nullptr;
  const ticktrue::ByteView setup = session->session->setup();
  if (size != nullptr) *size = setup.size();
  return setup.empty() ? nullptr : setup.data();
}

int ticktrue_build_facts(ticktrue_session* session, const char* unit, const char* facts) {
  return without_exceptions(session, [&](Session& s) { return s.build_facts(unit, facts); });
}
int ticktrue_column(ticktrue_session* session, const char* table, const char* name, const void* data, int type,
                    uint32_t lanes, uint32_t rows, size_t stride) {
  return without_exceptions(session,
                            [&](Session& s) { return s.column(table, name, data, type, lanes, rows, stride); });
}
uint32_t ticktrue_table(ticktrue_session* session, const char* name, size_t stride, const ticktrue_member* members,
                        uint32_t member_count) {
  std::uint32_t number = 0;
  const int status =
      without_exceptions(session, [&](Session& s) { return s.table(name, stride, members, member_count, number); });
  return status == TICKTRUE_OK ? number : TICKTRUE_NO_TABLE;
}
int ticktrue_rows(ticktrue_session* session, uint32_t table, const void* base, uint32_t rows) {
  return without_exceptions(session, [&](Session& s) { return s.rows(table, base, rows); });
}
int ticktrue_child(ticktrue_session* session, const char* table, const char* parent, ticktrue_elements elements,
                   void* user, size_t stride, const ticktrue_member* members, uint32_t member_count) {
  return without_exceptions(session, [&](Session& s) {
    return s.child(table, parent, {ticktrue::TableForm::rows, elements, user, stride}, members, member_count);
  });
}
int ticktrue_text(ticktrue_session* session, const char* table, const char* parent, ticktrue_elements bytes,
                  void* user) {
  return without_exceptions(session, [&](Session& s) {
    return s.child(table, parent, {ticktrue::TableForm::text, bytes, user, 1}, nullptr, 0);
  });
}
int ticktrue_bytes(ticktrue_session* session, const char* table, const char* parent, ticktrue_elements bytes,
                   void* user) {
  return without_exceptions(session, [&](Session& s) {
    return s.child(table, parent, {ticktrue::TableForm::bytes, bytes, user, 1}, nullptr, 0);
  });
}
int ticktrue_key(ticktrue_session* session, const char* table, uint32_t columns) {
  return without_exceptions(session, [&](Session& s) { return s.key(table, columns); });
}
int ticktrue_reference(ticktrue_session* session, const char* table, const char* column, const char* target) {
  return without_exceptions(session, [&](Session& s) { return s.reference(table, column, target); });
}
int ticktrue_row_names(ticktrue_session* session, const char* table, ticktrue_namer namer, void* user) {
  return without_exceptions(session, [&](Session& s) { return s.row_names(table, namer, user); });
}
int ticktrue_add_stage(ticktrue_session* session, const char* name) {
  return without_exceptions(session, [&](Session& s) { return s.add_stage(name); });
}
int ticktrue_stage(ticktrue_session* session, const char* name) {
  return without_exceptions(session, [&](Session& s) { return s.stage(name); });
}
int ticktrue_input(ticktrue_session* session, void* data, size_t size) {
  return without_exceptions(session, [&](Session& s) { return s.input(data, size); });
}
int ticktrue_mark(ticktrue_session* session, const char* name, uint64_t value) {
  // A program may make thousands of marks per tick: most return here.
  if (session != nullptr && session->session != nullptr && session->session->mark_quickly(name, value))
    return TICKTRUE_OK;
  return mark(session, name, value, TICKTRUE_RETURN_ADDRESS());
}
int ticktrue_note(ticktrue_session* session, const char* topic, const char* text) {
  return without_exceptions(session, [&](Session& s) { return s.note(topic, text); });
}
int ticktrue_begin_tick(ticktrue_session* session, double* dt) {
  return without_exceptions(session, [&](Session& s) {
    const int status = s.begin_tick(dt);
    if (status == TICKTRUE_OK) ticktrue::capi::tell_tick_begin(s.tick());
    return status;
  });
}
int ticktrue_end_tick(ticktrue_session* session) {
  return without_exceptions(session, [&](Session& s) {
    const std::uint64_t tick = s.tick();
    const int status = s.end_tick();
    if (status == TICKTRUE_OK) ticktrue::capi::tell_tick_end(tick);
    return status;
  });
}
int ticktrue_rewind(ticktrue_session* session, uint64_t tick) {
  return without_exceptions(session, [&](Session& s) { return s.rewind(tick); });
}
int ticktrue_confirm(ticktrue_session* session, uint64_t tick) {
  return without_exceptions(session, [&](Session& s) { return s.confirm(tick); });
}
int ticktrue_seek(ticktrue_session* session, uint64_t tick) {
  return without_exceptions(session, [&](Session& s) { return s.seek(tick); });
}

int ticktrue_root(ticktrue_session* session, uint64_t tick, uint64_t* root) {
  if (session == nullptr) return TICKTRUE_END;
  return without_exceptions(session, [&](Session& s) { return s.root(tick, root); });
}
size_t ticktrue_hello(ticktrue_session* session, void* buffer, size_t size) {
  std::size_t bytes = 0;
  without_exceptions(session, [&](Session& s) {
    bytes = s.hello(buffer, size);
    return s.status();
  });
  return bytes;
}
int ticktrue_hello_check(ticktrue_session* session, uint32_t peer, const void* bytes, size_t size, char* text,
                         size_t text_size) {
  if (text != nullptr && text_size > 0) text[0] = 0;
  return without_exceptions(session, [&](Session& s) { return s.hello_check(peer, bytes, size, text, text_size); });
}
int ticktrue_peer_root(ticktrue_session* session, uint32_t peer, uint64_t tick, uint64_t root) {
  return without_exceptions(session, [&](Session& s) { return s.peer_root(peer, tick, root); });
}
size_t ticktrue_desync_message(ticktrue_session* session, uint32_t peer, void* buffer, size_t size) {
  std::size_t bytes = 0;
  without_exceptions(session, [&](Session& s) {
    bytes = s.desync_message(peer, buffer, size);
    return s.status();
  });
  return bytes;
}
int ticktrue_desync_receive(ticktrue_session* session, uint32_t peer, const void* bytes, size_t size) {
  return without_exceptions(session, [&](Session& s) { return s.desync_receive(peer, bytes, size); });
}
const char* ticktrue_desync_report(ticktrue_session* session, int* complete) {
  if (complete != nullptr) *complete = 0;
  if (session == nullptr || session->session == nullptr) return "";
  bool is_complete = false;
  const int status = without_exceptions(session, [&](Session& s) {
    session->report = s.desync_report(is_complete);
    return TICKTRUE_OK;
  });
  if (complete != nullptr) *complete = status == TICKTRUE_OK && is_complete ? 1 : 0;
  return status == TICKTRUE_OK ? session->report.c_str() : "";
}

int ticktrue_bundle(ticktrue_session* session, const char* path) {
  return without_exceptions(session, [&](Session& s) { return s.bundle(path); });
}
int ticktrue_box_save(ticktrue_session* session, const char* path) {
  return without_exceptions(session, [&](Session& s) { return s.box_save(path); });
}

uint64_t ticktrue_tick(const ticktrue_session* session) {
  return session == nullptr || session->session == nullptr ? 0 : session->session->tick();
}
int ticktrue_status(const ticktrue_session* session) {
  if (session == nullptr) return TICKTRUE_OK;
  return session->session == nullptr ? TICKTRUE_FAILED : session->session->status();
}
const char* ticktrue_message(const ticktrue_session* session) {
  if (session == nullptr) return "";
  return session->session == nullptr ? no_memory : session->session->last_message().c_str();
}

int ticktrue_finish(ticktrue_session* session) {
  if (session != nullptr && session->session == nullptr) return 2;
  int exit_code = 0;
  const int status = without_exceptions(session, [&](Session& s) {
    const bool is_first = !s.is_finished();
    exit_code = s.finish();
    if (is_first) ticktrue::capi::append_result(s.result_json());
    if (is_first) ticktrue::capi::append_mapped();
    return TICKTRUE_OK;
  });
  return status == TICKTRUE_OK ? exit_code : 2;
}

const char* ticktrue_report(ticktrue_session* session) {
  if (session == nullptr || session->session == nullptr) return "";
  const int status = without_exceptions(session, [&](Session& s) {
    session->report = s.is_finished() ? s.report_text() : "";
    return TICKTRUE_OK;
  });
  return status == TICKTRUE_OK ? session->report.c_str() : "";
}

const char* ticktrue_report_json(ticktrue_session* session) {
  if (session == nullptr || session->session == nullptr) return "";
  const int status = without_exceptions(session, [&](Session& s) {
    session->report = s.is_finished() ? s.report_json() : "";
    return TICKTRUE_OK;
  });
  return status == TICKTRUE_OK ? session->report.c_str() : "";
}

int ticktrue_close(ticktrue_session* session) {
  if (session == nullptr) return 0;
  if (session->session != nullptr && session->session->refuse_in_callback("close")) return 2;
  const InLibrary inside;
  const int exit_code = ticktrue_finish(session);
  const bool is_quiet = session->session != nullptr && session->session->is_quiet();
  const bool is_json = session->session != nullptr && session->session->wants_json();
  if (!is_quiet) {
    std::fputs(is_json ? ticktrue_report_json(session) : ticktrue_report(session), stdout);
    std::fflush(stdout);
    const std::string message = session->session != nullptr ? session->session->message() : no_memory;
    if (!message.empty()) std::fprintf(stderr, "ticktrue: error: %s\n", ticktrue::plain_text(message).c_str());
  }
  if (session != &memory_failure) delete session;
  return exit_code;
}

const char* ticktrue_version(void) {
  return ticktrue::build_info().version.c_str();
}
uint32_t ticktrue_api_version(void) {
  return TICKTRUE_API_VERSION;
}

}  // extern "C"
