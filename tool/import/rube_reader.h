// Reads the values of a R.U.B.E. file: checks each value, stores the first error, and notes keys that are not imported.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// A JSON value and its path.
struct RubePlace {
  const nlohmann::json* value;
  std::string path;

  bool has(const char* key) const { return value->contains(key); }
  RubePlace at(const char* key) const { return {&value->at(key), path.empty() ? key : path + "." + key}; }
  RubePlace at(std::size_t index) const { return {&value->at(index), path + "[" + std::to_string(index) + "]"}; }
};

/// An invalid value stops the import: the reading functions store the first error, and then return zeros.
class RubeReader {
 public:
  using UsedKeys = std::set<std::pair<const nlohmann::json*, std::string>>;

  /// `source` begins messages and outlives this object.
  explicit RubeReader(const std::string& source) : source_(source) {}

  bool has_failed() const { return error_.has_value(); }
  const std::optional<Error>& error() const { return error_; }
  void refuse(const RubePlace& at, const std::string& expected);
  void fail(ErrorCode code, const RubePlace& at, const std::string& what);

  void note(std::string text);
  /// At most rube_note_count_max notes. The last one counts further notes.
  std::vector<std::string> take_notes();

  // ---- Values. A missing key gives `missing`, or zero. ----

  double number(const RubePlace& object, const char* key, double missing = 0);
  bool flag(const RubePlace& object, const char* key, bool missing = false);
  /// An integer within limits.
  std::int64_t whole(const RubePlace& object, const char* key, std::int64_t min, std::int64_t max,
                     std::int64_t missing);
  engine::Point point(const RubePlace& object, const char* key);
  std::string text(const RubePlace& object, const char* key);
  std::size_t list_size(const RubePlace& object, const char* key, std::size_t count_max);
  /// The vertices of a shape.
  std::vector<engine::Point> points(const RubePlace& shape, std::size_t count_max);
  /// The name of a body or joint. Stores an error if the value is not an object.
  std::string name_of(const RubePlace& at);
  /// `joint[3] "wheel"`, for notes.
  static std::string label(const RubePlace& at);

  // ---- Keys that were not read ----

  void use(const RubePlace& object, const char* key) { used_.insert({object.value, key}); }
  /// Counts each key of an object that no function has read, and forgets the keys that were read.
  void count_ignored(const RubePlace& object, const std::string& kind);
  /// Adds a note for each kind of ignored key.
  void note_ignored_keys();
  /// Exchanges the keys that were read: objects inside another object are counted separately.
  UsedKeys exchange_used(UsedKeys used) { return std::exchange(used_, std::move(used)); }

 private:
  double to_number(const RubePlace& at);
  engine::Point to_point(const RubePlace& at);

  const std::string& source_;
  std::vector<std::string> notes_;
  std::size_t note_count_ = 0;
  UsedKeys used_;
  std::map<std::string, std::size_t> ignored_;
  std::optional<Error> error_;
};

/// Makes names unique: "wheel", "wheel#2", "wheel#3".
class RubeNames {
 public:
  void reserve(const std::string& name) { given_by_file_.insert(name); }
  std::string take(const std::string& name) {
    if (name.empty() || taken_.insert(name).second) return name;
    std::size_t& count = counts_.emplace(name, 1).first->second;
    std::string unique;
    do {
      unique = name + "#" + std::to_string(++count);
    } while (given_by_file_.count(unique) > 0 || !taken_.insert(unique).second);
    return unique;
  }

 private:
  std::set<std::string> given_by_file_;
  std::set<std::string> taken_;
  std::map<std::string, std::size_t> counts_;
};

/// The point turned about the origin, rad.
engine::Point rotated_point(double angle, const engine::Point& p);

}  // namespace ticktrue::tool
