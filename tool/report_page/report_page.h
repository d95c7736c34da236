// The page about one trace: a self-contained HTML file that says what verify found and plays what happened.
// SPDX-License-Identifier: MIT
//
// Verified: only what the report states; the page contains the report (the object of `verify --json`) unchanged, next
// to pictures of a run of this build. Whatever comes from a trace is escaped: it is text on the page, never markup. Not
// verified: positions are rounded to a grid that the page states.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "verifier/report/report.h"

namespace ticktrue::tool {

struct PageOptions {
  std::string against;                       // another trace, whose bodies are drawn as ghosts; may be empty
  std::span<const verifier::Report> others;  // reports of the same call, listed with a sentence each
  std::string command;                       // that makes the page again
  bool allow_truncated = false;              // as for the report
  std::size_t size_max = 5'000'000 - 4'096;  // bytes; frames are left out until the page fits
  std::function<void(std::uint64_t done, std::uint64_t of)> progress;  // ticks; may be empty
};

struct Page {
  std::string html;
  int exit_code = 0;    // of the report, or worse where the two traces differ
  std::string against;  // the verdict on the other trace; empty without one
};

/// `report`: of verifying the trace, or of the attempt; its file is read again.
/// Errors: what opening the trace `against` refuses.
Result<Page> make_report_page(const verifier::Report& report, const PageOptions& options);

/// As text of an HTML element or attribute. Control characters become spaces.
std::string html_text(std::string_view text);
/// JSON inside a script element: no character that could end it.
std::string script_json(std::string_view json);

}  // namespace ticktrue::tool
