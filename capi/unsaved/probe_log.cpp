// Writes the findings as JSON, for `ticktrue unsaved`: addresses are modules and offsets.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "capi/unsaved/probe.h"

namespace ticktrue::capi {

#ifdef __linux__
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* owner_names[] = {"variable", "module", "thread", "stack", "generator", "block"};

Json place(std::uint64_t address, const std::vector<LoadedModule>& modules) {
  const LoadedModule* nearest = nullptr;
  for (const LoadedModule& module : modules)
    if (module.base <= address && address < module.end && (nearest == nullptr || module.base > nearest->base))
      nearest = &module;
  if (nearest == nullptr) return {{"module", ""}, {"offset", address}, {"base", 0}};
  return {{"module", nearest->path}, {"offset", address - nearest->base}, {"base", nearest->base}};
}

Json unit_json(const Unit& unit, const std::vector<LoadedModule>& modules) {
  const Piece& first = unit.pieces.front();
  const Piece& last = unit.pieces.back();
  Json json{{"owner", owner_names[static_cast<std::size_t>(unit.owner)]},
            {"name", unit.name},
            {"size", unit.size},
            {"first", first.address - unit.begin},
            {"last", last.address + last.size - 1 - unit.begin}};
  json["place"] = place(unit.begin, modules);
  json["holder"] = unit.holder;
  Json stack = Json::array();
  for (const void* address : unit.stack) stack.push_back(place(reinterpret_cast<std::uint64_t>(address), modules));
  json["stack"] = std::move(stack);
  return json;
}

}  // namespace

void Probe::write_log() const {
  if (is_copy()) return;
  constexpr std::size_t units_max = 4'096;
  const auto findings_json = [&](const std::vector<Finding>& findings) {
    Json list = Json::array();
    for (const Finding& finding : findings) {
      Json units = Json::array();
      for (std::size_t i = 0; i < std::min(finding.units.size(), units_max); ++i)
        units.push_back(unit_json(finding.units[i], modules_));
      list.push_back({{"tick", finding.tick},
                      {"window", finding.window},
                      {"columns", finding.columns},
                      {"is_joint", finding.is_joint},
                      {"units", std::move(units)}});
    }
    return list;
  };
  Json json{{"windows", window_count_}, {"moved", moved_count_},       {"trials", trial_count_},
            {"lost", lost_count_},      {"lost_reason", lost_reason_}, {"missing_saves", missing_saves_},
            {"threads", threads_},      {"left_out", left_out_},       {"ticks", ticks_run_},
            {"has_ended", has_ended_},  {"refusal", refusal_},         {"hint", hint_}};
  json["unexamined"] = unexamined_count_;
  json["findings"] = findings_json(findings_);
  json["unexplained"] = findings_json(unexplained_);
  json["not_loaded"] = findings_json(not_loaded_);
  Json harmless = Json::array();
  for (std::size_t i = 0; i < std::min(harmless_.size(), units_max); ++i)
    harmless.push_back(unit_json(harmless_[i], modules_));
  json["harmless"] = std::move(harmless);
  const std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
  std::FILE* file = std::fopen(path_.c_str(), "wb");
  if (file == nullptr) return;
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
}

#else

std::unique_ptr<Probe> Probe::from_environment() {
  return nullptr;
}
Probe::~Probe() = default;
bool Probe::run_window(std::uint64_t, const StateView&, const Register&) {
  return false;
}
void Probe::no_save(std::uint64_t) {}
void Probe::tick_ended(std::uint64_t, const StateView&, bool) {}
void Probe::column_moved(const MovedColumn&) {}
void Probe::loaded(const StateView&) {}
void Probe::load_failed(const std::string&) {
  std::abort();
}
void Probe::leave() {
  std::abort();
}
void Probe::refuse(const std::string&, const std::string&) {}
void Probe::finish(std::uint64_t) {}

#endif

}  // namespace ticktrue::capi
