// The helper threads of the process, which teams borrow while they run.
//
// Threads belong to the process: a team that is dropped, or kept but idle, holds none. There are never more than the teams that
// run at the same time have asked for; one that nobody has called for ten seconds ends. A child after fork() begins with none.
#pragma once

#include <memory>

namespace rcr {

class SharedLoop;

/// Calls threads − 1 helpers to the loop; those that are there already come again as soon as they leave. Where the system gives no
/// more threads there are fewer: the leader does their share.
void callHelpers(const std::shared_ptr<SharedLoop>&);

/// Helper threads that the process has now.
int helperCount();

} // namespace rcr
