#include "watch/missed_steps.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

namespace rcr {

namespace {
	constexpr double none = std::numeric_limits<double>::infinity();
}

bool MissedSteps::count(bool stepMissed, bool stepYielded, double overlap, bool takenBack)
{
	++steps;
	if (steps == 1 && !stepMissed) toldDeepest = overlap;
	missed += stepMissed;
	yielded += stepYielded;
	if (!takenBack || stepMissed) deepest = std::max(deepest, overlap);
	const bool first    = missed > 0 && toldMissed == 0;
	const bool deeper   = deepest > (missed > 0 ? harmless : takenBack ? none : deep) && deepest >= 2 * toldDeepest;
	const bool moreOften = yielded > 0 && yielded >= 10 * toldYielded;
	if (!first && !deeper && !moreOften) return false;
	toldMissed = missed, toldYielded = yielded, toldDeepest = deepest;
	return true;
}

std::string MissedSteps::message() const
{
	std::ostringstream text;
	text.precision(2);
	if (missed == 0) {
		text << "the deepest overlap, " << deepest << " of R₁ + R₂, grows although all steps reached the tolerance. Something moves the bodies that the solver "
		     << "does not see, such as forces that a PyRunner adds after ContactDynamics, or positions that are set; or they go too far in a step: take a smaller one.";
		return text.str();
	}
	if (steps == 1) text << "the first step did not reach the tolerance";
	else
		text << missed << " of " << steps << " steps so far did not reach the tolerance";
	if (deepest > deep) text << " or left an overlap beyond " << deep;
	if (yielded > 0) text << ", " << yielded << " of them without a solution, so that contacts have yielded to driven bodies";
	if (deepest == 0) text << "; no bodies overlap, so it is harmless. This is told again if it gets worse.";
	else if (deepest <= harmless)
		text << "; the deepest overlap, " << deepest << " of R₁ + R₂, is harmless. This is told again if it gets worse.";
	else
		text << "; the deepest overlap, " << deepest << " of R₁ + R₂, is beyond the " << harmless << " of beds at rest or in flow. "
		     << (yielded > 0 ? "Slow down or reverse what is driven, or press by a force." : "Take a smaller time step or more maxIterations.");
	return text.str();
}

} // namespace rcr
