// `ticktrue` with an engine that uses a cache too long, so that the printed commands of `ticktrue reduce` can run.
// SPDX-License-Identifier: MIT
//
// If a body is faster than 3 m/s, a bit of its velocity is wrong in each tick that uses caches. The linker replaces
// make_engine by the function below (--wrap, tests/CMakeLists.txt).
#include <cmath>
#include <string>

#include "tests/support/forwarding_engine.h"
#include "tool/cli/command_line.h"

namespace {

using ticktrue::Bytes;
using ticktrue::Error;
using ticktrue::ErrorCode;
using ticktrue::Result;
using ticktrue::StateView;
using ticktrue::Status;
using ticktrue::TickInput;
using ticktrue::engine::Engine;
using ticktrue::engine::EngineOptions;
using ticktrue::engine::Scene;

class StaleEngine : public ticktrue::test::ForwardingEngine {
 public:
  StaleEngine(std::unique_ptr<Engine> inner, bool checks_caches)
      : ForwardingEngine(std::move(inner)), checks_caches_(checks_caches) {}

  void forget_caches(ticktrue::engine::CacheSet caches) override {
    is_cold_ = true;
    ForwardingEngine::forget_caches(caches);
  }

  Status step(const TickInput& input, ticktrue::StageObserver* observer) override {
    if (Status did = inner().step(input, observer); !did) return did;
    const bool is_cold = std::exchange(is_cold_, false);
    const auto bodies = inner().bodies();
    for (std::size_t row = 0; row < bodies.size() && !is_cold; ++row) {
      if (!(std::hypot(bodies[row].velocity.x, bodies[row].velocity.y) > 3)) continue;
      if (checks_caches_) return found(row);
      return flip(row);
    }
    return {};
  }

 private:
  /// The message of the engine (engine/world.cpp).
  Error found(std::size_t row) const {
    return {ErrorCode::inconsistent,
            "tick " + std::to_string(tick() - 1) + ": stage tgs_soft: bodies.velocity row " + std::to_string(row) +
                ": found 1 with cached structures, expected 0 without",
            ""};
  }

  Status flip(std::size_t row) {
    const StateView& state = inner().state();
    const std::size_t table = *state.schema->find_table("bodies");
    Bytes image;
    encode_image(state, image);
    const auto tables = split_image(*state.schema, image);
    std::size_t at = static_cast<std::size_t>((*tables)[table].rows.data() - image.data()) +
                     row * state.schema->tables[table].row_size;
    for (const ticktrue::Column& column : state.schema->tables[table].columns)
      if (column.name == "velocity") at += column.offset;
    image[at] ^= 1;
    return inner().load(image);
  }

  bool checks_caches_;
  bool is_cold_ = false;
};

}  // namespace

using Made = Result<std::unique_ptr<Engine>>;
Made make_real(const Scene& scene, const EngineOptions& options) __asm__("__real_" TICKTRUE_MAKE_ENGINE);
Made make_stale(const Scene& scene, const EngineOptions& options) __asm__("__wrap_" TICKTRUE_MAKE_ENGINE);

Made make_stale(const Scene& scene, const EngineOptions& options) {
  EngineOptions real = options;
  real.check_caches = false;  // this engine's own caches are correct
  Made made = make_real(scene, real);
  if (!made) return made;
  return std::unique_ptr<Engine>(std::make_unique<StaleEngine>(*std::move(made), options.check_caches));
}

int main(int argc, char** argv) {
  return ticktrue::cli::run_command_line(argc, argv);
}
