// Reports in formats of continuous integration: JUnit, annotations and summary of GitHub Actions.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

/// Escapes the text of an XML attribute.
std::string xml_text(std::string_view text);

/// Escapes the data of a workflow command. In a parameter, `,` and `:` are escaped too.
std::string github_text(std::string_view text, bool is_parameter);

/// One sentence: "tick 137 of 600: bodies.velocity of row 41 (crate_7) differs by 1 ulp", or the reason.
std::string report_sentence(const Report& report);

/// JUnit XML: one test case per file. Findings and truncated traces are failures; a trace that could not be judged is
/// an error.
std::string report_junit(std::span<const Report> reports, bool allow_truncated);

/// Workflow commands of GitHub Actions, one line each: an error for each failed file, and its warnings.
std::string report_github(std::span<const Report> reports, bool allow_truncated);

/// A Markdown table for the page of a workflow run: counts, and a row for each failed file.
std::string report_markdown(std::span<const Report> reports, bool allow_truncated);

}  // namespace ticktrue::verifier
