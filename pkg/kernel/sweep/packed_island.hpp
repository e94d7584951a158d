// The operations of the sweep solvers on one island.
//
// Mixed precision: large islands may be swept in floats about a reference in doubles. The reference
// is updated every few hundred sweeps; then rounding of floats does not accumulate.
#pragma once

#include "sweep/packed_problem.hpp"

namespace rcr {

class PackedIsland {
public:
	PackedIsland(PackedProblem& packed, int number)
	        : packed_(packed)
	        , number_(number)
	        , island_(packed.layout_.islands()[number])
	        , state_(packed.states_[number])
	        , view_(packed.view())
	        , singleView_(packed.singleView())
	{
	}

	int number() const { return number_; }
	int points() const { return island_.shape.points; }
	const IslandShape& shape() const { return island_.shape; }

	/// Computes lever arms, Delassus coefficients and freeVelocity2. Call it while v = v_free.
	void prepare();
	/// Weights of the norms of error estimates.
	const NormWeights& norm() const { return state_.norm; }
	/// v ← v_free + M⁻¹Jᵀp, unless v has been recomputed from these impulses.
	void recomputeVelocities();
	/// Sweeps over the packed pairs by kernels, then over the pairs without a slot (overflow).
	void sweep(double relaxation);
	/// Returns ‖p − y‖² [(N s)²] with the extrapolated impulses y.
	double sweepMomentum(double momentum, const Yielding& = {});

	/// Makes sweeps and `measure` use floats. Does nothing if the island is small or has rolling
	/// resistance, if the cell stretches, or if values or their squares come near the limits of
	/// floats.
	void beginMixedPrecision();
	/// Returns to doubles: copies the impulses and recomputes the velocities from them.
	void endMixedPrecision();
	bool mixedPrecision() const { return mixedPrecision_; }

	/// Saves the impulses in a slot, 0 … savedSlots − 1.
	void saveImpulses(int slot);
	/// Change Δp of the impulses since they were saved.
	struct Change {
		double square = 0; // Σ |Δp|² [(N s)²]
		double energy = 0; // Σ w_nn |Δp|², over the points of impulseEnergy (Measures) [J/m]

		Change& operator+=(const Change& other)
		{
			square += other.square, energy += other.energy;
			return *this;
		}
	};
	Change changeSinceSaved(int slot);
	/// Σ m |v − v_free|² over the bodies with 1/m ≥ leastResponse (Measures) [J/m].
	double changeEnergy() const;

	/// Sums for the stop criteria at the present impulses and velocities.
	Measures measure();
	/// Returns true if contacts have yielded in an earlier pass of the step.
	bool hasYielded() const { return state_.hasYielded; }
	/// Mass of the bodies, except hinged ones [kg].
	double mass() const { return state_.mass; }
	/// Σ |u|² over the points at zero impulses [(m/s)²].
	double freeVelocity2() const { return state_.freeVelocity2; }

private:
	using OverflowPoint              = PackedProblem::OverflowPoint;
	template <class Real> using View = PackedViewOf<Real>;

	template <class Real>
	double sweepMomentum(
	        View<Real>&, const SweepKernels<Real>&, double momentum, const Yielding&);
	template <class Real>
	Measures measure(const View<Real>&, const SweepKernels<Real>&, const ColumnOf<Real>* bias);
	template <class Real>
	LocalVector relativeVelocity(const View<Real>&, const OverflowPoint&) const;
	template <class Real>
	void applyImpulse(const View<Real>&, const OverflowPoint&, const LocalVector&);
	template <class Real>
	LocalVector solve(const View<Real>&, const OverflowPoint&, const LocalVector& from) const;

	// rolling resistance of a point of the overflow
	template <class Real> double rollingVelocity(const View<Real>&, const OverflowPoint&) const;
	template <class Real> void   applyRolling(const View<Real>&, const OverflowPoint&, double p);
	template <class Real> double roll(const View<Real>&, OverflowPoint&, double from);
	static double                rollingResponse(const OverflowPoint& c)
	{
		return c.mass1.rotation * c.turn1 * c.turn1 + c.mass2.rotation * c.turn2 * c.turn2;
	}

	/// Call before the velocities change. Invalidates cached velocities and measures.
	void invalidate()
	{
		state_.velocityRecomputed = false;
		state_.measures.reset();
	}
	void updateStretchRate();
	void setNormWeights();
	/// Calls visit(velocity of a record, what it carries) for the bodies of a stretching cell,
	/// which has one island.
	template <class Visit> void forEachCarried(Visit visit)
	{
		for (int k = 0; k < island_.overflowRecords.end; k += island_.halfRecords ? 1 : 2)
			visit(view_.recordAt(k), packed_.carried_[k]);
	}
	/// Calls work(view, kernels) with those of the present precision.
	template <class Work> auto inPrecision(Work work)
	{
		return mixedPrecision_ ? work(singleView_, *packed_.singleKernels_)
		                       : work(view_, *packed_.kernels_);
	}
	void beginSweep(); // call before each sweep
	void copyToDoubles();
	void updateReference();
	void resetMomentum();

	/// Calls work(range) for the records of all bodies of the island.
	template <class Work> void forEachRecords(Work work)
	{
		work(island_.overflowRecords);
		forEachSection([&](const Section& section) { work(section.records); });
	}

	/// Calls work(section) for all partitions, then for all interfaces; in parallel if the island
	/// is shared and helpers save time.
	template <class Work> void forEachSection(Work work)
	{
		const bool parallel = island_.shared && packed_.sweepChoice_.parallel();
		for (const Range sections : { island_.partitions, island_.interfaces }) {
			const auto workOn = [&](int k) { work(packed_.layout_.sections()[k]); };
			if (parallel) packed_.team.parallelFor(sections.begin, sections.end, workOn);
			else
				for (int k = sections.begin; k < sections.end; ++k)
					workOn(k);
		}
	}
	/// Calls the loops of a sweep, and records their time for the choice of helpers.
	template <class Loops> void timeSweep(Loops loops)
	{
		if (island_.shared)
			packed_.team.runTimed(packed_.sweepChoice_, island_.shape.points, loops);
		else
			loops();
	}
	/// Calls kernel(chunk, its number) for all chunks of a section.
	template <class Kernel> void forEachChunk(const Section& section, Kernel kernel)
	{
		for (int k = section.chunks.begin; k < section.chunks.end; ++k)
			kernel(packed_.layout_.chunks()[k], k);
	}
	template <class Kernel> void forEachChunk(Kernel kernel)
	{
		forEachSection([&](const Section& section) { forEachChunk(section, kernel); });
	}
	/// Calls visit(column) for the first column of each point block of a chunk.
	template <class Visit> static void forEachPointBlock(const Chunk& chunk, Visit visit)
	{
		const int columns = columnsOf(chunk.model);
		const int end     = chunk.firstColumn + chunk.blocks * chunk.pointsPerPair * columns;
		for (int column = chunk.firstColumn; column < end; column += columns)
			visit(column);
	}
	/// Sum of a value per chunk, in the order of the chunks.
	template <class Value> Value sum(const std::vector<Value>& ofChunk) const
	{
		Value total {};
		for (const Range sections : { island_.partitions, island_.interfaces })
			for (int s = sections.begin; s < sections.end; ++s) {
				const Range chunks = packed_.layout_.sections()[s].chunks;
				for (int k = chunks.begin; k < chunks.end; ++k)
					total += ofChunk[k];
			}
		return total;
	}
	template <class Visit> void forEachOverflowPoint(Visit visit)
	{
		for (int k = state_.overflow.begin; k < state_.overflow.end; ++k)
			visit(packed_.overflow_[k]);
	}

	PackedProblem&              packed_;
	const int                   number_;
	const Island&               island_;
	PackedProblem::IslandState& state_;
	PackedView                  view_;
	View<float>                 singleView_;
	bool                        mixedPrecision_ = false;
	int                         sweepsSinceReference_ = 0;
};

template <class Work> void PackedProblem::forEachIsland(Work work)
{
	const auto shared = [&](int number) { return layout_.islands()[number].shared; };
	team.parallelFor(0, islands(), [&](int number) {
		if (!shared(number)) work(PackedIsland(*this, number));
	});
	for (int number = 0; number < islands(); ++number)
		if (shared(number)) work(PackedIsland(*this, number));
}

} // namespace rcr
