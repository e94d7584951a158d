// Errors of parallel loops, where an exception would end the process, and of YADE's run thread.
#pragma once

#include <string>

namespace yade {

class Scene;

/// Stops the run. Raises a ValueError in Python as soon as its main thread runs, right after
/// O.step().
void deferError(const std::string& message);

/// Stores an error of the scene in a parallel loop; ContactDynamics throws it later in this step.
void leaveSceneError(const Scene&, const std::string& message);
/// Returns the error of the scene in this step, and clears it; empty: none.
std::string takeSceneError(const Scene&);

/// Stores the message of an exception that ended a step. YADE's run thread discards it if nobody
/// waits for the run.
void rememberError(const std::string& message);
/// Returns the message of the exception that ended the last run, and clears it.
std::string takeError();

/// Waits until YADE's thread of a run has begun. YADE does not wait for a thread that has not, when
/// it destroys the run; that thread would then read freed memory. Releases Python's lock meanwhile.
void awaitStart();

/// Waits until a paused run is over, since O.pause() returns during its last step. Releases
/// Python's lock meanwhile.
void awaitEnd();

} // namespace yade
