// Describes the floating point settings as text.
// SPDX-License-Identifier: MIT
#include "capi/tick.h"

#include "base/float_behaviour.h"

namespace ticktrue::capi {

std::string float_deviation() {
  // Whether products and sums are fused depends on how the program was compiled: the caller states it as a fact.
  const FloatBehaviour behaviour = probe_float_behaviour();
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (behaviour.rounding != "nearest") add("rounding " + std::string(behaviour.rounding));
  if (behaviour.flushes_to_zero) add("subnormal results flushed to zero");
  if (behaviour.subnormals_are_zero) add("subnormal operands taken as zero");
  return text;
}

}  // namespace ticktrue::capi
