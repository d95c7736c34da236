// The numbers of the arc tangent, for trig.cpp and for kernels that take several at a time.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::engine {

inline constexpr double half_pi_near = 0x1.921fb54442d18p+0;   // the double nearest to pi/2
inline constexpr double half_pi_rest = 0x1.1a62633145c07p-54;  // pi/2 - half_pi_near

/// atan(i / 8)
inline constexpr double atan_of_eighths[9] = {
    0,
    0x1.fd5ba9aac2f6ep-4,
    0x1.f5b75f92c80ddp-3,
    0x1.6f61941e4def1p-2,
    0x1.dac670561bb4fp-2,
    0x1.1e00babdefeb4p-1,
    0x1.4978fa3269ee1p-1,
    0x1.700a7c5784634p-1,
    0x1.921fb54442d18p-1,
};

}  // namespace ticktrue::engine
