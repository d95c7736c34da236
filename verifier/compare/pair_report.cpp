// Combines two verdicts on a trace, and merges the divergences of two programs.
// SPDX-License-Identifier: MIT
#include "verifier/compare/pair_report.h"

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "base/hash.h"
#include "base/plain_text.h"

namespace ticktrue::verifier {
namespace {

std::optional<std::uint64_t> diverged_at(const Report& report) {
  if (report.verdict != Verdict::diverged || !report.divergence) return std::nullopt;
  return report.divergence->tick;
}

Report not_judged_there(Report pair, const OtherBuild& other) {
  const auto found = std::find_if(verdicts.begin(), verdicts.end(),
                                  [&](const VerdictInfo& info) { return info.name == other.verdict; });
  if (found == verdicts.end())
    return pair_failed(std::move(pair), other.binary, "gave an unknown verdict: \"" + plain_line(other.verdict) + "\"",
                       "");
  pair.verdict = found->verdict;
  pair.reason = other.binary + " says " + other.verdict + (other.reason.empty() ? "" : ": " + plain_line(other.reason));
  pair.hint.clear();
  return pair;
}

Report builds_differ(Report pair, std::uint64_t tick, std::optional<std::uint64_t> here_at,
                     std::optional<std::uint64_t> there_at, const std::function<void(Report&)>& locate) {
  pair.verdict = Verdict::diverged;
  pair.reason.clear();
  pair.hint.clear();
  pair.again.clear();
  pair.against->is_expected = true;
  const auto words = [](std::optional<std::uint64_t> at) {
    return at ? "leaves the recording at tick " + std::to_string(*at) : std::string("gives the recorded bits");
  };
  pair.notes.push_back("this build " + words(here_at) + ", " + pair.against->binary + " " + words(there_at));
  if (!pair.divergence || pair.divergence->tick != tick) pair.divergence = Divergence{};
  pair.divergence->tick = tick;
  locate(pair);
  return pair;
}

using LaneKey = std::tuple<std::string, std::string, std::uint64_t, std::uint32_t>;  // table, column, row, lane

std::map<LaneKey, LaneReport> lanes_of(const Divergence& divergence) {
  std::map<LaneKey, LaneReport> lanes;
  for (const LaneReport& lane : divergence.rows) lanes[{lane.table, lane.column, lane.row, lane.lane}] = lane;
  return lanes;
}

bool lists_all(const Divergence& divergence) {
  return divergence.lane_count == divergence.rows.size() && !divergence.rows.empty() && divergence.content_count == 0 &&
         divergence.row_counts.empty();
}

/// Exchanges the values of both programs.
void swap_sides(Divergence& divergence) {
  for (LaneReport& lane : divergence.rows) std::swap(lane.expected, lane.got);
  for (ContentReport& content : divergence.contents) {
    std::swap(content.expected, content.got);
    std::swap(content.expected_size, content.got_size);
  }
  for (RowCountDifference& count : divergence.row_counts) std::swap(count.expected, count.got);
  std::swap(divergence.expected_root, divergence.got_root);
}

/// For two programs that leave the recording at the same tick: finds the lanes in which they differ. If one list lacks
/// a lane, that program has the recorded value.
void join_lanes(const Divergence& here, const Divergence& there, Divergence& pair) {
  const std::map<LaneKey, LaneReport> here_lanes = lanes_of(here), there_lanes = lanes_of(there);
  std::map<LaneKey, LaneReport> joined;
  for (const auto& [key, lane] : here_lanes) {
    LaneReport& row = joined[key] = lane;
    if (const auto other = there_lanes.find(key); other != there_lanes.end()) row.expected = other->second.got;
  }
  for (const auto& [key, lane] : there_lanes) {
    if (here_lanes.count(key) != 0) continue;
    LaneReport& row = joined[key] = lane;
    row.got = lane.expected;
    row.expected = lane.got;
  }
  pair.rows.clear();
  pair.tables.clear();
  for (const auto& [key, lane] : joined) {
    if (lane.expected == lane.got) continue;
    pair.rows.push_back(lane);
    if (pair.tables.empty() || pair.tables.back().table != lane.table) pair.tables.push_back({lane.table, {}});
    std::vector<std::string>& columns = pair.tables.back().columns;
    if (columns.empty() || columns.back() != lane.column) columns.push_back(lane.column);
  }
  pair.lane_count = pair.rows.size();
}

void join_places(const Divergence& here, const Divergence& there, Report& pair) {
  Divergence& divergence = *pair.divergence;
  divergence.expected_root = there.got_root;
  divergence.got_root = here.got_root;
  divergence.spread.clear();
  if (lists_all(here) && lists_all(there)) return join_lanes(here, there, divergence);
  pair.notes.push_back(
      "values and rows are those in which this build leaves the recording: not all are known of both builds");
}

}  // namespace

Report pair_failed(Report here, const std::string& other_name, const std::string& what, const std::string& hint) {
  here.verdict = Verdict::error;
  here.reason = other_name + " " + what;
  here.hint = hint;
  return here;
}

Report pair_report(Report here, const OtherVerdict& other, const std::function<void(Report& pair)>& locate) {
  here.against = other.build;
  const std::string& name = other.build.binary;
  const std::optional<std::uint64_t> here_at = diverged_at(here);
  const std::optional<std::uint64_t> there_at = other.build.diverged_at;
  if (here.verdict != Verdict::match && !here_at) return here;  // the verdict of this program gives the reason
  if (other.build.verdict != "match" && !there_at) return not_judged_there(std::move(here), other.build);
  if (!here_at && !there_at) {
    here.notes.push_back(name + " gives the recorded bits too, in all " + std::to_string(other.build.ticks_compared) +
                         " ticks");
    return here;
  }
  const std::uint64_t tick = std::min(here_at.value_or(*there_at), there_at.value_or(*here_at));
  const bool is_alike =
      here_at && there_at && *here_at == *there_at && other.got_hash == hex64(here.divergence->got_root);
  if (!is_alike) return builds_differ(std::move(here), tick, here_at, there_at, locate);
  here.notes.push_back("both builds give the same other bits at tick " + std::to_string(tick) +
                       ": the recording is of a third build, or was changed");
  return here;
}

Report pair_of_programs(Report here, const Report& there, const std::string& there_name) {
  if (there.verdict == Verdict::error)
    return pair_failed(std::move(here), there_name, "failed: " + there.reason, there.hint);
  OtherVerdict other;
  other.build.binary = there_name;
  other.build.verdict = std::string(verdict_info(there.verdict).name);
  other.build.reason = there.reason;
  other.build.ticks_compared = there.ticks_compared;
  other.build.diverged_at = diverged_at(there);
  other.build.facts = there.here_build;
  if (there.divergence) other.got_hash = hex64(there.divergence->got_root);
  const std::optional<Divergence> own = here.divergence;
  const std::optional<std::uint64_t> here_at = diverged_at(here);
  const auto locate = [&](Report& pair) {
    const bool only_there = !here_at || *here_at != pair.divergence->tick;
    if (only_there) {
      pair.divergence = there.divergence;
      swap_sides(*pair.divergence);
    } else if (diverged_at(there) == here_at) {
      join_places(*own, *there.divergence, pair);
    }
  };
  Report pair = pair_report(std::move(here), other, locate);
  const bool is_cut = pair.verdict == Verdict::diverged;
  if (is_cut)
    pair.notes.push_back(
        "behind the tick at which a program leaves the recording it is not compared: record a trace "
        "with one of them, and verify it by the other");
  return pair;
}

}  // namespace ticktrue::verifier
