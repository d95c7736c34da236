// `ticktrue accuracy --peer box2d2,box2d3`: error against run time beside Box2D.
// SPDX-License-Identifier: MIT
#include "tool/cli/study/accuracy_peer.h"

#include <fmt/format.h>

#include <algorithm>

#include "tool/crosscheck/peers.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/study/peer_curves.h"

namespace ticktrue::cli {
namespace {

using tool::PeerKind;
using tool::short_number;
using tool::TextTable;

std::string_view peer_name(PeerKind kind) {
  return engine::info_of(tool::peers, kind).name;
}

// Of a peer that has run.
std::string peer_version(PeerKind kind) {
  const Result<std::string> version = engine::info_of(tool::peers, kind).version();
  return version ? *version : std::string();
}

Json peer_json(const std::vector<tool::PeerCurves>& scenes, const std::vector<PeerKind>& kinds,
               const std::string& engine_program) {
  Json object;
  object["schema"] = "ticktrue.accuracy_peer/1";
  const auto one_json = [](PeerKind kind) {
    Json peer{{"name", "Box2D"}, {"version", peer_version(kind)}};
    if (kind != PeerKind::box2d2) peer["id"] = peer_name(kind);
    return peer;
  };
  object["peer"] = one_json(kinds.front());
  if (kinds.size() > 1)
    for (const PeerKind kind : kinds) object["peers"].push_back(one_json(kind));
  if (!engine_program.empty()) object["engine"] = engine_program;
  int passed = 0;
  int not_judged = 0;
  for (const auto& scene : scenes) passed += scene.holds ? 1 : 0;
  for (const auto& scene : scenes) not_judged += scene.is_judged ? 0 : 1;
  object["passed"] = passed;
  object["failed"] = static_cast<int>(scenes.size()) - passed - not_judged;
  object["expected"] = 0;
  object["not_applicable"] = not_judged;
  object["rows"] = Json::array();
  for (const auto& scene : scenes) {
    const std::string_view verdict = !scene.is_judged ? "not_judged" : scene.holds ? "pass" : "fail";
    Json row{{"scene", scene.name}, {"measure", scene.measure}, {"verdict", verdict}};
    if (scene.peer != PeerKind::box2d2) row["peer"] = peer_name(scene.peer);
    if (!scene.is_judged)
      row["time"] = "wasm, not comparable with native";
    else if (scene.peer == PeerKind::box2d3)
      row["time"] = scene.peer_label == "Box2D 3" ? "native" : "wasm, both";
    row["ratio"] = number_json(scene.ratio);
    for (const auto& bar : scene.bars)
      row["bars"].push_back({{"setting", bar.setting},
                             {"ratio", number_json(bar.ratio)},
                             {"ratio_max", bar.ratio_max},
                             {"verdict", bar.ratio <= bar.ratio_max ? "pass" : "fail"}});
    const auto points_json = [](const std::vector<tool::PeerPoint>& points) {
      Json array = Json::array();
      for (const auto& point : points)
        array.push_back({{"setting", point.setting},
                         {"error_m", number_json(point.error)},
                         {"error_max_m", number_json(point.error_max)},
                         {"stands", point.stands},
                         {"ms_per_tick",
                          {{"min", point.time_ms.min}, {"median", point.time_ms.median}, {"iqr", point.time_ms.iqr}}}});
      return array;
    };
    row["ours"] = points_json(scene.ours);
    row["box2d"] = points_json(scene.box2d);
    object["rows"].push_back(std::move(row));
  }
  return object;
}

std::string peer_text(const std::vector<tool::PeerCurves>& scenes, const std::vector<PeerKind>& kinds,
                      const std::string& command_line) {
  std::string text = "accuracy  " + command_line;
  for (const PeerKind kind : kinds) text += "  Box2D " + peer_version(kind);
  text += "\n";
  for (const auto& scene : scenes) {
    text += fmt::format("\n{}  {}\n", scene.name, scene.measure);
    TextTable table({"engine", "setting", "error mm", "max mm", "ms/tick", "min", "IQR",
                     scene.is_judged ? "ours at no more time: error mm" : "ours at equal substeps: error mm", "ratio"},
                    2);
    const auto add = [&](std::string_view engine, const tool::PeerPoint& point, bool is_peer) {
      std::vector<std::string> row{std::string(engine),
                                   point.setting,
                                   point.stands        ? short_number(point.error * 1e3)
                                   : point.error > 1e8 ? std::string("not finite")
                                                       : "fell " + short_number(point.error * 1e3),
                                   short_number(point.error_max * 1e3),
                                   fmt::format("{:.4f}", point.time_ms.median),
                                   fmt::format("{:.4f}", point.time_ms.min),
                                   fmt::format("{:.4f}", point.time_ms.iqr)};
      if (is_peer) {
        const tool::PeerPoint* ours = scene.is_judged ? tool::best_within(scene.ours, point.time_ms.min)
                                                      : tool::find_setting(scene.ours, point.setting);
        row.push_back(ours ? short_number(ours->error * 1e3) + " (" + ours->setting + ")" : "none so quick");
        row.push_back(ours && point.error > 0 ? short_number(ours->error / point.error) : "-");
      }
      table.add(std::move(row));
    };
    for (const auto& point : scene.ours) add(scene.own_label, point, false);
    for (const auto& point : scene.box2d) add(scene.peer_label, point, true);
    text += table.text();
    text += tool::wrapped(scene.conclusion, 4);
  }
  return text;
}

}  // namespace

int run_accuracy_peer(const AccuracyPeerOptions& options, const StudyFiles& files) {
  std::vector<PeerKind> kinds;
  std::string asked_text;
  for (const std::string& name : options.peers) {
    asked_text += (asked_text.empty() ? "" : ",") + name;
    const PeerKind kind = name == first_peer_name ? PeerKind::box2d2 : engine::find_choice(tool::peers, name)->kind;
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
  }
  if (!options.engine_program.empty()) asked_text += " --engine" + words_text({options.engine_program});
  Progress progress("accuracy --peer " + asked_text, 1, "runs");
  tool::PeerCurvesOptions curves;
  curves.names = options.scenes;
  curves.kinds = kinds;
  curves.repeat_max = options.repeat_count;
  curves.engine_program = options.engine_program;
  curves.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  const auto scenes = tool::run_peer_curves(curves);
  progress.finish();
  if (!scenes) return fail_usage(scenes.error());
  if (files.json)
    print_json(peer_json(*scenes, kinds, options.engine_program));
  else
    print(peer_text(*scenes, kinds,
                    fmt::format("ticktrue accuracy --peer {}{} --repeats {}", asked_text, words_text(options.scenes),
                                options.repeat_count)));
  std::string csv = tool::csv_line({"scene", "engine", "setting", "error_m", "error_max_m", "stands", "ms_per_tick_min",
                                    "ms_per_tick_median", "ms_per_tick_iqr"});
  std::vector<tool::Plot> plots;
  for (const auto& scene : *scenes) {
    tool::Plot plot{scene.is_judged ? scene.name : scene.name + ", Box2D 3 in WebAssembly",
                    "error, m",
                    "ms per tick",
                    true,
                    true,
                    {}};
    const auto add_curve = [&](const std::string& name, const std::vector<tool::PeerPoint>& points, bool is_direct) {
      tool::PlotCurve line{name, {}, {}, false};
      for (const auto& point : points) {
        if (point.joins_direct != is_direct) continue;
        if (point.stands) {  // how far a heap is from the stack that it was says nothing
          line.x.push_back(point.error);
          line.y.push_back(point.time_ms.min);
        }
        csv += tool::csv_line({scene.name, name, point.setting, tool::full_number(point.error),
                               tool::full_number(point.error_max), point.stands ? "1" : "0",
                               tool::full_number(point.time_ms.min), tool::full_number(point.time_ms.median),
                               tool::full_number(point.time_ms.iqr)});
      }
      if (!line.x.empty()) plot.curves.push_back(std::move(line));
    };
    add_curve(scene.own_label, scene.ours, false);
    add_curve(scene.own_label + " direct", scene.ours, true);
    add_curve(scene.peer_label, scene.box2d, false);
    plots.push_back(std::move(plot));
  }
  if (const int code = write_study_files(files, csv, plots); code != exit_ok) return code;
  const bool fails =
      std::any_of(scenes->begin(), scenes->end(), [](const auto& scene) { return scene.is_judged && !scene.holds; });
  return fails ? exit_finding : exit_ok;
}

}  // namespace ticktrue::cli
