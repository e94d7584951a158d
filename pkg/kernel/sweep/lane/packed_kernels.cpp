// Inner loops of the sweep solvers over the blocks of a chunk, RCR_LANES points at a time.
// Compiled like lane.hpp.
#include "sweep/lane/pair_loops.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

namespace {

	/// One sweep. next(point, lane, u) stores the new impulse and returns its change.
	template <class M, class Next>
	inline void sweepPairs(const PackedView& view, const Chunk& chunk, Next next)
	{
		forEachPair<M>(view, chunk,
		        [&](const P& at1, const P& at2, const auto& point, int lane) INLINE {
			        auto v1 = M::load(at1), v2 = M::load(at2);
			        for (int i = 0; i < chunk.pointsPerPair; ++i) {
				        const auto c      = pointAt(point, i);
				        const auto change = next(c, lane, M::velocity(c, lane, v1, v2));
				        M::apply(c, lane, change, v1, v2);
			        }
			        M::store(v1, at1);
			        M::store(v2, at2);
		        });
	}

	/// A rigid contact takes the whole solution of its point.
	constexpr auto wholeSolution
	        = [](const auto&, int, const auto&, const auto& solved) INLINE { return solved; };

	template <class M, class NewImpulse>
	NOINLINE void sweepAs(const PackedView& view, const Chunk& chunk, NewImpulse newImpulse)
	{
		sweepPairs<M>(view, chunk, [&](const auto& c, int lane, const auto& u) INLINE {
			const auto p = M::impulse(c, lane);
			const auto q = newImpulse(c, lane, p, M::solve(c, lane, u, p));
			M::set(c, lane, q);
			return q - p;
		});
	}

	void sweep(const PackedView& view, const Chunk& chunk, double relaxation)
	{
		withModel(chunk, [&](auto model) {
			using M            = decltype(model);
			const auto relaxed = [by = L(Real(relaxation))](const auto& c, int lane, const auto& p,
			                             const auto& solved) INLINE {
				return M::project(c, lane, p + by * (solved - p));
			};
			relaxation == 1 ? sweepAs<M>(view, chunk, wholeSolution)
			                : sweepAs<M>(view, chunk, relaxed);
		});
	}

	template <class M, class NewImpulse>
	NOINLINE double sweepMomentumAs(
	        const PackedView& view, const Chunk& chunk, double momentum, NewImpulse newImpulse)
	{
		const L beta = Real(momentum);
		Sum     change2;
		sweepPairs<M>(view, chunk, [&](const auto& c, int lane, const auto& u) INLINE {
			const auto p = M::impulse(c, lane), last = p - M::oldImpulse(c, lane),
			           y = addProduct(p, beta, last);
			const auto q = newImpulse(c, lane, y, M::solve(c, lane, u, y));
			// q − y. In floats, the rounding of y would accumulate in the velocities.
			const auto change = relativeToReference ? subtractProduct(q - p, beta, last) : q - y;
			M::setOld(c, lane, p);
			M::set(c, lane, q);
			change2.add(lane, square(change));
			return change;
		});
		return change2.total();
	}

	double sweepMomentum(
	        const PackedView& view, const Chunk& chunk, double momentum, const Yielding& yielding)
	{
		const L compliance = Real(yielding.compliance), leastResponse = Real(yielding.leastResponse);
		// a share of the solution (problem/yielding.hpp)
		const auto yielded = [=](const auto& c, int lane, const auto&, const auto& solved) INLINE {
			const L scale = max(L(1.0), leastResponse * L::load(c.inverseNn() + lane));
			return (L(1.0) / (L(1.0) + compliance * scale)) * solved;
		};
		double change2 = 0;
		withModel(chunk, [&](auto model) {
			const auto sweep = [&](auto newImpulse) {
				return sweepMomentumAs<decltype(model)>(view, chunk, momentum, newImpulse);
			};
			change2 = yielding.compliance == 0 ? sweep(wholeSolution) : sweep(yielded);
		});
		return change2;
	}

	/// b_n of the contact law; the column `bias` of floats contains u_ref too.
	INLINE inline L contactBias(const PointColumns& c, int lane, const Column* bias, int point)
	{
		if constexpr (relativeToReference) return L::load(bias[point].of + lane);
		else
			return L::load(c.bias() + lane);
	}

	Measures measure(const PackedView& view, const Chunk& chunk, const Column* bias,
	        double leastResponse)
	{
		Sum error2, impulse2, normal, kinematicError2, stopping2, dissipated, rootSpeed,
		        errorEnergy, impulseEnergy;
		const L mostScale = Real(std::min(1 / leastResponse, double(unlimited<Real>)));
		const Column* const first = view.points + chunk.firstColumn;
		forEachPoint(view, chunk, [&](const auto& c, int lane, const B& v1, const B& v2) INLINE {
			const Vector u = wholeVelocity(c, lane, v1, v2),
			             p { L::load(c.pn() + lane), tangential(c, lane) };
			const int number   = chunk.firstPointBlock + int(c.first() - first) / c.count;
			const L   un       = u.n + L::load(c.bias() + lane), mu = friction(c, lane);
			const L   law      = contactBias(c, lane, bias, number);
			const L   speed    = relativeToReference ? un - law : u.n;
			const L   scale    = L::load(c.inverseNn() + lane),
			          stopping = (abs(speed) + abs(law)) * scale;
			const Vector q     = projectCone(
			        { p.n - (un + mu * abs(u.t)) * scale, p.t - u.t * scale }, mu);
			const L pointError2 = (p.n - q.n) * (p.n - q.n) + (p.t - q.t) * (p.t - q.t);
			const L pointImpulse2 = p.n * p.n + p.t * p.t;
			const L response      = select(scale <= L(0.0), L(0.0), L(1.0) / scale);
			const L energy        = select(scale <= mostScale, response, L(0.0));
			error2.add(lane, pointError2);
			impulse2.add(lane, pointImpulse2);
			normal.add(lane, p.n);
			kinematicError2.add(lane, pointError2 * response * response);
			errorEnergy.add(lane, pointError2 * energy);
			impulseEnergy.add(lane, pointImpulse2 * energy);
			stopping2.add(lane, stopping * stopping);
			dissipated.add(lane, L(0.0) - (p.n * un + p.t * u.t));
			rootSpeed.add(lane, sqrt(abs(speed) + abs(u.t)));
			if constexpr (isRolling<decltype(c)>) {
				const L ur = Rolling::rollingVelocity(c, lane, v1, v2), pr = L::load(c.pr() + lane),
				        inverseRr = L::load(c.inverseRr() + lane);
				const L wrr   = select(inverseRr <= L(0.0), L(0.0), L(1.0) / inverseRr);
				const L error = pr - clampTo(pr - ur * inverseRr, Rolling::most(c, lane, p));
				const L turns = select(inverseRr <= L(0.0), L(0.0), error * error);
				error2.add(lane, turns);
				impulse2.add(lane, pr * pr);
				kinematicError2.add(lane, turns * wrr * wrr);
				errorEnergy.add(lane, turns * wrr);
				impulseEnergy.add(lane, pr * pr * wrr);
				stopping2.add(lane, ur * ur * inverseRr * inverseRr);
				dissipated.add(lane, L(0.0) - pr * ur);
			}
		});
		return { error2.total(), impulse2.total(), normal.total(), kinematicError2.total(),
			stopping2.total(), dissipated.total(), rootSpeed.total(), errorEnergy.total(),
			impulseEnergy.total() };
	}

	void extrapolate(const PackedView& view, int first, int last, double momentum)
	{
		const Real  beta  = Real(momentum);
		const Real* value = view.body;
		Real*       old   = view.oldBody;
		for (long i = 2L * first; i < 2L * last; ++i)
			old[i] = fma(beta, value[i] - old[i], value[i]);
	}

} // namespace

#ifdef RCR_SINGLE
extern const SweepKernels<float> kernels;
const SweepKernels<float>        kernels { sweep, sweepMomentum, measure, extrapolate };
#else
namespace {

	inline L inverse(L value) { return zeroWhere(value <= L(0.0), L(1.0) / value); }

	inline void preparePoint(const FrictionlessDiscColumns& c, int lane, L m1, L m2)
	{
		inverse(m1 + m2).store(c.inverseNn() + lane);
	}

	inline void preparePoint(const NoLeverColumns& c, int lane, L m1, L m2)
	{
		const L j1 = lever1t(c, lane), j2 = lever2t(c, lane);
		inverse(m1 + m2).store(c.inverseNn() + lane);
		inverse(m1 + m2 + (m1 * (j1 * j1) + m2 * (j2 * j2))).store(c.inverseSchur() + lane);
	}

	/// Computes lever arms from r/k, and 1/w_nn: all that a frictionless point needs.
	template <class Columns> inline void preparePoint(const Columns& c, int lane, L m1, L m2)
	{
		const L nx = L::load(c.nx() + lane), ny = L::load(c.ny() + lane);
		const L x1 = lever1n(c, lane), y1 = lever1t(c, lane), x2 = lever2n(c, lane),
		        y2  = lever2t(c, lane);
		const L j1n = x1 * ny - y1 * nx, j2n = x2 * ny - y2 * nx;
		j1n.store(c.lever1n() + lane);
		j2n.store(c.lever2n() + lane);
		(x1 * nx + y1 * ny).store(c.lever1t() + lane);
		(x2 * nx + y2 * ny).store(c.lever2t() + lane);
		inverse(m1 + m2 + (m1 * (j1n * j1n) + m2 * (j2n * j2n))).store(c.inverseNn() + lane);
	}

	inline void preparePoint(const FrictionalColumns& c, int lane, L m1, L m2)
	{
		preparePoint<FrictionalColumns>(c, lane, m1, m2);
		const auto slide = [&](L with) {
			return select(with <= L(0.0), L(unlimited<Real>), friction(c, lane) / with);
		};
		const L j1n = lever1n(c, lane), j1t = lever1t(c, lane), j2n = lever2n(c, lane),
		        j2t   = lever2t(c, lane);
		const L nt    = m1 * (j1n * j1t) + m2 * (j2n * j2t);
		const L tt    = m1 + m2 + (m1 * (j1t * j1t) + m2 * (j2t * j2t));
		const L ratio = nt * L::load(c.inverseNn() + lane), slope = friction(c, lane) * ratio;
		ratio.store(c.ratio() + lane);
		inverse(tt - nt * ratio).store(c.inverseSchur() + lane);
		slide(L(1.0) + slope).store(c.slidePlus() + lane);
		slide(L(1.0) - slope).store(c.slideMinus() + lane);
	}

	inline void preparePoint(const RollingColumns& c, int lane, L m1, L m2)
	{
		preparePoint(static_cast<const FrictionalColumns&>(c), lane, m1, m2);
		const L turn1 = L::load(c.turn1() + lane), turn2 = L::load(c.turn2() + lane);
		(m1 * (lever1n(c, lane) * turn1) + m2 * (lever2n(c, lane) * turn2)).store(c.responseN() + lane);
		(m1 * (lever1t(c, lane) * turn1) + m2 * (lever2t(c, lane) * turn2)).store(c.responseT() + lane);
		inverse(m1 * (turn1 * turn1) + m2 * (turn2 * turn2)).store(c.inverseRr() + lane);
	}

	double prepare(const PackedView& view, const Chunk& chunk)
	{
		Sum velocity2;
		forEachPoint(view, chunk, [&](const auto& c, int lane, const B& v1, const B& v2) INLINE {
			preparePoint(c, lane, v1.inverseMass, v2.inverseMass);
			const Vector u = wholeVelocity(c, lane, v1, v2);
			velocity2.add(lane, u.n * u.n + u.t * u.t);
		});
		return velocity2.total();
	}

	void apply(const PackedView& view, const Chunk& chunk)
	{
		withModel(chunk, [&](auto model) {
			using M = decltype(model);
			forEachPair<M>(view, chunk,
			        [&](const P& at1, const P& at2, const auto& point, int lane) INLINE {
				        auto [v1, v2] = loadWhole<M>(point, lane, at1, at2);
				        for (int i = 0; i < chunk.pointsPerPair; ++i) {
					        const auto c = pointAt(point, i);
					        applyImpulse(c, lane,
					                { L::load(c.pn() + lane), tangential(c, lane) }, v1, v2);
					        if constexpr (isRolling<decltype(c)>)
						        Rolling::applyRolling(c, lane, L::load(c.pr() + lane), v1, v2);
				        }
				        storeWhole<M>(v1, at1);
				        storeWhole<M>(v2, at2);
			        });
		});
	}

	void updateReference(const PackedView& view, const Chunk& chunk, ColumnOf<float>* points)
	{
		forEachPoint(view, chunk, [&](const auto& c, int lane, const B& v1, const B& v2) INLINE {
			const PointColumnsOf<float> single(points + (c.first() - view.points));
			const Vector                u = wholeVelocity(c, lane, v1, v2);
			(u.n + L::load(c.bias() + lane)).store(single.bias() + lane);
			u.t.store(single.tangentialBias() + lane);
		});
	}

} // namespace

extern const PackedKernels kernels;
const PackedKernels        kernels { { sweep, sweepMomentum, measure, extrapolate },
	RCR_LANES, prepare, apply, updateReference };
#endif

} // namespace rcr::RCR_LANE_NAMESPACE
