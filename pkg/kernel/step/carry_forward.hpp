// Forces that a contact passes from its points of the last step to those of this step.
#pragma once

#include <cmath>
#include <utility>

namespace rcr {

/// The nearest point inherits a force. Two points inherit forces in their order along the tangent.
/// `along`: position of each point along the tangent [m]. `none`: a force of zero.
template <class Along, class Force>
inline void carryForward(int before, const Along& alongBefore, int now, const Along& alongNow,
        Force& force1, Force& force2, const Force& none)
{
	if (before == 1 && now == 2) {
		const bool second
		        = std::abs(alongNow[1] - alongBefore[0]) < std::abs(alongNow[0] - alongBefore[0]);
		force2            = second ? force1 : none;
		if (second) force1 = none;
	} else if (before == 2 && now == 1) {
		if (std::abs(alongBefore[1] - alongNow[0]) < std::abs(alongBefore[0] - alongNow[0]))
			force1 = force2;
		force2 = none;
	} else if (before == 2 && now == 2
	        && (alongBefore[0] < alongBefore[1]) != (alongNow[0] < alongNow[1])) {
		std::swap(force1, force2);
	}
}

} // namespace rcr
