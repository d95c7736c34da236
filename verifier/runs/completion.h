// A program reports to its parent process that its work is complete: an exit status alone also comes from exit(0).
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::verifier {

/// The environment variable that run_child sets: the number of the pipe descriptor to write one byte to.
inline constexpr const char* completion_variable = "TICKTRUE_FINISHED_FD";

/// At the start of a program: reads the descriptor and marks it close-on-exec.
void take_completion_pipe();
/// In a forked child that must not report completion.
void close_completion_pipe();
/// At the end: writes the byte. Without a descriptor it does nothing.
void report_completion();

}  // namespace ticktrue::verifier
