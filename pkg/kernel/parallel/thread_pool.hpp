// Helper threads of the process, shared by all thread teams.
//
// A team holds helpers only while it runs. The pool never has more threads than the teams that run
// at one time have requested. A helper ends after ten seconds without a request. A child process
// starts without helpers after fork().
#pragma once

#include <memory>

namespace rcr {

class SharedLoop;

/// Assigns threads − 1 helpers to the loop. Helpers that served it before are preferred. If the
/// system provides fewer threads, the leader does their work.
void requestHelpers(const std::shared_ptr<SharedLoop>&);

int helperCount(); // of the process

} // namespace rcr
