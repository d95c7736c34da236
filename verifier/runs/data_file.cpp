// Writes output files: new ones exclusively, or beside the file that they replace. Each write, flush and close is
// checked.
// SPDX-License-Identifier: MIT
#include "verifier/runs/data_file.h"

#include <fcntl.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "replay/file/file_calls.h"

namespace ticktrue::verifier {
namespace {

Error exists_error(const std::string& path) {
  return Error{ErrorCode::io, path + ": cannot create: found an existing file, expected none",
               "give another name, or --force to replace it"};
}

}  // namespace

std::string system_message(int error_number) {
  return std::generic_category().message(error_number);
}

Status write_data_file(const std::string& path, std::string_view text, bool overwrite) {
  Result<DataFile> file = DataFile::create(path, overwrite);
  if (!file) return file.error();
  if (const Status written = file->write(text); !written) return written;
  return file->close();
}

Status check_writable_target(const std::string& path, bool overwrite) {
  namespace fs = std::filesystem;
  std::error_code code;
  const fs::file_status status = fs::status(replay::system_path(path), code);
  if (fs::is_directory(status))
    return Error{ErrorCode::io, path + ": cannot write: found a directory, expected a file name", ""};
  if (fs::exists(status)) {
    if (!overwrite) return exists_error(path);
    return {};
  }
  const fs::path folder = replay::system_path(path).parent_path();
  if (folder.empty() || fs::is_directory(folder, code)) return {};
  const std::u8string name = folder.u8string();
  return Error{ErrorCode::io, path + ": cannot create: found no directory " + std::string(name.begin(), name.end()),
               ""};
}

Status check_not_read(const std::string& output, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    std::error_code code;
    if (std::filesystem::equivalent(replay::system_path(output), replay::system_path(input), code))
      return Error{ErrorCode::io, output + ": cannot write: it is what the command reads", "give another name"};
  }
  return {};
}

Result<DataFile> DataFile::create(const std::string& path, bool overwrite) {
  namespace fs = std::filesystem;
  if (const Status target = check_writable_target(path, overwrite); !target) return target.error();
  DataFile file;
  file.path_ = path;
  std::error_code code;
  const fs::file_status status = fs::status(replay::system_path(path), code);
  // A link stays; the file that it points to is replaced.
  if (fs::is_symlink(fs::symlink_status(replay::system_path(path), code)) && fs::is_regular_file(status))
    file.path_ = fs::canonical(replay::system_path(path), code).string();
  file.new_path_ = file.path_;
  int flags = O_EXCL;  // fails if the file exists by now
  if (fs::exists(status)) {
    flags = O_TRUNC;
    file.removable_ = fs::is_regular_file(status);
    if (file.removable_) file.new_path_ = file.path_ + ".ticktrue-new";
  }
  const int descriptor = replay::open_file(file.new_path_, O_WRONLY | O_CREAT | flags);
  if (descriptor >= 0) file.file_ = ::fdopen(descriptor, "wb");
  if (file.file_ == nullptr) {
    const int error_number = errno;
    file.removable_ = false;
    if (error_number == EEXIST) return exists_error(path);
    return Error{ErrorCode::io, path + ": cannot create: " + system_message(error_number), ""};
  }
  return file;
}

DataFile::DataFile(DataFile&& other) noexcept
    : file_(std::exchange(other.file_, nullptr)),
      path_(std::move(other.path_)),
      new_path_(std::move(other.new_path_)),
      removable_(other.removable_) {}

DataFile::~DataFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  remove_new();
}

void DataFile::remove_new() const {
  std::error_code ignored;
  if (removable_) std::filesystem::remove(replay::system_path(new_path_), ignored);
}

Error DataFile::failure(int error_number) const {
  return Error{ErrorCode::io, path_ + ": cannot write: " + system_message(error_number),
               removable_ ? "nothing was left behind" : ""};
}

Status DataFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) return failure(errno);
  return {};
}

Status DataFile::close() {
  if (std::fflush(file_) != 0) return failure(errno);
  std::FILE* closing = std::exchange(file_, nullptr);
  if (std::fclose(closing) != 0) {
    const int error_number = errno;
    remove_new();
    return failure(error_number);
  }
  if (new_path_ == path_) return {};
  std::error_code code;
  std::filesystem::rename(replay::system_path(new_path_), replay::system_path(path_), code);
  if (!code) return {};
  remove_new();
  return failure(code.default_error_condition().value());
}

}  // namespace ticktrue::verifier
