// ticktrue/math.h: pinned digests, special values, the generator's published numbers, stable sorting.
// SPDX-License-Identifier: MIT
//
// Not verified here: errors in ulp (tests/math/accuracy.cpp), other compilers and flags (tests/math/compilers.sh).
#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "tests/math/digest.h"
#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

constexpr std::uint32_t argument_count = 100000;  // like the first column of digests.tsv

/// Lines "name digest ..." of tests/math/digests.tsv.
std::vector<std::pair<std::string, std::string>> pinned_digests() {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/tests/math/digests.tsv");
  REQUIRE(in.good());
  std::vector<std::pair<std::string, std::string>> lines;
  std::string name, digest, rest;
  while (in >> name >> digest && std::getline(in, rest)) lines.emplace_back(name, digest);
  return lines;
}

std::string digest_of(const MathFunction& function, bool wide) {
  ticktrue_random random = ticktrue_random_seeded(23, 4);
  Bytes bytes;
  for (std::uint32_t first = 0; first < argument_count; first += math_block_count) {
    std::array<unsigned char, 8 * math_block_count> block;
    const std::uint32_t count = std::min(argument_count - first, math_block_count);
    const std::size_t size = math_block(&function, wide ? 1 : 0, &random, first, count, block.data());
    bytes.insert(bytes.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(size));
  }
  return hex64(hash64(bytes));
}

TEST_CASE("functions of math.h have the digests of every platform", "[math][determinism]") {
  std::vector<std::pair<std::string, std::string>> found;
  for (const MathFunction& function : math_functions) {
    found.emplace_back(function.name + std::string("_f64"), digest_of(function, true));
    found.emplace_back(function.name + std::string("_f32"), digest_of(function, false));
  }
  std::vector<unsigned char> others(math_others_size);
  math_others(others.data());
  found.emplace_back("others", hex64(hash64(others)));
  const auto pinned = pinned_digests();
  REQUIRE(pinned.size() == found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].first == pinned[i].first);
    CHECK(found[i].first + " " + found[i].second == pinned[i].first + " " + pinned[i].second);
  }
}

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double largest = std::numeric_limits<double>::max();
constexpr double least = std::numeric_limits<double>::denorm_min();

struct Special {
  const char* name;
  double x, y, expected;
};
// C11, annex F.10; large angles are from MPFR.
constexpr Special specials[] = {
    {"sin", 0, 0, 0},
    {"sin", -0.0, 0, -0.0},
    {"sin", infinite, 0, nan_value},
    {"sin", nan_value, 0, nan_value},
    {"sin", -nan_value, 0, nan_value},
    {"sin", least, 0, least},
    {"sin", 1e22, 0, -0.85220084976718879},
    {"cos", 0, 0, 1},
    {"cos", -infinite, 0, nan_value},
    {"cos", 1e22, 0, 0.52321478539513899},
    {"cos", 5.3193726483265414e+255, 0, -4.6871659242546277e-19},  // the double closest to a multiple of pi/2
    {"sin", largest, 0, 0.004961954789184062},
    {"cos", largest, 0, -0.99998768942655991},
    {"tan", -0.0, 0, -0.0},
    {"tan", infinite, 0, nan_value},
    {"tan", 5.3193726483265414e+255, 0, -2.1334853857537039e+18},
    {"asin", 1, 0, 1.5707963267948966},
    {"asin", -0.0, 0, -0.0},
    {"asin", 1.0000000000000002, 0, nan_value},
    {"acos", 1, 0, 0},
    {"acos", -1, 0, 3.1415926535897931},
    {"acos", -0.0, 0, 1.5707963267948966},
    {"acos", -2, 0, nan_value},
    {"atan", -infinite, 0, -1.5707963267948966},
    {"atan", -0.0, 0, -0.0},
    {"atan2", 0.0, -0.0, 3.1415926535897931},
    {"atan2", -0.0, -0.0, -3.1415926535897931},
    {"atan2", -0.0, 0.0, -0.0},
    {"atan2", 0.0, -1, 3.1415926535897931},
    {"atan2", -0.0, 1, -0.0},
    {"atan2", -1, 0.0, -1.5707963267948966},
    {"atan2", infinite, infinite, 0.78539816339744828},
    {"atan2", -infinite, -infinite, -2.3561944901923448},
    {"atan2", 1, -infinite, 3.1415926535897931},
    {"atan2", -1, infinite, -0.0},
    {"atan2", infinite, -5, 1.5707963267948966},
    {"atan2", least, largest, 0},
    {"atan2", nan_value, 1, nan_value},
    {"exp", 0, 0, 1},
    {"exp", -0.0, 0, 1},
    {"exp", -infinite, 0, 0},
    {"exp", infinite, 0, infinite},
    {"exp", 709.782712893384, 0, 1.7976931348622732e+308},
    {"exp", 709.78271289338409, 0, infinite},
    {"exp", -745.13321910194111, 0, least},
    {"exp", -745.13321910194134, 0, 0},
    {"log", 1, 0, 0},
    {"log", 0, 0, -infinite},
    {"log", -0.0, 0, -infinite},
    {"log", -1, 0, nan_value},
    {"log", infinite, 0, infinite},
    {"log", least, 0, -744.44007192138122},
    {"pow", 0.0, -3, infinite},
    {"pow", -0.0, -3, -infinite},
    {"pow", -0.0, -2, infinite},
    {"pow", -0.0, 3, -0.0},
    {"pow", -0.0, 0.5, 0},
    {"pow", -1, infinite, 1},
    {"pow", -1, -infinite, 1},
    {"pow", 1, nan_value, 1},
    {"pow", nan_value, 0, 1},
    {"pow", nan_value, 1, nan_value},
    {"pow", -8, 1.0 / 3, nan_value},
    {"pow", -2, 3, -8},
    {"pow", 0.5, -infinite, infinite},
    {"pow", 2, -infinite, 0},
    {"pow", -infinite, 3, -infinite},
    {"pow", -infinite, -3, -0.0},
    {"pow", infinite, -1, 0},
    {"pow", 2, 0.5, 1.4142135623730951},
    {"pow", -1, 9007199254740993.0, 1},  // this literal is rounded to an even number
    {"pow", 1.0000000000000002, 1e300, infinite},
    {"hypot", -infinite, nan_value, infinite},
    {"hypot", nan_value, 1, nan_value},
    {"hypot", 3, -4, 5},
    {"hypot", largest, largest, infinite},
    {"hypot", least, 0, least},
    {"sqrt", -0.0, 0, -0.0},
    {"sqrt", -1, 0, nan_value},
    {"sqrt", infinite, 0, infinite},
    {"fmod", -0.0, 1, -0.0},
    {"fmod", -6, 3, -0.0},
    {"fmod", 5, infinite, 5},
    {"fmod", infinite, 1, nan_value},
    {"fmod", 1, 0, nan_value},
    {"fmod", largest, least, 0},
    {"remainder", 5, 2, 1},
    {"remainder", 7, 2, -1},
    {"remainder", -7, 2, 1},
    {"remainder", 3, infinite, 3},
    {"remainder", -6, 3, -0.0},
    {"floor", -0.5, 0, -1},
    {"floor", -0.0, 0, -0.0},
    {"floor", 0.9999999999999999, 0, 0},
    {"ceil", -0.5, 0, -0.0},
    {"ceil", 4503599627370495.5, 0, 4503599627370496.0},
    {"trunc", -0.9, 0, -0.0},
    {"round", 0.49999999999999994, 0, 0},
    {"round", -2.5, 0, -3},
    {"round", infinite, 0, infinite},
    {"rint", 2.5, 0, 2},
    {"rint", -0.5, 0, -0.0},
};

const MathFunction& function_of(const std::string& name) {
  for (const MathFunction& function : math_functions)
    if (function.name == name) return function;
  FAIL("no function " << name);
  return math_functions[0];
}

TEST_CASE("special values of math.h are those of C11, with one NaN", "[math][analytic]") {
  for (const Special& special : specials) {
    CAPTURE(special.name, special.x, special.y);
    const double expected = special.expected != special.expected ? nan_value : special.expected;
    CHECK(hex64(bits_of(function_of(special.name).f64(special.x, special.y))) == hex64(bits_of(expected)));
    const auto x = static_cast<float>(special.x), y = static_cast<float>(special.y);
    const auto narrow = static_cast<float>(expected);
    const bool same_in_float = static_cast<double>(x) == special.x && static_cast<double>(y) == special.y &&
                               static_cast<double>(narrow) == expected;
    if (!same_in_float && !(expected != expected && x != 1 && y < 1)) continue;
    CHECK(hex32(bits_of(function_of(special.name).f32(x, y))) == hex32(bits_of(narrow)));
  }
}

TEST_CASE("functions of one sign are symmetric to the bit", "[math][analytic]") {
  ticktrue_random random = ticktrue_random_seeded(1, 2);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const double x = next_f64(&random, -2, 2, i), y = next_f64(&random, -2, 2, i / 4);
    if (x != x || y != y) continue;
    CAPTURE(x, y);
    for (const char* name : {"sin", "tan", "atan", "trunc", "round", "rint"})
      if (!(ticktrue_fabs(x) > largest && function_of(name).f64(x, 0) != function_of(name).f64(x, 0)))
        CHECK(bits_of(function_of(name).f64(-x, 0)) == bits_of(-function_of(name).f64(x, 0)));
    CHECK(bits_of(ticktrue_cos(-x)) == bits_of(ticktrue_cos(x)));
    CHECK(bits_of(ticktrue_atan2(-y, x)) == bits_of(-ticktrue_atan2(y, x)));
    CHECK(bits_of(ticktrue_hypot(x, y)) == bits_of(ticktrue_hypot(y, -x)));
    CHECK(bits_of(ticktrue_floor(-x)) == bits_of(-ticktrue_ceil(x)));
    double sine = 0, cosine = 0;
    math::sincos(x, sine, cosine);
    CHECK(bits_of(sine) == bits_of(ticktrue_sin(x)));
    CHECK(bits_of(cosine) == bits_of(ticktrue_cos(x)));
    float sine_f32 = 0, cosine_f32 = 0;
    math::sincos(static_cast<float>(x), sine_f32, cosine_f32);
    CHECK(bits_of(sine_f32) == bits_of(ticktrue_sinf(static_cast<float>(x))));
    CHECK(bits_of(cosine_f32) == bits_of(ticktrue_cosf(static_cast<float>(x))));
  }
}

TEST_CASE("overloads of math.h keep the type", "[math]") {
  static_assert(std::is_same_v<decltype(math::sin(1.0f)), float>);
  static_assert(std::is_same_v<decltype(math::sin(1.0)), double>);
  static_assert(std::is_same_v<decltype(math::pow(1.0f, 2.0f)), float>);
  CHECK(bits_of(math::atan2(1.0f, 2.0f)) == bits_of(ticktrue_atan2f(1.0f, 2.0f)));
  CHECK(bits_of(math::pow(1.5, 2.5)) == bits_of(ticktrue_pow(1.5, 2.5)));
}

TEST_CASE("the generator has the published numbers of PCG32", "[math][random]") {
  math::Random random(42, 54);  // pcg32-demo of the PCG C library
  for (const std::uint32_t expected : {0xa15c02b7u, 0x7b47f409u, 0xba1d3330u, 0x83d2f293u, 0xbfa4784bu, 0xcbed606eu})
    CHECK(hex32(random.u32()) == hex32(expected));
}

TEST_CASE("random integers and reals lie where they should, evenly", "[math][random]") {
  math::Random random(7);
  std::array<int, 6> counts{};
  for (int i = 0; i < 60000; ++i) ++counts[random.below(6)];
  for (const int count : counts) CHECK(std::abs(count - 10000) < 500);  // 5.5 standard deviations
  CHECK(random.below(0) == 0);
  CHECK(random.below(1) == 0);
  for (int i = 0; i < 1000; ++i) {
    const std::int32_t value = random.between(-3, 3);
    CHECK((value >= -3 && value <= 3));
    CHECK(random.between(5, 5) == 5);
    const float narrow = random.unit_float();
    const double wide = random.unit_double();
    CHECK((narrow >= 0 && narrow < 1 && wide >= 0 && wide < 1));
  }
  std::int64_t sum = 0;
  for (int i = 0; i < 1000; ++i)
    sum += random.between(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()) / 1000;
  CHECK(std::abs(sum) < 300000000);
  std::vector<int> rows{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, shuffled = rows;
  math::Random again(3);
  math::shuffle(shuffled.begin(), shuffled.end(), again);
  CHECK(shuffled != rows);
  std::sort(shuffled.begin(), shuffled.end());
  CHECK(shuffled == rows);
}

TEST_CASE("sorts are stable for every count", "[math][sort][equivalence]") {
  math::Random random(11);
  const auto less = [](const MathRow& a, const MathRow& b) { return a.key < b.key; };
  const auto is_same = [](const MathRow& a, const MathRow& b) { return a.key == b.key && a.place == b.place; };
  for (std::uint32_t count = 0; count < 300; ++count) {
    std::vector<MathRow> rows(count), buffer(count);
    for (std::uint32_t i = 0; i < count; ++i) rows[i] = {static_cast<double>(random.below(1 + count / 4)), i};
    std::vector<MathRow> expected = rows, by_template = rows;
    std::stable_sort(expected.begin(), expected.end(), less);
    math::sort(by_template.begin(), by_template.end(), less);
    ticktrue_sort(rows.data(), count, sizeof(MathRow), compare_rows, nullptr, buffer.data());
    CAPTURE(count);
    CHECK(std::equal(expected.begin(), expected.end(), by_template.begin(), is_same));
    CHECK(std::equal(expected.begin(), expected.end(), rows.begin(), is_same));
  }
  std::vector<std::unique_ptr<int>> owned;
  for (int i = 0; i < 100; ++i) owned.push_back(std::make_unique<int>(static_cast<int>(random.below(50))));
  math::sort(owned.begin(), owned.end(), [](const auto& a, const auto& b) { return *a < *b; });
  CHECK(std::is_sorted(owned.begin(), owned.end(), [](const auto& a, const auto& b) { return *a < *b; }));
}

TEST_CASE("floats are sorted by the total order", "[math][sort]") {
  const std::vector<double> expected{-nan_value, -infinite, -largest, -1,      -least,   -0.0,
                                     0.0,        least,     1,        largest, infinite, nan_value};
  std::vector<double> rows = expected;
  math::Random random(2);
  for (int round = 0; round < 100; ++round) {
    math::shuffle(rows.begin(), rows.end(), random);
    std::vector<double> by_function = rows;
    math::sort(rows.begin(), rows.end());
    math::sort(by_function.begin(), by_function.end(),
               [](double a, double b) { return ticktrue_total_order(a, b) < 0; });
    for (std::size_t i = 0; i < rows.size(); ++i) {
      CHECK(hex64(bits_of(rows[i])) == hex64(bits_of(expected[i])));
      CHECK(hex64(bits_of(by_function[i])) == hex64(bits_of(expected[i])));
    }
  }
  CHECK(ticktrue_total_orderf(-0.0f, 0.0f) < 0);
  CHECK(ticktrue_total_orderf(1.0f, 1.0f) == 0);
}

}  // namespace
}  // namespace ticktrue::test
