// Exact solution of the contact problem of one point.
//
// Given are the Delassus block W = [w_nn w_nt; w_nt w_tt] and g = (g_n + b_n, g_t), the relative
// velocity without the impulse of this point. The solution p satisfies u = W p + g:
//
//   0 ≤ u_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0.
//
// In the plane there are three cases. They are tried in this order:
//
//   open    g_n ≥ 0                                     p = 0
//   stick   p = −W⁻¹ g lies in the cone
//   slide   p_t = s µ p_n,  p_n = −g_n / (w_nn + s µ w_nt),  s = ±1 against u_t
//
// If µ |w_nt| < w_nn, exactly one case holds. Otherwise (Painlevé) sliding is inconsistent on the
// side where w_nn + s µ w_nt ≤ 0. The solution then slides to the other side: an impact without
// collision. Source: Moreau 1988; Jean 1999, §4; Génot and Brogliato 1999 (Painlevé case).
#pragma once

#include "problem/contact_problem.hpp"

namespace rcr {

struct Delassus {
	double nn = 0, nt = 0, tt = 0;
};

/// Components of directions and levers below this share of the length count as rounding errors [-].
constexpr double negligibleLever = 1e-10;
constexpr double roundingShare   = 1e-12; // rounding of a difference over its largest term [-]

/// J M⁻¹ Jᵀ of one point [1/kg]. w_nn and w_nt are 0 if w_nn is a rounding error: the normal
/// direction is blocked.
inline Delassus delassus(const ContactPoint& c, const InverseMass& m1, const InverseMass& m2)
{
	const Vec2   n = c.normal, t = perp(c.normal);
	const double n1 = cross(c.arm1, n), t1 = cross(c.arm1, t), n2 = cross(c.arm2, n),
	             t2 = cross(c.arm2, t);
	const double x = m1.x + m2.x, y = m1.y + m2.y;
	Delassus     w {
        x * n.x * n.x + y * n.y * n.y + m1.rotation * n1 * n1 + m2.rotation * n2 * n2,
        x * n.x * t.x + y * n.y * t.y + m1.rotation * n1 * t1 + m2.rotation * n2 * t2,
        x * t.x * t.x + y * t.y * t.y + m1.rotation * t1 * t1 + m2.rotation * t2 * t2
	};
	if (w.nn <= negligibleLever * negligibleLever * w.tt) w.nn = w.nt = 0;
	return w;
}

/// J M⁻¹ Jᵀ of one point, without the stretch of a cell.
inline Delassus delassus(const ContactProblem& problem, const ContactPoint& c)
{
	return delassus(c, problem.inverseMass[c.body1], problem.inverseMass[c.body2]);
}

/// Impulse of one point [N s]; `gn` is g_n + b_n [m/s]. Requires w.nn > 0.
inline LocalVector solveCoulomb(const Delassus& w, double gn, double gt, double friction)
{
	if (gn >= 0) return {};
	const double slip = gt - w.nt * gn / w.nn; // tangential velocity without friction
	if (friction <= 0 || slip == 0) return { -gn / w.nn, 0 };
	// 0 if the bodies can move in one way only: a wall along one axis, or a hinged body
	const double schur = w.tt - w.nt * w.nt / w.nn;
	if (schur > roundingShare * w.tt) {
		const double t = -slip / schur, n = -(gn + w.nt * t) / w.nn;
		if (std::abs(t) <= friction * n) return { n, t };
	}
	const double opposing = slip > 0 ? -friction : friction;
	// p_t/p_n; Painlevé: sliding against the slip is inconsistent
	const double ratio = w.nn + opposing * w.nt > roundingShare * w.nn ? opposing : -opposing;
	const double n     = -gn / (w.nn + ratio * w.nt);
	return { n, ratio * n };
}

/// Largest factor φ ≤ 1 of the restitution bias b_n < 0 for which one point adds no energy [-]:
/// p · (u + u⁻) ≤ 0. p and u solve the point for φ b_n with all other impulses fixed. Returns 1 if
/// the gain is below 1e-3 |p| |u⁻|, the error of the solver.
inline double passiveRestitutionFactor(const Delassus& w, LocalVector p, LocalVector before,
        LocalVector after, double bias, double friction)
{
	const double gain = dot(p, after + before);
	if (gain <= 0 || gain <= 1e-3 * std::hypot(p.n, p.t) * std::hypot(before.n, before.t)) return 1;
	const LocalVector rest { after.n - w.nn * p.n - w.nt * p.t,
		                     after.t - w.nt * p.n - w.tt * p.t }; // u without p
	double passive = 0, active = 1;
	for (int halving = 0; halving < 30; ++halving) {
		const double      factor = 0.5 * (passive + active);
		const LocalVector q      = solveCoulomb(w, rest.n + factor * bias, rest.t, friction);
		const LocalVector u { rest.n + w.nn * q.n + w.nt * q.t, rest.t + w.nt * q.n + w.tt * q.t };
		(dot(q, u + before) > 0 ? active : passive) = factor;
	}
	return passive;
}

/// Orthogonal projection onto the cone |t| ≤ µ n.
inline LocalVector projectCone(LocalVector p, double friction)
{
	const double t = std::abs(p.t);
	if (friction * t <= -p.n) return {}; // first: for µ = t = 0, the next test holds for any n
	if (t <= friction * p.n) return p;
	const double n = (p.n + friction * t) / (1 + friction * friction);
	return { n, std::copysign(friction * n, p.t) };
}

/// The value clamped to ±most; 0 for most ≤ 0.
inline double clampTo(double value, double most)
{
	return most > 0 ? std::max(-most, std::min(value, most)) : 0;
}

/// w_rr = ℓ² (1/I₁ + 1/I₂) of a point [1/kg].
inline double rollingResponse(const ContactProblem& problem, const ContactPoint& c)
{
	return c.rollingLength * c.rollingLength
	        * (problem.inverseMass[c.body1].rotation + problem.inverseMass[c.body2].rotation);
}

/// Error p − P_K(p − (u + µ|u_t| n)/w_nn) of one point (residual.hpp). `u` includes the bias b_n.
inline LocalVector lawError(LocalVector p, LocalVector u, double friction, double wnn)
{
	const LocalVector stepped { p.n - (u.n + friction * std::abs(u.t)) / wnn, p.t - u.t / wnn };
	return p - projectCone(stepped, friction);
}

} // namespace rcr
