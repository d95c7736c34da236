// The output of `ticktrue accuracy`: tables, JSON and plots of its curves.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tool/cli/study/study_output.h"
#include "tool/output/json_output.h"
#include "tool/study/accuracy.h"

namespace ticktrue::cli {

/// How much is shown.
struct AccuracyView {
  bool points = false;    // every point of every curve, instead of one line a curve
  bool brief = false;     // one line a problem
  bool no_times = false;  // what is the same on every machine
};

std::string_view class_name(tool::ProblemClass kind);
tool::VerdictCounts verdicts_of(const std::vector<tool::AccuracyCurve>& curves);

std::string accuracy_text(const std::vector<tool::Problem>& problems, const std::vector<tool::AccuracyCurve>& curves,
                          const AccuracyView& view, const std::vector<engine::Precision>& precisions);
Json accuracy_json(const std::vector<tool::Problem>& problems, const std::vector<tool::AccuracyCurve>& curves,
                   const std::string& command_line);
std::string accuracy_csv(const std::vector<tool::AccuracyCurve>& curves);
/// A line for each value at each sampled time. Requires: the curves were run with keep_samples.
std::string samples_csv(const std::vector<tool::Problem>& problems, const std::vector<tool::AccuracyCurve>& curves);
/// One diagram a problem and precision: error across, time upwards; the floor of rounding as a line.
std::vector<tool::Plot> accuracy_plots(const std::vector<tool::Problem>& problems,
                                       const std::vector<tool::AccuracyCurve>& curves,
                                       const std::vector<engine::Precision>& precisions);

}  // namespace ticktrue::cli
