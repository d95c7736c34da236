// Makes temporary files that get their name by link or rename.
// SPDX-License-Identifier: MIT
//
// Verified: two publishers of one name, a file system without hard links, a full disk. Not verified: servers that break
// the rules of NFS, for example by a rename that is not atomic.
#include "verifier/store/store_folder.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "replay/file/file_calls.h"
#ifdef _WIN32
#include <process.h>
#else
#include <unistd.h>
#endif

namespace ticktrue::verifier {
namespace {

namespace fs = std::filesystem;

constexpr const char* marker_name = "ticktrue-store";
constexpr std::string_view marker_text = "ticktrue store 1\n";
constexpr auto temporary_age_max = std::chrono::hours(48);  // for files of ended processes

ByteView view_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Error failure_of(const std::string& path, const std::string& action, const std::error_code& code) {
  return replay::io_error(path, action, code);
}

std::string host_name() {
#if defined(_WIN32) || defined(__EMSCRIPTEN__)
  return "host";
#else
  constexpr std::size_t host_name_size_max = 255;
  std::array<char, host_name_size_max + 1> name{};
  if (::gethostname(name.data(), host_name_size_max) != 0) return "host";
  std::string text;
  for (const char c : std::string(name.data()))
    text += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ? c : '-';
  return text.empty() ? "host" : text;
#endif
}

std::string new_owner() {
  std::random_device source;
  const std::uint64_t number = (std::uint64_t{source()} << 32) | source();
#ifdef _WIN32
  const auto id = static_cast<long>(::_getpid());
#else
  const auto id = static_cast<long>(::getpid());
#endif
  return host_name() + "-" + std::to_string(id) + "-" + hex64(number);
}

/// A descriptor that the destructor closes.
class OpenFile {
 public:
  OpenFile(const std::string& path, int flags) : descriptor_(replay::open_file(path, flags)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) replay::close_file(descriptor_);
  }
  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  bool close() { return replay::close_file(std::exchange(descriptor_, -1)) == 0; }

 private:
  int descriptor_;
};

bool write_all(int descriptor, ByteView bytes) {
  while (!bytes.empty()) {
    const std::int64_t done = replay::write_some(descriptor, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
  return true;
}

/// Calls rename or link, and makes the folder of the new name if it is missing.
template <typename Call>
std::error_code with_folder(const fs::path& target, const Call& call) {
  std::error_code failure;
  call(failure);
  if (failure != std::errc::no_such_file_or_directory) return failure;
  std::error_code made;
  fs::create_directories(target.parent_path(), made);
  if (made) return made;
  failure.clear();
  call(failure);
  return failure;
}

/// Whether another process is about to write the marker of this store.
bool is_being_made(const std::string& path) {
  std::error_code failure;
  for (fs::directory_iterator at(path, failure), end; !failure && at != end; at.increment(failure))
    if (at->path().filename() != "tmp") return false;
  return !failure;
}

/// Whether the file has two names. Then the link of a publisher succeeded, whatever its call returned.
bool has_two_names(const std::string& path) {
  std::error_code failure;
  return fs::hard_link_count(path, failure) == 2 && !failure;
}

}  // namespace

std::string spread_name(const std::string& name) {
  constexpr std::size_t head = 2;
  return name.substr(0, head) + "/" + name.substr(head);
}

StoreFolder::StoreFolder(std::string path, bool syncs) : path_(std::move(path)), syncs_(syncs), owner_(new_owner()) {}

Result<StoreFolder> StoreFolder::open(const std::string& path, Use use, bool syncs) {
  StoreFolder folder(path, syncs);
  if (const Status status = folder.prepare(use); !status) return status.error();
  return folder;
}

StoreFolder StoreFolder::unsynced() const {
  StoreFolder folder = *this;
  folder.syncs_ = false;
  return folder;
}

Status StoreFolder::prepare(Use use) const {
  std::error_code failure;
  const bool is_folder = fs::is_directory(path_, failure);
  const std::string expected = ": not a store of verdicts: expected a folder with the file ";
  if (use == Use::reading || (is_folder && !fs::is_empty(path_, failure))) {
    if (!exists(marker_name)) {
      // The marker is written first: a process that has made other files since the first look wrote the marker before
      // them.
      if (use == Use::reading || (!is_being_made(path_) && !exists(marker_name)))
        return Error{use == Use::reading ? ErrorCode::io : ErrorCode::usage, path_ + expected + marker_name,
                     "the option --cache makes a store where there is no folder, or an empty one"};
    } else {
      const Result<std::optional<Bytes>> marker = read(marker_name, marker_text.size());
      if (!marker) return marker.error();
      if (!*marker || !std::equal(marker_text.begin(), marker_text.end(), (*marker)->begin(), (*marker)->end()))
        return Error{ErrorCode::incompatible,
                     path_of(marker_name) + ": found another version, expected " +
                         std::string(marker_text.substr(0, marker_text.size() - 1)),
                     "use another store, or the version of ticktrue that made it"};
    }
  }
  if (use == Use::reading) return {};
  fs::create_directories(path_of("tmp"), failure);
  if (failure) return failure_of(path_of("tmp"), "cannot be made", failure);
  // A store on a full disk can still be read.
  if (!exists(marker_name))
    if (const Result<Publish> marker = publish(marker_name, view_of(marker_text)); !marker) return marker.error();
  remove_old_temporaries();
  return {};
}

/// Removes temporary files of processes that ended early. Their age is measured by a new file on the same file system.
void StoreFolder::remove_old_temporaries() const {
  const std::string fresh = temporary_name();
  if (!write_temporary(fresh, {})) return;
  std::error_code failure;
  const fs::file_time_type now = fs::last_write_time(fresh, failure);
  fs::remove(fresh, failure);
  if (failure) return;
  for (fs::directory_iterator at(path_of("tmp"), failure), end; !failure && at != end; at.increment(failure)) {
    std::error_code ignored;
    const fs::file_time_type written = at->last_write_time(ignored);
    if (!ignored && now - written > temporary_age_max) fs::remove(at->path(), ignored);
  }
}

std::string StoreFolder::temporary_name() const {
  static std::atomic<std::uint64_t> count{0};
  return path_of("tmp/" + owner_ + "-" + std::to_string(count++));
}

Status StoreFolder::write_temporary(const std::string& path, ByteView bytes) const {
  OpenFile file(path, O_WRONLY | O_CREAT | O_EXCL);
  if (!file.is_open()) return replay::io_error(path, "cannot create", errno);
  const bool is_written = write_all(file.descriptor(), bytes) && (!syncs_ || replay::sync_file(file.descriptor()) == 0);
  const int why = errno;
  if (is_written && file.close()) return {};
  const Error error = replay::io_error(path, "cannot write", is_written ? errno : why);
  std::error_code ignored;
  fs::remove(path, ignored);
  return error;
}

Result<StoreFolder::Publish> StoreFolder::publish(const std::string& name, ByteView bytes) const {
  const std::string from = temporary_name();
  if (const Status status = write_temporary(from, bytes); !status) return status.error();
  const std::string to = path_of(name);
  std::error_code failure = with_folder(to, [&](std::error_code& code) { fs::create_hard_link(from, to, code); });
  if (failure && has_two_names(from)) failure.clear();
  std::error_code ignored;
  fs::remove(from, ignored);
  if (!failure) return Publish::created;
  if (failure == std::errc::file_exists) return Publish::exists;
  Error error = failure_of(to, "cannot be linked", failure);
  if (failure == std::errc::operation_not_permitted || failure == std::errc::operation_not_supported ||
      failure == std::errc::function_not_supported)
    error = Error{ErrorCode::unsupported, path_ + ": the file system has no hard links, which a store needs",
                  "put the store on another file system, such as ext4, xfs or NFS"};
  return error;
}

Status StoreFolder::replace(const std::string& name, ByteView bytes) const {
  const std::string from = temporary_name();
  if (const Status status = write_temporary(from, bytes); !status) return status.error();
  const std::string to = path_of(name);
  const std::error_code failure = with_folder(to, [&](std::error_code& code) { fs::rename(from, to, code); });
  if (!failure) return {};
  std::error_code ignored;
  fs::remove(from, ignored);
  return failure_of(to, "cannot be renamed to", failure);
}

Result<std::optional<Bytes>> StoreFolder::read(const std::string& name, std::size_t size_max) const {
  const std::string path = path_of(name);
  const OpenFile file(path, O_RDONLY);
  if (!file.is_open()) {
    if (errno == ENOENT || errno == ENOTDIR) return std::optional<Bytes>();
    return replay::io_error(path, "cannot open", errno);
  }
  const std::optional<replay::FileFacts> facts = replay::file_facts(file.descriptor());
  if (!facts) return replay::io_error(path, "cannot be read", errno);
  if (facts->size > size_max)
    return Error{
        ErrorCode::limit,
        path + ": size: found " + std::to_string(facts->size) + " bytes, expected at most " + std::to_string(size_max),
        ""};
  Bytes bytes(static_cast<std::size_t>(facts->size));
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const std::int64_t got = replay::read_some(file.descriptor(), bytes.data() + filled, bytes.size() - filled, filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return replay::io_error(path, "cannot be read", errno);
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  bytes.resize(filled);
  return std::optional<Bytes>(std::move(bytes));
}

Result<std::string> StoreFolder::set_aside(const std::string& name) const {
  static std::atomic<std::uint64_t> count{0};
  std::string flat = name;
  for (char& c : flat)
    if (c == '/') c = '_';
  const std::string aside = "damaged/" + flat + "-" + owner_ + "-" + std::to_string(count++);
  const std::string from = path_of(name), to = path_of(aside);
  const std::error_code failure = with_folder(to, [&](std::error_code& code) { fs::rename(from, to, code); });
  if (!failure) return aside;
  if (!exists(name)) return std::string();
  return failure_of(from, "cannot be set aside", failure);
}

void StoreFolder::put_back(const std::string& aside, const std::string& name) const {
  std::error_code failure;
  fs::create_hard_link(path_of(aside), path_of(name), failure);
  if (!failure) fs::remove(path_of(aside), failure);
}

void StoreFolder::remove(const std::string& name) const {
  std::error_code ignored;
  fs::remove(path_of(name), ignored);
}

bool StoreFolder::exists(const std::string& name) const {
  std::error_code failure;
  return fs::exists(path_of(name), failure);
}

std::vector<std::string> StoreFolder::list(const std::string& name) const {
  std::vector<std::string> names;
  std::error_code failure;
  for (fs::directory_iterator at(path_of(name), failure), end; !failure && at != end; at.increment(failure))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace ticktrue::verifier
