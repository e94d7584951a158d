// Mixed precision of an island: sweeps in floats about a reference in doubles.
#include "sweep/packed_island.hpp"

namespace rcr {

namespace {

	constexpr int sweepsPerReference = 400; // a new reference takes as long as four sweeps

	/// Rounds to floats; `unlimited` of doubles becomes that of floats.
	void round(const Column& from, ColumnOf<float>& to)
	{
		for (int lane = 0; lane < blockWidth; ++lane)
			to.of[lane] = float(std::min(from.of[lane], double(unlimited<float>)));
	}

	/// Returns true if the number and its square are far from the limits of floats. Zero means an
	/// empty slot or no impulse.
	bool fitsFloat(double value)
	{
		return value == 0 || (std::abs(value) > 1e-12 && std::abs(value) < 1e12);
	}

	template <class From, class To>
	void copyImpulses(ColumnOf<From>* from, ColumnOf<To>* to, Model model)
	{
		std::copy_n(PointColumnsOf<From>(from).pn(), blockWidth, PointColumnsOf<To>(to).pn());
		if (!hasFriction(model)) return;
		std::copy_n(NoLeverColumnsOf<From>(from).pt(), blockWidth, NoLeverColumnsOf<To>(to).pt());
	}

} // namespace

void PackedIsland::beginMixedPrecision()
{
	const double speed = std::sqrt(freeVelocity2() / island_.shape.points);
	if (!island_.shared || packed_.stretches_ || shape().rolls) return;
	if (speed == 0 || !fitsFloat(speed)) return;
	forEachRecords([&](const Range& records) {
		for (float* const body : { singleView_.body, singleView_.oldBody }) {
			std::fill(body + offsetOf(records.begin), body + offsetOf(records.end), 0.0f);
			for (int k = records.begin; k < records.end && !island_.halfRecords; k += 2)
				body[offsetOf(k) + record::inverseMass] = float(
				        view_.recordAt(k)[record::inverseMass]);
		}
	});
	forEachChunk([&](const Chunk& chunk, int number) {
		bool fits  = true;
		int  point = chunk.firstPointBlock;
		forEachPointBlock(chunk, [&](int first) {
			if (state_.singleFilled)
				copyImpulses(view_.points + first, singleView_.points + first, chunk.model);
			else
				for (int k = first; k < first + columnsOf(chunk.model); ++k)
					round(view_.points[k], singleView_.points[k]);
			const PointColumnsOf<double> c(view_.points + first);
			for (int lane = 0; lane < blockWidth; ++lane) {
				fits = fits & fitsFloat(c.inverseNn()[lane]) & (c.pn()[lane] < 1e12);
				packed_.singleBias_[point].of[lane] = float(c.bias()[lane]);
			}
			++point;
		});
		packed_.sum_[number] = !fits;
	});
	double misfits = sum(packed_.sum_);
	forEachOverflowPoint([&](const OverflowPoint& c) { misfits += !fitsFloat(c.w.nn); });
	if (misfits > 0) return;
	state_.singleFilled = true;
	mixedPrecision_     = true;
	updateReference();
}

/// Copies the impulses of floats and recomputes the velocities.
void PackedIsland::copyToDoubles()
{
	invalidate();
	forEachChunk([&](const Chunk& chunk, int) {
		forEachPointBlock(chunk, [&](int k) {
			copyImpulses(singleView_.points + k, view_.points + k, chunk.model);
		});
	});
	recomputeVelocities();
}

/// The velocities in doubles become the reference. Inverse masses stay.
void PackedIsland::updateReference()
{
	forEachChunk([&](const Chunk& chunk, int) {
		packed_.kernels_->updateReference(view_, chunk, singleView_.points);
	});
	forEachOverflowPoint([&](OverflowPoint& c) { c.reference = relativeVelocity(view_, c); });
	forEachRecords([&](const Range& records) {
		float *const body = singleView_.body, *const old = singleView_.oldBody;
		for (std::uint32_t i = offsetOf(records.begin); i < offsetOf(records.end); ++i) {
			const bool isMass = !island_.halfRecords && i % 4 == record::inverseMass;
			old[i]            = isMass ? body[i] : old[i] - body[i];
			body[i]           = isMass ? body[i] : 0;
		}
	});
	sweepsSinceReference_ = 0;
}

void PackedIsland::beginSweep()
{
	if (!mixedPrecision_) {
		if (sweepsSinceReference_ > 0) resetMomentum();
		invalidate();
		return;
	}
	if (sweepsSinceReference_ == sweepsPerReference) {
		copyToDoubles();
		updateReference();
	}
	++sweepsSinceReference_;
}

void PackedIsland::endMixedPrecision()
{
	if (!mixedPrecision_) return;
	mixedPrecision_ = false;
	copyToDoubles();
}

/// Resets the momentum in doubles after sweeps in floats.
void PackedIsland::resetMomentum()
{
	sweepsSinceReference_ = 0;
	forEachRecords([&](const Range& records) {
		std::copy(view_.recordAt(records.begin), view_.recordAt(records.end),
		        view_.oldBody + offsetOf(records.begin));
	});
	forEachChunk([&](const Chunk& chunk, int) {
		forEachPointBlock(chunk, [&](int k) {
			const NoLeverColumnsOf<double> c(view_.points + k);
			std::copy_n(c.pn(), blockWidth, c.oldPn());
			if (hasFriction(chunk.model)) std::copy_n(c.pt(), blockWidth, c.oldPt());
		});
	});
	forEachOverflowPoint([](OverflowPoint& c) { c.old = c.p; });
}

} // namespace rcr
