// JSON of the parts that the reports of verify and diff share.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "replay/format/trace.h"
#include "verifier/report/fact_differences.h"
#include "verifier/report/likely_causes.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

nlohmann::ordered_json facts_json(const replay::BuildFacts& facts);
nlohmann::ordered_json build_json();
nlohmann::ordered_json differences_json(const std::vector<FactDifference>& differences, const char* a_name,
                                        const char* b_name);
nlohmann::ordered_json causes_json(const std::vector<Cause>& found);
/// Reports of verify. Version 1 had values of columns as strings; readers accept both.
inline constexpr const char* verify_schema = "ticktrue.verify/2";
bool is_verify_schema(std::string_view name);
/// A value of a column as the shortest number that is exact in its type. It is a string if no JSON number is exact: for
/// an integer beyond 2^53, or a real that is not finite.
nlohmann::ordered_json value_json(ScalarType type, std::uint64_t bits);
/// A value in a report of version 1 or 2, as text. Empty: no value.
std::string value_text(const nlohmann::json& value);
nlohmann::ordered_json lane_json(const LaneReport& row);
nlohmann::ordered_json content_json(const ContentReport& content);
nlohmann::ordered_json compared_json(const ComparedParts& compared);
nlohmann::ordered_json divergence_json(const Divergence& divergence);
nlohmann::ordered_json non_finite_json(const NonFinite& found);
nlohmann::ordered_json end_json(const TraceEnd& end);
/// JSON Lines as an array of strings, one per line.
nlohmann::ordered_json input_lines_json(const std::string& lines);
/// The whole report.
nlohmann::ordered_json report_row_json(const Report& report);
/// `passed`, `failed`, `expected` and `not_applicable`.
void add_counts(nlohmann::ordered_json& object, std::span<const Report> reports, bool allow_truncated);

}  // namespace ticktrue::verifier
