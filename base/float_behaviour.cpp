// Probes of the floating point settings. Operands pass through volatile, so that the compiler computes nothing.
// SPDX-License-Identifier: MIT
#include "base/float_behaviour.h"

#include <limits>
#include <string>

#include "base/float_rules.h"

namespace ticktrue {
namespace {

template <typename Real>
Real opaque(Real value) {
  volatile Real hidden = value;
  return hidden;
}

template <typename Real>
std::string_view rounding_of() {
  const Real tiny = opaque(std::numeric_limits<Real>::epsilon() / 1024);
  const Real one = opaque(Real(1));
  if (opaque(one + tiny) > one) return "upward";
  if (opaque(-one - tiny) < -one) return "downward";
  if (opaque(one - tiny) < one) return "toward_zero";
  return "nearest";
}

template <typename Real>
bool flushes() {
  return opaque(opaque(std::numeric_limits<Real>::min()) * opaque(Real(0.5))) == Real(0);
}

template <typename Real>
bool drops_subnormals() {
  // The product of a subnormal operand and a large one is normal. It is zero only if the operand was taken as zero.
  return opaque(opaque(std::numeric_limits<Real>::denorm_min()) *
                opaque(Real(1) / std::numeric_limits<Real>::epsilon() * Real(4))) == Real(0);
}

template <typename Real>
bool contracts() {
  // (1 + e)(1 - e) = 1 - e^2 is not representable. If the product is rounded first, the sum differs.
  const Real e = std::numeric_limits<Real>::epsilon();
  const Real a = opaque(1 + e);
  const Real b = opaque(1 - e);
  const Real c = opaque(Real(-1));
  return opaque(a * b + c) != opaque(opaque(a * b) + c);
}

}  // namespace

FloatBehaviour probe_float_behaviour() {
  FloatBehaviour behaviour;
  behaviour.rounding = rounding_of<float>() == "nearest" ? rounding_of<double>() : rounding_of<float>();
  behaviour.flushes_to_zero = flushes<float>() || flushes<double>();
  behaviour.subnormals_are_zero = drops_subnormals<float>() || drops_subnormals<double>();
  behaviour.contracts = contracts<float>() || contracts<double>();
  return behaviour;
}

Status check_float_behaviour(const FloatBehaviour& behaviour) {
  std::string found;
  const auto add = [&found](const std::string& text) { found += (found.empty() ? "" : ", ") + text; };
  if (behaviour.rounding != "nearest") add("rounding " + std::string(behaviour.rounding));
  if (behaviour.flushes_to_zero) add("subnormal results flushed to zero");
  if (behaviour.subnormals_are_zero) add("subnormal operands taken as zero");
  if (behaviour.contracts) add("a * b + c rounded once");
  if (found.empty()) return {};
  return Error{
      ErrorCode::unsupported,
      "floating point: found " + found + ", expected IEEE 754's defaults: no run of this thread would be portable",
      "something in this process changed them: often a library that was linked with -ffast-math"};
}

Status check_float_behaviour() {
  return check_float_behaviour(probe_float_behaviour());
}

}  // namespace ticktrue
