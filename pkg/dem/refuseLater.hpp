// An error found in a parallel loop of YADE, where an exception would end the process: it is raised in Python as a ValueError
// as soon as the main thread is back there, that is right after O.step(), and a run in the background stops.
#pragma once

#include <string>

namespace yade {

void refuseLater(const std::string& message);

} // namespace yade
