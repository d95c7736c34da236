// A page of memory that outlives the child process that writes to it.
// SPDX-License-Identifier: MIT
#include "verifier/runs/shared_count.h"

#if !defined(_WIN32) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_CAN_SHARE 1
#include <sys/mman.h>
#endif

#include <new>

namespace ticktrue::verifier {

SharedCount::SharedCount() {
#ifdef TICKTRUE_CAN_SHARE
  void* page = mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page != MAP_FAILED) page_ = new (page) Page;
#endif
}

SharedCount::~SharedCount() {
#ifdef TICKTRUE_CAN_SHARE
  if (page_ != &own_) munmap(page_, sizeof(Page));
#endif
}

void SharedCount::add_tick(double time_s) {
  page_->time_s.store(time_s, std::memory_order_relaxed);
  page_->ticks.fetch_add(1, std::memory_order_release);
}

std::uint64_t SharedCount::ticks() const {
  return page_->ticks.load(std::memory_order_acquire);
}

double SharedCount::time_s() const {
  return page_->time_s.load(std::memory_order_relaxed);
}

}  // namespace ticktrue::verifier
