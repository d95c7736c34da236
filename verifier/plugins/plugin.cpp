// Loads plug-ins, checks their data, and calls them.
// SPDX-License-Identifier: MIT
#include "verifier/plugins/plugin.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/hash.h"
#include "base/limits.h"
#include "base/state/declared_members.h"
#include "base/state/gathered_state.h"
#include "base/state/save_calls.h"
#include "include/ticktrue.h"
#include "verifier/runs/plugin_isolation.h"

#ifdef _WIN32
#include <windows.h>

#include <filesystem>
#include <system_error>
#elif !defined(__EMSCRIPTEN__)
#include <dlfcn.h>
#define TICKTRUE_HAS_DLOPEN 1
#endif

/// The target of a plug-in's `columns`.
struct ticktrue_columns {
  ticktrue::GatheredState& state;
  ticktrue::Status failure;
};

/// The target of stage reports in a plug-in's `step`.
struct ticktrue_stages {
  void* simulation;  // ticktrue::verifier::PluginSimulation
  ticktrue::StageObserver* observer;
  std::uint32_t next;  // the next expected stage
};

namespace ticktrue::verifier {
namespace {

constexpr std::size_t text_size_max = 64 * 1024;  // bytes of inputs as text; messages and names are shorter
constexpr std::size_t build_size_max = 4'096;     // bytes; a trace stores no longer fact
static_assert(TICKTRUE_SAVE_FAILED == save_refused);

/// A loaded library. Calls are serialised: plug-ins need not be thread-safe.
struct Plugin {
  std::string path;
  ticktrue_plugin functions{};
  std::string name;
  std::string build;  // may be empty
  std::vector<std::string> stages;
  SimulationInfo info;
  std::recursive_mutex mutex;
};

Error plugin_error(ErrorCode code, const std::string& path, const std::string& what, const std::string& hint = "") {
  return {code, "plug-in " + path + ": " + what, hint};
}

/// A buffer for the text of a plug-in.
class TextBuffer {
 public:
  explicit TextBuffer(std::size_t size) : text_(size, '\0') {}
  char* data() { return text_.data(); }
  std::size_t size() const { return text_.size(); }
  std::string take() {
    text_.back() = '\0';
    return std::string(text_.c_str());
  }

 private:
  std::string text_;
};

int host_column(ticktrue_columns* columns, const char* table, const char* name, void* data, int type,
                std::uint32_t lanes, std::uint32_t rows, std::size_t stride) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_FAILED;
  ColumnSource source;
  source.data = data;
  source.writable = data;
  source.type = static_cast<ScalarType>(type >= 0 && type <= 255 ? type : 0);
  source.lane_count = lanes;
  source.row_count = rows;
  source.stride = stride;
  columns->failure = columns->state.column(bounded_name(table), bounded_name(name), source);
  return columns->failure ? TICKTRUE_OK : TICKTRUE_FAILED;
}

int host_key(ticktrue_columns* columns, const char* table, std::uint32_t key_columns) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_FAILED;
  columns->failure = columns->state.key(bounded_name(table), key_columns);
  return columns->failure ? TICKTRUE_OK : TICKTRUE_FAILED;
}

int host_reference(ticktrue_columns* columns, const char* table, const char* column, const char* target) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_FAILED;
  columns->failure = columns->state.reference(bounded_name(table), bounded_name(column), bounded_name(target));
  return columns->failure ? TICKTRUE_OK : TICKTRUE_FAILED;
}

/// As in a session, without shown columns: a recording of a plug-in has none. Errors: usage.
Result<std::vector<RowMember>> host_members(const char* table, const ticktrue_member* members,
                                            std::uint32_t member_count) {
  const std::string place = "table " + std::string(bounded_name(table)) + ": ";
  Result<std::vector<RowMember>> row = read_members(place, members, member_count);
  if (!row) return row;
  for (const RowMember& member : *row)
    if (member.is_shown)
      return Error{ErrorCode::usage,
                   place + "column " + std::string(member.name) + ": found a shown column, expected a judged one",
                   "traces of plug-ins hold no shown columns"};
  return row;
}

std::uint32_t host_table(ticktrue_columns* columns, const char* name, std::size_t stride,
                         const ticktrue_member* members, std::uint32_t member_count) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_NO_TABLE;
  const Result<std::vector<RowMember>> row = host_members(name, members, member_count);
  const Result<std::size_t> made = row ? columns->state.table(bounded_name(name), stride, *row) : row.error();
  if (!made) columns->failure = made.error();
  return made ? static_cast<std::uint32_t>(*made) : TICKTRUE_NO_TABLE;
}

int host_rows(ticktrue_columns* columns, std::uint32_t table, void* base, std::uint32_t rows) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_FAILED;
  columns->failure = columns->state.rows(table, base, rows, base);
  return columns->failure ? TICKTRUE_OK : TICKTRUE_FAILED;
}

int add_child(ticktrue_columns* columns, const char* table, const char* parent, const ChildSource& source,
              const ticktrue_member* members, std::uint32_t member_count) {
  if (columns == nullptr || !columns->failure) return TICKTRUE_FAILED;
  const Result<std::vector<RowMember>> row = host_members(table, members, member_count);
  columns->failure =
      row ? columns->state.child(bounded_name(table), bounded_name(parent), source, *row) : Status(row.error());
  return columns->failure ? TICKTRUE_OK : TICKTRUE_FAILED;
}

int host_child(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements elements, void* user,
               std::size_t stride, const ticktrue_member* members, std::uint32_t member_count) {
  return add_child(columns, table, parent, {TableForm::rows, elements, user, stride}, members, member_count);
}

int host_text(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements bytes, void* user) {
  return add_child(columns, table, parent, {TableForm::text, bytes, user, 1}, nullptr, 0);
}

int host_bytes(ticktrue_columns* columns, const char* table, const char* parent, ticktrue_elements bytes, void* user) {
  return add_child(columns, table, parent, {TableForm::bytes, bytes, user, 1}, nullptr, 0);
}

void host_stage_done(ticktrue_stages* stages, std::uint32_t stage);

constexpr ticktrue_host host{sizeof(ticktrue_host),
                             TICKTRUE_API_VERSION,
                             host_column,
                             host_key,
                             host_reference,
                             host_stage_done,
                             host_table,
                             host_rows,
                             host_child,
                             host_text,
                             host_bytes};

class PluginSimulation : public Simulation {
 public:
  static Result<std::unique_ptr<Simulation>> make(Plugin& plugin, ByteView setup) {
    auto made = std::make_unique<PluginSimulation>(plugin);
    TextBuffer text(limits::name_size_max);
    {
      const std::lock_guard lock(plugin.mutex);
      const WatchedCall call(PluginCall::create);
      if (plugin.functions.create(&host, setup.data(), setup.size(), &made->simulation_, text.data(), text.size()) != 0)
        return plugin_error(ErrorCode::invalid_scene, plugin.path, "create: refused the setup: " + text.take());
    }
    if (made->simulation_ == nullptr)
      return plugin_error(ErrorCode::invalid_scene, plugin.path, "create: found success and no simulation");
    made->saves_ = SaveCalls(plugin.functions.save, plugin.functions.load, made->simulation_);
    if (const Status status = made->gather(); !status) return status.error();
    return std::unique_ptr<Simulation>(std::move(made));
  }

  explicit PluginSimulation(Plugin& plugin) : plugin_(plugin) {}
  PluginSimulation(const PluginSimulation&) = delete;
  PluginSimulation& operator=(const PluginSimulation&) = delete;
  ~PluginSimulation() override {
    if (simulation_ == nullptr) return;
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::destroy);
    plugin_.functions.destroy(simulation_);
  }

  Status accept(const TickInput& input) const override {
    if (plugin_.functions.accept == nullptr) return {};
    TextBuffer text(limits::name_size_max);
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::accept, tick_);
    if (plugin_.functions.accept(simulation_, input.dt, input.inputs.data(), input.inputs.size(), text.data(),
                                 text.size()) == 0)
      return {};
    return Error{ErrorCode::invalid_input, "tick " + std::to_string(tick_) + ": inputs: refused: " + text.take(), ""};
  }

  Status step(const TickInput& input, StageObserver* observer) override {
    TextBuffer text(limits::name_size_max);
    ticktrue_stages stages{this, observer, 0};
    int failed = 0;
    {
      const std::lock_guard lock(plugin_.mutex);
      const WatchedCall call(PluginCall::step, tick_);
      failed = plugin_.functions.step(simulation_, input.dt, input.inputs.data(), input.inputs.size(), &host, &stages,
                                      text.data(), text.size());
    }
    if (failed != 0) throw PluginFailure(place("step of tick " + std::to_string(tick_) + ": failed: " + text.take()));
    if (stages.next != plugin_.stages.size())
      throw PluginFailure(place("step of tick " + std::to_string(tick_) + ": stages said to be done: found " +
                                std::to_string(stages.next) + ", expected " + std::to_string(plugin_.stages.size()) +
                                " in their order"));
    ++tick_;
    if (const Status status = gather(); !status) throw PluginFailure(status.error().message);
    return {};
  }

  void after_stage(std::uint32_t stage, ticktrue_stages& stages) {
    if (stage != stages.next || stage >= plugin_.stages.size()) {
      stages.next = static_cast<std::uint32_t>(plugin_.stages.size()) + 1;  // reported when step returns
      return;
    }
    ++stages.next;
    if (stages.observer == nullptr) return;
    if (!gather()) return;  // reported when step returns
    stages.observer->after_stage(stage, state_.view());
  }

  const StateView& state() const override { return state_.view(); }

  Status load(ByteView image) override {
    if (plugin_.functions.loaded == nullptr)
      return Error{ErrorCode::unsupported, place("its state can only be observed, not loaded"), ""};
    if (state_.has_children())
      return Error{ErrorCode::unsupported, place("its state has child tables, which `loaded` does not bring back"), ""};
    const Result<std::vector<ImageTable>> tables = check_image(state_.schema(), image);
    if (!tables) return tables.error();
    for (std::size_t t = 0; t < tables->size(); ++t)
      if (const Status status = resize(t, (*tables)[t].row_count); !status) return status;
    if (const Status status = register_columns(); !status) return status;
    for (std::size_t t = 0; t < tables->size(); ++t) {
      if (state_.row_count(t) != (*tables)[t].row_count) return row_count_error(t, (*tables)[t].row_count);
      state_.scatter(t, (*tables)[t]);
    }
    TextBuffer text(limits::name_size_max);
    {
      const std::lock_guard lock(plugin_.mutex);
      const WatchedCall call(PluginCall::loaded);
      if (plugin_.functions.loaded(simulation_, text.data(), text.size()) != 0)
        return Error{ErrorCode::corrupt, place("loaded: refused the state: " + text.take()), ""};
    }
    return gather();
  }

  Result<std::optional<Bytes>> save(std::uint64_t tick) override {
    if (!saves_.is_set()) return Simulation::save(tick);
    const std::uint64_t before = root_hash(state_.view());
    Result<std::optional<Bytes>> saved = [&] {
      const std::lock_guard lock(plugin_.mutex);
      const WatchedCall call(PluginCall::save, tick);
      return saves_.save(tick);
    }();
    if (!saved) return plugin_error(saved.error().code, plugin_.path, saved.error().message, saved.error().hint);
    if (const Status status = gather(); !status) return status.error();
    const std::uint64_t behind = root_hash(state_.view());
    if (behind == before) return saved;
    return plugin_error(ErrorCode::usage, plugin_.path,
                        "save callback: tick " + std::to_string(tick) + ": it changes the state: hash before " +
                            hex64(before) + ", behind it " + hex64(behind),
                        "save writes to the buffer alone");
  }

  Status load_saved(std::uint64_t tick, ByteView save) override {
    if (!saves_.is_set()) return Simulation::load_saved(tick, save);
    tick_ = tick;
    const Status loaded = [&] {
      const std::lock_guard lock(plugin_.mutex);
      const WatchedCall call(PluginCall::load, tick);
      return saves_.load(tick, save);
    }();
    if (!loaded) return plugin_error(loaded.error().code, plugin_.path, loaded.error().message, loaded.error().hint);
    return gather();
  }

  std::span<const std::string> stage_names() const override { return plugin_.stages; }

  std::string row_name(std::size_t table, std::size_t row) const override {
    if (plugin_.functions.row_name == nullptr) return "";
    TextBuffer text(limits::name_size_max);
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::names);
    const int failed = plugin_.functions.row_name(simulation_, state_.schema().tables[table].name.c_str(),
                                                  static_cast<std::uint32_t>(row), text.data(), text.size());
    return failed == 0 ? text.take() : "";
  }

  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    if (plugin_.functions.inputs_text == nullptr || inputs.empty()) return "";
    TextBuffer text(text_size_max);
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::names);
    const int failed =
        plugin_.functions.inputs_text(simulation_, tick, inputs.data(), inputs.size(), text.data(), text.size());
    return failed == 0 ? text.take() : "";
  }

 private:
  std::string place(const std::string& what) const { return "plug-in " + plugin_.path + ": " + what; }

  Status register_columns() {
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::columns, tick_);
    ticktrue_columns columns{state_, {}};
    const int failed = plugin_.functions.columns(simulation_, &host, &columns);
    if (!columns.failure)
      return plugin_error(ErrorCode::usage, plugin_.path, columns.failure.error().message,
                          columns.failure.error().hint);
    if (failed != 0) return plugin_error(ErrorCode::usage, plugin_.path, "columns: failed");
    return {};
  }

  Status gather() {
    if (const Status status = register_columns(); !status) return status;
    if (!state_.is_frozen())
      if (const Status status = state_.freeze(); !status)
        return plugin_error(ErrorCode::usage, plugin_.path, status.error().message, status.error().hint);
    const Status status = [&] {
      if (!state_.has_children()) return state_.gather();
      const std::lock_guard lock(plugin_.mutex);
      const WatchedCall call(PluginCall::elements, tick_);
      return state_.gather();
    }();
    return status ? status
                  : plugin_error(status.error().code, plugin_.path, status.error().message, status.error().hint);
  }

  Error row_count_error(std::size_t table, std::uint32_t wanted) const {
    return plugin_error(ErrorCode::corrupt, plugin_.path,
                        "load: table " + state_.schema().tables[table].name + ": rows: found " +
                            std::to_string(state_.row_count(table)) + ", expected " + std::to_string(wanted),
                        "a state with other row counts needs `resize`");
  }

  Status resize(std::size_t table, std::uint32_t rows) {
    if (state_.row_count(table) == rows) return {};
    if (plugin_.functions.resize == nullptr) return row_count_error(table, rows);
    const std::lock_guard lock(plugin_.mutex);
    const WatchedCall call(PluginCall::resize);
    if (plugin_.functions.resize(simulation_, state_.schema().tables[table].name.c_str(), rows) == 0) return {};
    return row_count_error(table, rows);
  }

  Plugin& plugin_;
  void* simulation_ = nullptr;
  SaveCalls saves_;  // empty: the plug-in has none
  GatheredState state_;
  std::uint64_t tick_ = 0;  // number of ticks since it was made; after load_saved, number of ticks of the loaded state
};

void host_stage_done(ticktrue_stages* stages, std::uint32_t stage) {
  if (stages != nullptr) static_cast<PluginSimulation*>(stages->simulation)->after_stage(stage, *stages);
}

std::vector<std::unique_ptr<Plugin>>& plugins() {
  static std::vector<std::unique_ptr<Plugin>> list;
  return list;
}

std::vector<const SimulationInfo*>& plugin_infos() {
  static std::vector<const SimulationInfo*> list;
  return list;
}

struct Entry {
  ticktrue_plugin_entry_function call = nullptr;
};

Error no_entry_error(const std::string& path) {
  return plugin_error(ErrorCode::io, path, "found no function ticktrue_plugin_entry",
                      "declare it with TICKTRUE_PLUGIN_API, and extern \"C\" in C++");
}

#if defined(TICKTRUE_HAS_DLOPEN)
Result<Entry> find_entry(const std::string& path) {
  // The system would search its own folders for a name without a slash.
  const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return plugin_error(ErrorCode::io, path, std::string("cannot be loaded: ") + (reason != nullptr ? reason : "?"));
  }
  void* entry = dlsym(library, "ticktrue_plugin_entry");
  if (entry == nullptr) return no_entry_error(path);
  return Entry{reinterpret_cast<ticktrue_plugin_entry_function>(entry)};
}
#elif defined(_WIN32)
Result<Entry> find_entry(const std::string& path) {
  // An absolute path: the system then also searches the plug-in's dependencies beside it.
  std::error_code failure;
  const std::filesystem::path file = std::filesystem::absolute(path, failure);
  const HMODULE library = ::LoadLibraryExW(file.c_str(), nullptr, LOAD_WITH_ALTERED_SEARCH_PATH);
  if (library == nullptr) {
    const std::error_code code(static_cast<int>(::GetLastError()), std::system_category());
    return plugin_error(ErrorCode::io, path, "cannot be loaded: " + code.message());
  }
  const FARPROC entry = ::GetProcAddress(library, "ticktrue_plugin_entry");
  if (entry == nullptr) return no_entry_error(path);
  return Entry{reinterpret_cast<ticktrue_plugin_entry_function>(reinterpret_cast<void*>(entry))};
}
#else
Result<Entry> find_entry(const std::string& path) {
  return plugin_error(ErrorCode::io, path, "this system loads no plug-ins");
}
#endif

/// Copies the plug-in's description, up to the size that both it and this build know.
Status read_plugin(const ticktrue_plugin& given, Plugin& plugin) {
  constexpr std::size_t size_min = offsetof(ticktrue_plugin, inputs_text) + sizeof(void*);
  if (given.struct_size < size_min || given.struct_size > 4096)
    return plugin_error(ErrorCode::incompatible, plugin.path,
                        "struct_size: found " + std::to_string(given.struct_size) +
                            ", expected sizeof(ticktrue_plugin), " + std::to_string(sizeof(ticktrue_plugin)));
  std::memcpy(&plugin.functions, &given, std::min(given.struct_size, sizeof given));
  const ticktrue_plugin& functions = plugin.functions;
  if (functions.api_version == 0 || functions.api_version > TICKTRUE_API_VERSION)
    return plugin_error(ErrorCode::incompatible, plugin.path,
                        "interface version: found " + std::to_string(functions.api_version) + ", expected 1.." +
                            std::to_string(TICKTRUE_API_VERSION),
                        "use a newer ticktrue, or build the plug-in with this one's header");
  plugin.name = std::string(bounded_name(functions.name));
  if (const Status status = check_name("name", plugin.name); !status)
    return plugin_error(ErrorCode::usage, plugin.path, status.error().message);
  if (functions.flags != 0)
    return plugin_error(ErrorCode::usage, plugin.path,
                        "flags: found " + std::to_string(functions.flags) + ", expected 0");
  if (functions.create == nullptr || functions.destroy == nullptr || functions.columns == nullptr ||
      functions.step == nullptr)
    return plugin_error(ErrorCode::usage, plugin.path,
                        "found a null function, expected create, destroy, columns and step");
  if ((functions.save == nullptr) != (functions.load == nullptr))
    return plugin_error(
        ErrorCode::usage, plugin.path,
        std::string(functions.save == nullptr ? "load: found it without save" : "save: found it without load") +
            ", expected both or none",
        "load takes the bytes that save gave");
  if (functions.build != nullptr) {
    plugin.build = std::string(functions.build, strnlen(functions.build, build_size_max + 1));
    if (plugin.build.size() > build_size_max)
      return plugin_error(ErrorCode::usage, plugin.path,
                          "build: found more than " + std::to_string(build_size_max) + " bytes, expected a text");
  }
  if (functions.stage_count > limits::stage_count_max || (functions.stage_count > 0 && functions.stages == nullptr))
    return plugin_error(ErrorCode::usage, plugin.path,
                        "stages: found " + std::to_string(functions.stage_count) + ", expected at most " +
                            std::to_string(limits::stage_count_max) + " and their names");
  for (std::uint32_t i = 0; i < functions.stage_count; ++i) {
    plugin.stages.emplace_back(bounded_name(functions.stages[i]));
    if (const Status status = check_name("stage " + std::to_string(i), plugin.stages.back()); !status)
      return plugin_error(ErrorCode::usage, plugin.path, status.error().message);
  }
  return {};
}

}  // namespace

bool can_load_plugins() {
#if defined(TICKTRUE_HAS_DLOPEN) || defined(_WIN32)
  return true;
#else
  return false;
#endif
}

Status load_plugin(const std::string& path, const std::function<bool(std::string_view)>& is_taken) {
  auto plugin = std::make_unique<Plugin>();
  plugin->path = path;
  const ticktrue_plugin* given = nullptr;
  {
    const WatchedCall call(PluginCall::open);
    const Result<Entry> entry = find_entry(path);
    if (!entry) return entry.error();
    given = entry->call(TICKTRUE_API_VERSION);
  }
  if (given == nullptr)
    return plugin_error(ErrorCode::incompatible, path,
                        "it does not work with interface version " + std::to_string(TICKTRUE_API_VERSION),
                        "use a newer ticktrue");
  if (const Status status = read_plugin(*given, *plugin); !status) return status;
  if (is_taken(plugin->name))
    return plugin_error(ErrorCode::usage, path,
                        "simulation " + plugin->name + ": found another one of this name, expected one of each");
  Plugin* loaded = plugin.get();
  loaded->info.name = loaded->name;
  loaded->info.physics_version = loaded->functions.version;
  loaded->info.has_saves = loaded->functions.save != nullptr;
  loaded->info.make = [loaded](ByteView setup) { return PluginSimulation::make(*loaded, setup); };
  plugin_infos().push_back(&loaded->info);
  plugins().push_back(std::move(plugin));
  return {};
}

std::span<const SimulationInfo* const> plugin_simulations() {
  return plugin_infos();
}

std::string plugin_path(std::string_view simulation) {
  for (const std::unique_ptr<Plugin>& plugin : plugins())
    if (plugin->name == simulation) return plugin->path;
  return "";
}

std::vector<std::pair<std::string, std::string>> plugin_facts(std::string_view simulation) {
  for (const std::unique_ptr<Plugin>& plugin : plugins()) {
    if (plugin->name != simulation) continue;
    std::vector<std::pair<std::string, std::string>> facts{{"plugin.path", plugin->path}};
    if (!plugin->build.empty()) facts.emplace_back("plugin.build", plugin->build);
    return facts;
  }
  return {};
}

}  // namespace ticktrue::verifier
