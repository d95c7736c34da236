// Probes of the floating point environment. Operands pass through volatile, so that the compiler computes nothing.
// SPDX-License-Identifier: MIT
#include "tool/environment/float_environment.h"

#include <cfloat>
#include <limits>

#include "base/bytes.h"
#include "base/hash.h"

namespace ticktrue::tool {
namespace {

template <typename Real>
Real opaque(Real value) {
  volatile Real hidden = value;
  return hidden;
}

float root(float value) {
  return __builtin_sqrtf(value);
}
double root(double value) {
  return __builtin_sqrt(value);
}

std::uint64_t wide_bits(float value) {
  return bits_of(value);
}
std::uint64_t wide_bits(double value) {
  return bits_of(value);
}

template <typename Real>
void operate(ByteWriter& out) {
  // Numbers of many magnitudes from a linear congruential generator (Knuth, MMIX), never zero.
  std::uint64_t seed = 1;
  const auto number = [&seed] {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    const auto digits = static_cast<Real>(static_cast<std::int64_t>(seed >> 40) + 1);
    const int exponent = static_cast<int>((seed >> 16) % 41) - 20;
    Real value = digits;
    for (int i = 0; i < exponent; ++i) value *= Real(2);
    for (int i = 0; i > exponent; --i) value /= Real(2);
    return (seed & 256u) != 0 ? -value : value;
  };
  Real sum = 0;
  for (int i = 0; i < 500; ++i) {
    const Real a = opaque(number());
    const Real b = opaque(number());
    sum = opaque(sum * Real(0.7) + a);
    for (const Real value : {a + b, a - b, a * b, a / b, root(a < 0 ? -a : a), a * b + sum, sum})
      out.u64(wide_bits(opaque(value)));
    out.u64(static_cast<std::uint64_t>(static_cast<std::int64_t>(opaque(a / Real(3)))));
    out.u64(wide_bits(static_cast<float>(opaque(static_cast<double>(a) / 3.0))));
  }
  // Down through the subnormal numbers; counted, since where rounding goes upward zero is never reached.
  Real value = opaque(std::numeric_limits<Real>::min());
  for (int i = 0; i < 64; ++i) {
    out.u64(wide_bits(value));
    value = opaque(value * Real(0.4));
  }
}

}  // namespace

FloatEnvironment probe_float_environment() {
  FloatEnvironment environment;
  environment.behaviour = probe_float_behaviour();
  environment.evaluation_method = FLT_EVAL_METHOD;
  ByteWriter out;
  operate<float>(out);
  operate<double>(out);
  environment.digest = hash64(out.view());
  return environment;
}

bool follows_rules(const FloatEnvironment& environment) {
  return check_float_behaviour(environment.behaviour) && environment.evaluation_method == 0 &&
         environment.digest == float_digest_expected;
}

}  // namespace ticktrue::tool
