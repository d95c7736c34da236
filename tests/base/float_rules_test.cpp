// Float rules that base/float_rules.h cannot check at compile time: contraction, denormals, rounding, excess precision.
// SPDX-License-Identifier: MIT
#include "base/float_rules.h"

#include "base/bytes.h"
#include "tests/support/catch.h"

namespace ticktrue {
namespace {

// Volatile prevents the compiler from computing the result.
template <typename Real>
Real multiply_add(Real a, Real b, Real c) {
  volatile Real va = a, vb = b, vc = c;
  const Real x = va, y = vb, z = vc;
  return x * y + z;
}

TEST_CASE("a product and a sum round twice, also in one expression", "[base][float_rules][determinism]") {
  // (1 + e)^2 = 1 + 2e + e^2. A rounded product loses e^2; a fused multiply-add keeps it.
  const float e32 = 0x1p-23f;
  CHECK(bits_of(multiply_add(1 + e32, 1 + e32, -(1 + 2 * e32))) == 0);
  const double e64 = 0x1p-52;
  CHECK(bits_of(multiply_add(1 + e64, 1 + e64, -(1 + 2 * e64))) == 0);
}

TEST_CASE("denormal results are kept", "[base][float_rules][determinism]") {
  CHECK(bits_of(multiply_add(0x1p-100f, 0x1p-30f, 0.0f)) == 1u << 19);
  CHECK(bits_of(multiply_add(0x1p-1000, 0x1p-50, 0.0)) == 1ull << 24);
}

TEST_CASE("division and square root round correctly, to nearest even", "[base][float_rules][determinism]") {
  volatile float one = 1, three = 3, two = 2;
  CHECK(bits_of(one / three) == 0x3eaaaaabu);
  CHECK(bits_of(__builtin_sqrtf(two)) == 0x3fb504f3u);
  volatile double one64 = 1, three64 = 3, two64 = 2;
  CHECK(bits_of(one64 / three64) == 0x3fd5555555555555u);
  CHECK(bits_of(__builtin_sqrt(two64)) == 0x3ff6a09e667f3bcdu);
  volatile float large = 0x1p24f;
  CHECK(large + one == 0x1p24f);        // a tie goes to the even neighbour below ...
  CHECK(large + three == 0x1p24f + 4);  // ... and to the even one above
}

TEST_CASE("zero keeps its sign", "[base][float_rules][determinism]") {
  volatile float minus = -1, zero = 0;
  CHECK(bits_of(minus * zero) == 0x80000000u);
  CHECK(bits_of(zero - zero) == 0u);
}

}  // namespace
}  // namespace ticktrue
