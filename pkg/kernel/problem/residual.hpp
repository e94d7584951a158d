// The error measure of a solution, used by every solver, test and chart.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "problem/contact_problem.hpp"

namespace rcr {

/// Natural-map residual of De Saxcé's form of the contact law, relative [-]:
///
///   ‖ p − P_K( p − (u + (b_n + µ|u_t|) n) / w_nn ) ‖ / ‖p‖ ,   K = { |p_t| ≤ µ p_n },
///
/// with u computed anew from `impulse` (not from `velocity`). It is 0 if and only if the laws hold exactly. Points between two bodies
/// of prescribed motion (w_nn = 0) carry nothing and do not count.
/// Source: De Saxcé and Feng 1998; Acary, Brémond and Huber 2018, §4 (natural map).
double residual(const ContactProblem&);

/// The same error as a velocity, RMS of w_nn |p − P_K(…)| over the points, relative to the RMS of |u| or to the share `rest` of that
/// of the free velocities, the larger [-]: by how much points still close, or slip where they should stick. Computed from `impulse`.
double violation(const ContactProblem&, double rest);

/// √(error2/scale2). NaN where the scale overflows: the error is no smaller for it.
inline double relative(double error2, double scale2)
{
	if (error2 == 0) return 0;
	return scale2 <= std::numeric_limits<double>::max() ? std::sqrt(error2 / scale2) : std::numeric_limits<double>::quiet_NaN();
}

/// The violation from its sums.
inline double kinematicError(double violation2, double velocity2, double freeVelocity2, double rest)
{
	return relative(violation2, std::max(velocity2, rest * rest * freeVelocity2));
}

/// The residual from its sums. Where nothing presses, ‖p‖ is rounding and no measure: then 1e-8 of the impulses that
/// would stop the points, (|u_n| + |b_n|)/w_nn, takes its place; `stopping2` is the sum of their squares.
inline double relativeError(double error2, double impulse2, double stopping2)
{
	return relative(error2, std::max(impulse2, 1e-16 * stopping2));
}

} // namespace rcr
