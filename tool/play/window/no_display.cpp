// Frames of equal length without a display: for tests, for pictures, for measuring.
// SPDX-License-Identifier: MIT
#include "tool/play/window/host.h"

namespace ticktrue::play {
namespace {

class NoDisplay : public Host {
 public:
  explicit NoDisplay(double hz) : hz_(hz) {}
  Result<HostFrame> next(const Canvas&) override {
    // From the number of frames, so that rounding errors do not accumulate.
    const double begin = static_cast<double>(frame_count_) / hz_;
    ++frame_count_;
    HostFrame frame;
    frame.seconds = static_cast<double>(frame_count_) / hz_ - begin;
    return frame;
  }
  void set_title(const std::string&) override {}

 private:
  double hz_;
  std::uint64_t frame_count_ = 0;
};

}  // namespace

std::unique_ptr<Host> no_display(double hz) {
  return std::make_unique<NoDisplay>(hz);
}

}  // namespace ticktrue::play
