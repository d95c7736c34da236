// A terminal that a program prints to, and whose text nobody reads.
// SPDX-License-Identifier: MIT
#pragma once

#include <thread>

namespace ticktrue::shake {

/// Takes what is printed, so that the program need not wait. Elsewhere than on Linux there is none.
class Terminal {
 public:
  Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  /// For the standard output of a child; -1: there is no terminal.
  int descriptor() const { return program_side_; }

 private:
  int own_side_ = -1;
  int program_side_ = -1;
  int end_[2] = {-1, -1};  // a pipe: the reader ends when it is closed
  std::thread reader_;
};

}  // namespace ticktrue::shake
