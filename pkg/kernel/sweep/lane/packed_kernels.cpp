// The inner loops of the sweep solvers, over the blocks of a chunk. Compiled once for every lane width, and for floats too: RCR_LANES Reals at a time.
#include <type_traits>

#include "sweep/lane/point_models.hpp"

#define INLINE __attribute__((always_inline)) // lambdas of inner loops: a call costs as much as a tenth of a point
#define APART  __attribute__((noinline))      // one loop a function: together they run out of registers

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	namespace {

		template <int Points> struct Count {
			static constexpr int value = Points;
		};

		/// Calls work(model, points a pair) of the chunk.
		template <class Work> inline void dispatch(const Chunk& chunk, Work work)
		{
			const auto as = [&](auto model) { chunk.pointsPerPair == 1 ? work(model, Count<1>()) : work(model, Count<2>()); };
			switch (chunk.model) {
				case Model::frictional: return as(Frictional());
				case Model::round: return as(Round());
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
			return { u.n, u.t + L::load(c.slip + lane) };
		}

		inline L inverse(L value) { return zeroWhere(value <= L(0.0), L(1.0) / value); }

		inline void preparePoint(CentralBlock& c, int lane, L m1, L m2) { inverse(m1 + m2).store(c.inverseNn + lane); }

		inline void preparePoint(RoundBlock& c, int lane, L m1, L m2)
		{
			const L j1 = turn1t(c, lane), j2 = turn2t(c, lane);
			inverse(m1 + m2).store(c.inverseNn + lane);
			inverse(m1 + m2 + (m1 * (j1 * j1) + m2 * (j2 * j2))).store(c.inverseSchur + lane);
		}

		/// Lever arms from r/k, and the normal coefficient.
		template <class Block> inline void prepareLevers(Block& c, int lane, L m1, L m2)
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

		inline void preparePoint(FrictionlessBlock& c, int lane, L m1, L m2) { prepareLevers(c, lane, m1, m2); }

		inline void preparePoint(FrictionalBlock& c, int lane, L m1, L m2)
		{
			prepareLevers(c, lane, m1, m2);
			const auto slide = [&](L with) { return select(with <= L(0.0), L(unlimited<Real>), friction(c, lane) / with); };
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
			const L relaxation = Real(by);
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
			const L beta = Real(momentum);
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
			return sweepKeeping(view, chunk, momentum, Share { Real(kept) });
		}

		/// The biases of points: of floats those of the law, beside which theirs holds the velocity of the reference, too.
		INLINE inline L biasOf(const PointBlock& c, int lane, const Column* bias)
		{
			return L::load((std::is_same_v<Real, double> ? c.bias : bias->of) + lane);
		}

		Measures measure(const PackedView& view, const Chunk& chunk, const Column* bias)
		{
			Sum error2, impulse2, normal, violation2, velocity2, stopping2, taken;
			dispatch(chunk, [&](auto model, auto) {
				using M           = decltype(model);
				const auto* first = reinterpret_cast<const typename M::Block*>(view.points + chunk.firstColumn);
				forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, const auto* point, int lane) INLINE {
					const auto [v1, v2] = loadWhole<M>(*point, lane, at1, at2);
					for (auto* c = point; c < point + chunk.pointsPerPair; ++c) {
						const Vector u = wholeVelocity(*c, lane, v1, v2), p { L::load(c->pn + lane), tangential(*c, lane) };
						const L      un = u.n + L::load(c->bias + lane), mu = friction(*c, lane);
						const L      law   = biasOf(*c, lane, bias + chunk.firstPoint + (c - first));
						const L      speed = std::is_same_v<Real, double> ? u.n : un - law; // else without the reference's
						const L      scale = L::load(c->inverseNn + lane), stopping = (abs(speed) + abs(law)) * scale;
						const Vector q     = projectCone({ p.n - (un + mu * abs(u.t)) * scale, p.t - u.t * scale }, mu);
						const L      miss = (p.n - q.n) * (p.n - q.n) + (p.t - q.t) * (p.t - q.t);
						error2.add(lane, miss);
						impulse2.add(lane, p.n * p.n + p.t * p.t);
						normal.add(lane, p.n);
						violation2.add(lane, select(scale <= L(0.0), L(0.0), miss / (scale * scale)));
						velocity2.add(lane, speed * speed + u.t * u.t);
						stopping2.add(lane, stopping * stopping);
						taken.add(lane, L(0.0) - (p.n * un + p.t * u.t));
					}
				});
			});
			return { error2.total(), impulse2.total(), normal.total(), violation2.total(), velocity2.total(), stopping2.total(), taken.total() };
		}

		void refer(const PackedView& view, const Chunk& chunk, ColumnOf<float>* points)
		{
			dispatch(chunk, [&](auto model, auto) {
				using M          = decltype(model);
				auto* const from = reinterpret_cast<typename M::Block*>(view.points + chunk.firstColumn);
				auto* const to   = reinterpret_cast<typename M::Single*>(points + chunk.firstColumn);
				forEachPair<M>(view, chunk, [&](const P& at1, const P& at2, const auto* point, int lane) INLINE {
					const auto [v1, v2] = loadWhole<M>(*point, lane, at1, at2);
					for (auto* c = point; c < point + chunk.pointsPerPair; ++c) {
						const Vector u = wholeVelocity(*c, lane, v1, v2);
						(u.n + L::load(c->bias + lane)).store(to[c - from].bias + lane);
						u.t.store(to[c - from].slip + lane);
					}
				});
			});
		}

		void extrapolate(const PackedView& view, int first, int last, double momentum)
		{
			const Real  beta  = Real(momentum);
			const Real* value = &view.body[0].x;
			Real*       old   = &view.oldBody[0].x;
			for (long i = 2L * first; i < 2L * last; ++i)
				old[i] = fma(beta, value[i] - old[i], value[i]);
		}

	} // namespace

	extern const PackedKernelsOf<Real> kernels;
	const PackedKernelsOf<Real> kernels { RCR_LANES, prepare, apply, sweep, sweepRelaxed, sweepMomentum, sweepYielding, measure, refer, extrapolate };

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
