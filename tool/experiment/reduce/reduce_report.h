// What a reduction prints: text and JSON.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "tool/experiment/reduce/reduce.h"
#include "tool/experiment/reduce/result_folder.h"

namespace ticktrue::reduce {

/// What was reduced, and how long it took.
struct ReduceSubject {
  std::string name;  // as it was given
  const SoakCase* session = nullptr;
  double wall_s = 0;
};

std::string reduce_text(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder);
/// Schema ticktrue.reduce/1.
std::string reduce_json(const ReduceResult& result, const ReduceSubject& subject, const ResultFolder& folder);

/// Of `--once`: how a session fails, or that it does not.
std::string once_text(const std::string& name, const std::optional<Failure>& failure);
std::string once_json(const std::string& name, const std::optional<Failure>& failure);

}  // namespace ticktrue::reduce
