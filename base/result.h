// Result<T> and Status: the result of an operation that can fail, without exceptions.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "base/assert.h"

namespace ticktrue {

/// The reason of a failure. The tool maps each code to an exit code (verifier/report/exit_codes.h).
enum class ErrorCode : std::uint8_t {
  io,             // the operating system refused: missing file, disk full, no permission
  usage,          // the caller asked for something that does not exist
  invalid_scene,  // a scene breaks a rule of the schema or of physics
  invalid_input,  // an input event breaks a rule
  corrupt,        // the bytes differ from those written
  truncated,      // the bytes end too early
  incompatible,   // valid, but of another physics version, schema, precision or format
  unsupported,    // valid, but this build or simulation cannot do it
  limit,          // a limit of base/limits.h would be exceeded
  inconsistent,   // an internal check failed: the same work, done in two ways, gave two results
};

/// A failed operation: its code, and one line `place: what is wrong: found, expected`, with an optional second line
/// that names the next step.
struct Error {
  ErrorCode code;
  std::string message;
  std::string hint;  // next step, without indentation; may be empty
};

/// A value or an Error. A subset of C++23's std::expected.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  bool has_value() const { return content_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  /// Requires: has_value().
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T operator*() && { return std::move(value()); }  // by value: `for (x : *f())` must not dangle
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& value() {
    TICKTRUE_ASSERT(has_value());
    return *std::get_if<0>(&content_);
  }
  const T& value() const {
    TICKTRUE_ASSERT(has_value());
    return *std::get_if<0>(&content_);
  }

  /// Requires: !has_value().
  const Error& error() const {
    TICKTRUE_ASSERT(!has_value());
    return *std::get_if<1>(&content_);
  }

 private:
  std::variant<T, Error> content_;
};

/// Success, or an Error.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)), failed_(true) {}

  bool has_value() const { return !failed_; }
  explicit operator bool() const { return !failed_; }
  /// Requires: !has_value().
  const Error& error() const {
    TICKTRUE_ASSERT(failed_);
    return error_;
  }

 private:
  Error error_{};
  bool failed_ = false;
};

}  // namespace ticktrue
