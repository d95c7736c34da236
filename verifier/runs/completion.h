// A program reports completed work to its parent process: an exit status alone can also come from exit(0).
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::verifier {

/// The environment variable that run_child sets: the number of the pipe descriptor to write one byte to.
inline constexpr const char* completion_variable = "TICKTRUE_FINISHED_FD";

/// To be called at the start of a program: reads the descriptor and marks it close-on-exec.
void take_completion_pipe();
/// To be called in a forked child that must not report completion.
void close_completion_pipe();
/// To be called at the end: writes the byte. Without a descriptor it does nothing.
void report_completion();

}  // namespace ticktrue::verifier
