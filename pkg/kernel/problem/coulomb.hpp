// The contact problem of one point, solved exactly.
//
// Given the Delassus block W = [w_nn w_nt; w_nt w_tt] and the relative velocity g = (g_n + b_n, g_t) that the point
// would have without its own impulse, find p with u = W p + g,
//   0 ≤ u_n ⟂ p_n ≥ 0,  |p_t| ≤ µ p_n,  p_t = −µ p_n sign(u_t) where u_t ≠ 0.
// In the plane the cone has three faces, so the solution is found by trying them:
//   apart   g_n ≥ 0                                    p = 0
//   stick   p = −W⁻¹ g inside the cone
//   slide   p_t = s µ p_n,  p_n = −g_n / (w_nn + s µ w_nt),  s = ±1 against u_t
// While µ |w_nt| < w_nn exactly one face fits. Beyond (Painlevé) sliding on the side where w_nn + s µ w_nt ≤ 0 is
// inconsistent and the other faces are taken: an impact without collision.
// Source: Moreau 1988; Jean 1999, §4; Génot and Brogliato 1999 for the Painlevé case.
#pragma once

#include <cmath>

#include "problem/contact_problem.hpp"

namespace rcr {

struct Delassus {
	double nn = 0, nt = 0, tt = 0;
};

/// J M⁻¹ Jᵀ of one point [1/kg].
inline Delassus delassus(const ContactPoint& c, const InverseMass& m1, const InverseMass& m2)
{
	const Vec2   n = c.normal, t = perp(c.normal);
	const double n1 = cross(c.arm1, n), t1 = cross(c.arm1, t), n2 = cross(c.arm2, n), t2 = cross(c.arm2, t);
	const double x = m1.x + m2.x, y = m1.y + m2.y;
	return { x * n.x * n.x + y * n.y * n.y + m1.rotation * n1 * n1 + m2.rotation * n2 * n2,
		 x * n.x * t.x + y * n.y * t.y + m1.rotation * n1 * t1 + m2.rotation * n2 * t2,
		 x * t.x * t.x + y * t.y * t.y + m1.rotation * t1 * t1 + m2.rotation * t2 * t2 };
}

/// The same in a cell that may stretch: body 2 is lighter, since its image moves with the cell too.
inline Delassus delassus(const ContactProblem& problem, const ContactPoint& c)
{
	const Vec2  cell = componentwise(problem.inverseStretchMass, componentwise(c.shift, c.shift));
	InverseMass m2   = problem.inverseMass[c.body2];
	m2.x += cell.x;
	m2.y += cell.y;
	return delassus(c, problem.inverseMass[c.body1], m2);
}

/// The impulse of one point; `gn` holds g_n + b_n. Needs w.nn > 0.
inline Impulse solveCoulomb(const Delassus& w, double gn, double gt, double friction)
{
	if (gn >= 0) return {};
	const double slip = gt - w.nt * gn / w.nn; // what slides without friction
	if (friction <= 0 || slip == 0) return { -gn / w.nn, 0 };
	const double schur = w.tt - w.nt * w.nt / w.nn; // 0 where friction moves nothing: a wall with one degree of freedom
	if (schur > 0) {
		const double t = -slip / schur, n = -(gn + w.nt * t) / w.nn;
		if (std::abs(t) <= friction * n) return { n, t };
	}
	const double s     = slip > 0 ? -friction : friction;
	const double slide = w.nn + s * w.nt > 0 ? s : -s; // Painlevé: the face against the slip is inconsistent
	const double n     = -gn / (w.nn + slide * w.nt);
	return { n, slide * n };
}

/// Share of the restitution b_n < 0 that one point keeps so as to give no energy: the largest φ ≤ 1 with p · (u + u⁻) ≤ 0 for the p
/// and u of φ b_n, all other points as they are. 1 unless the point gains more than a thousandth of |p| |u⁻|, which is the solver's.
inline double passiveShare(const Delassus& w, Impulse p, Impulse before, Impulse after, double bias, double friction)
{
	const auto    work = [&](Impulse q, Impulse u) { return q.n * (u.n + before.n) + q.t * (u.t + before.t); };
	const Impulse rest { after.n - w.nn * p.n - w.nt * p.t, after.t - w.nt * p.n - w.tt * p.t }; // u without p
	if (work(p, after) <= 1e-3 * std::hypot(p.n, p.t) * std::hypot(before.n, before.t)) return 1;
	double passive = 0, active = 1;
	for (int halving = 0; halving < 30; ++halving) {
		const double  share = 0.5 * (passive + active);
		const Impulse q     = solveCoulomb(w, rest.n + share * bias, rest.t, friction);
		(work(q, { rest.n + w.nn * q.n + w.nt * q.t, rest.t + w.nt * q.n + w.tt * q.t }) > 0 ? active : passive) = share;
	}
	return passive;
}

/// Orthogonal projection onto the cone |t| ≤ µ n.
inline Impulse projectCone(Impulse p, double friction)
{
	const double t = std::abs(p.t);
	if (friction * t <= -p.n) return {}; // first: where µ = t = 0 the other test holds for any n
	if (t <= friction * p.n) return p;
	const double n = (p.n + friction * t) / (1 + friction * friction);
	return { n, std::copysign(friction * n, p.t) };
}

} // namespace rcr
