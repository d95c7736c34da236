// Results of ticktrue/math.h as little-endian bytes, for digests: C and C++.
// SPDX-License-Identifier: MIT
#pragma once

#include "tests/math/functions.h"

#define math_block_count 1024u
#define math_others_count 4000u
#define math_others_size (32 * math_others_count)

static inline size_t put_u64(unsigned char* bytes, size_t at, uint64_t value) {
  size_t i;
  for (i = 0; i < 8; ++i) bytes[at + i] = (unsigned char)(value >> (8 * i));
  return at + 8;
}
static inline size_t put_u32(unsigned char* bytes, size_t at, uint32_t value) {
  size_t i;
  for (i = 0; i < 4; ++i) bytes[at + i] = (unsigned char)(value >> (8 * i));
  return at + 4;
}

// Results of arguments first .. first + count - 1 of a sequence that `random` draws. Returns the size in bytes.
static size_t math_block(const MathFunction* function, int wide, ticktrue_random* random, uint32_t first,
                         uint32_t count, unsigned char* bytes) {
  size_t size = 0;
  uint32_t i;
  for (i = first; i < first + count; ++i) {
    if (wide) {
      double x = next_f64(random, function->low, function->high, i), y = 0;
      if (function->argument_count == 2) y = next_f64(random, function->low_y, function->high_y, i / 4);
      size = put_u64(bytes, size, ttm_bits(function->f64(x, y)));
    } else {
      float x = next_f32(random, function->low, function->high, i), y = 0;
      if (function->argument_count == 2) y = next_f32(random, function->low_y, function->high_y, i / 4);
      size = put_u32(bytes, size, ttm_bits_f32(function->f32(x, y)));
    }
  }
  return size;
}

typedef struct MathRow {
  double key;
  uint32_t place;
} MathRow;

static int compare_rows(const void* a, const void* b, void* user) {
  (void)user;
  return ticktrue_total_order(((const MathRow*)a)->key, ((const MathRow*)b)->key);
}

// Numbers of the generator, sine and cosine together, and rows sorted by a key with ties, zeros of both signs and NaN.
static void math_others(unsigned char* bytes) {
  static MathRow rows[math_others_count], buffer[math_others_count];
  ticktrue_random random = ticktrue_random_seeded(42, 54);
  size_t size = 0;
  uint32_t i;
  for (i = 0; i < math_others_count; ++i) {
    double sine, cosine, key = (double)ticktrue_random_between(&random, -300, 300);
    rows[i].key = i % 7 == 0 ? -0.0 : (i % 11 == 0 ? ttm_nan() : key);
    rows[i].place = i;
    size = put_u32(bytes, size, ticktrue_random_below(&random, 3000000000u));
    size = put_u32(bytes, size, ttm_bits_f32(ticktrue_random_float(&random)));
    ticktrue_sincos(next_f64(&random, -1e7, 1e7, i), &sine, &cosine);
    size = put_u64(bytes, size, ttm_bits(sine));
    size = put_u64(bytes, size, ttm_bits(cosine));
  }
  ticktrue_sort(rows, math_others_count, sizeof(MathRow), compare_rows, NULL, buffer);
  for (i = 0; i < math_others_count; ++i) {
    size = put_u32(bytes, size, rows[i].place);
    size = put_u32(bytes, size, ticktrue_random_u32(&random));
  }
}
