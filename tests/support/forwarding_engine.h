// An engine that forwards every call to another engine: the base of test engines with an injected fault.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>

#include "engine/engine.h"

namespace ticktrue::test {

class ForwardingEngine : public engine::Engine {
 public:
  explicit ForwardingEngine(std::unique_ptr<engine::Engine> inner) : inner_(std::move(inner)) {}

  Status accept(const TickInput& input) const override { return inner_->accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override { return inner_->step(input, observer); }
  const StateView& state() const override { return inner_->state(); }
  Status load(ByteView image) override { return inner_->load(image); }
  std::span<const std::string> stage_names() const override { return inner_->stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return inner_->row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return inner_->inputs_text(tick, inputs);
  }
  std::vector<engine::StageDescription> describe() const override { return inner_->describe(); }
  const engine::Scene& scene() const override { return inner_->scene(); }
  std::vector<engine::BodyReport> bodies() const override { return inner_->bodies(); }
  std::vector<engine::ContactReport> contacts() const override { return inner_->contacts(); }
  engine::BroadPhaseReport broad_phase() const override { return inner_->broad_phase(); }
  std::uint64_t tick() const override { return inner_->tick(); }
  double time_s() const override { return inner_->time_s(); }
  std::uint64_t ignored_inputs() const override { return inner_->ignored_inputs(); }
  std::optional<engine::BudgetReport> budget_report() const override { return inner_->budget_report(); }
  void forget_caches(engine::CacheSet caches) override { inner_->forget_caches(caches); }
  engine::CacheReport cache_report() const override { return inner_->cache_report(); }

 protected:
  engine::Engine& inner() { return *inner_; }
  const engine::Engine& inner() const { return *inner_; }

 private:
  std::unique_ptr<engine::Engine> inner_;
};

}  // namespace ticktrue::test
