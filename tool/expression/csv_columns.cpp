// Lines of CSV.
// SPDX-License-Identifier: MIT
#include "tool/expression/csv_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ticktrue::tool {
namespace {

constexpr std::size_t column_count_max = 10000;

std::string cell(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

}  // namespace

namespace {

/// Whether body `i` is already the other one of `contacts.*.1.overlap` or `contacts.1.*.overlap`. `star`: of ".*.".
bool is_other_of_contact(const std::string& name, std::size_t star, std::size_t i, const engine::Scene& scene) {
  const std::string part = "contacts";
  if (name.compare(0, part.size(), part) != 0 || i >= scene.bodies.size()) return false;
  const std::string other = star == part.size() ? name.substr(star + 3, name.find('.', star + 3) - star - 3)
                                                : name.substr(part.size() + 1, star - part.size() - 1);
  return other == std::to_string(i) || (!scene.bodies[i].name.empty() && other == scene.bodies[i].name);
}

}  // namespace

Result<CsvColumns> CsvColumns::make(const std::vector<std::string>& names, const engine::Scene& scene,
                                    const std::string& option) {
  CsvColumns columns;
  if (names.empty())
    for (const WorldValueInfo& info : world_values)
      if (info.value != WorldValue::tick && info.value != WorldValue::time) columns.columns_.emplace_back(info.value);
  for (const std::string& name : names) {
    if (name == "tick" || name == "time") continue;  // they are the first two
    const std::size_t star = name.find(".*.");
    if (star == std::string::npos) {
      if (const Status added = columns.add(name, scene, option); !added) return added.error();
      continue;
    }
    const bool is_joint = name.substr(0, star) == "joints";
    const std::size_t count = is_joint ? scene.joints.size() : scene.bodies.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (is_other_of_contact(name, star, i, scene)) continue;
      if (const Status added =
              columns.add(name.substr(0, star + 1) + std::to_string(i) + name.substr(star + 2), scene, option);
          !added)
        return added.error();
    }
  }
  return columns;
}

Status CsvColumns::add(const std::string& name, const engine::Scene& scene, const std::string& option) {
  if (columns_.size() == column_count_max)
    return Error{ErrorCode::usage, fmt::format("{}: found more than {} columns", option, column_count_max), {}};
  const auto world = std::find_if(world_values.begin(), world_values.end(),
                                  [&](const WorldValueInfo& info) { return info.name == name; });
  if (world != world_values.end()) {
    columns_.emplace_back(world->value);
    return {};
  }
  if (std::optional<NamedValue> named = find_named_value(name)) {
    if (const Status exists = check_exists(*named, scene, option); !exists) return exists;
    columns_.emplace_back(*std::move(named));
    return {};
  }
  std::string known;
  for (const WorldValueInfo& info : world_values) known += std::string(info.name) + " ";
  return Error{ErrorCode::usage, option + ": found \"" + name + "\", expected the name of a value",
               known + "; " + named_values_text() + "; * for each body or joint"};
}

std::vector<std::string> CsvColumns::names() const {
  std::vector<std::string> names;
  for (const auto& column : columns_) {
    const auto* world = std::get_if<WorldValue>(&column);
    names.push_back(world != nullptr ? std::string(world_values[static_cast<std::size_t>(*world)].name)
                                     : std::get<NamedValue>(column).name);
  }
  return names;
}

std::vector<double> CsvColumns::values(const engine::Engine& engine) const {
  WorldMeasures measures(engine);
  NamedValues named(engine);
  std::vector<double> values;
  for (const auto& column : columns_) {
    const auto* world = std::get_if<WorldValue>(&column);
    values.push_back(world != nullptr ? measures.of(*world) : named.of(std::get<NamedValue>(column)));
  }
  return values;
}

std::string CsvColumns::head() const {
  std::string text = "tick,time";
  for (const std::string& name : names()) text += "," + name;
  return text + "\n";
}

std::string CsvColumns::row(const engine::Engine& engine, std::uint64_t tick) const {
  std::string text = fmt::format("{},{}", tick, cell(engine.time_s()));
  for (const double value : values(engine)) text += "," + cell(value);
  return text + "\n";
}

}  // namespace ticktrue::tool
