#include "watch/step_counts.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

namespace rcr {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// Returns true if a count has grown tenfold since the last warning.
static bool grownTenfold(long count, long warned) { return count > 0 && count >= 10 * warned; }

bool StepCounts::count(bool hasMissed, bool hasYielded, double overlap, bool removesOverlaps,
        bool hasIntruded)
{
	++steps;
	if (steps == 1 && !hasMissed) warnedDepth = overlap;
	missed += hasMissed;
	yielded += hasYielded;
	intruded += hasIntruded;
	if (!removesOverlaps || hasMissed) deepest = std::max(deepest, overlap);
	const bool deeper = deepest > (missed == 0 && removesOverlaps ? unlimited : reportedOverlap)
	        && deepest >= 2 * warnedDepth;
	const bool moreOften
	        = grownTenfold(yielded, warnedYielded) || grownTenfold(intruded, warnedIntruded);
	if (!deeper && !moreOften) return false;
	warnedYielded = yielded, warnedIntruded = intruded, warnedDepth = deepest;
	return true;
}

std::string StepCounts::message() const
{
	std::ostringstream text;
	text.precision(2);
	const auto deepestText = [&] { text << "the deepest overlap is " << deepest << " of R₁ + R₂"; };
	if (missed == 0 && yielded == 0 && intruded == 0) {
		deepestText();
		text << " and grows, although all steps converged. Positions and forces are wrong to that "
		        "extent. Something moves the bodies beside the "
		     << "solver: bodies inserted into others, positions that a script sets, forces added "
		        "after ContactDynamics, or displacements "
		     << "in a step that are too large; remove it, or take a smaller O.dt.";
		return text.str();
	}
	text << (missed > 0 ? missed : yielded > 0 ? yielded : intruded) << " of " << steps
	     << (steps == 1 ? " step has" : " steps have")
	     << (missed > 0 ? " not converged" : yielded > 0 ? " no solution" : " intrusions");
	if (missed > 0 && yielded > 0) text << ", " << yielded << " of them without a solution";
	text << "; ";
	deepestText();
	text << ". ";
	if (intruded > 0)
		text << "In " << intruded << (intruded == 1 ? " step" : " steps")
		     << " bodies moved into each other by more than a cap radius on their paths, and may "
		        "have passed through each other. Take a smaller O.dt.";
	if (yielded > 0)
		text << (intruded > 0 ? " " : "")
		     << "Forces of the steps without a solution are those of yielding contacts: leave these "
		        "steps out of averages. Slow down or reverse what is driven, or press by a force.";
	else if (intruded == 0)
		text << "Positions are wrong to that extent. Place bodies apart at the start, take a "
		        "smaller O.dt or more maxIterations.";
	return text.str();
}

} // namespace rcr
