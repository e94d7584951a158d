#include "watch/missed_steps.hpp"

#include <algorithm>
#include <sstream>

namespace rcr {

bool MissedSteps::count(bool stepMissed, bool stepYielded, double overlap)
{
	++steps;
	missed += stepMissed;
	yielded += stepYielded;
	deepest             = std::max(deepest, overlap);
	const bool first    = missed > 0 && toldMissed == 0;
	const bool deeper   = missed > 0 && deepest > harmless && deepest >= 2 * toldDeepest;
	const bool moreOften = yielded > 0 && yielded >= 10 * toldYielded;
	if (!first && !deeper && !moreOften) return false;
	toldMissed = missed, toldYielded = yielded, toldDeepest = deepest;
	return true;
}

std::string MissedSteps::message() const
{
	std::ostringstream text;
	text.precision(2);
	text << missed << " of " << steps << " steps missed the tolerance (" << 100 * share() << " %)";
	if (yielded > 0) text << ", " << yielded << " of them without a solution, where contacts have yielded to driven bodies";
	text << "; the deepest overlap so far is " << deepest << " of the radii";
	if (deepest <= harmless) text << ": harmless. This is told again if it gets worse.";
	else
		text << ", beyond the " << harmless << " of beds at rest or in flow. " << (yielded > 0 ? "Slow down or reverse what is driven, or press by a force." : "Take a smaller time step or more iterations.");
	return text.str();
}

} // namespace rcr
