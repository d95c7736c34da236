// Prints a digest of each function of ticktrue/math.h over fixed arguments, of the generator and of the sort.
// SPDX-License-Identifier: MIT
//
// usage: digest [COUNT] [FUNCTION]    COUNT arguments, 100000 if not given
// It is C and C++. Link libxxhash, or define XXH_INLINE_ALL.
#include "tests/math/digest.h"

#include <stdio.h>
#include <stdlib.h>
#include <xxhash.h>

int main(int count, char** words) {
  uint32_t argument_count = count > 1 ? (uint32_t)strtoul(words[1], NULL, 10) : 100000u;
  size_t i;
  for (i = 0; i < sizeof math_functions / sizeof math_functions[0]; ++i) {
    XXH3_state_t* state;
    uint32_t block;
    int wide;
    if (count > 2 && strcmp(words[2], math_functions[i].name) != 0) continue;
    for (wide = 1; wide >= 0; --wide) {
      ticktrue_random random = ticktrue_random_seeded(23, 4);
      state = XXH3_createState();
      XXH3_64bits_reset(state);
      for (block = 0; block < argument_count; block += math_block_count) {
        unsigned char bytes[8 * math_block_count];
        uint32_t left = argument_count - block < math_block_count ? argument_count - block : math_block_count;
        XXH3_64bits_update(state, bytes, math_block(&math_functions[i], wide, &random, block, left, bytes));
      }
      printf("%s_%s\t%016llx\n", math_functions[i].name, wide ? "f64" : "f32",
             (unsigned long long)XXH3_64bits_digest(state));
      XXH3_freeState(state);
    }
  }
  if (count <= 2) {
    static unsigned char bytes[math_others_size];
    math_others(bytes);
    printf("others\t%016llx\n", (unsigned long long)XXH3_64bits(bytes, sizeof bytes));
  }
  return 0;
}
