// A terminal that a program prints to, and whose text is discarded.
// SPDX-License-Identifier: MIT
#pragma once

#include <thread>

namespace ticktrue::shake {

/// Discards printed text, so that the program never blocks. Systems other than Linux have no such terminal.
class Terminal {
 public:
  Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  /// For the standard output of a child; -1: no terminal.
  int descriptor() const { return program_side_; }

 private:
  int own_side_ = -1;
  int program_side_ = -1;
  int end_[2] = {-1, -1};  // a pipe; closing it ends the reader
  std::thread reader_;
};

}  // namespace ticktrue::shake
