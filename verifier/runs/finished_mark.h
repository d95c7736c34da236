// How a program tells whoever runs it that its work was done: an exit status alone also comes from exit(0).
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::verifier {

/// The environment variable that run_child sets: the number of a descriptor to write one byte to.
inline constexpr const char* finished_mark_variable = "TICKTRUE_FINISHED_FD";

/// At the start of a program: takes the descriptor, so that programs it starts itself do not have it.
void take_finished_mark();
/// In a forked child that does not speak for this program.
void drop_finished_mark();
/// At the end: says that the work was done. Without such a descriptor it does nothing.
void write_finished_mark();

}  // namespace ticktrue::verifier
