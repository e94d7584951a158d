// The steps of the sweep solvers on one island: what has slots by the kernels, the overflow here.
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "sweep/packed_problem.hpp"

namespace rcr {

namespace {
	constexpr int sweepsPerReference = 400; // a reference takes as long as four sweeps; 1000 leave the same residual
}

// ---- points of the overflow

template <class Real> Impulse PackedIsland::relativeVelocity(const View<Real>& view, const OverflowPoint& c) const
{
	const HalfRecordOf<Real> &v1 = view.halfBody(c.record1), &v2 = view.halfBody(c.record2);
	constexpr bool            whole   = std::is_same_v<Real, double>; // or what differs from the reference
	const Vec2                stretch = whole ? packed_.stretch_ : packed_.stretch_ - packed_.referenceStretch_;
	const Vec2                u       = Vec2 { double(v2.x) - v1.x, double(v2.y) - v1.y } + componentwise(stretch, c.shift);
	const double              spin1 = c.turns ? view.wholeBody(c.record1).spin : 0, spin2 = c.turns ? view.wholeBody(c.record2).spin : 0;
	const Impulse&            rest = whole ? c.drift : c.reference;
	return { dot(u, c.normal) + spin2 * c.turn2n - spin1 * c.turn1n + rest.n, dot(u, perp(c.normal)) + spin2 * c.turn2t - spin1 * c.turn1t + rest.t };
}

template <class Real> void PackedIsland::applyImpulse(const View<Real>& view, const OverflowPoint& c, const Impulse& p)
{
	const Vec2 f    = p.n * c.normal + p.t * perp(c.normal);
	const auto push = [&](int record, const InverseMass& mass, double sign, double torque) {
		if (mass.x == 0 && mass.y == 0 && mass.rotation == 0) return; // other islands may share it
		HalfRecordOf<Real>& v = view.halfBody(record);
		v.x = Real(v.x + sign * (mass.x * f.x));
		v.y = Real(v.y + sign * (mass.y * f.y));
		if (!c.turns) return;
		Real& spin = view.wholeBody(record).spin;
		spin       = Real(spin + sign * (mass.rotation * torque));
	};
	push(c.record1, c.mass1, -1, p.n * c.turn1n + p.t * c.turn1t);
	push(c.record2, c.mass2, +1, p.n * c.turn2n + p.t * c.turn2t);
	if (stretches()) packed_.stretch_ = packed_.stretch_ + componentwise(packed_.inverseStretchMass_, componentwise(c.shift, f));
}

/// The impulse that solves the point while all others stay; `p` is what the velocities hold of it.
template <class Real> Impulse PackedIsland::solve(const View<Real>& view, const OverflowPoint& c, const Impulse& p) const
{
	const Impulse u = relativeVelocity(view, c);
	return solveCoulomb(c.w, u.n + c.bias - c.w.nn * p.n - c.w.nt * p.t, u.t - c.w.nt * p.n - c.w.tt * p.t, c.friction);
}

// ---- the steps of the solvers

void PackedIsland::prepare()
{
	forEachChunk([&](const Chunk& chunk, int k) { packed_.sum_[k] = packed_.kernels_->prepare(view_, chunk); });
	double velocity2 = sum(packed_.sum_);
	forEachOverflowPoint([&](OverflowPoint& c) { velocity2 += square(relativeVelocity(view_, c)); });
	packed_.freeVelocity2_[number_] = velocity2;
}

void PackedIsland::followImpulses()
{
	if (packed_.anew_[number_]) return;
	const HalfRecord* const free = packed_.freeBody_.data()->half;
	if (stretches()) packed_.stretch_ = {};
	forEachRecords([&](const Range& records) { std::copy(free + records.begin, free + records.end, view_.body + records.begin); });
	applyImpulses();
	packed_.measures_[number_].reset();
	packed_.anew_[number_] = true;
}

/// v ← v + M⁻¹Jᵀp
void PackedIsland::applyImpulses()
{
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->apply(view_, chunk); });
	forEachOverflowPoint([&](OverflowPoint& c) { applyImpulse(view_, c, c.p); });
}

void PackedIsland::sweep()
{
	sweptOn();
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->sweep(view_, chunk); });
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse next = solve(view_, c, c.p);
		applyImpulse(view_, c, next - c.p);
		c.p = next;
	});
}

void PackedIsland::sweepRelaxed(double relaxation)
{
	sweptOn();
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->sweepRelaxed(view_, chunk, relaxation); });
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse next = projectCone(c.p + relaxation * (solve(view_, c, c.p) - c.p), c.friction);
		applyImpulse(view_, c, next - c.p);
		c.p = next;
	});
}

double PackedIsland::sweepMomentum(double momentum)
{
	if (!single_) {
		if (sinceRefer_ > 0) restMomentum();
		sweptOn();
		const PackedKernels& kernels = *packed_.kernels_;
		return sweepMomentum(view_, kernels.extrapolate, momentum, 1, [&](const Chunk& chunk) { return kernels.sweepMomentum(view_, chunk, momentum); });
	}
	if (sinceRefer_ == sweepsPerReference) {
		widen();
		refer();
	}
	++sinceRefer_;
	const PackedKernelsOf<float>& kernels = *packed_.singleKernels_;
	return sweepMomentum(singleView_, kernels.extrapolate, momentum, 1, [&](const Chunk& chunk) { return kernels.sweepMomentum(singleView_, chunk, momentum); });
}

double PackedIsland::sweepYielding(double momentum, double compliance)
{
	sweptOn();
	const double         kept    = 1 / (1 + compliance);
	const PackedKernels& kernels = *packed_.kernels_;
	return sweepMomentum(view_, kernels.extrapolate, momentum, kept, [&](const Chunk& chunk) { return kernels.sweepYielding(view_, chunk, momentum, kept); });
}

/// Each slab extrapolates the velocities of its bodies, v_old ← v + β (v − v_old) in the place where v_old was, and is swept there.
template <class Real, class Kernel>
double PackedIsland::sweepMomentum(View<Real>& view, void (*extrapolate)(const View<Real>&, int, int, double), double momentum, double kept, Kernel sweepChunk)
{
	const View<Real> before = view;
	std::swap(view.body, view.oldBody);
	extrapolate(before, island_.loose.begin, island_.loose.end, momentum);
	if (stretches()) {
		const Vec2 now      = packed_.stretch_;
		packed_.stretch_    = now + momentum * (now - packed_.oldStretch_);
		packed_.oldStretch_ = now;
	}
	const auto sweepSections = [&] {
		forEachSection([&](const Section& section) {
			extrapolate(before, section.records.begin, section.records.end, momentum);
			forEachChunk(section, [&](const Chunk& chunk, int k) { packed_.sum_[k] = sweepChunk(chunk); });
		});
	};
	if (island_.shared) packed_.team.runAdaptive(packed_.sweepTrial_, island_.points, sweepSections);
	else
		sweepSections();
	double change2 = sum(packed_.sum_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse from = c.p + momentum * (c.p - c.old), next = kept * solve(view, c, from);
		applyImpulse(view, c, next - from);
		c.old = c.p;
		c.p   = next;
		change2 += square(next - from);
	});
	return change2;
}

Measures PackedIsland::measure()
{
	if (single_) return measure<float>(singleView_, *packed_.singleKernels_, packed_.singleBias_.data());
	std::optional<Measures>& known = packed_.measures_[number_];
	if (!known) known = measure<double>(view_, *packed_.kernels_, nullptr);
	return *known;
}

template <class Real> Measures PackedIsland::measure(const View<Real>& view, const PackedKernelsOf<Real>& kernels, const ColumnOf<Real>* bias)
{
	forEachChunk([&](const Chunk& chunk, int k) { packed_.partial_[k] = kernels.measure(view, chunk, bias); });
	Measures total = sum(packed_.partial_);
	forEachOverflowPoint([&](OverflowPoint& c) {
		const Impulse u = relativeVelocity(view, c);
		const double  un = u.n + c.bias;
		const double  stopping = (std::abs(u.n) + std::abs(c.bias)) / c.w.nn;
		const Impulse q = projectCone({ c.p.n - (un + c.friction * std::abs(u.t)) / c.w.nn, c.p.t - u.t / c.w.nn }, c.friction);
		const double  miss = square(c.p - q);
		total += { miss, square(c.p), c.p.n, c.w.nn * c.w.nn * miss, square(u), stopping * stopping, -(c.p.n * un + c.p.t * u.t) };
	});
	return total;
}

// ---- floats about a reference

namespace {

	/// Floats from doubles, `unlimited` too.
	void narrow(const Column& from, ColumnOf<float>& to)
	{
		for (int lane = 0; lane < blockWidth; ++lane)
			to.of[lane] = float(std::min(from.of[lane], double(unlimited<float>)));
	}

	/// Whether a number and its square stay far from the ends of the range of floats; 0 is that of a vacant slot, or of no impulse.
	bool fitsFloat(double value) { return value == 0 || (std::abs(value) > 1e-12 && std::abs(value) < 1e12); }

	template <class Real> PointBlockOf<Real>& pointAt(ColumnOf<Real>* column) { return *reinterpret_cast<PointBlockOf<Real>*>(column); }
	template <class Real> RoundBlockOf<Real>& roughAt(ColumnOf<Real>* column) { return *reinterpret_cast<RoundBlockOf<Real>*>(column); }

	template <class From, class To> void copyImpulses(ColumnOf<From>* from, ColumnOf<To>* to, Model model)
	{
		std::copy_n(pointAt(from).pn, blockWidth, pointAt(to).pn);
		if (rough(model)) std::copy_n(roughAt(from).pt, blockWidth, roughAt(to).pt);
	}

	double squared(double value) { return value * value; }

	int columns(const Chunk& chunk) { return chunk.blocks * chunk.pointsPerPair * columnsOf(chunk.model); }

} // namespace

void PackedIsland::beginSingle()
{
	const double speed = std::sqrt(freeVelocity2() / island_.points);
	if (!island_.shared || speed == 0 || !fitsFloat(speed)) return;
	forEachRecords([&](const Range& records) {
		for (int k = records.begin; k < records.end; ++k)
			singleView_.body[k] = singleView_.oldBody[k] = {};
		for (int k = records.begin + 1; k < records.end && !island_.central; k += 2) // (spin, inverse mass)
			singleView_.body[k].y = singleView_.oldBody[k].y = float(view_.body[k].y);
	});
	forEachChunk([&](const Chunk& chunk, int number) {
		bool fits = true;
		for (int block = 0; block < chunk.blocks * chunk.pointsPerPair; ++block) {
			const int first = chunk.firstColumn + block * columnsOf(chunk.model);
			if (packed_.narrowed_[number_]) copyImpulses(view_.points + first, singleView_.points + first, chunk.model);
			else
				for (int k = first; k < first + columnsOf(chunk.model); ++k)
					narrow(view_.points[k], singleView_.points[k]);
			const PointBlock& point = pointAt(view_.points + first);
			for (int lane = 0; lane < blockWidth; ++lane) {
				fits = fits & fitsFloat(point.inverseNn[lane]) & (point.pn[lane] < 1e12);
				packed_.singleBias_[chunk.firstPoint + block].of[lane] = float(point.bias[lane]);
			}
		}
		packed_.sum_[number] = !fits;
	});
	double misfits = sum(packed_.sum_);
	forEachOverflowPoint([&](const OverflowPoint& c) { misfits += !fitsFloat(c.w.nn); });
	if (misfits > 0) return;
	single_ = packed_.narrowed_[number_] = true;
	refer();
}

/// The doubles follow the floats: impulses, and the velocities made anew from them.
void PackedIsland::widen()
{
	sweptOn();
	forEachChunk([&](const Chunk& chunk, int) {
		for (int k = chunk.firstColumn; k < chunk.firstColumn + columns(chunk); k += columnsOf(chunk.model))
			copyImpulses(singleView_.points + k, view_.points + k, chunk.model);
	});
	followImpulses();
}

void PackedIsland::remember()
{
	Column* const to = packed_.rememberedPoint_.data();
	forEachChunk([&](const Chunk& chunk, int) {
		for (int k = chunk.firstColumn; k < chunk.firstColumn + columns(chunk); k += columnsOf(chunk.model))
			if (single_) copyImpulses(singleView_.points + k, to + k, chunk.model);
			else
				copyImpulses(view_.points + k, to + k, chunk.model);
	});
	forEachOverflowPoint([](OverflowPoint& c) { c.remembered = c.p; });
	remembers_ = true;
}

double PackedIsland::changeSinceRemembered()
{
	forEachChunk([&](const Chunk& chunk, int number) {
		double change2 = 0;
		for (int k = chunk.firstColumn; k < chunk.firstColumn + columns(chunk); k += columnsOf(chunk.model)) {
			Column *const now = view_.points + k, *const then = packed_.rememberedPoint_.data() + k;
			for (int lane = 0; lane < blockWidth; ++lane) {
				change2 += squared(pointAt(now).pn[lane] - pointAt(then).pn[lane]);
				if (rough(chunk.model)) change2 += squared(roughAt(now).pt[lane] - roughAt(then).pt[lane]);
			}
		}
		packed_.sum_[number] = change2;
	});
	double change2 = sum(packed_.sum_);
	forEachOverflowPoint([&](const OverflowPoint& c) { change2 += square(c.p - c.remembered); });
	return change2;
}

/// The impulses and velocities in doubles become the reference.
void PackedIsland::refer()
{
	forEachChunk([&](const Chunk& chunk, int) { packed_.kernels_->refer(view_, chunk, singleView_.points); });
	forEachOverflowPoint([&](OverflowPoint& c) { c.reference = relativeVelocity(view_, c); });
	if (stretches()) packed_.referenceStretch_ = packed_.stretch_;
	forEachRecords([&](const Range& records) {
		for (int k = records.begin; k < records.end; ++k) {
			if (!island_.central && k % 2 == 1) { // (spin, inverse mass)
				singleView_.oldBody[k] = { singleView_.oldBody[k].x - singleView_.body[k].x, singleView_.body[k].y };
				singleView_.body[k].x  = 0;
				continue;
			}
			singleView_.oldBody[k] = { singleView_.oldBody[k].x - singleView_.body[k].x, singleView_.oldBody[k].y - singleView_.body[k].y };
			singleView_.body[k]    = {};
		}
	});
	sinceRefer_ = 0;
}

void PackedIsland::endSingle()
{
	if (!single_) return;
	single_ = false;
	widen();
}

/// After floats: momentum starts from rest.
void PackedIsland::restMomentum()
{
	sinceRefer_ = 0;
	forEachRecords([&](const Range& records) { std::copy(view_.body + records.begin, view_.body + records.end, view_.oldBody + records.begin); });
	forEachChunk([&](const Chunk& chunk, int) {
		for (int k = chunk.firstColumn; k < chunk.firstColumn + columns(chunk); k += columnsOf(chunk.model)) {
			std::copy_n(pointAt(view_.points + k).pn, blockWidth, pointAt(view_.points + k).oldPn);
			if (rough(chunk.model)) std::copy_n(roughAt(view_.points + k).pt, blockWidth, roughAt(view_.points + k).oldPt);
		}
	});
	forEachOverflowPoint([](OverflowPoint& c) { c.old = c.p; });
	if (stretches()) packed_.oldStretch_ = packed_.stretch_;
}

} // namespace rcr
