// Time of the functions of ticktrue/math.h and of the C library's, in turn over the same arguments.
// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "include/ticktrue/math.h"

namespace {

constexpr std::size_t argument_count = 4096;

template <class Real>
struct Arguments {
  std::vector<Real> x, y;
};

struct Range {
  double low, high;
};

template <class Real>
Arguments<Real> arguments_in(Range x, Range y) {
  Arguments<Real> arguments;
  ticktrue::math::Random random(5);
  for (std::size_t i = 0; i < argument_count; ++i) {
    arguments.x.push_back(static_cast<Real>(x.low + (x.high - x.low) * random.unit_double()));
    arguments.y.push_back(static_cast<Real>(y.low + (y.high - y.low) * random.unit_double()));
  }
  return arguments;
}

/// Nanoseconds per call.
template <class Real, class Function>
double time_of(const Arguments<Real>& arguments, Function function) {
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < argument_count; ++i) {
    Real result = function(arguments.x[i], arguments.y[i]);
    benchmark::DoNotOptimize(result);
  }
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - begin;
  return time.count() / static_cast<double>(argument_count);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

template <class Real>
using Function = Real (*)(Real x, Real y);

template <class Real, Function<Real> ours, Function<Real> theirs>
void compare(benchmark::State& bench, Range x, Range y) {
  const Arguments<Real> arguments = arguments_in<Real>(x, y);
  std::vector<double> our_times, their_times, ratios;
  for (auto _ : bench) {
    our_times.push_back(time_of(arguments, [](Real a, Real b) { return ours(a, b); }));
    their_times.push_back(time_of(arguments, [](Real a, Real b) { return theirs(a, b); }));
    ratios.push_back(our_times.back() / their_times.back());
  }
  bench.counters["ours_ns"] = median(our_times);
  bench.counters["libm_ns"] = median(their_times);
  bench.counters["ratio"] = median(ratios);
}

#define ONE(name)                   \
  template <class Real>             \
  Real our_##name(Real x, Real) {   \
    return ticktrue::math::name(x); \
  }                                 \
  template <class Real>             \
  Real their_##name(Real x, Real) { \
    return std::name(x);            \
  }
#define TWO(name)                      \
  template <class Real>                \
  Real our_##name(Real x, Real y) {    \
    return ticktrue::math::name(x, y); \
  }                                    \
  template <class Real>                \
  Real their_##name(Real x, Real y) {  \
    return std::name(x, y);            \
  }
ONE(sin)
ONE(cos)
ONE(tan)
ONE(asin)
ONE(acos)
ONE(atan)
ONE(exp)
ONE(log)
ONE(sqrt)
ONE(floor)
ONE(round)
TWO(atan2)
TWO(pow)
TWO(hypot)
TWO(fmod)
TWO(remainder)

template <Function<double> our_f64, Function<double> their_f64, Function<float> our_f32, Function<float> their_f32>
void add(const std::string& name, Range x, Range y = {0, 0}) {
  benchmark::RegisterBenchmark((name + "_f64").c_str(), compare<double, our_f64, their_f64>, x, y)->Iterations(2000);
  benchmark::RegisterBenchmark((name + "_f32").c_str(), compare<float, our_f32, their_f32>, x, y)->Iterations(2000);
}
#define ADD(name, ...) \
  add<our_##name<double>, their_##name<double>, our_##name<float>, their_##name<float>>(#name, __VA_ARGS__)

void add_all() {
  ADD(sin, {-100, 100});
  ADD(cos, {-100, 100});
  ADD(tan, {-100, 100});
  ADD(asin, {-1, 1});
  ADD(acos, {-1, 1});
  ADD(atan, {-10, 10});
  ADD(atan2, {-10, 10}, {-10, 10});
  ADD(exp, {-80, 80});
  ADD(log, {0, 10});
  ADD(pow, {0, 10}, {-20, 20});
  ADD(sqrt, {0, 100});
  ADD(hypot, {-10, 10}, {-10, 10});
  ADD(fmod, {-1000, 1000}, {0, 10});
  ADD(remainder, {-1000, 1000}, {0, 10});
  ADD(floor, {-100, 100});
  ADD(round, {-100, 100});
}

}  // namespace

int main(int count, char** words) {
  add_all();
  benchmark::Initialize(&count, words);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
