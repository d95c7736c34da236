// Reports in the forms that continuous integration shows: JUnit, annotations and summary of GitHub Actions.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Text of an XML attribute.
std::string xml_text(std::string_view text);

/// The data of a workflow command; in a parameter, `,` and `:` too would end it.
std::string github_text(std::string_view text, bool is_parameter);

/// One sentence: "tick 137 of 600: bodies.velocity of row 41 (crate_7) differs by 1 ulp", or the reason.
std::string report_sentence(const Report& report);

/// JUnit XML: a test case for each file. Findings and cut traces are failures; what could not be judged is an error.
std::string report_junit(std::span<const Report> reports, bool allow_truncated);

/// Workflow commands of GitHub Actions, one line each: an error for each file that failed, its warnings as warnings.
std::string report_github(std::span<const Report> reports, bool allow_truncated);

/// A table in Markdown for the page of a workflow run: counts, and a row for each file that failed.
std::string report_markdown(std::span<const Report> reports, bool allow_truncated);

}  // namespace ticktrue::verifier
