// An error found in a parallel loop of YADE, where an exception would end the process: it is raised in Python as a ValueError
// as soon as the main thread is back there, that is right after O.step(), and a run in the background stops.
#pragma once

#include <string>

namespace yade {

void deferError(const std::string& message);

/// An exception that ends a step: YADE's run thread throws it away where it ends before the session waits for it.
void rememberError(const std::string& message);
/// What ended the last run, once: such an exception, or one of another engine.
std::string takeError();

/// Waits for a run that was paused to be over: O.pause() returns in the midst of its last step.
void awaitEnd();

} // namespace yade
