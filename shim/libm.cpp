// libm: results off by one ulp, as another library or processor may return them; a log of all calls.
// SPDX-License-Identifier: MIT
#include <string.h>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::uint32_t mode_up = 1;
constexpr std::uint32_t mode_down = 2;
// A result with this many trailing zero bits is exact: every library returns it.
constexpr int exact_bits_double = 24;
constexpr int exact_bits_float = 9;

template <typename T>
struct Bits;
template <>
struct Bits<double> {
  using Word = std::uint64_t;
  static constexpr Word infinity = 0x7ff0000000000000;
  static constexpr Word magnitude = 0x7fffffffffffffff;
  static constexpr int exact = exact_bits_double;
};
template <>
struct Bits<float> {
  using Word = std::uint32_t;
  static constexpr Word infinity = 0x7f800000;
  static constexpr Word magnitude = 0x7fffffff;
  static constexpr int exact = exact_bits_float;
};

template <typename T>
typename Bits<T>::Word bits_of(T value) {
  typename Bits<T>::Word word;
  ::memcpy(&word, &value, sizeof word);
  return word;
}

template <typename T>
T off_by_one(T value, std::uint64_t number) {
  auto word = bits_of(value);
  const auto magnitude = word & Bits<T>::magnitude;
  if (magnitude == 0 || magnitude >= Bits<T>::infinity - 1) return value;
  if ((word & ((typename Bits<T>::Word{1} << Bits<T>::exact) - 1)) == 0) return value;
  const std::uint32_t mode = settings().libm_mode;
  const bool is_up = mode == mode_up || (mode != mode_down && (mixed(number) & 1) != 0);
  word = is_up ? word + 1 : word - 1;
  ::memcpy(&value, &word, sizeof value);
  count_change();
  return value;
}

template <typename T>
T finished(const Call& call, T value) {
  return call.is_changed && settings().libm_mode != 0 ? off_by_one(value, call.number) : value;
}

template <typename T>
T marked(Function function, T value, const void* return_address) {
  mark_call(function, bits_of(value), return_address);
  return value;
}

bool is_logging() {
  return settings().libm_log != 0;
}

template <typename T>
using Unary = T (*)(T);
template <typename T>
using Binary = T (*)(T, T);
template <typename T>
using SineCosine = void (*)(T, T*, T*);

template <typename T>
T unary(Function function, Unary<T>& real, const char* name, T x, const void* return_address) {
  const Call call = begin_call(function);
  const T value = real_function(real, name)(x);
  if (is_logging()) log_libm(function, call, bits_of(x), bits_of(value), return_address);
  return marked(function, finished(call, value), return_address);
}

template <typename T>
T binary(Function function, Binary<T>& real, const char* name, T x, T y, const void* return_address) {
  const Call call = begin_call(function);
  const T value = real_function(real, name)(x, y);
  if (is_logging()) log_libm(function, call, bits_of(x) * 31 + bits_of(y), bits_of(value), return_address);
  return marked(function, finished(call, value), return_address);
}

template <typename T>
void sine_cosine(Function function, SineCosine<T>& real, const char* name, T x, T* sine, T* cosine,
                 const void* return_address) {
  const Call call = begin_call(function);
  real_function(real, name)(x, sine, cosine);
  if (is_logging()) log_libm(function, call, bits_of(x), bits_of(*sine) * 31 + bits_of(*cosine), return_address);
  *sine = finished(call, *sine);
  *cosine = finished(call, *cosine);
  mark_call(function, bits_of(*sine) * 31 + bits_of(*cosine), return_address);
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

#define TICKTRUE_SHIM_NAME(name)                                                      \
  TICKTRUE_SHIM_API double name(double x) noexcept {                                  \
    static Unary<double> real = nullptr;                                              \
    return unary(Function::name, real, #name, x, __builtin_return_address(0));        \
  }                                                                                   \
  TICKTRUE_SHIM_API float name##f(float x) noexcept {                                 \
    static Unary<float> real = nullptr;                                               \
    return unary(Function::name##f, real, #name "f", x, __builtin_return_address(0)); \
  }
TICKTRUE_SHIM_LIBM_1(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
#define TICKTRUE_SHIM_NAME(name)                                                          \
  TICKTRUE_SHIM_API double name(double x, double y) noexcept {                            \
    static Binary<double> real = nullptr;                                                 \
    return binary(Function::name, real, #name, x, y, __builtin_return_address(0));        \
  }                                                                                       \
  TICKTRUE_SHIM_API float name##f(float x, float y) noexcept {                            \
    static Binary<float> real = nullptr;                                                  \
    return binary(Function::name##f, real, #name "f", x, y, __builtin_return_address(0)); \
  }
TICKTRUE_SHIM_LIBM_2(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME

TICKTRUE_SHIM_API void sincos(double x, double* sine, double* cosine) noexcept {
  static SineCosine<double> real = nullptr;
  sine_cosine(Function::sincos, real, "sincos", x, sine, cosine, __builtin_return_address(0));
}
TICKTRUE_SHIM_API void sincosf(float x, float* sine, float* cosine) noexcept {
  static SineCosine<float> real = nullptr;
  sine_cosine(Function::sincosf, real, "sincosf", x, sine, cosine, __builtin_return_address(0));
}
