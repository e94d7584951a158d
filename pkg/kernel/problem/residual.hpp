// Error measures of a solution. All solvers, tests and charts use these.
#pragma once

#include <algorithm>
#include <limits>

#include "problem/coulomb.hpp"
#include "problem/measures.hpp"

namespace rcr {

/// Largest friction coefficient [-], an angle of 89.94°. If a slipping point closes, µ |u_t|
/// outweighs |u_n|, and the residual is only about 1/µ. For µ > 1e4 such a point would meet the
/// default tolerance.
constexpr double maxFriction = 1e3;

/// Errors of the impulses. The velocities u are recomputed from them. Points between two prescribed
/// bodies (w_nn = 0) do not count.
Errors errorsOf(const ContactProblem&, double velocityFloor);

/// √(error2 / scale2); NaN if the scale overflows, because the error may have overflowed too.
inline double relativeRms(double error2, double scale2)
{
	if (error2 == 0) return 0;
	return scale2 <= std::numeric_limits<double>::max() ? std::sqrt(error2 / scale2)
	                                                    : std::numeric_limits<double>::quiet_NaN();
}

/// Terms of one point in the sums. `u`: without the bias; `wnn` > 0.
inline Measures measuresOf(LocalVector p, LocalVector u, double bias, double friction, double wnn)
{
	const double un       = u.n + bias;
	const double error2   = square(lawError(p, { un, u.t }, friction, wnn));
	const double stopping = (std::abs(u.n) + std::abs(bias)) / wnn;
	return { error2, square(p), p.n, wnn * wnn * error2, square(u), stopping * stopping,
		     -dot(p, { un, u.t }) };
}

/// Residual from sums of squares over the points: error, p, and the impulse that stops a point,
/// (|u_n| + |b_n|)/w_nn. Without load, ‖p‖ is a rounding error. The denominator is therefore at
/// least 1e-8 of the stopping impulses.
inline double residualFromSums(double error2, double impulse2, double stopping2)
{
	return relativeRms(error2, std::max(impulse2, 1e-16 * stopping2));
}

/// Errors from sums over the points; `freeVelocity2`: Σ |u_free|² [(m/s)²].
inline Errors errorsFromSums(const Measures& m, double freeVelocity2, double velocityFloor)
{
	const double scale2 = std::max(m.velocity2, velocityFloor * velocityFloor * freeVelocity2);
	return { residualFromSums(m.error2, m.impulse2, m.stopping2),
		relativeRms(m.kinematicError2, scale2) };
}

} // namespace rcr
