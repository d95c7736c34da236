// Text and JSON of a reduction.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/reduce_report.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "base/plain_text.h"
#include "tool/output/json_output.h"

namespace ticktrue::reduce {
namespace {

using cli::Json;

struct Count {
  std::string_view name;
  std::uint64_t before = 0;
  std::uint64_t after = 0;
};

std::uint64_t shapes_of(const SoakCase& session) {
  std::uint64_t count = 0;
  for (const engine::Body& body : session.scene.bodies) count += body.shapes.size();
  return count;
}

std::vector<Count> counts_of(const SoakCase& before, const SoakCase& after) {
  return {{"bodies", before.scene.bodies.size(), after.scene.bodies.size()},
          {"shapes", shapes_of(before), shapes_of(after)},
          {"joints", before.scene.joints.size(), after.scene.joints.size()},
          {"forces", before.scene.forces.size(), after.scene.forces.size()},
          {"inputs", before.inputs.size(), after.inputs.size()},
          {"ticks", before.tick_count, after.tick_count}};
}

std::string failure_line(const Failure& failure) {
  const std::string place = place_text(failure);
  return failure.kind + "  tick " + std::to_string(failure.tick) + (place.empty() ? "" : "  " + place);
}

Json failure_json(const Failure& failure) {
  const auto text = [](const std::string& word) { return word.empty() ? Json(nullptr) : Json(word); };
  return {{"kind", failure.kind},
          {"tick", failure.tick},
          {"stage", text(failure.stage)},
          {"table", text(failure.table)},
          {"column", text(failure.column)},
          {"row", failure.row ? Json(*failure.row) : Json(nullptr)},
          {"what", failure.what}};
}

std::string dumped(const Json& object) {
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string reduce_text(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder) {
  std::string text = "reduced  " + plain_text(subject.name) + "\n  failure  " + failure_line(result.last) +
                     "\n           " + plain_text(result.last.what) + "\n";
  for (const Count& count : counts_of(*subject.session, result.smallest))
    if (count.before != 0) text += fmt::format("  {:<8} {} -> {}\n", count.name, count.before, count.after);
  if (result.cut_tick > 0) text += fmt::format("  start    the state before tick {}\n", result.cut_tick);
  text += fmt::format("  files    {}: {} bytes{}\n", plain_text(folder.path), folder.size,
                      folder.has_trace ? "" : "; no tick can be recorded: there is no trace");
  text += fmt::format("  search   {} runs, {:.1f} s{}\n", result.run_count, subject.wall_s,
                      result.ended_early ? ", ended before nothing more could be left out" : "");
  return text + "  again    " + plain_text(folder.command) + "\n";
}

std::string reduce_json(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder) {
  Json object;
  object["schema"] = "ticktrue.reduce/1";
  object["session"] = subject.name;
  object["failure"] = failure_json(result.last);
  object["first_failure"] = failure_json(result.first);
  for (const Count& count : counts_of(*subject.session, result.smallest))
    object[std::string(count.name)] = {{"before", count.before}, {"after", count.after}};
  object["cut_tick"] = result.cut_tick;
  object["folder"] = folder.path;
  object["size"] = folder.size;
  object["trace"] = folder.has_trace;
  object["command"] = folder.command;
  object["runs"] = result.run_count;
  object["seconds"] = subject.wall_s;
  object["ended_early"] = result.ended_early;
  return dumped(object);
}

std::string once_text(const std::string& name, const std::optional<Failure>& failure) {
  if (!failure) return "holds    " + plain_text(name) + "\n";
  return "fails    " + plain_text(name) + "\n  failure  " + failure_line(*failure) + "\n           " +
         plain_text(failure->what) + "\n";
}

std::string once_json(const std::string& name, const std::optional<Failure>& failure) {
  Json object;
  object["schema"] = "ticktrue.reduce_once/1";
  object["session"] = name;
  object["failure"] = failure ? failure_json(*failure) : Json(nullptr);
  return dumped(object);
}

}  // namespace ticktrue::reduce
