// The row kernels for AVX2.
// SPDX-License-Identifier: MIT
#define TICKTRUE_ISA avx2
#include "base/row_kernels.cpp"
