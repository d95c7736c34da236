// Reads the history of a trace.
// SPDX-License-Identifier: MIT
#include "tool/corpus/trace_log.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "tool/corpus/trace_identity.h"
#include "verifier/report/report.h"
#include "verifier/store/stat_index.h"

namespace ticktrue::tool {
namespace {

std::string two_digits(std::int64_t number) {
  return (number < 10 ? "0" : "") + std::to_string(number);
}

}  // namespace

TraceLog log_of(verifier::TraceHistory history, std::string_view mode) {
  TraceLog log;
  log.warnings = std::move(history.warnings);
  for (verifier::HistoryRow& row : history.rows) {
    if (row.mode != mode) continue;
    if (!log.changed && row.verdict == verdict_info(verifier::Verdict::match).name) log.last_match = log.rows.size();
    if (!log.changed && row.verdict == verdict_info(verifier::Verdict::diverged).name) log.changed = log.rows.size();
    log.rows.push_back(std::move(row));
  }
  return log;
}

Result<TraceLog> read_trace_log(const std::string& file, const verifier::StoreFolder& folder, std::string_view mode) {
  verifier::StatIndex index(folder, file);
  const Result<TraceIdentity> identity = identify_trace(file, index, true);
  if (!identity) return identity.error();
  return log_of(verifier::History(folder).find(verifier::history_name(identity->hash, identity->facts.size)), mode);
}

std::string time_text(std::int64_t when_s) {
  using namespace std::chrono;
  const sys_seconds when{seconds(when_s)};
  const sys_days day = floor<days>(when);
  const year_month_day date(day);
  const hh_mm_ss clock(when - day);
  return std::to_string(static_cast<int>(date.year())) + "-" + two_digits(static_cast<unsigned>(date.month())) + "-" +
         two_digits(static_cast<unsigned>(date.day())) + " " + two_digits(clock.hours().count()) + ":" +
         two_digits(clock.minutes().count()) + ":" + two_digits(clock.seconds().count());
}

}  // namespace ticktrue::tool
