// The inner loops of the sweep solvers. Compiled once for every lane width: RCR_LANES doubles at a time.
//
// Per point, with û_n = u_n + b_n and the symbols of packed_blocks.hpp, the solution of coulomb.hpp becomes
//   n₀ = max(p_n + r p_t − û_n / w_nn, 0)    normal impulse without friction; 0 where the point opens
//   t₀ = p_t − (u_t − r û_n) / s             tangential impulse that stops sliding
//   p_t = t₀ clamped to n₀ [−d₋, d₊],  p_n = n₀ − r p_t
// for |t| ≤ µ (n₀ − r t) says −n₀ d₋ ≤ t ≤ n₀ d₊, and a point that slides is at the end of that range. Without friction that is p_n = n₀.
#include "sweep/lane_vector.hpp"

#define INLINE __attribute__((always_inline)) // lambdas of inner loops: a call costs as much as a tenth of a point
#define APART  __attribute__((noinline))      // one loop a function: together they run out of registers

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	namespace {

		using L = Lane<RCR_LANES>;
		using B = Bodies<RCR_LANES>;
		using P = Places<RCR_LANES>;

		using Vector = Components<RCR_LANES>;

		inline L square(L a) { return a * a; }

		// what the lesser models have not
		inline L turn1n(const CentralBlock&, int) { return 0.0; }
		inline L turn1t(const CentralBlock&, int) { return 0.0; }
		inline L turn2n(const CentralBlock&, int) { return 0.0; }
		inline L turn2t(const CentralBlock&, int) { return 0.0; }
		inline L turn1n(const FrictionlessBlock& c, int lane) { return L::load(c.turn1n + lane); }
		inline L turn1t(const FrictionlessBlock& c, int lane) { return L::load(c.turn1t + lane); }
		inline L turn2n(const FrictionlessBlock& c, int lane) { return L::load(c.turn2n + lane); }
		inline L turn2t(const FrictionlessBlock& c, int lane) { return L::load(c.turn2t + lane); }
		inline L friction(const PointBlock&, int) { return 0.0; }
		inline L friction(const FrictionalBlock& c, int lane) { return L::load(c.friction + lane); }
		inline L tangential(const PointBlock&, int) { return 0.0; }
		inline L tangential(const FrictionalBlock& c, int lane) { return L::load(c.pt + lane); }

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

		struct Frictional {
			using Block   = FrictionalBlock;
			using Impulse = Vector;

			static B       load(const P& at) { return loadBodies<RCR_LANES>(at); }
			static void    store(const B& v, const P& at) { storeBodies<RCR_LANES>(v, at); }
			static Impulse impulse(const Block& c, int lane) { return { L::load(c.pn + lane), L::load(c.pt + lane) }; }
			static Impulse oldImpulse(const Block& c, int lane) { return { L::load(c.oldPn + lane), L::load(c.oldPt + lane) }; }
			static void    set(Block& c, int lane, const Impulse& p) { p.n.store(c.pn + lane), p.t.store(c.pt + lane); }
			static void    setOld(Block& c, int lane, const Impulse& p) { p.n.store(c.oldPn + lane), p.t.store(c.oldPt + lane); }
			static Vector  velocity(const Block& c, int lane, const B& v1, const B& v2) { return relativeVelocity(c, lane, v1, v2); }
			static Impulse solve(const Block& c, int lane, const Vector& u, const Impulse& p) { return solvePoint(c, lane, u, p); }
			static Impulse project(const Block& c, int lane, const Impulse& p) { return projectCone(p, friction(c, lane)); }
			static void    apply(const Block& c, int lane, const Impulse& p, B& v1, B& v2)
			{
				if (RCR_LANES > 8) keepOrder();
				applyImpulse(c, lane, p, v1, v2);
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
			using Block = FrictionlessBlock;

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
			using Block = CentralBlock;
			using C     = Centres<RCR_LANES>;

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

		template <int Points> struct Count {
			static constexpr int value = Points;
		};

		/// Calls work(model, points a pair) of the chunk.
		template <class Work> inline void dispatch(const Chunk& chunk, Work work)
		{
			const auto as = [&](auto model) { chunk.pointsPerPair == 1 ? work(model, Count<1>()) : work(model, Count<2>()); };
			switch (chunk.model) {
				case Model::frictional: return as(Frictional());
				case Model::frictionless: return as(Frictionless());
				case Model::central: return as(Central());
			}
		}

		// ---- the loops

		/// Calls visit(bodies 1, bodies 2, first point block, lane) for all pairs of a chunk, RCR_LANES at a time.
		template <class M, class Visit> inline void forEachPair(const PackedView& view, const Chunk& chunk, Visit visit)
		{
			auto* const point = reinterpret_cast<typename M::Block*>(view.points + chunk.firstColumn);
			for (int b = 0; b < chunk.blocks; ++b)
				for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
					visit(
					        P { view.body, view.pairs[chunk.firstPair + b].body1 + lane },
					        P { view.body, view.pairs[chunk.firstPair + b].body2 + lane },
					        point + b * chunk.pointsPerPair,
					        lane);
		}

		using Sum = SlotSum<blockWidth>;

		// bodies as the frictional model has them, of central pairs without spin

		struct WholePair {
			B v1, v2;
		};

		template <class M> INLINE inline WholePair loadWhole(const typename M::Block& c, int lane, const P& at1, const P& at2)
		{
			const auto v1 = M::load(at1), v2 = M::load(at2);
			if constexpr (std::is_same_v<M, Central>)
				return { { v1.x, v1.y, L(0.0), L::load(c.mass1 + lane) }, { v2.x, v2.y, L(0.0), L::load(c.mass2 + lane) } };
			else
				return { v1, v2 };
		}

		template <class M> INLINE inline void storeWhole(const B& v, const P& at)
		{
			if constexpr (std::is_same_v<M, Central>) M::store({ v.x, v.y }, at);
			else
				M::store(v, at);
		}

		/// The velocity that counts in the criteria.
		template <class Block> inline Vector wholeVelocity(const Block& c, int lane, const B& v1, const B& v2)
		{
			const Vector u = relativeVelocity(c, lane, v1, v2);
			if constexpr (std::is_same_v<Block, CentralBlock>) return { u.n, u.t + L::load(c.slip + lane) };
			else
				return u;
		}

		inline L inverse(L value) { return zeroWhere(value <= L(0.0), L(1.0) / value); }

		inline void preparePoint(CentralBlock& c, int lane, L m1, L m2) { inverse(m1 + m2).store(c.inverseNn + lane); }

		inline void preparePoint(FrictionlessBlock& c, int lane, L m1, L m2)
		{
			const L nx = L::load(c.nx + lane), ny = L::load(c.ny + lane);
			const L x1 = turn1n(c, lane), y1 = turn1t(c, lane), x2 = turn2n(c, lane), y2 = turn2t(c, lane);
			const L j1n = x1 * ny - y1 * nx, j2n = x2 * ny - y2 * nx;
			j1n.store(c.turn1n + lane);
			j2n.store(c.turn2n + lane);
			(x1 * nx + y1 * ny).store(c.turn1t + lane);
			(x2 * nx + y2 * ny).store(c.turn2t + lane);
			inverse(m1 + m2 + (m1 * (j1n * j1n) + m2 * (j2n * j2n))).store(c.inverseNn + lane);
		}

		inline void preparePoint(FrictionalBlock& c, int lane, L m1, L m2)
		{
			preparePoint(static_cast<FrictionlessBlock&>(c), lane, m1, m2);
			const auto slide = [&](L with) { return select(with <= L(0.0), L(unlimited), friction(c, lane) / with); };
			const L    j1n = turn1n(c, lane), j1t = turn1t(c, lane), j2n = turn2n(c, lane), j2t = turn2t(c, lane);
			const L    nt = m1 * (j1n * j1t) + m2 * (j2n * j2t);
			const L    tt = m1 + m2 + (m1 * (j1t * j1t) + m2 * (j2t * j2t));
			const L    ratio = nt * L::load(c.inverseNn + lane), slope = friction(c, lane) * ratio;
			ratio.store(c.ratio + lane);
			inverse(tt - nt * ratio).store(c.inverseSchur + lane);
			slide(L(1.0) + slope).store(c.slidePlus + lane);
			slide(L(1.0) - slope).store(c.slideMinus + lane);
		}

		double prepare(const PackedView& view, const Chunk& chunk)
		{
			Sum velocity2;
			dispatch(chunk, [&](auto model, auto) {
				using M = decltype(model);
				forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, auto* point, int lane) INLINE {
					const auto [v1, v2] = loadWhole<M>(*point, lane, at1, at2);
					for (auto* c = point; c < point + chunk.pointsPerPair; ++c) {
						preparePoint(*c, lane, v1.inverseMass, v2.inverseMass);
						const Vector u = wholeVelocity(*c, lane, v1, v2);
						velocity2.add(lane, u.n * u.n + u.t * u.t);
					}
				});
			});
			return velocity2.total();
		}

		void apply(const PackedView& view, const Chunk& chunk)
		{
			dispatch(chunk, [&](auto model, auto) {
				using M = decltype(model);
				forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, const auto* point, int lane) INLINE {
					auto [v1, v2] = loadWhole<M>(*point, lane, at1, at2);
					for (auto* c = point; c < point + chunk.pointsPerPair; ++c)
						applyImpulse(*c, lane, { L::load(c->pn + lane), tangential(*c, lane) }, v1, v2);
					storeWhole<M>(v1, at1);
					storeWhole<M>(v2, at2);
				});
			});
		}

		/// One sweep; `next(point, lane, u)` gives the change of the impulse and stores it.
		template <class M, int Points, class Next> inline void sweepPairs(const PackedView& view, const Chunk& chunk, Next next)
		{
			forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, auto* point, int lane) INLINE {
				auto v1 = M::load(at1), v2 = M::load(at2);
				for (int i = 0; i < Points; ++i) {
					const auto change = next(point[i], lane, M::velocity(point[i], lane, v1, v2));
					M::apply(point[i], lane, change, v1, v2);
				}
				M::store(v1, at1);
				M::store(v2, at2);
			});
		}

		template <class M, int Points> APART void sweepAs(const PackedView& view, const Chunk& chunk)
		{
			sweepPairs<M, Points>(view, chunk, [](auto& c, int lane, const auto& u) INLINE {
				const auto p = M::impulse(c, lane), q = M::solve(c, lane, u, p);
				M::set(c, lane, q);
				return q - p;
			});
		}

		void sweep(const PackedView& view, const Chunk& chunk)
		{
			dispatch(chunk, [&](auto model, auto points) { sweepAs<decltype(model), points.value>(view, chunk); });
		}

		template <class M, int Points> APART void sweepRelaxedAs(const PackedView& view, const Chunk& chunk, double by)
		{
			const L relaxation = by;
			sweepPairs<M, Points>(view, chunk, [=](auto& c, int lane, const auto& u) INLINE {
				const auto p = M::impulse(c, lane), solved = M::solve(c, lane, u, p);
				const auto q = M::project(c, lane, p + relaxation * (solved - p));
				M::set(c, lane, q);
				return q - p;
			});
		}

		void sweepRelaxed(const PackedView& view, const Chunk& chunk, double relaxation)
		{
			dispatch(chunk, [&](auto model, auto points) { sweepRelaxedAs<decltype(model), points.value>(view, chunk, relaxation); });
		}

		template <class M, int Points, class Keep> APART double sweepMomentumAs(const PackedView& view, const Chunk& chunk, double momentum, Keep keep)
		{
			const L beta = momentum;
			Sum change2;
			sweepPairs<M, Points>(view, chunk, [&](auto& c, int lane, const auto& u) INLINE {
				const auto p = M::impulse(c, lane), y = addProduct(p, beta, p - M::oldImpulse(c, lane));
				const auto q = keep(M::solve(c, lane, u, y)), change = q - y;
				M::setOld(c, lane, p);
				M::set(c, lane, q);
				change2.add(lane, square(change));
				return change;
			});
			return change2.total();
		}

		struct All {
			template <class Impulse> INLINE Impulse operator()(const Impulse& p) const { return p; }
		};

		struct Share {
			L kept;

			template <class Impulse> INLINE Impulse operator()(const Impulse& p) const { return kept * p; }
		};

		template <class Keep> double sweepKeeping(const PackedView& view, const Chunk& chunk, double momentum, Keep keep)
		{
			double change2 = 0;
			dispatch(chunk, [&](auto model, auto points) {
				change2 = sweepMomentumAs<decltype(model), points.value>(view, chunk, momentum, keep);
			});
			return change2;
		}

		double sweepMomentum(const PackedView& view, const Chunk& chunk, double momentum) { return sweepKeeping(view, chunk, momentum, All()); }

		double sweepYielding(const PackedView& view, const Chunk& chunk, double momentum, double kept)
		{
			return sweepKeeping(view, chunk, momentum, Share { kept });
		}

		Measures measure(const PackedView& view, const Chunk& chunk)
		{
			Sum error2, impulse2, normal, violation2, velocity2, stopping2, taken;
			dispatch(chunk, [&](auto model, auto) {
				using M = decltype(model);
				forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, const auto* point, int lane) INLINE {
					const auto [v1, v2] = loadWhole<M>(*point, lane, at1, at2);
					for (auto* c = point; c < point + chunk.pointsPerPair; ++c) {
						const Vector u = wholeVelocity(*c, lane, v1, v2), p { L::load(c->pn + lane), tangential(*c, lane) };
						const L      bias = L::load(c->bias + lane), un = u.n + bias, mu = friction(*c, lane);
						const L      scale = L::load(c->inverseNn + lane), stopping = (abs(u.n) + abs(bias)) * scale;
						const Vector q     = projectCone({ p.n - (un + mu * abs(u.t)) * scale, p.t - u.t * scale }, mu);
						const L      miss = (p.n - q.n) * (p.n - q.n) + (p.t - q.t) * (p.t - q.t);
						error2.add(lane, miss);
						impulse2.add(lane, p.n * p.n + p.t * p.t);
						normal.add(lane, p.n);
						violation2.add(lane, select(scale <= L(0.0), L(0.0), miss / (scale * scale)));
						velocity2.add(lane, u.n * u.n + u.t * u.t);
						stopping2.add(lane, stopping * stopping);
						taken.add(lane, L(0.0) - (p.n * un + p.t * u.t));
					}
				});
			});
			return { error2.total(), impulse2.total(), normal.total(), violation2.total(), velocity2.total(), stopping2.total(), taken.total() };
		}

		void extrapolate(const PackedView& view, int first, int last, double momentum)
		{
			using Few       = Lane<RCR_LANES == 1 ? 1 : 4>; // records of an island begin and end with whole ones
			const Few beta  = momentum;
			double*   value = &view.body[0].x;
			double*   old   = &view.oldBody[0].x;
			for (long i = 2L * first; i < 2L * last; i += RCR_LANES == 1 ? 1 : 4) {
				const Few v = Few::load(value + i);
				addProduct(v, beta, v - Few::load(old + i)).store(old + i);
			}
		}

	} // namespace

	extern const PackedKernels kernels;
	const PackedKernels        kernels { RCR_LANES, prepare, apply, sweep, sweepRelaxed, sweepMomentum, sweepYielding, measure, extrapolate };

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
