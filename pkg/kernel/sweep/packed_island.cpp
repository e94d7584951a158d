// Kernels sweep the pairs with slots; the code below sweeps the overflow.
#include "sweep/packed_island.hpp"

#include <type_traits>
#include <utility>

#include "problem/error_estimate.hpp"
#include "problem/residual.hpp"

namespace rcr {

// ---- points of the overflow

template <class Real>
LocalVector PackedIsland::relativeVelocity(const View<Real>& view, const OverflowPoint& c) const
{
	const Real *   v1 = view.recordAt(c.record1), *v2 = view.recordAt(c.record2);
	constexpr bool whole = std::is_same_v<Real, double>; // or relative to the reference
	Vec2 u { double(v2[record::x]) - v1[record::x], double(v2[record::y]) - v1[record::y] };
	if (packed_.stretches_) u = u + componentwise(packed_.stretchRate_, c.stretchArm);
	const double       spin1 = c.wholeRecords ? v1[record::spin] : 0;
	const double       spin2 = c.wholeRecords ? v2[record::spin] : 0;
	const LocalVector& rest  = whole ? c.drift : c.reference;
	return { dot(u, c.normal) + spin2 * c.lever2n - spin1 * c.lever1n + rest.n,
		dot(u, perp(c.normal)) + spin2 * c.lever2t - spin1 * c.lever1t + rest.t };
}

template <class Real>
void PackedIsland::applyImpulse(
        const View<Real>& view, const OverflowPoint& c, const LocalVector& p)
{
	const Vec2 f    = toCartesian(c.normal, p);
	const auto push = [&](int number, const InverseMass& mass, double sign, double torque) {
		// islands may share a prescribed body: do not write to it
		if (mass.prescribed()) return;
		Real* const v = view.recordAt(number);
		v[record::x]  = Real(v[record::x] + sign * (mass.x * f.x));
		v[record::y]  = Real(v[record::y] + sign * (mass.y * f.y));
		if (c.wholeRecords)
			v[record::spin] = Real(v[record::spin] + sign * (mass.rotation * torque));
	};
	push(c.record1, c.mass1, -1, p.n * c.lever1n + p.t * c.lever1t);
	push(c.record2, c.mass2, +1, p.n * c.lever2n + p.t * c.lever2t);
	if (!packed_.stretches_ || packed_.cellLags_) return;
	packed_.stretchRate_ = packed_.stretchRate_
	        + componentwise(packed_.inverseStretchMass_, componentwise(c.stretchArm, f));
}

/// The impulse that solves the point, other impulses fixed. The velocities contain impulse p.
template <class Real>
LocalVector PackedIsland::solve(
        const View<Real>& view, const OverflowPoint& c, const LocalVector& p) const
{
	const LocalVector u  = relativeVelocity(view, c);
	const double      gn = u.n + c.bias - c.w.nn * p.n - c.w.nt * p.t;
	const double      gt = u.t - c.w.nt * p.n - c.w.tt * p.t;
	return solveCoulomb(c.w, gn, gt, c.friction);
}

template <class Real>
double PackedIsland::rollingVelocity(const View<Real>& view, const OverflowPoint& c) const
{
	return c.turn2 * view.recordAt(c.record2)[record::spin]
	        - c.turn1 * view.recordAt(c.record1)[record::spin];
}

template <class Real>
void PackedIsland::applyRolling(const View<Real>& view, const OverflowPoint& c, double p)
{
	const auto turn = [&](int number, const InverseMass& mass, double arm) {
		Real& spin = view.recordAt(number)[record::spin];
		if (mass.rotation > 0) spin = Real(spin + mass.rotation * arm * p);
	};
	turn(c.record1, c.mass1, -c.turn1);
	turn(c.record2, c.mass2, c.turn2);
}

/// Solves the rolling resistance of the point at its impulse c.p, from p_r = `from` in the
/// velocities. Returns the change of p_r.
template <class Real>
double PackedIsland::roll(const View<Real>& view, OverflowPoint& c, double from)
{
	const double w = rollingResponse(c);
	c.r            = w > 0 ? clampTo(from - rollingVelocity(view, c) / w, c.rollingFriction * c.p.n)
	                       : 0;
	applyRolling(view, c, c.r - from);
	return c.r - from;
}

// ---- the steps of the solvers

void PackedIsland::prepare()
{
	forEachChunk([&](const Chunk& chunk, int k) {
		packed_.sum_[k] = packed_.kernels_->prepare(view_, chunk);
	});
	double velocity2 = sum(packed_.sum_);
	forEachOverflowPoint(
	        [&](OverflowPoint& c) { velocity2 += square(relativeVelocity(view_, c)); });
	state_.freeVelocity2 = velocity2;
	setNormWeights();
}

/// Sets the weights of the norms from the mean w_nn and the masses of the bodies.
void PackedIsland::setNormWeights()
{
	forEachChunk([&](const Chunk& chunk, int k) {
		packed_.sum_[k] = 0;
		forEachPointBlock(chunk, [&](int column) {
			const double* const scale = PointColumnsOf<double>(&packed_.point_[column]).inverseNn();
			for (int lane = 0; lane < blockWidth; ++lane)
				packed_.sum_[k] += scale[lane] > 0 ? 1 / scale[lane] : 0;
		});
	});
	double      response = sum(packed_.sum_);
	LargestMass mass;
	forEachOverflowPoint([&](OverflowPoint& c) { response += c.ownNn; });
	forEachRecords([&](const Range& records) {
		for (int k = records.begin; k < records.end; ++k)
			mass.include(packed_.inverseMass_[k]);
	});
	state_.norm = { shape(), response / shape().points, mass };
}

void PackedIsland::recomputeVelocities()
{
	if (state_.velocityRecomputed) return;
	const double* const free = packed_.freeBody_.data()->of;
	if (packed_.stretches_) packed_.stretchRate_ = {};
	const auto reset = [&](const Range& records) {
		std::copy(free + offsetOf(records.begin), free + offsetOf(records.end),
		        view_.recordAt(records.begin));
	};
	reset(island_.overflowRecords);
	forEachSection([&](const Section& section) {
		reset(section.records);
		forEachChunk(section, [&](const Chunk& chunk, int) {
			packed_.kernels_->apply(view_, chunk);
		});
	});
	forEachOverflowPoint([&](OverflowPoint& c) {
		applyImpulse(view_, c, c.p);
		if (c.rollingFriction > 0) applyRolling(view_, c, c.r);
	});
	updateStretchRate();
	state_.measures.reset();
	state_.velocityRecomputed = true;
}

void PackedIsland::sweep(double relaxation)
{
	beginSweep();
	inPrecision([&](const auto& view, const auto& kernels) {
		timeSweep([&] {
			forEachChunk([&](const Chunk& chunk, int) { kernels.sweep(view, chunk, relaxation); });
		});
		forEachOverflowPoint([&](OverflowPoint& c) {
			LocalVector p = solve(view, c, c.p);
			if (relaxation != 1) p = projectCone(c.p + relaxation * (p - c.p), c.friction);
			applyImpulse(view, c, p - c.p);
			c.p = p;
			if (c.rollingFriction > 0) roll(view, c, c.r);
		});
	});
	updateStretchRate();
}

double PackedIsland::sweepMomentum(double momentum, const Yielding& yielding)
{
	beginSweep();
	return inPrecision([&](auto& view, const auto& kernels) {
		return sweepMomentum(view, kernels, momentum, yielding);
	});
}

/// Each partition extrapolates the velocities of its bodies, v_old ← v + β (v − v_old), and sweeps
/// with these. v and v_old change places.
template <class Real>
double PackedIsland::sweepMomentum(View<Real>& view, const SweepKernels<Real>& kernels,
        double momentum, const Yielding& yielding)
{
	const View<Real> before      = view;
	const auto       extrapolate = [&](const Range& records) {
		kernels.extrapolate(before, records.begin, records.end, momentum);
	};
	std::swap(view.body, view.oldBody);
	extrapolate(island_.overflowRecords);
	if (packed_.stretches_) {
		const Vec2 now          = packed_.stretchRate_;
		packed_.stretchRate_    = now + momentum * (now - packed_.oldStretchRate_);
		packed_.oldStretchRate_ = now;
	}
	timeSweep([&] {
		forEachSection([&](const Section& section) {
			extrapolate(section.records);
			forEachChunk(section, [&](const Chunk& chunk, int k) {
				packed_.sum_[k] = kernels.sweepMomentum(view, chunk, momentum, yielding);
			});
		});
	});
	double change2 = sum(packed_.sum_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		const LocalVector from = c.p + momentum * (c.p - c.old);
		const LocalVector next = yielding.yieldFactor(c.w.nn) * solve(view, c, from);
		applyImpulse(view, c, next - from);
		c.old = c.p;
		c.p   = next;
		change2 += square(next - from);
		if (!(c.rollingFriction > 0)) return;
		const double last = c.r, start = last + momentum * (last - c.oldR);
		const double rolled = roll(view, c, start);
		c.oldR              = last;
		change2 += rolled * rolled;
	});
	updateStretchRate();
	return change2;
}

Measures PackedIsland::measure()
{
	if (mixedPrecision_)
		return measure<float>(singleView_, *packed_.singleKernels_, packed_.singleBias_.data());
	if (!state_.measures) state_.measures = measure<double>(view_, *packed_.kernels_, nullptr);
	return *state_.measures;
}

template <class Real>
Measures PackedIsland::measure(
        const View<Real>& view, const SweepKernels<Real>& kernels, const ColumnOf<Real>* bias)
{
	forEachChunk([&](const Chunk& chunk, int k) {
		packed_.partial_[k] = kernels.measure(view, chunk, bias, state_.norm.leastResponse);
	});
	Measures total = sum(packed_.partial_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		total += measuresOf(c.p, relativeVelocity(view, c), c.bias, c.friction, c.ownNn,
		        state_.norm.leastResponse);
		if (c.rollingFriction > 0)
			total += rollingMeasures(
			        c.r, rollingVelocity(view, c), c.rollingFriction * c.p.n, rollingResponse(c));
	});
	return total;
}

template LocalVector PackedIsland::relativeVelocity(
        const View<double>&, const OverflowPoint&) const;

} // namespace rcr
