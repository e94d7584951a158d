// The solution of a contact point with rolling resistance. Compiled like lane.hpp.
//
//   (p_n, p_t)  as in point_models.hpp
//   p_r         = p_r − u_r/w_rr clamped to ±µ_r p_n, with the spins that (p_n, p_t) leave
#pragma once

#include <type_traits>

#include "sweep/lane/point_models.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

/// Components of a point with rolling resistance.
struct RollingVector {
	Vector at; // n, t
	L      r;

	friend RollingVector operator+(RollingVector a, RollingVector b)
	{
		return { a.at + b.at, a.r + b.r };
	}
	friend RollingVector operator-(RollingVector a, RollingVector b)
	{
		return { a.at - b.at, a.r - b.r };
	}
	friend RollingVector operator*(L s, RollingVector a) { return { s * a.at, s * a.r }; }
	friend RollingVector addProduct(RollingVector a, L s, RollingVector b)
	{
		return { addProduct(a.at, s, b.at), addProduct(a.r, s, b.r) };
	}
	friend RollingVector subtractProduct(RollingVector a, L s, RollingVector b)
	{
		return { subtractProduct(a.at, s, b.at), subtractProduct(a.r, s, b.r) };
	}
	friend L square(RollingVector a) { return addProduct(square(a.at), a.r, a.r); }
};

inline L clampTo(L value, L most) { return max(min(value, most), L(0.0) - most); }

/// Unknowns: normal and tangential impulse, and that of rolling resistance. Not for floats.
struct Rolling : WithFriction {
	using Columns = RollingColumns;
	using Impulse = RollingVector;

	static Impulse impulse(const Columns& c, int lane)
	{
		return { WithFriction::impulse(c, lane), L::load(c.pr() + lane) };
	}
	static Impulse oldImpulse(const Columns& c, int lane)
	{
		return { WithFriction::oldImpulse(c, lane), L::load(c.oldPr() + lane) };
	}
	static void set(const Columns& c, int lane, const Impulse& p)
	{
		WithFriction::set(c, lane, p.at), p.r.store(c.pr() + lane);
	}
	static void setOld(const Columns& c, int lane, const Impulse& p)
	{
		WithFriction::setOld(c, lane, p.at), p.r.store(c.oldPr() + lane);
	}
	static L most(const Columns& c, int lane, const Vector& p)
	{
		return L::load(c.rollingFriction() + lane) * p.n;
	}
	static Impulse project(const Columns& c, int lane, const Impulse& p)
	{
		const Vector at = projectCone(p.at, friction(c, lane));
		return { at, clampTo(p.r, most(c, lane, at)) };
	}
	static L rollingVelocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		return subtractProduct(
		        v2.spin * L::load(c.turn2() + lane), v1.spin, L::load(c.turn1() + lane));
	}
	static Impulse velocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		return { relativeVelocity(c, lane, v1, v2), rollingVelocity(c, lane, v1, v2) };
	}
	/// Solves (n, t), then r with the spins that these leave.
	static Impulse solve(const Columns& c, int lane, const Impulse& u, const Impulse& p)
	{
		const Vector at = solvePoint(c, lane, u.at, p.at), change = at - p.at;
		const L      ur = addProduct(
		             addProduct(u.r, L::load(c.responseN() + lane), change.n),
		             L::load(c.responseT() + lane), change.t);
		return { at,
			 clampTo(subtractProduct(p.r, L::load(c.inverseRr() + lane), ur),
			         most(c, lane, at)) };
	}
	static void apply(const Columns& c, int lane, const Impulse& p, B& v1, B& v2)
	{
		applyImpulse(c, lane, p.at, v1, v2);
		applyRolling(c, lane, p.r, v1, v2);
	}
	static void applyRolling(const Columns& c, int lane, L p, B& v1, B& v2)
	{
		v1.spin = subtractProduct(v1.spin, v1.inverseMass, p * L::load(c.turn1() + lane));
		v2.spin = addProduct(v2.spin, v2.inverseMass, p * L::load(c.turn2() + lane));
	}
};

template <class Columns>
constexpr bool isRolling = std::is_same_v<std::decay_t<Columns>, RollingColumns>;

} // namespace rcr::RCR_LANE_NAMESPACE
