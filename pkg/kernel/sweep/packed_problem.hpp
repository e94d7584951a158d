// The contact problem of a step in the form of the sweeps: in islands, coloured and packed.
//
// The order of operations, and so every bit of the result, depends on the present problem alone. It
// does not depend on earlier problems, on the lane width or on the number of threads. The result of
// an island does not depend on the other islands. Points of the overflow (layout/layout.hpp) are
// solved one by one after all colours.
#pragma once

#include <optional>

#include "parallel/thread_team.hpp"
#include "problem/coulomb.hpp"
#include "sweep/layout/layout.hpp"

namespace rcr {

class PackedIsland;

constexpr int savedSlots = 3; // impulses of earlier sweeps that an island can save

class PackedProblem {
public:
	ThreadTeam team; // for all loops of a step

	/// Loads a problem and computes v = v_free + M⁻¹Jᵀp. `lanes` as in packedKernels.
	void load(const ContactProblem&, int lanes, const Reductions&);
	/// Loads the present impulses of the loaded problem, and other biases [m/s].
	void reload(const ContactProblem&, const std::vector<double>& bias);
	/// Writes the impulses and the velocities recomputed from them.
	void store(ContactProblem&);
	/// Impulses saved in a slot, of islands that have saved them.
	std::vector<LocalVector> savedImpulses(int slot) const;
	/// Writes the velocities recomputed from the impulses.
	void storeVelocity(const ContactProblem&, std::vector<PlanarVector>& velocity);

	int  islands() const { return int(layout_.islands().size()); }
	/// Lists the points of each island as listByKey does.
	void listPoints(std::vector<std::int32_t>& begin, std::vector<std::int32_t>& points) const;
	/// Calls work(island) for each island. One thread sweeps a small island, all threads share a
	/// large one. Include packed_island.hpp to use it.
	template <class Work> void forEachIsland(Work work);

	/// Stretch rate of the cell that the impulses cause [1/s].
	Vec2 stretchRate() const { return stretchRate_; }
	const ModelSummary& summary() const { return summary_; } // of the last problem
	/// Time of all layouts so far, checks included [s].
	double layoutSeconds() const { return layoutSeconds_; }

private:
	friend class PackedIsland;

	/// Numbers of records, sixteen in a column: aligned loads of lanes require multiples of 64 bytes.
	template <class Real> using Records = std::vector<ColumnOf<Real>>;

	/// A point of the overflow, in the scaled velocities of packed_blocks.hpp.
	struct OverflowPoint {
		std::int32_t record1, record2, point;
		bool         wholeRecords; // with spins
		Vec2         normal;
		double       lever1n, lever1t, lever2n, lever2t;
		LocalVector  drift; // added to u: periodic images, and spins that the records do not hold
		InverseMass  mass1, mass2;
		Vec2         stretchArm; // r₂ + s − r₁ without the carried places
		double       bias, friction;
		Delassus     w;     // with the response of a cell whose rate does not lag
		double       ownNn; // w_nn of the bodies alone
		LocalVector  p, old;
		double       rollingFriction, turn1, turn2; // ℓ/k: lever arms of scaled spins
		double       r, oldR;                       // p_r
		LocalVector  reference; // u of the reference of floats
	};

	void findYielded(const ContactProblem&);
	void loadCell(const ContactProblem&);
	/// Part of the place of a body whose stretch its record holds [m].
	Vec2 carriedPlace(const ContactProblem&, int body) const;
	/// The rest of its place [m].
	Vec2 uncarriedPlace(const ContactProblem& problem, int body) const
	{
		return problem.placeOf(body) - cellOrigin_ - carriedPlace(problem, body);
	}
	/// w of a point with the response of a cell whose rate does not lag.
	static Delassus delassusInCell(const ContactProblem&, const ContactPoint&);
	void loadBody(const ContactProblem&, int body, int record, bool half);
	void recomputeVelocities();
	void fill(const ContactProblem&, const PackedPair&);
	void fillPoint(const ContactProblem&, const PackedPair&, int point, Column*);
	void addToOverflow(const ContactProblem&, const PackedPair&, bool halfRecords);
	/// Calls visit(point, first of its columns, lane) for the points of a pair that has a slot.
	template <class Visit> void forEachPoint(const PackedPair&, Visit visit);

	PackedView view()
	{
		return { body_.data()->of, oldBody_.data()->of, layout_.pairBlocks().data(),
			point_.data() };
	}
	PackedViewOf<float> singleView()
	{
		return { singleBody_.data()->of, singleOldBody_.data()->of, layout_.pairBlocks().data(),
			singlePoint_.data() };
	}

	const PackedKernels*          kernels_       = nullptr;
	const SweepKernels<float>*    singleKernels_ = nullptr;
	Layout                        layout_;
	std::vector<double>           inverseGyration_; // 1/k of each body [1/m]

	// records of the layout: now, one sweep before, without impulses
	Records<double>     body_, oldBody_, freeBody_;
	std::vector<Column> point_;
	std::vector<Column>      savedPoint_[savedSlots];    // p_n and p_t of each point block
	std::vector<LocalVector> savedOverflow_[savedSlots]; // p
	std::vector<InverseMass> inverseMass_; // per half record, for the scaled velocities

	// the same in floats about a reference
	Records<float>               singleBody_, singleOldBody_;
	std::vector<ColumnOf<float>> singlePoint_;
	std::vector<ColumnOf<float>> singleBias_; // b_n of the law, a column per point block

	std::vector<OverflowPoint> overflow_;

	struct IslandState {
		Range                   overflow;                   // in overflow_
		NormWeights             norm;                       // of the energies in Measures
		double                  mass               = 0;     // of its bodies, not hinged ones [kg]
		bool                    hasYielded         = false; // in an earlier pass of the step
		double                  freeVelocity2      = 0;     // Σ |u|² without impulses [(m/s)²]
		bool                    velocityRecomputed = false; // body_ is v_free + M⁻¹Jᵀp to the bit
		bool                    singleFilled = false; // floats hold all but impulses and biases
		std::optional<Measures> measures;             // cached, of doubles
	};
	std::vector<IslandState> states_; // of each island

	// of each chunk
	std::vector<Measures> partial_;
	std::vector<double>   sum_;

	/// Place of a body, and times its mass: what its record holds of the stretch of a cell. 0 along
	/// prescribed axes, and unless the rate lags.
	struct Carried {
		Vec2 place, moment;
	};
	// of a stretching cell, whose points all belong to one island
	std::vector<Carried> carried_;          // per half record
	Vec2                 cellOrigin_;       // of all places, near the bodies: little rounding
	Vec2                 freeMoment_;       // Σ moment ∘ v_free
	Vec2                 carriedInertia_;   // Σ moment ∘ place
	Vec2                 inverseStretchMass_, stretchRate_, oldStretchRate_;
	bool                 stretches_ = false;
	bool                 cellLags_  = false; // the rate changes after each sweep, not in it

	ParallelChoice sweepChoice_; // of large islands
	ModelSummary   summary_;
	double         layoutSeconds_ = 0;
};

} // namespace rcr
