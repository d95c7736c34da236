// Processes that outlive the child that started them and have left its process group.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <vector>

namespace ticktrue::verifier {

/// fork(). From the first call on, processes whose parent has ended become children of this one (Linux), so that they
/// can be found; the child is known as started by this process until forget_own_child.
pid_t fork_own_child();
void forget_own_child(pid_t id);

/// Whether the process goes on without its first thread (Linux; elsewhere: not known, false).
bool main_thread_has_ended(pid_t id);

/// Children of this process that it did not start itself and that were not named before. Processes that have ended are
/// reaped. With several runs at once, the first to end names them. Elsewhere than on Linux: none.
std::vector<EscapedChild> escaped_children();

}  // namespace ticktrue::verifier

#endif
