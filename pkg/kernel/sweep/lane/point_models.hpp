// The solution of one contact point for each model, RCR_LANES points at a time.
// Compiled like lane.hpp. packed_blocks.hpp explains the models and the symbols.
//
// The solution of problem/coulomb.hpp, with û_n = u_n + b_n:
//
//   n₀ = max(p_n + r p_t − û_n / w_nn, 0)    normal impulse without friction; 0 if the point opens
//   t₀ = p_t − (u_t − r û_n) / z             tangential impulse that stops the slip
//   p_t = t₀ clamped to n₀ [−d₋, d₊],   p_n = n₀ − r p_t
//
// The cone |t| ≤ µ (n₀ − r t) is the range −n₀ d₋ ≤ t ≤ n₀ d₊. A sliding point is at its end.
// Without friction, p_n = n₀.
#pragma once

#include "sweep/lane/lane_records.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

using L = Lane<RCR_LANES>;
using B = Bodies<RCR_LANES>;
using P = Places<RCR_LANES>;

using PointColumns            = PointColumnsOf<Real>;
using FrictionlessDiscColumns = FrictionlessDiscColumnsOf<Real>;
using FrictionlessColumns     = FrictionlessColumnsOf<Real>;
using NoLeverColumns          = NoLeverColumnsOf<Real>;
using FrictionalColumns       = FrictionalColumnsOf<Real>;
using RollingColumns          = RollingColumnsOf<Real>;
using Column                  = ColumnOf<Real>;
using PackedView              = PackedViewOf<Real>;

/// True for floats. Their records are relative to a reference, so sweeps need `tangentialBias`.
constexpr bool relativeToReference = sizeof(Real) < sizeof(double);

inline L square(L a) { return a * a; }

/// Components at RCR_LANES points.
struct Vector {
	L n, t;

	friend Vector operator+(Vector a, Vector b) { return { a.n + b.n, a.t + b.t }; }
	friend Vector operator-(Vector a, Vector b) { return { a.n - b.n, a.t - b.t }; }
	friend Vector operator*(L s, Vector a) { return { s * a.n, s * a.t }; }
	friend Vector addProduct(Vector a, L s, Vector b)
	{
		return { addProduct(a.n, s, b.n), addProduct(a.t, s, b.t) };
	}
	friend Vector subtractProduct(Vector a, L s, Vector b)
	{
		return { subtractProduct(a.n, s, b.n), subtractProduct(a.t, s, b.t) };
	}
	friend L square(Vector a) { return addProduct(a.n * a.n, a.t, a.t); }
};

/// Projects onto the cone |t| ≤ µ n (problem/coulomb.hpp).
inline Vector projectCone(const Vector& p, L friction)
{
	const L    size = abs(p.t), n = (p.n + friction * size) / (L(1.0) + friction * friction);
	const auto inside = size <= friction * p.n, polar = friction * size <= L(0.0) - p.n;
	return { zeroWhere(polar, select(inside, p.n, n)),
		zeroWhere(polar, select(inside, p.t, copySign(friction * n, p.t))) };
}

/// One sum per slot: the order of additions does not depend on the lane width.
struct Sum {
	alignas(64) Real slot[blockWidth] = {};

	void add(int lane, L value) { (L::load(slot + lane) + value).store(slot + lane); }
	double total() const
	{
		double sum = 0;
		for (Real part : slot)
			sum += part;
		return sum;
	}
};

// Quantities that a cheaper model does not store are zero.
inline L lever1n(const PointColumns&, int) { return 0.0; }
inline L lever1t(const PointColumns&, int) { return 0.0; }
inline L lever2n(const PointColumns&, int) { return 0.0; }
inline L lever2t(const PointColumns&, int) { return 0.0; }
inline L friction(const PointColumns&, int) { return 0.0; }
inline L tangential(const PointColumns&, int) { return 0.0; }
inline L lever1n(const FrictionlessColumns& c, int lane) { return L::load(c.lever1n() + lane); }
inline L lever1t(const FrictionlessColumns& c, int lane) { return L::load(c.lever1t() + lane); }
inline L lever2n(const FrictionlessColumns& c, int lane) { return L::load(c.lever2n() + lane); }
inline L lever2t(const FrictionlessColumns& c, int lane) { return L::load(c.lever2t() + lane); }
inline L lever1t(const NoLeverColumns& c, int lane) { return L::load(c.lever1t() + lane); }
inline L lever2t(const NoLeverColumns& c, int lane) { return L::load(c.lever2t() + lane); }
inline L friction(const NoLeverColumns& c, int lane) { return L::load(c.friction() + lane); }
inline L lever1n(const FrictionalColumns& c, int lane) { return L::load(c.lever1n() + lane); }
inline L lever2n(const FrictionalColumns& c, int lane) { return L::load(c.lever2n() + lane); }
inline L tangential(const NoLeverColumns& c, int lane) { return L::load(c.pt() + lane); }

/// Velocity (u_n, u_t) of body 2 relative to body 1 at the point.
template <class Columns>
inline Vector relativeVelocity(const Columns& c, int lane, const B& v1, const B& v2)
{
	const L nx = L::load(c.nx() + lane), ny = L::load(c.ny() + lane);
	const L x = v2.x - v1.x, y = v2.y - v1.y;
	const L n = subtractProduct(v2.spin * lever2n(c, lane), v1.spin, lever1n(c, lane));
	const L t = subtractProduct(v2.spin * lever2t(c, lane), v1.spin, lever1t(c, lane));
	return { addProduct(addProduct(n, y, ny), x, nx),
		subtractProduct(addProduct(t, y, nx), x, ny) };
}

template <class Columns>
inline void applyImpulse(const Columns& c, int lane, const Vector& p, B& v1, B& v2)
{
	const L nx = L::load(c.nx() + lane), ny = L::load(c.ny() + lane);
	const L fx = subtractProduct(p.n * nx, p.t, ny), fy = addProduct(p.n * ny, p.t, nx);
	const L torque1 = addProduct(p.n * lever1n(c, lane), p.t, lever1t(c, lane));
	const L torque2 = addProduct(p.n * lever2n(c, lane), p.t, lever2t(c, lane));
	v1.x            = subtractProduct(v1.x, v1.inverseMass, fx);
	v1.y            = subtractProduct(v1.y, v1.inverseMass, fy);
	v1.spin         = subtractProduct(v1.spin, v1.inverseMass, torque1);
	v2.x            = addProduct(v2.x, v2.inverseMass, fx);
	v2.y            = addProduct(v2.y, v2.inverseMass, fy);
	v2.spin         = addProduct(v2.spin, v2.inverseMass, torque2);
}

/// Impulse that solves the point, given u at the impulse p.
inline Vector solvePoint(const FrictionalColumns& c, int lane, const Vector& u, const Vector& p)
{
	const L un = u.n + L::load(c.bias() + lane), ratio = L::load(c.ratio() + lane);
	const L n0 = max(
	        subtractProduct(addProduct(p.n, ratio, p.t), L::load(c.inverseNn() + lane), un),
	        L(0.0));
	const L t0 = subtractProduct(
	        p.t, L::load(c.inverseSchur() + lane), subtractProduct(u.t, ratio, un));
	const L t = max(min(t0, n0 * L::load(c.slidePlus() + lane)),
	        subtractProduct(L(0.0), n0, L::load(c.slideMinus() + lane)));
	return { subtractProduct(n0, ratio, t), t };
}

// ---- steps of a sweep at one point, for each model

/// Unknowns: normal and tangential impulse.
struct WithFriction {
	using Columns = NoLeverColumns;
	using Impulse = Vector;

	static B       load(const P& at) { return loadBodies<RCR_LANES>(at); }
	static void    store(const B& v, const P& at) { storeBodies<RCR_LANES>(v, at); }
	static Impulse impulse(const Columns& c, int lane)
	{
		return { L::load(c.pn() + lane), L::load(c.pt() + lane) };
	}
	static Impulse oldImpulse(const Columns& c, int lane)
	{
		return { L::load(c.oldPn() + lane), L::load(c.oldPt() + lane) };
	}
	static void set(const Columns& c, int lane, const Impulse& p)
	{
		p.n.store(c.pn() + lane), p.t.store(c.pt() + lane);
	}
	static void setOld(const Columns& c, int lane, const Impulse& p)
	{
		p.n.store(c.oldPn() + lane), p.t.store(c.oldPt() + lane);
	}
	static Impulse project(const Columns& c, int lane, const Impulse& p)
	{
		return projectCone(p, friction(c, lane));
	}
	static Vector withBias(const Columns& c, int lane, const Vector& u)
	{
		if constexpr (relativeToReference)
			return { u.n, u.t + L::load(c.tangentialBias() + lane) };
		else
			return u;
	}
};

struct Frictional : WithFriction {
	using Columns = FrictionalColumns;

	static Vector velocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		return withBias(c, lane, relativeVelocity(c, lane, v1, v2));
	}
	static Impulse solve(const Columns& c, int lane, const Vector& u, const Impulse& p)
	{
		return solvePoint(c, lane, u, p);
	}
	static void apply(const Columns& c, int lane, const Impulse& p, B& v1, B& v2)
	{
		if (RCR_LANES > 8) scheduleBarrier();
		applyImpulse(c, lane, p, v1, v2);
	}
};

struct NoLever : WithFriction {
	static Vector velocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		const L nx = L::load(c.nx() + lane), ny = L::load(c.ny() + lane);
		const L x = v2.x - v1.x, y = v2.y - v1.y;
		const L t = subtractProduct(v2.spin * lever2t(c, lane), v1.spin, lever1t(c, lane));
		return withBias(c, lane,
		        { addProduct(y * ny, x, nx), subtractProduct(addProduct(t, y, nx), x, ny) });
	}
	static Impulse solve(const Columns& c, int lane, const Vector& u, const Impulse& p)
	{
		const L n    = max(subtractProduct(p.n, L::load(c.inverseNn() + lane),
		                           u.n + L::load(c.bias() + lane)),
		           L(0.0));
		const L most = n * friction(c, lane);
		return { n,
			max(min(subtractProduct(p.t, L::load(c.inverseSchur() + lane), u.t), most),
			        L(0.0) - most) };
	}
	static void apply(const Columns& c, int lane, const Impulse& p, B& v1, B& v2)
	{
		if (RCR_LANES > 8) scheduleBarrier();
		const L nx = L::load(c.nx() + lane), ny = L::load(c.ny() + lane);
		const L fx = subtractProduct(p.n * nx, p.t, ny), fy = addProduct(p.n * ny, p.t, nx);
		v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
		v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
		v1.spin = subtractProduct(v1.spin, v1.inverseMass, p.t * lever1t(c, lane));
		v2.x    = addProduct(v2.x, v2.inverseMass, fx);
		v2.y    = addProduct(v2.y, v2.inverseMass, fy);
		v2.spin = addProduct(v2.spin, v2.inverseMass, p.t * lever2t(c, lane));
	}
};

/// Unknown: the normal impulse.
struct Normal {
	using Impulse = L;

	static L impulse(const PointColumns& c, int lane) { return L::load(c.pn() + lane); }
	static L oldImpulse(const PointColumns& c, int lane) { return L::load(c.oldPn() + lane); }
	static void set(const PointColumns& c, int lane, L p) { p.store(c.pn() + lane); }
	static void setOld(const PointColumns& c, int lane, L p) { p.store(c.oldPn() + lane); }
	static L    solve(const PointColumns& c, int lane, L un, L p)
	{
		return max(subtractProduct(p, L::load(c.inverseNn() + lane), un + L::load(c.bias() + lane)),
		        L(0.0));
	}
	static L project(const PointColumns&, int, L p) { return max(p, L(0.0)); }
};

struct Frictionless : Normal {
	using Columns = FrictionlessColumns;

	static B    load(const P& at) { return loadBodies<RCR_LANES>(at); }
	static void store(const B& v, const P& at) { storeBodies<RCR_LANES>(v, at); }
	static L    velocity(const Columns& c, int lane, const B& v1, const B& v2)
	{
		const L n = subtractProduct(v2.spin * lever2n(c, lane), v1.spin, lever1n(c, lane));
		return addProduct(addProduct(n, v2.y - v1.y, L::load(c.ny() + lane)), v2.x - v1.x,
		        L::load(c.nx() + lane));
	}
	static void apply(const Columns& c, int lane, L p, B& v1, B& v2)
	{
		if (RCR_LANES > 8) scheduleBarrier();
		const L fx = p * L::load(c.nx() + lane), fy = p * L::load(c.ny() + lane);
		v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
		v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
		v1.spin = subtractProduct(v1.spin, v1.inverseMass, p * lever1n(c, lane));
		v2.x    = addProduct(v2.x, v2.inverseMass, fx);
		v2.y    = addProduct(v2.y, v2.inverseMass, fy);
		v2.spin = addProduct(v2.spin, v2.inverseMass, p * lever2n(c, lane));
	}
};

struct FrictionlessDisc : Normal {
	using Columns = FrictionlessDiscColumns;
	using C       = Centers<RCR_LANES>;

	static C    load(const P& at) { return loadCenters<RCR_LANES>(at); }
	static void store(const C& v, const P& at) { storeCenters<RCR_LANES>(v, at); }
	static L    velocity(const Columns& c, int lane, const C& v1, const C& v2)
	{
		return addProduct(
		        (v2.y - v1.y) * L::load(c.ny() + lane), v2.x - v1.x, L::load(c.nx() + lane));
	}
	static void apply(const Columns& c, int lane, L p, C& v1, C& v2)
	{
		const L fx = p * L::load(c.nx() + lane), fy = p * L::load(c.ny() + lane);
		const L m1 = L::load(c.inverseMass1() + lane), m2 = L::load(c.inverseMass2() + lane);
		v1.x = subtractProduct(v1.x, m1, fx);
		v1.y = subtractProduct(v1.y, m1, fy);
		v2.x = addProduct(v2.x, m2, fx);
		v2.y = addProduct(v2.y, m2, fy);
	}
};

} // namespace rcr::RCR_LANE_NAMESPACE
