// qsort: elements that compare equal are in reverse order.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

using CompareWith = int (*)(const void*, const void*, void*);

void reverse(char* base, std::size_t count, std::size_t size) {
  for (std::size_t i = 0; i < count / 2; ++i)
    for (std::size_t k = 0; k < size; ++k) {
      char& a = base[i * size + k];
      char& b = base[(count - 1 - i) * size + k];
      const char held = a;
      a = b;
      b = held;
    }
}

struct Compare {
  int (*function)(const void*, const void*);
};
int compare_by(const void* a, const void* b, void* by) {
  return static_cast<Compare*>(by)->function(a, b);
}

void sort(void* base, std::size_t count, std::size_t size, CompareWith compare, void* with) {
  static void (*real)(void*, std::size_t, std::size_t, CompareWith, void*) = nullptr;
  const auto found = real_function(real, "qsort_r");
  const Call call = begin_call(Function::qsort);
  found(base, count, size, compare, with);
  if (!call.is_changed || settings().sort_mode == 0) return;
  // Reverses runs of equal elements in the sorted array: no sort must keep their order.
  auto* bytes = static_cast<char*>(base);
  bool has_ties = false;
  for (std::size_t first = 0, end = 0; first < count; first = end) {
    for (end = first + 1; end < count && compare(bytes + first * size, bytes + end * size, with) == 0;) ++end;
    if (end - first < 2) continue;
    reverse(bytes + first * size, end - first, size);
    has_ties = true;
  }
  if (has_ties) count_change();
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API void qsort(void* base, std::size_t count, std::size_t size,
                             int (*compare)(const void*, const void*)) {
  Compare by{compare};
  sort(base, count, size, compare_by, &by);
}

TICKTRUE_SHIM_API void qsort_r(void* base, std::size_t count, std::size_t size, CompareWith compare, void* with) {
  sort(base, count, size, compare, with);
}
