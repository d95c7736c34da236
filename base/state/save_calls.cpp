// Calls save and load of a program or plug-in. A write behind the buffer, a wrong result and exceptions are errors.
// SPDX-License-Identifier: MIT
#include "base/state/save_calls.h"

#include <algorithm>
#include <exception>
#include <string>

#include "base/limits.h"

namespace ticktrue {
namespace {

constexpr std::size_t guard_size = 4'096;  // bytes behind the buffer: a save that writes too much hits them first
constexpr std::uint8_t guard_value = 0xa5;
constexpr int size_try_count_max = 4;

Error fault(const char* callback, std::uint64_t tick, const std::string& what, const std::string& hint) {
  return {ErrorCode::usage, std::string(callback) + " callback: tick " + std::to_string(tick) + ": " + what, hint};
}

std::string exception_text() {
  try {
    throw;
  } catch (const std::exception& exception) {
    return std::string("found an exception that left it: ") + exception.what();
  } catch (...) {
    return "found an exception that left it";
  }
}

constexpr const char* exception_hint = "catch it inside: no exception may pass the C interface";

}  // namespace

Result<std::size_t> SaveCalls::call_save(std::uint64_t tick, Bytes& buffer, std::size_t size) {
  buffer.assign(size + guard_size, 0);
  std::fill(buffer.begin() + static_cast<std::ptrdiff_t>(size), buffer.end(), guard_value);
  std::size_t returned = 0;
  try {
    returned = save_(user_, buffer.data(), size);
  } catch (...) {
    return fault("save", tick, exception_text(), exception_hint);
  }
  const auto guard = buffer.begin() + static_cast<std::ptrdiff_t>(size);
  if (std::any_of(guard, buffer.end(), [](std::uint8_t byte) { return byte != guard_value; }))
    return fault("save", tick, "found bytes written behind its buffer of " + std::to_string(size) + " bytes",
                 "write at most `size` bytes, and return how many there are: it is called again with room for them");
  return returned;
}

Result<std::optional<Bytes>> SaveCalls::save(std::uint64_t tick) {
  std::size_t size = usual_size_;
  Bytes buffer;
  for (int i = 0; i < size_try_count_max; ++i) {
    const Result<std::size_t> returned = call_save(tick, buffer, size);
    if (!returned) return returned.error();
    if (*returned == save_refused) return std::optional<Bytes>();
    if (*returned == 0)
      return fault("save", tick, "found 0 bytes, expected at least 1",
                   "return how many bytes there are; TICKTRUE_SAVE_FAILED says that there is no save now");
    if (*returned > limits::save_size_max)
      return Error{ErrorCode::limit,
                   "save callback: tick " + std::to_string(tick) + ": bytes: found " + std::to_string(*returned) +
                       ", expected at most " + std::to_string(limits::save_size_max),
                   "return how many bytes there are, not an error code"};
    if (*returned <= size) {
      buffer.resize(*returned);
      usual_size_ = std::max(usual_size_, *returned);
      return std::optional<Bytes>(std::move(buffer));
    }
    size = *returned;
  }
  return fault("save", tick, "found more bytes than it had asked for, " + std::to_string(size_try_count_max) + " times",
               "one state has one size: return the same number in each call");
}

Status SaveCalls::load(std::uint64_t tick, ByteView bytes) {
  // A copy: the program may write to what it is given.
  Bytes copy(bytes.begin(), bytes.end());
  int returned = 0;
  try {
    returned = load_(user_, copy.data(), copy.size());
  } catch (...) {
    return fault("load", tick, exception_text(), exception_hint);
  }
  if (returned == 0) return {};
  return fault(
      "load", tick,
      "returned " + std::to_string(returned) + " for a save of " + std::to_string(bytes.size()) + " bytes, expected 0",
      "it must take every save that the save callback of this version gave");
}

}  // namespace ticktrue
