// Errors of ticktrue/math.h in ulp: against MPFR, and for every float against the C library's double.
// SPDX-License-Identifier: MIT
//
// usage: accuracy [--count N] [--every-float] [FUNCTION...]    Exits 1 if a bound of ticktrue/math.h is exceeded.
#include <mpfr.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "tests/math/functions.h"

namespace {

struct Reference {
  const char* name;
  int (*one)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
  int (*two)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);
  double (*library)(double);
  double bound_f64, bound_f32;  // ulp
};

const Reference references[] = {{"sin", mpfr_sin, nullptr, std::sin, 0.82, 0.501},
                                {"cos", mpfr_cos, nullptr, std::cos, 0.82, 0.501},
                                {"tan", mpfr_tan, nullptr, std::tan, 0.95, 0.501},
                                {"asin", mpfr_asin, nullptr, std::asin, 0.70, 0.501},
                                {"acos", mpfr_acos, nullptr, std::acos, 0.65, 0.501},
                                {"atan", mpfr_atan, nullptr, std::atan, 0.65, 0.501},
                                {"exp", mpfr_exp, nullptr, std::exp, 0.51, 0.501},
                                {"log", mpfr_log, nullptr, std::log, 0.62, 0.501},
                                {"sqrt", mpfr_sqrt, nullptr, std::sqrt, 0.5, 0.5},
                                {"atan2", nullptr, mpfr_atan2, nullptr, 0.65, 0.501},
                                {"pow", nullptr, mpfr_pow, nullptr, 0.53, 0.501},
                                {"hypot", nullptr, mpfr_hypot, nullptr, 0.51, 0.501},
                                {"fmod", nullptr, mpfr_fmod, nullptr, 0, 0},
                                {"remainder", nullptr, mpfr_remainder, nullptr, 0, 0},
                                {"floor", mpfr_rint_floor, nullptr, std::floor, 0, 0},
                                {"ceil", mpfr_rint_ceil, nullptr, std::ceil, 0, 0},
                                {"trunc", mpfr_rint_trunc, nullptr, std::trunc, 0, 0},
                                {"round", mpfr_rint_round, nullptr, std::round, 0, 0},
                                {"rint", mpfr_rint_roundeven, nullptr, std::rint, 0, 0}};

const Reference& reference_of(const char* name) {
  for (const Reference& reference : references)
    if (std::strcmp(reference.name, name) == 0) return reference;
  std::abort();
}

struct Worst {
  double error = 0, x = 0, y = 0;
  void see(double found, double at_x, double at_y) {
    if (!(found <= error)) *this = {found, at_x, at_y};  // a NaN counts as an error
  }
};

/// The distance of `got` from `exact` in units of the last place of `exact`, with `digits` bits from 2^`lowest` on.
double error_of(double got, mpfr_srcptr exact, int digits, int lowest, double largest) {
  if (mpfr_nan_p(exact)) return got != got ? 0 : HUGE_VAL;
  if (got != got) return HUGE_VAL;
  if (std::isinf(got)) {  // correct if the exact value rounds to infinity
    if (mpfr_sgn(exact) != (got > 0 ? 1 : -1)) return HUGE_VAL;
    mpfr_t limit;
    mpfr_init2(limit, 200);
    mpfr_set_d(limit, largest, MPFR_RNDN);
    mpfr_mul_d(limit, limit, 1 + std::ldexp(1.0, -digits - 1), MPFR_RNDN);
    const bool overflows = mpfr_cmpabs(exact, limit) >= 0;
    mpfr_clear(limit);
    return overflows ? 0 : HUGE_VAL;
  }
  if (mpfr_inf_p(exact)) return HUGE_VAL;
  if (mpfr_zero_p(exact)) return got == 0 ? 0 : HUGE_VAL;
  long exponent = mpfr_get_exp(exact) - digits;
  if (exponent < lowest) exponent = lowest;
  mpfr_t difference;
  mpfr_init2(difference, 200);
  mpfr_sub_d(difference, exact, got, MPFR_RNDN);
  mpfr_mul_2si(difference, difference, -exponent, MPFR_RNDN);
  const double error = std::fabs(mpfr_get_d(difference, MPFR_RNDN));
  mpfr_clear(difference);
  return error;
}

class Evaluator {
 public:
  explicit Evaluator(const Reference& reference) : reference_(reference) {
    mpfr_inits2(53, x_, y_, static_cast<mpfr_ptr>(nullptr));
    mpfr_init2(exact_, 130);
  }
  ~Evaluator() { mpfr_clears(x_, y_, exact_, static_cast<mpfr_ptr>(nullptr)); }
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  mpfr_srcptr at(double x, double y) {
    mpfr_set_d(x_, x, MPFR_RNDN);
    mpfr_set_d(y_, y, MPFR_RNDN);
    if (reference_.one != nullptr) {
      reference_.one(exact_, x_, MPFR_RNDN);
    } else {
      reference_.two(exact_, x_, y_, MPFR_RNDN);
    }
    return exact_;
  }

 private:
  const Reference& reference_;
  mpfr_t x_, y_, exact_;
};

/// Arguments of many sizes: in the table's range, close to its ends and to 1, and of any exponent.
double argument(ticktrue_random& random, double low, double high, std::uint32_t i) {
  const double any = next_f64(&random, low, high, i);
  switch (i % 16) {
    case 0:
      return next_f64(&random, -1, 1, 0);
    case 1:
      return 1 + next_f64(&random, -0.07, 0.07, 0);
    case 2:
      return next_f64(&random, -1, 1, 0) * std::ldexp(1.0, static_cast<int>(random.state % 64) - 40);
    case 4:
      return high > 1 ? next_f64(&random, -750, 750, 0) : any;
    case 5:
      return static_cast<double>(ticktrue_random_between(&random, -200000, 200000)) * 0.78539816339744831;
    case 6:
      return low < 0 ? 0.5 + next_f64(&random, -0.01, 0.01, 0) : any;
    default:
      return any;
  }
}

Worst worst_f64(const MathFunction& function, std::uint32_t count) {
  Evaluator exact(reference_of(function.name));
  Worst worst;
  ticktrue_random random = ticktrue_random_seeded(64, 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = argument(random, function.low, function.high, i);
    const double y = function.argument_count == 2 ? argument(random, function.low_y, function.high_y, i / 16) : 0;
    worst.see(error_of(function.f64(x, y), exact.at(x, y), 53, -1074, DBL_MAX), x, y);
  }
  return worst;
}

Worst worst_f32(const MathFunction& function, std::uint32_t count) {
  Evaluator exact(reference_of(function.name));
  Worst worst;
  ticktrue_random random = ticktrue_random_seeded(32, 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(argument(random, function.low, function.high, i));
    const auto y = static_cast<float>(
        function.argument_count == 2 ? argument(random, function.low_y, function.high_y, i / 16) : 0);
    worst.see(error_of(function.f32(x, y), exact.at(x, y), 24, -149, FLT_MAX), x, y);
  }
  return worst;
}

/// Compares every float with the C library's double, whose own error is below a 2^28th of a float's ulp.
Worst worst_of_every_float(const MathFunction& function) {
  const Reference& reference = reference_of(function.name);
  Worst worst;
  std::uint32_t bits = 0;
  do {
    const float x = ttm_from_bits_f32(bits);
    const float got = function.f32(x, 0);
    const double exact = reference.library(x);
    double error = 0;
    if (static_cast<float>(exact) != got && !(exact != exact && got != got)) {
      int exponent = std::ilogb(exact) - 23;
      if (exponent < -149) exponent = -149;
      error = std::fabs(std::ldexp(exact - static_cast<double>(got), -exponent));
    } else if (exact != 0 && std::fabs(exact) <= FLT_MAX) {
      continue;  // rounded correctly
    }
    if (error > worst.error || error != error) worst.see(error, x, 0);
  } while (++bits != 0);
  return worst;
}

}  // namespace

int main(int count, char** words) {
  std::uint32_t argument_count = 20000;
  bool every_float = false;
  std::vector<std::string> names;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word == "--count" && i + 1 < count) {
      argument_count = static_cast<std::uint32_t>(std::strtoul(words[++i], nullptr, 10));
    } else if (word == "--every-float") {
      every_float = true;
    } else {
      names.push_back(word);
    }
  }
  int status = 0;
  for (const MathFunction& function : math_functions) {
    bool wanted = names.empty();
    for (const std::string& name : names) wanted = wanted || name == function.name;
    if (!wanted) continue;
    const Reference& reference = reference_of(function.name);
    if (every_float) {
      if (function.argument_count != 1) continue;
      const Worst worst = worst_of_every_float(function);
      std::printf("%-9s f32 %.6f ulp at %.9g, every float\n", function.name, worst.error, worst.x);
      if (!(worst.error <= reference.bound_f32)) status = 1;
    } else {
      const Worst wide = worst_f64(function, argument_count), narrow = worst_f32(function, argument_count);
      std::printf("%-9s f64 %.4f ulp at %.17g %.17g   f32 %.6f ulp at %.9g %.9g\n", function.name, wide.error, wide.x,
                  wide.y, narrow.error, narrow.x, narrow.y);
      if (!(wide.error <= reference.bound_f64) || !(narrow.error <= reference.bound_f32)) status = 1;
    }
    std::fflush(stdout);
  }
  return status;
}
