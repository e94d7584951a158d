// The inner loops of the sweep solvers. Compiled once for every lane width: RCR_LANES doubles at a time.
//
// Per point, with û_n = u_n + b_n and the symbols of packed_blocks.hpp, the solution of coulomb.hpp becomes
//   n₀ = max(p_n + r p_t − û_n / w_nn, 0)    normal impulse without friction; 0 where the point opens
//   t₀ = p_t − (u_t − r û_n) / s             tangential impulse that stops sliding
//   p_t = t₀ clamped to n₀ [−d₋, d₊],  p_n = n₀ − r p_t
// for |t| ≤ µ (n₀ − r t) says −n₀ d₋ ≤ t ≤ n₀ d₊, and a point that slides is at the end of that range.
#include "lane.hpp"

#define INLINE __attribute__((always_inline)) // lambdas of inner loops: a call costs as much as a tenth of a point

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	namespace {

		using L = Lane<RCR_LANES>;
		using B = Bodies<RCR_LANES>;
		using P = Places<RCR_LANES>;

		struct Vector { // (n, t) components
			L n, t;
		};

		/// The velocity of body 2 relative to body 1 at the point.
		inline Vector relativeVelocity(const PointBlock& c, int lane, const B& v1, const B& v2)
		{
			const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
			const L x = v2.x - v1.x, y = v2.y - v1.y;
			const L n = subtractProduct(v2.spin * L::load(c.turn2n + lane), v1.spin, L::load(c.turn1n + lane));
			const L t = subtractProduct(v2.spin * L::load(c.turn2t + lane), v1.spin, L::load(c.turn1t + lane));
			return { addProduct(addProduct(n, y, ny), x, nx), subtractProduct(addProduct(t, y, nx), x, ny) };
		}

		inline void applyImpulse(const PointBlock& c, int lane, const Vector& p, B& v1, B& v2)
		{
			const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
			const L fx = subtractProduct(p.n * nx, p.t, ny), fy = addProduct(p.n * ny, p.t, nx);
			const L turn1 = addProduct(p.n * L::load(c.turn1n + lane), p.t, L::load(c.turn1t + lane));
			const L turn2 = addProduct(p.n * L::load(c.turn2n + lane), p.t, L::load(c.turn2t + lane));
			v1.x    = subtractProduct(v1.x, v1.inverseMass, fx);
			v1.y    = subtractProduct(v1.y, v1.inverseMass, fy);
			v1.spin = subtractProduct(v1.spin, v1.inverseMass, turn1);
			v2.x    = addProduct(v2.x, v2.inverseMass, fx);
			v2.y    = addProduct(v2.y, v2.inverseMass, fy);
			v2.spin = addProduct(v2.spin, v2.inverseMass, turn2);
		}

		/// The impulse that solves the point, given u for the impulse p.
		inline Vector solvePoint(const PointBlock& c, int lane, const Vector& u, const Vector& p)
		{
			const L un = u.n + L::load(c.bias + lane), ratio = L::load(c.ratio + lane);
			const L n0 = max(subtractProduct(addProduct(p.n, ratio, p.t), L::load(c.inverseNn + lane), un), L(0.0));
			const L t0 = subtractProduct(p.t, L::load(c.inverseSchur + lane), subtractProduct(u.t, ratio, un));
			const L t  = max(min(t0, n0 * L::load(c.slidePlus + lane)), subtractProduct(L(0.0), n0, L::load(c.slideMinus + lane)));
			return { subtractProduct(n0, ratio, t), t };
		}

		inline Vector projectCone(const Vector& p, L friction)
		{
			const L    size = abs(p.t), n = (p.n + friction * size) / (L(1.0) + friction * friction);
			const auto inside = size <= friction * p.n, polar = friction * size <= L(0.0) - p.n;
			return { zeroWhere(polar, select(inside, p.n, n)), zeroWhere(polar, select(inside, p.t, copySign(friction * n, p.t))) };
		}

		/// Calls visit(bodies 1, bodies 2, first point block, lane) for all pairs of a chunk, RCR_LANES at a time.
		template <class Visit> inline void forEachPair(const PackedView& view, const Chunk& chunk, Visit visit)
		{
			for (int b = 0; b < chunk.blocks; ++b)
				for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
					visit(
					        P { view.body, view.pairs[chunk.firstPair + b].body1 + lane },
					        P { view.body, view.pairs[chunk.firstPair + b].body2 + lane },
					        view.points + chunk.firstPoint + b * chunk.pointsPerPair,
					        lane);
		}

		/// A sum kept apart for each slot of a block, so that its order is the same for every lane width.
		struct SlotSum {
			alignas(64) double slot[blockWidth] = {};

			void   add(int lane, L value) { (L::load(slot + lane) + value).store(slot + lane); }
			double total() const
			{
				double sum = 0;
				for (double part : slot)
					sum += part;
				return sum;
			}
		};

		double prepare(const PackedView& view, const Chunk& chunk)
		{
			SlotSum    velocity2;
			const auto inverse = [](L value) { return zeroWhere(value <= L(0.0), L(1.0) / value); };
			const auto slide   = [](L friction, L with) { return select(with <= L(0.0), L(unlimited), friction / with); };
			forEachPair(view, chunk, [&](const P& at1, const P& at2, PointBlock* point, int lane) INLINE {
				const B v1 = loadBodies<RCR_LANES>(at1), v2 = loadBodies<RCR_LANES>(at2);
				const L m1 = v1.inverseMass, m2 = v2.inverseMass;
				for (PointBlock* c = point; c < point + chunk.pointsPerPair; ++c) {
					const L nx = L::load(c->nx + lane), ny = L::load(c->ny + lane), friction = L::load(c->friction + lane);
					const L x1 = L::load(c->turn1n + lane), y1 = L::load(c->turn1t + lane);
					const L x2 = L::load(c->turn2n + lane), y2 = L::load(c->turn2t + lane);
					const L j1n = x1 * ny - y1 * nx, j1t = x1 * nx + y1 * ny, j2n = x2 * ny - y2 * nx, j2t = x2 * nx + y2 * ny;
					const L nn = m1 + m2 + (m1 * (j1n * j1n) + m2 * (j2n * j2n));
					const L nt = m1 * (j1n * j1t) + m2 * (j2n * j2t);
					const L tt = m1 + m2 + (m1 * (j1t * j1t) + m2 * (j2t * j2t));
					const L inverseNn = inverse(nn), ratio = nt * inverseNn;
					j1n.store(c->turn1n + lane);
					j1t.store(c->turn1t + lane);
					j2n.store(c->turn2n + lane);
					j2t.store(c->turn2t + lane);
					inverseNn.store(c->inverseNn + lane);
					ratio.store(c->ratio + lane);
					inverse(tt - nt * ratio).store(c->inverseSchur + lane);
					slide(friction, L(1.0) + friction * ratio).store(c->slidePlus + lane);
					slide(friction, L(1.0) - friction * ratio).store(c->slideMinus + lane);
					const Vector u = relativeVelocity(*c, lane, v1, v2);
					velocity2.add(lane, u.n * u.n + u.t * u.t);
				}
			});
			return velocity2.total();
		}

		void apply(const PackedView& view, const Chunk& chunk)
		{
			forEachPair(view, chunk, [&](const P& at1, const P& at2, const PointBlock* point, int lane) INLINE {
				B v1 = loadBodies<RCR_LANES>(at1), v2 = loadBodies<RCR_LANES>(at2);
				for (const PointBlock* c = point; c < point + chunk.pointsPerPair; ++c)
					applyImpulse(*c, lane, { L::load(c->pn + lane), L::load(c->pt + lane) }, v1, v2);
				storeBodies<RCR_LANES>(v1, at1);
				storeBodies<RCR_LANES>(v2, at2);
			});
		}

		/// One sweep; `next(point, lane, u)` gives the change of the impulse and stores it.
		template <int Points, class Next> inline void sweepPairs(const PackedView& view, const Chunk& chunk, Next next)
		{
			forEachPair(view, chunk, [&](const P& at1, const P& at2, PointBlock* point, int lane) INLINE {
				B v1 = loadBodies<RCR_LANES>(at1), v2 = loadBodies<RCR_LANES>(at2);
				for (int i = 0; i < Points; ++i) {
					const Vector change = next(point[i], lane, relativeVelocity(point[i], lane, v1, v2));
					if (RCR_LANES > 8) keepOrder();
					applyImpulse(point[i], lane, change, v1, v2);
				}
				storeBodies<RCR_LANES>(v1, at1);
				storeBodies<RCR_LANES>(v2, at2);
			});
		}

		template <class Next> inline void sweepChunk(const PackedView& view, const Chunk& chunk, Next next)
		{
			if (chunk.pointsPerPair == 1) sweepPairs<1>(view, chunk, next);
			else
				sweepPairs<2>(view, chunk, next);
		}

		void sweep(const PackedView& view, const Chunk& chunk)
		{
			sweepChunk(view, chunk, [](PointBlock& c, int lane, const Vector& u) INLINE -> Vector {
				const Vector p { L::load(c.pn + lane), L::load(c.pt + lane) }, q = solvePoint(c, lane, u, p);
				q.n.store(c.pn + lane);
				q.t.store(c.pt + lane);
				return { q.n - p.n, q.t - p.t };
			});
		}

		void sweepRelaxed(const PackedView& view, const Chunk& chunk, double by)
		{
			const L relaxation = by;
			sweepChunk(view, chunk, [=](PointBlock& c, int lane, const Vector& u) INLINE -> Vector {
				const Vector p { L::load(c.pn + lane), L::load(c.pt + lane) }, solved = solvePoint(c, lane, u, p);
				const Vector q = projectCone(
				        { p.n + relaxation * (solved.n - p.n), p.t + relaxation * (solved.t - p.t) }, L::load(c.friction + lane));
				q.n.store(c.pn + lane);
				q.t.store(c.pt + lane);
				return { q.n - p.n, q.t - p.t };
			});
		}

		double sweepMomentum(const PackedView& view, const Chunk& chunk, double momentum)
		{
			const L beta = momentum;
			SlotSum change2;
			sweepChunk(view, chunk, [&](PointBlock& c, int lane, const Vector& u) INLINE -> Vector {
				const Vector p { L::load(c.pn + lane), L::load(c.pt + lane) };
				const Vector y { addProduct(p.n, beta, p.n - L::load(c.oldPn + lane)), addProduct(p.t, beta, p.t - L::load(c.oldPt + lane)) };
				const Vector q = solvePoint(c, lane, u, y), change { q.n - y.n, q.t - y.t };
				p.n.store(c.oldPn + lane);
				p.t.store(c.oldPt + lane);
				q.n.store(c.pn + lane);
				q.t.store(c.pt + lane);
				change2.add(lane, addProduct(change.n * change.n, change.t, change.t));
				return change;
			});
			return change2.total();
		}

		Measures measure(const PackedView& view, const Chunk& chunk)
		{
			SlotSum error2, impulse2, normal, violation2, velocity2, stopping2;
			forEachPair(view, chunk, [&](const P& at1, const P& at2, const PointBlock* point, int lane) INLINE {
				const B v1 = loadBodies<RCR_LANES>(at1), v2 = loadBodies<RCR_LANES>(at2);
				for (const PointBlock* c = point; c < point + chunk.pointsPerPair; ++c) {
					const Vector u = relativeVelocity(*c, lane, v1, v2), p { L::load(c->pn + lane), L::load(c->pt + lane) };
					const L      bias = L::load(c->bias + lane), un = u.n + bias, friction = L::load(c->friction + lane);
					const L      scale = L::load(c->inverseNn + lane), stopping = (abs(u.n) + abs(bias)) * scale;
					const Vector q     = projectCone({ p.n - (un + friction * abs(u.t)) * scale, p.t - u.t * scale }, friction);
					const L      miss = (p.n - q.n) * (p.n - q.n) + (p.t - q.t) * (p.t - q.t);
					error2.add(lane, miss);
					impulse2.add(lane, p.n * p.n + p.t * p.t);
					normal.add(lane, p.n);
					violation2.add(lane, select(scale <= L(0.0), L(0.0), miss / (scale * scale)));
					velocity2.add(lane, u.n * u.n + u.t * u.t);
					stopping2.add(lane, stopping * stopping);
				}
			});
			return { error2.total(), impulse2.total(), normal.total(), violation2.total(), velocity2.total(), stopping2.total() };
		}

		void extrapolate(const PackedView& view, int first, int last, double momentum)
		{
			using Four       = Lane<RCR_LANES == 1 ? 1 : 4>;
			const Four beta  = momentum;
			double*    value = &view.body[0].x;
			double*    old   = &view.oldBody[0].x;
			for (long i = 4L * first; i < 4L * last; i += RCR_LANES == 1 ? 1 : 4) {
				const Four v = Four::load(value + i);
				addProduct(v, beta, v - Four::load(old + i)).store(old + i);
			}
		}

	} // namespace

	extern const PackedKernels kernels;
	const PackedKernels        kernels { RCR_LANES, prepare, apply, sweep, sweepRelaxed, sweepMomentum, measure, extrapolate };

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
