// Helpers for tests of Box2D 3: whether it is there, and folders in place of node and of the package.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "tests/support/catch.h"
#include "tool/box2d3/box2d3_peer.h"

namespace ticktrue::test {

/// An environment variable for as long as this object lives.
class Variable {
 public:
  Variable(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* before = std::getenv(name_.c_str())) before_ = before;
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() {
    if (before_)
      ::setenv(name_.c_str(), before_->c_str(), 1);
    else
      ::unsetenv(name_.c_str());
  }

 private:
  std::string name_;
  std::optional<std::string> before_;
};

/// Whether Box2D 3 can run: where the variable says, or where `./dev setup box2d3` puts it.
inline bool has_box2d3() {
  namespace fs = std::filesystem;
  const fs::path installed = fs::path(TICKTRUE_SOURCE_DIR) / "build" / "box2d3";
  if (std::getenv(tool::box2d3_variable) == nullptr && fs::exists(installed / "node_modules" / "box2d3-wasm"))
    ::setenv(tool::box2d3_variable, installed.c_str(), 1);
  return tool::box2d3_version().has_value();
}

}  // namespace ticktrue::test
