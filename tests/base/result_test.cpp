// Result and Status: the value or the error, never neither.
// SPDX-License-Identifier: MIT
#include "base/result.h"

#include <memory>

#include "tests/support/catch.h"

namespace ticktrue {
namespace {

TEST_CASE("a result holds a value or an error, never both", "[base][result][analytic]") {
  const Result<int> good = 7;
  REQUIRE(good);
  CHECK(good.has_value());
  CHECK(*good == 7);
  CHECK(good.value() == 7);

  const Result<int> bad = Error{ErrorCode::limit, "place: too many: found 3, expected 2", "take fewer"};
  REQUIRE_FALSE(bad);
  CHECK(bad.error().code == ErrorCode::limit);
  CHECK(bad.error().message == "place: too many: found 3, expected 2");
  CHECK(bad.error().hint == "take fewer");
}

TEST_CASE("a result of a move-only value gives it away", "[base][result][analytic]") {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(5);
  REQUIRE(result);
  const std::unique_ptr<int> taken = *std::move(result);
  CHECK(*taken == 5);
}

TEST_CASE("a status is success unless it was made from an error", "[base][result][analytic]") {
  const Status good;
  CHECK(good);
  const Status bad = Error{ErrorCode::io, "disk full", ""};
  REQUIRE_FALSE(bad);
  CHECK(bad.error().code == ErrorCode::io);
  CHECK(bad.error().message == "disk full");
}

}  // namespace
}  // namespace ticktrue
