// The output of a reduction as text and JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tool/experiment/reduce/reduce.h"
#include "tool/experiment/reduce/result_folder.h"

namespace ticktrue::reduce {

/// The reduced session, and the duration of the reduction.
struct ReduceSubject {
  std::string name;  // as the user gave it
  const SoakCase* session = nullptr;
  double wall_s = 0;
};

std::string reduce_text(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder);
/// Schema ticktrue.reduce/1.
std::string reduce_json(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder);

/// The output of `--once`: how a session fails, or that it does not fail.
std::string once_text(const std::string& name, const std::optional<Failure>& failure);
std::string once_json(const std::string& name, const std::optional<Failure>& failure);

}  // namespace ticktrue::reduce
