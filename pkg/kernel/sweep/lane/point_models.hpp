// One contact point of a sweep, for each model (packed_blocks.hpp), RCR_LANES of them at a time. Compiled as lane.hpp is.
//
// Per point, with û_n = u_n + b_n and the symbols of packed_blocks.hpp, the solution of coulomb.hpp becomes
//   n₀ = max(p_n + r p_t − û_n / w_nn, 0)    normal impulse without friction; 0 where the point opens
//   t₀ = p_t − (u_t − r û_n) / s             tangential impulse that stops sliding
//   p_t = t₀ clamped to n₀ [−d₋, d₊],  p_n = n₀ − r p_t
// for |t| ≤ µ (n₀ − r t) says −n₀ d₋ ≤ t ≤ n₀ d₊, and a point that slides is at the end of that range. Without friction that is p_n = n₀.
#pragma once

#include "sweep/lane/lane_records.hpp"
#include "sweep/lane/components.hpp"

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	using L = Lane<RCR_LANES>;
	using B = Bodies<RCR_LANES>;
	using P = Places<RCR_LANES>;

	using Vector = Components<RCR_LANES>;

	using PointBlock        = PointBlockOf<Real>;
	using CentralBlock      = CentralBlockOf<Real>;
	using FrictionlessBlock = FrictionlessBlockOf<Real>;
	using RoundBlock        = RoundBlockOf<Real>;
	using FrictionalBlock   = FrictionalBlockOf<Real>;
	using Column            = ColumnOf<Real>;
	using PackedView        = PackedViewOf<Real>;

	constexpr bool aboutReference = sizeof(Real) < sizeof(double); // floats: `slip` is no constant, and sweeps need it

	inline L square(L a) { return a * a; }

	// what the lesser models have not
	inline L turn1n(const PointBlock&, int) { return 0.0; }
	inline L turn1t(const PointBlock&, int) { return 0.0; }
	inline L turn2n(const PointBlock&, int) { return 0.0; }
	inline L turn2t(const PointBlock&, int) { return 0.0; }
	inline L turn1n(const FrictionlessBlock& c, int lane) { return L::load(c.turn1n + lane); }
	inline L turn1t(const FrictionlessBlock& c, int lane) { return L::load(c.turn1t + lane); }
	inline L turn2n(const FrictionlessBlock& c, int lane) { return L::load(c.turn2n + lane); }
	inline L turn2t(const FrictionlessBlock& c, int lane) { return L::load(c.turn2t + lane); }
	inline L turn1t(const RoundBlock& c, int lane) { return L::load(c.turn1t + lane); }
	inline L turn2t(const RoundBlock& c, int lane) { return L::load(c.turn2t + lane); }
	inline L turn1n(const FrictionalBlock& c, int lane) { return L::load(c.turn1n + lane); }
	inline L turn2n(const FrictionalBlock& c, int lane) { return L::load(c.turn2n + lane); }
	inline L friction(const PointBlock&, int) { return 0.0; }
	inline L friction(const RoundBlock& c, int lane) { return L::load(c.friction + lane); }
	inline L tangential(const PointBlock&, int) { return 0.0; }
	inline L tangential(const RoundBlock& c, int lane) { return L::load(c.pt + lane); }

	/// The velocity of body 2 relative to body 1 at the point.
	template <class Block> inline Vector relativeVelocity(const Block& c, int lane, const B& v1, const B& v2)
	{
		const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
		const L x = v2.x - v1.x, y = v2.y - v1.y;
		const L n = subtractProduct(v2.spin * turn2n(c, lane), v1.spin, turn1n(c, lane));
		const L t = subtractProduct(v2.spin * turn2t(c, lane), v1.spin, turn1t(c, lane));
		return { addProduct(addProduct(n, y, ny), x, nx), subtractProduct(addProduct(t, y, nx), x, ny) };
	}

	template <class Block> inline void applyImpulse(const Block& c, int lane, const Vector& p, B& v1, B& v2)
	{
		const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
		const L fx = subtractProduct(p.n * nx, p.t, ny), fy = addProduct(p.n * ny, p.t, nx);
		const L torque1 = addProduct(p.n * turn1n(c, lane), p.t, turn1t(c, lane));
		const L torque2 = addProduct(p.n * turn2n(c, lane), p.t, turn2t(c, lane));
		v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
		v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
		v1.spin = subtractProduct(v1.spin, v1.inverseMass, torque1);
		v2.x    = addProduct(v2.x, v2.inverseMass, fx);
		v2.y    = addProduct(v2.y, v2.inverseMass, fy);
		v2.spin = addProduct(v2.spin, v2.inverseMass, torque2);
	}

	/// The impulse that solves the point, given u for the impulse p.
	inline Vector solvePoint(const FrictionalBlock& c, int lane, const Vector& u, const Vector& p)
	{
		const L un = u.n + L::load(c.bias + lane), ratio = L::load(c.ratio + lane);
		const L n0 = max(subtractProduct(addProduct(p.n, ratio, p.t), L::load(c.inverseNn + lane), un), L(0.0));
		const L t0 = subtractProduct(p.t, L::load(c.inverseSchur + lane), subtractProduct(u.t, ratio, un));
		const L t  = max(min(t0, n0 * L::load(c.slidePlus + lane)), subtractProduct(L(0.0), n0, L::load(c.slideMinus + lane)));
		return { subtractProduct(n0, ratio, t), t };
	}

	// ---- what a sweep does at a point, for each model

	/// Two unknowns: both impulses.
	struct Rough {
		using Block   = RoundBlock;
		using Impulse = Vector;

		static B       load(const P& at) { return loadBodies<RCR_LANES>(at); }
		static void    store(const B& v, const P& at) { storeBodies<RCR_LANES>(v, at); }
		static Impulse impulse(const Block& c, int lane) { return { L::load(c.pn + lane), L::load(c.pt + lane) }; }
		static Impulse oldImpulse(const Block& c, int lane) { return { L::load(c.oldPn + lane), L::load(c.oldPt + lane) }; }
		static void    set(Block& c, int lane, const Impulse& p) { p.n.store(c.pn + lane), p.t.store(c.pt + lane); }
		static void    setOld(Block& c, int lane, const Impulse& p) { p.n.store(c.oldPn + lane), p.t.store(c.oldPt + lane); }
		static Impulse project(const Block& c, int lane, const Impulse& p) { return projectCone(p, friction(c, lane)); }
		static Vector  slipping(const Block& c, int lane, const Vector& u)
		{
			if constexpr (aboutReference) return { u.n, u.t + L::load(c.slip + lane) };
			else
				return u;
		}
	};

	struct Frictional : Rough {
		using Block  = FrictionalBlock;
		using Single = FrictionalBlockOf<float>;

		static Vector  velocity(const Block& c, int lane, const B& v1, const B& v2) { return slipping(c, lane, relativeVelocity(c, lane, v1, v2)); }
		static Impulse solve(const Block& c, int lane, const Vector& u, const Impulse& p) { return solvePoint(c, lane, u, p); }
		static void    apply(const Block& c, int lane, const Impulse& p, B& v1, B& v2)
		{
			if (RCR_LANES > 8) keepOrder();
			applyImpulse(c, lane, p, v1, v2);
		}
	};

	struct Round : Rough {
		using Single = RoundBlockOf<float>;

		static Vector velocity(const Block& c, int lane, const B& v1, const B& v2)
		{
			const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
			const L x = v2.x - v1.x, y = v2.y - v1.y;
			const L t = subtractProduct(v2.spin * turn2t(c, lane), v1.spin, turn1t(c, lane));
			return slipping(c, lane, { addProduct(y * ny, x, nx), subtractProduct(addProduct(t, y, nx), x, ny) });
		}
		static Impulse solve(const Block& c, int lane, const Vector& u, const Impulse& p)
		{
			const L n = max(subtractProduct(p.n, L::load(c.inverseNn + lane), u.n + L::load(c.bias + lane)), L(0.0));
			const L most = n * friction(c, lane);
			return { n, max(min(subtractProduct(p.t, L::load(c.inverseSchur + lane), u.t), most), L(0.0) - most) };
		}
		static void apply(const Block& c, int lane, const Impulse& p, B& v1, B& v2)
		{
			if (RCR_LANES > 8) keepOrder();
			const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
			const L fx = subtractProduct(p.n * nx, p.t, ny), fy = addProduct(p.n * ny, p.t, nx);
			v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
			v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
			v1.spin = subtractProduct(v1.spin, v1.inverseMass, p.t * turn1t(c, lane));
			v2.x    = addProduct(v2.x, v2.inverseMass, fx);
			v2.y    = addProduct(v2.y, v2.inverseMass, fy);
			v2.spin = addProduct(v2.spin, v2.inverseMass, p.t * turn2t(c, lane));
		}
	};

	/// One unknown: the normal impulse.
	struct Normal {
		using Impulse = L;

		static L    impulse(const PointBlock& c, int lane) { return L::load(c.pn + lane); }
		static L    oldImpulse(const PointBlock& c, int lane) { return L::load(c.oldPn + lane); }
		static void set(PointBlock& c, int lane, L p) { p.store(c.pn + lane); }
		static void setOld(PointBlock& c, int lane, L p) { p.store(c.oldPn + lane); }
		static L    solve(const PointBlock& c, int lane, L un, L p)
		{
			return max(subtractProduct(p, L::load(c.inverseNn + lane), un + L::load(c.bias + lane)), L(0.0));
		}
		static L project(const PointBlock&, int, L p) { return max(p, L(0.0)); }
	};

	struct Frictionless : Normal {
		using Block  = FrictionlessBlock;
		using Single = FrictionlessBlockOf<float>;

		static B    load(const P& at) { return loadBodies<RCR_LANES>(at); }
		static void store(const B& v, const P& at) { storeBodies<RCR_LANES>(v, at); }
		static L    velocity(const Block& c, int lane, const B& v1, const B& v2)
		{
			const L n = subtractProduct(v2.spin * turn2n(c, lane), v1.spin, turn1n(c, lane));
			return addProduct(addProduct(n, v2.y - v1.y, L::load(c.ny + lane)), v2.x - v1.x, L::load(c.nx + lane));
		}
		static void apply(const Block& c, int lane, L p, B& v1, B& v2)
		{
			const L fx = p * L::load(c.nx + lane), fy = p * L::load(c.ny + lane);
			v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
			v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
			v1.spin = subtractProduct(v1.spin, v1.inverseMass, p * turn1n(c, lane));
			v2.x    = addProduct(v2.x, v2.inverseMass, fx);
			v2.y    = addProduct(v2.y, v2.inverseMass, fy);
			v2.spin = addProduct(v2.spin, v2.inverseMass, p * turn2n(c, lane));
		}
	};

	struct Central : Normal {
		using Block  = CentralBlock;
		using Single = CentralBlockOf<float>;
		using C      = Centres<RCR_LANES>;

		static C    load(const P& at) { return loadCentres<RCR_LANES>(at); }
		static void store(const C& v, const P& at) { storeCentres<RCR_LANES>(v, at); }
		static L    velocity(const Block& c, int lane, const C& v1, const C& v2)
		{
			return addProduct((v2.y - v1.y) * L::load(c.ny + lane), v2.x - v1.x, L::load(c.nx + lane));
		}
		static void apply(const Block& c, int lane, L p, C& v1, C& v2)
		{
			const L fx = p * L::load(c.nx + lane), fy = p * L::load(c.ny + lane);
			const L m1 = L::load(c.mass1 + lane), m2 = L::load(c.mass2 + lane);
			v1.x = subtractProduct(v1.x, m1, fx);
			v1.y = subtractProduct(v1.y, m1, fy);
			v2.x = addProduct(v2.x, m2, fx);
			v2.y = addProduct(v2.y, m2, fy);
		}
	};

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
