// Processes that outlive the child that started them, and that have left its process group.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <vector>

namespace ticktrue::verifier {

/// Calls fork(). From the first call on, processes whose parent has ended become children of this process (Linux), so
/// that they can be found. The child counts as this process's own until forget_own_child.
pid_t fork_own_child();
void forget_own_child(pid_t id);

/// Whether the process continues without its first thread (Linux; false on other systems).
bool main_thread_has_ended(pid_t id);

/// Children of this process that it did not start itself and has not returned before. Reaps ended processes. With
/// several runs at once, the first run to end returns them. Linux only; empty on other systems.
std::vector<EscapedChild> escaped_children();

}  // namespace ticktrue::verifier

#endif
