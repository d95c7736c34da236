// Lends simulations and takes them back.
// SPDX-License-Identifier: MIT
#include "verifier/inject/simulation_pool.h"

#include <utility>

#include "base/assert.h"

namespace ticktrue::verifier {

class SimulationPool::PooledSimulation : public Simulation {
 public:
  PooledSimulation(SimulationPool& pool, std::unique_ptr<Simulation> real) : pool_(pool), real_(std::move(real)) {}
  PooledSimulation(const PooledSimulation&) = delete;
  PooledSimulation& operator=(const PooledSimulation&) = delete;
  ~PooledSimulation() override { pool_.idle_.push_back(std::move(real_)); }

  Status accept(const TickInput& input) const override { return real_->accept(input); }
  Status step(const TickInput& input, StageObserver* observer) override {
    TICKTRUE_ASSERT(is_loaded_);
    return real_->step(input, observer);
  }
  const StateView& state() const override { return real_->state(); }
  Status load(ByteView image) override {
    Status loaded = real_->load(image);
    is_loaded_ = is_loaded_ || loaded.has_value();
    return loaded;
  }
  Status inject(const InnerFault& fault) override { return real_->inject(fault); }
  std::span<const std::string> stage_names() const override { return real_->stage_names(); }
  std::string row_name(std::size_t table, std::size_t row) const override { return real_->row_name(table, row); }
  std::string inputs_text(std::uint64_t tick, ByteView inputs) const override {
    return real_->inputs_text(tick, inputs);
  }

 private:
  SimulationPool& pool_;
  std::unique_ptr<Simulation> real_;
  bool is_loaded_ = false;
};

SimulationPool::SimulationPool(const SimulationInfo& real) : real_(real) {
  info_.name = real.name;
  info_.physics_version = real.physics_version;
  info_.make = [this](ByteView setup) -> Result<std::unique_ptr<Simulation>> {
    if (idle_.empty()) {
      Result<std::unique_ptr<Simulation>> made = real_.make(setup);
      if (!made) return made.error();
      idle_.push_back(std::move(*made));
    }
    std::unique_ptr<Simulation> taken = std::move(idle_.back());
    idle_.pop_back();
    return std::unique_ptr<Simulation>(std::make_unique<PooledSimulation>(*this, std::move(taken)));
  };
}

}  // namespace ticktrue::verifier
