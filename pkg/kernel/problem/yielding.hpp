// Law of yielding contacts (sweep/solve_yielding.cpp).
#pragma once

#include <algorithm>
#include <limits>

namespace rcr {

struct Yielding {
	double compliance = 0, leastResponse = 0; // ε [-], w₀ [1/kg]
	/// Normal impulse beyond which contacts yield even if the step has a solution [N s].
	double yieldImpulse = std::numeric_limits<double>::infinity();

	/// Impulse of a yielding contact over that of a rigid one [-].
	double yieldFactor(double responseNn) const
	{
		return 1 / (1 + compliance * std::max(1.0, leastResponse / responseNn));
	}
};

} // namespace rcr
