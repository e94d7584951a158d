// Relative natural-map residual of De Saxcé's form of the contact laws [-]:
//
//   ‖d‖ / ‖p‖,   d = p − P_K(p − (u + (b_n + µ|u_t|) n) / w_nn),   K = { |p_t| ≤ µ p_n }
//
// The denominator has a lower bound (residualFromSums). The residual is 0 if and only if the laws
// hold exactly. Rolling resistance adds its error to the sums. The residual is not the error of the
// solution: error_estimate.hpp.
// Source: De Saxcé and Feng 1998; Acary, Brémond and Huber 2018, §4 (natural map).
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

/// Sums over the points. The velocities u are recomputed from the impulses. Points between two
/// prescribed bodies (w_nn = 0) do not count.
Measures measuresOf(const ContactProblem&);
/// Residual of the impulses.
double residualOf(const ContactProblem&);

/// √(error2 / scale2); NaN if the scale overflows, because the error may have overflowed too.
inline double relativeRms(double error2, double scale2)
{
	if (error2 == 0) return 0;
	return scale2 <= std::numeric_limits<double>::max() ? std::sqrt(error2 / scale2)
	                                                    : std::numeric_limits<double>::quiet_NaN();
}

/// Terms of one point in the sums. `u`: without the bias; `wnn` > 0.
inline Measures measuresOf(LocalVector p, LocalVector u, double bias, double friction, double wnn,
        double leastResponse = 0)
{
	const double un       = u.n + bias;
	const double error2   = square(lawError(p, { un, u.t }, friction, wnn));
	const double stopping = (std::abs(u.n) + std::abs(bias)) / wnn;
	const double energy   = wnn >= leastResponse ? wnn : 0;
	return { error2, square(p), p.n, wnn * wnn * error2, stopping * stopping,
		-dot(p, { un, u.t }), std::sqrt(std::abs(u.n) + std::abs(u.t)), energy * error2,
		energy * square(p) };
}

/// Terms of the rolling resistance of a point: d_r = p_r − (p_r − u_r/w_rr clamped to ±most).
inline Measures rollingMeasures(double p, double u, double most, double wrr)
{
	if (wrr <= 0) return {};
	const double error  = p - clampTo(p - u / wrr, most);
	Measures     m;
	m.error2            = error * error;
	m.impulse2          = p * p;
	m.kinematicError2   = wrr * wrr * m.error2;
	m.stopping2         = u * u / (wrr * wrr);
	m.dissipated        = -p * u;
	m.errorEnergy       = wrr * m.error2;
	m.impulseEnergy     = wrr * m.impulse2;
	return m;
}

/// Residual from sums of squares over the points: error, p, and the impulse that stops a point,
/// (|u_n| + |b_n|)/w_nn. Without load, ‖p‖ is a rounding error. The denominator is therefore at
/// least 1e-8 of the stopping impulses.
inline double residualFromSums(double error2, double impulse2, double stopping2)
{
	return relativeRms(error2, std::max(impulse2, 1e-16 * stopping2));
}

/// Creep: RMS of w_nn |d| over a number of points [m/s]. Errors of velocities would add up to
/// overlaps from step to step. 0 below a share of the typical speed (mean √(|u_n| + |u_t|))², at
/// which contacts change sooner. A few fast contacts hardly raise this mean.
double creepOf(const Measures&, double points);

inline double residualFromSums(const Measures& m)
{
	return residualFromSums(m.error2, m.impulse2, m.stopping2);
}

} // namespace rcr
