// The contact problem of a step as the sweeps need it: by islands, coloured and packed.
//
// The order of work, and with it every bit of the result, depends on the present problem alone: neither on problems seen
// before, nor on the width of the lanes, nor on the number of threads; and that of an island not on the others. The
// overflow (layout.hpp) is solved point by point, after all colours.
#pragma once

#include <optional>
#include <vector>

#include "problem/contact_problem.hpp"
#include "problem/coulomb.hpp"
#include "sweep/layout/layout.hpp"
#include "sweep/lane/packed_blocks.hpp"
#include "parallel/thread_team.hpp"

namespace rcr {

class PackedIsland;

class PackedProblem {
public:
	ThreadTeam team; // shares out what follows

	/// Loads the problem, v = v_free + M⁻¹Jᵀp for its impulses; the lanes are those of packedKernels.
	void load(const ContactProblem&, int lanes, const Reductions&);
	/// Loads other biases of the same problem, and its present impulses.
	void rebias(const ContactProblem&, const std::vector<double>& bias);
	/// Writes impulses, and velocities computed anew from them; `measure` then measures what was written.
	void store(ContactProblem&);
	/// Computes the velocities anew from the impulses and writes them alone.
	void storeVelocity(const ContactProblem&, std::vector<Twist>& velocity);

	int islands() const { return int(layout_.islands().size()); }
	/// work(island) for each: small ones at once, each by one thread; large ones one after the other, each by all.
	template <class Work> void forEachIsland(Work work);

	/// Of the cell, that impulses make.
	Vec2 stretch() const { return stretch_; }
	/// The model of the last problem.
	ModelSummary summary() const;
	/// Number of layouts made: problems with other pairs, needs or kinds of bodies than the one before.
	int layouts() const { return layouts_; }
	/// Time spent on layouts so far, to find that one still stands too.
	double layoutSeconds() const { return layoutSeconds_; }

private:
	friend class PackedIsland;

	template <class Real> struct alignas(4 * sizeof(Real)) TwoHalves { // of one record, or of two bodies that nothing turns
		HalfRecordOf<Real> half[2];
	};

	/// A point of the overflow, in the scaled velocities of packed_blocks.hpp.
	struct OverflowPoint {
		std::int32_t record1, record2, point;
		bool         turns; // or the records are halves
		Vec2         normal;
		double       turn1n, turn1t, turn2n, turn2t;
		Impulse      drift; // added to u: of a periodic image, and of spins that stay as they are, where the records have none
		InverseMass  mass1, mass2;
		Vec2         shift; // of a cell that may stretch
		double       bias, friction;
		Delassus     w;
		Impulse      p, old;
		Impulse      reference; // u of the reference, where records hold what differs from it
		Impulse      remembered; // p
	};

	void       loadBody(const ContactProblem&, int body, int record, bool central);
	void       loadBodies(const ContactProblem&);
	void       followImpulses();
	void       fill(const ContactProblem&, const LaidPair&);
	void       fillPoint(const ContactProblem&, const LaidPair&, int point, Column*);
	void       addToOverflow(const ContactProblem&, const LaidPair&, bool central);
	/// visit(number of the point, its block, its lane) for the points of a pair that has a slot.
	template <class Visit> void forEachPoint(const LaidPair&, Visit visit);
	PackedView          view() { return { body_.data()->half, oldBody_.data()->half, layout_.pairBlocks().data(), point_.data() }; }
	PackedViewOf<float> singleView() { return { singleBody_.data()->half, singleOldBody_.data()->half, layout_.pairBlocks().data(), singlePoint_.data() }; }

	const PackedKernels*          kernels_       = nullptr;
	const PackedKernelsOf<float>* singleKernels_ = nullptr;
	Layout                  layout_;
	std::vector<double>     inverseGyration_; // a body: 1/k
	std::vector<TwoHalves<double>> body_, oldBody_; // the records of the layout, and one sweep before
	std::vector<TwoHalves<double>> freeBody_;       // without impulses
	std::vector<Column>            point_;
	std::vector<Column>            rememberedPoint_; // of which the impulses count
	std::vector<TwoHalves<float>>  singleBody_, singleOldBody_; // the same about a reference
	std::vector<ColumnOf<float>>   singlePoint_;
	std::vector<ColumnOf<float>>   singleBias_; // of the law; that of `singlePoint_` holds the velocity of the reference, too
	std::vector<OverflowPoint>  overflow_;
	std::vector<Range>      overflowOf_;        // an island
	std::vector<double>     freeVelocity2_; // an island
	std::vector<char>       anew_;          // an island: its velocities in body_ have been made anew from its impulses
	std::vector<char>       narrowed_;      // an island: its blocks of floats hold what this problem has, but for impulses and biases
	std::vector<std::optional<Measures>> measures_; // an island: of its doubles, where these are as they were measured
	std::vector<Measures>   partial_;       // a chunk
	std::vector<double>     sum_;           // a chunk
	Vec2                    inverseStretchMass_, stretch_, oldStretch_, referenceStretch_; // of the cell, whose points all belong to one island
	ParallelChoice                   sweepTrial_;    // of large islands
	double                  layoutSeconds_ = 0;
	int                     layouts_       = 0;
};

/// An island, swept to its own convergence.
class PackedIsland {
public:
	PackedIsland(PackedProblem& packed, int number)
	        : packed_(packed)
	        , number_(number)
	        , island_(packed.layout_.islands()[number])
	        , view_(packed.view())
	        , singleView_(packed.singleView())
	{
	}

	int number() const { return number_; }
	int points() const { return island_.points; }

	/// Lever arms and coefficients.
	void prepare();
	/// v ← v_free + M⁻¹Jᵀp, unless that is what v is.
	void followImpulses();
	/// Solves every point once.
	void sweep();
	/// An over-relaxed sweep changes each impulse by `relaxation` times as much.
	void sweepRelaxed(double relaxation);
	/// A sweep from y = p + β (p − p_old), the velocities extrapolated by the same β. Returns ‖p − y‖².
	double sweepMomentum(double momentum);
	/// The same with contacts that yield by u = −ε W p, W the point's own Delassus block: its solution is 1/(1 + ε) of the rigid one.
	double sweepYielding(double momentum, double compliance);
	/// From now on `sweepMomentum` and `measure` work on floats about a reference in doubles, which is made anew every so many sweeps. Not
	/// where the island is small, or where its numbers or their squares would leave the range of floats.
	void beginSingle();
	/// Back to doubles, with the impulses reached and the velocities that follow from them.
	void endSingle();
	bool single() const { return single_; }

	/// Keeps the impulses for `changeSinceRemembered`: the sum of the squares of what they have changed since, in doubles.
	void   remember();
	bool   remembers() const { return remembers_; }
	double changeSinceRemembered();

	/// Sums for the stop criteria at the present impulses and velocities.
	Measures measure();
	/// Σ |u|² over the points for the free velocities.
	double freeVelocity2() const { return packed_.freeVelocity2_[number_]; }

private:
	using OverflowPoint = PackedProblem::OverflowPoint;

	template <class Real> using View = PackedViewOf<Real>;

	template <class Real, class Kernel> double sweepMomentum(View<Real>&, void (*extrapolate)(const View<Real>&, int, int, double), double momentum, double kept, Kernel);
	template <class Real> Measures measure(const View<Real>&, const PackedKernelsOf<Real>&, const ColumnOf<Real>* bias);
	template <class Real> Impulse  relativeVelocity(const View<Real>&, const OverflowPoint&) const;
	template <class Real> void     applyImpulse(const View<Real>&, const OverflowPoint&, const Impulse&);
	template <class Real> Impulse  solve(const View<Real>&, const OverflowPoint&, const Impulse& from) const;

	void applyImpulses();
	/// The velocities are others than impulses alone would make them to the last bit, and than they were measured.
	void sweptOn()
	{
		packed_.anew_[number_] = false;
		packed_.measures_[number_].reset();
	}
	bool stretches() const { return island_.cell && (packed_.inverseStretchMass_.x > 0 || packed_.inverseStretchMass_.y > 0); }
	void widen();
	void refer();
	void restMomentum();
	/// work(range) for the records of all bodies of the island.
	template <class Work> void forEachRecords(Work work)
	{
		work(island_.loose);
		forEachSection([&](const Section& section) { work(section.records); });
	}

	/// work(section) for all slabs, then for all joints, by all threads where the island is theirs.
	template <class Work> void forEachSection(Work work)
	{
		for (const Range sections : { island_.slabs, island_.joints }) {
			const auto workOn = [&](int k) { work(packed_.layout_.sections()[k]); };
			if (island_.shared) packed_.team.parallelFor(sections.begin, sections.end, workOn);
			else
				for (int k = sections.begin; k < sections.end; ++k)
					workOn(k);
		}
	}
	/// kernel(chunk, its number) for all chunks of a section.
	template <class Kernel> void forEachChunk(const Section& section, Kernel kernel)
	{
		for (int k = section.chunks.begin; k < section.chunks.end; ++k)
			kernel(packed_.layout_.chunks()[k], k);
	}
	template <class Kernel> void forEachChunk(Kernel kernel)
	{
		forEachSection([&](const Section& section) { forEachChunk(section, kernel); });
	}
	/// The sum over all chunks of what a kernel left for each, in their order.
	template <class Value> Value sum(const std::vector<Value>& ofChunk) const
	{
		Value total {};
		for (const Range sections : { island_.slabs, island_.joints })
			for (int s = sections.begin; s < sections.end; ++s)
				for (int k = packed_.layout_.sections()[s].chunks.begin; k < packed_.layout_.sections()[s].chunks.end; ++k)
					total += ofChunk[k];
		return total;
	}
	template <class Visit> void forEachOverflowPoint(Visit visit)
	{
		const Range overflow = packed_.overflowOf_[number_];
		for (int k = overflow.begin; k < overflow.end; ++k)
			visit(packed_.overflow_[k]);
	}

	PackedProblem& packed_;
	const int      number_;
	const Island&  island_;
	PackedView     view_;
	View<float>    singleView_;
	bool           single_      = false, remembers_ = false;
	int            sinceRefer_ = 0; // sweeps
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
