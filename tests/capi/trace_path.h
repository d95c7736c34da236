// Paths of traces in a folder that a test has to itself.
// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace ticktrue::test {

/// The folder is removed with all it holds.
class TracePath {
 public:
  TracePath() {
    static int count = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("ticktrue_path_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(folder_);
  }
  TracePath(const TracePath&) = delete;
  ~TracePath() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string operator()(const std::string& name) const { return (folder_ / name).string(); }
  std::string bytes(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace ticktrue::test
