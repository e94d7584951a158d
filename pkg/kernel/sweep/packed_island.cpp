// The steps of the sweep solvers on one island: what has slots by the kernels, the overflow here.
#include <cmath>
#include <utility>

#include "sweep/packed_problem.hpp"

namespace rcr {

// ---- points of the overflow

Impulse PackedIsland::relativeVelocity(const OverflowPoint& c) const
{
	const HalfRecord &v1 = view_.halfBody(c.record1), &v2 = view_.halfBody(c.record2);
	const Vec2        u = Vec2 { v2.x - v1.x, v2.y - v1.y } + componentwise(packed_.stretch_, c.shift);
	const double      spin1 = c.turns ? view_.wholeBody(c.record1).spin : 0, spin2 = c.turns ? view_.wholeBody(c.record2).spin : 0;
	return { dot(u, c.normal) + spin2 * c.turn2n - spin1 * c.turn1n + c.drift.n,
		 dot(u, perp(c.normal)) + spin2 * c.turn2t - spin1 * c.turn1t + c.drift.t };
}

void PackedIsland::applyImpulse(const OverflowPoint& c, const Impulse& p)
{
	const Vec2 f    = p.n * c.normal + p.t * perp(c.normal);
	const auto push = [&](int record, const InverseMass& mass, double sign, double torque) {
		if (mass.x == 0 && mass.y == 0 && mass.rotation == 0) return; // other islands may share it
		HalfRecord& v = view_.halfBody(record);
		v.x += sign * (mass.x * f.x);
		v.y += sign * (mass.y * f.y);
		if (c.turns) view_.wholeBody(record).spin += sign * (mass.rotation * torque);
	};
	push(c.record1, c.mass1, -1, p.n * c.turn1n + p.t * c.turn1t);
	push(c.record2, c.mass2, +1, p.n * c.turn2n + p.t * c.turn2t);
	if (stretches()) packed_.stretch_ = packed_.stretch_ + componentwise(packed_.inverseStretchMass_, componentwise(c.shift, f));
}

/// The impulse that solves the point while all others stay; `p` is what the velocities hold of it.
Impulse PackedIsland::solve(const OverflowPoint& c, const Impulse& p) const
{
	const Impulse u = relativeVelocity(c);
	return solveCoulomb(c.w, u.n + c.bias - c.w.nn * p.n - c.w.nt * p.t, u.t - c.w.nt * p.n - c.w.tt * p.t, c.friction);
}

// ---- the steps of the solvers

void PackedIsland::prepare()
{
	forEachChunk([&](const Chunk& chunk, int k) { packed_.sum_[k] = packed_.kernels_->prepare(view_, chunk); });
	double velocity2 = sum(packed_.sum_);
	forEachOverflowPoint([&](OverflowPoint& c) { velocity2 += square(relativeVelocity(c)); });
	packed_.freeVelocity2_[number_] = velocity2;
}

void PackedIsland::applyImpulses()
{
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->apply(view_, chunk); });
	forEachOverflowPoint([&](OverflowPoint& c) { applyImpulse(c, c.p); });
}

void PackedIsland::sweep()
{
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->sweep(view_, chunk); });
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse next = solve(c, c.p);
		applyImpulse(c, next - c.p);
		c.p = next;
	});
}

void PackedIsland::sweepRelaxed(double relaxation)
{
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->sweepRelaxed(view_, chunk, relaxation); });
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse next = projectCone(c.p + relaxation * (solve(c, c.p) - c.p), c.friction);
		applyImpulse(c, next - c.p);
		c.p = next;
	});
}

double PackedIsland::sweepMomentum(double momentum)
{
	return sweepMomentum(momentum, 1, [&](const Chunk& chunk) { return packed_.kernels_->sweepMomentum(view_, chunk, momentum); });
}

double PackedIsland::sweepYielding(double momentum, double compliance)
{
	const double kept = 1 / (1 + compliance);
	return sweepMomentum(momentum, kept, [&](const Chunk& chunk) { return packed_.kernels_->sweepYielding(view_, chunk, momentum, kept); });
}

/// Each slab extrapolates the velocities of its bodies, v_old ← v + β (v − v_old) in the place where v_old was, and is swept there.
template <class Kernel> double PackedIsland::sweepMomentum(double momentum, double kept, Kernel sweepChunk)
{
	const PackedView before = view_;
	std::swap(view_.body, view_.oldBody);
	const auto extrapolate = [&](const Range& records) { packed_.kernels_->extrapolate(before, records.begin, records.end, momentum); };
	extrapolate(island_.loose);
	if (stretches()) {
		const Vec2 now      = packed_.stretch_;
		packed_.stretch_    = now + momentum * (now - packed_.oldStretch_);
		packed_.oldStretch_ = now;
	}
	forEachSection([&](const Section& section) {
		extrapolate(section.records);
		forEachChunk(section, [&](const Chunk& chunk, int k) { packed_.sum_[k] = sweepChunk(chunk); });
	});
	double change2 = sum(packed_.sum_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse from = c.p + momentum * (c.p - c.old), next = kept * solve(c, from);
		applyImpulse(c, next - from);
		c.old = c.p;
		c.p   = next;
		change2 += square(next - from);
	});
	return change2;
}

Measures PackedIsland::measure()
{
	forEachChunk([&](const Chunk& chunk, int k) { packed_.partial_[k] = packed_.kernels_->measure(view_, chunk); });
	Measures total = sum(packed_.partial_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse u = relativeVelocity(c);
		const double  un = u.n + c.bias;
		const double  stopping = (std::abs(u.n) + std::abs(c.bias)) / c.w.nn;
		const Impulse q = projectCone({ c.p.n - (un + c.friction * std::abs(u.t)) / c.w.nn, c.p.t - u.t / c.w.nn }, c.friction);
		const double  miss = square(c.p - q);
		total += { miss, square(c.p), c.p.n, c.w.nn * c.w.nn * miss, square(u), stopping * stopping, -(c.p.n * un + c.p.t * u.t) };
	});
	return total;
}

} // namespace rcr
