// Pitfall: threads write their result to one place, and the last one wins.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

class ThreadOrder : public Game {
 public:
  ThreadOrder() : Game(8), last_(run_count++ % 64) {}

 private:
  /// std::thread([&] { target = seen_by(thread); }) for each of 64 threads, each with a part of the map. The last
  /// thread wins. The scheduler decides which thread is last. Here it differs in each run, so that the test never
  /// passes by luck.
  void rules(float) override {
    if (tick() != 24) return;
    for (int thread = 0; thread < 64; ++thread)
      if (thread != last_) units[0].score = thread;
    units[0].score = last_;
  }
  static inline int run_count = 0;
  int last_;
};

}  // namespace

const Pitfall thread_order{"thread_order",
                           make_game<ThreadOrder>,
                           verifier::VerifyMode::replay,
                           verifier::Verdict::not_reproducible,
                           24,
                           "score",
                           {0}};

}  // namespace ticktrue::pitfalls
