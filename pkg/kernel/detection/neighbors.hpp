// List of all pairs of bodies that may touch within some steps (Verlet list).
//
// A pair has a contact if its gap is at most ℓ₁ + ℓ₂, the alert distances of its bodies
// (late_contacts.hpp). The list holds all pairs with a gap up to ℓ₁ + ℓ₂ + 2 margin,
// and some others. It is valid while every body satisfies
//
//   |x − x₀| + a |τ − τ₀| + ℓ − ℓ₀ ≤ margin
//
// The core of a body has the unit axis τ and the half length a. The index 0 marks values at the
// time of the list.
//
// 99.8 % of the bodies move less than the margin in 12 steps. It is 0.05 to 0.6 mean inscribed radii.
// Candidates come from a grid. A cell is at least as wide as the search circles of all but the
// widest grains. Wide grains and obstacles search their surroundings. If few bodies violate the
// condition, only their pairs are searched again.
#pragma once

#include <utility>

#include "parallel/thread_team.hpp"
#include "step/step.hpp"

namespace rcr {

class Neighbors {
public:
	using List = std::vector<std::pair<std::int32_t, std::int32_t>>; // (body 1, body 2)

	/// Makes the list valid for the step. Returns false if it was still valid. Not for clumps and
	/// periodic cells.
	bool update(const Step&, ThreadTeam&);

	const List& list() const { return list_; } // sorted by body 1, then body 2

private:
	struct Reference { // state of a body at the time of the list
		PlanarShape shape;
		Pose        pose;
		double      alertDistance; // ℓ₀
	};

	static double displacement(const Reference&, const StepBody&);
	void  findAll(const Step&, ThreadTeam&);
	void  repair(const Step&, ThreadTeam&);
	bool  findMovedBodies(const Step&, ThreadTeam&);
	void  setReference(std::size_t id, const StepBody& body)
	{
		reference_[id] = { body.shape, body.pose(), body.alertDistance };
	}
	int  clipped(double place, int count) const { return int(std::clamp(place, 0.0, count - 1.0)); }
	int  column(double x) const { return clipped((x - origin_.x) / width_, columns_); }
	int  row(double y) const { return clipped((y - origin_.y) / width_, rows_); }
	void chooseMargin();
	void sortIntoCells();
	bool near(std::int32_t body1, std::int32_t body2) const;
	template <class Visit> void forEachGrain(const BoundingBox&, Visit) const;
	void searchNarrow(ThreadTeam&);
	void searchAround(const std::vector<std::int32_t>& bodies, ThreadTeam&);

	double                 margin_ = 0; // [m]
	std::vector<Reference> reference_;
	List                   list_;
	// the grid
	Vec2                           origin_;
	double                         width_ = 1; // of a cell [m]
	int                            columns_ = 1, rows_ = 1;
	std::vector<std::int32_t>      firstIn_, inCells_; // per cell: its first grain; grains by cell
	std::vector<std::int32_t>      wide_; // grains wider than a cell or moved, and obstacles
	std::vector<char>              isWide_;
	std::size_t                    wideAtFirst_ = 0; // their number when the list was made
	std::vector<std::int32_t>      moved_; // bodies that violate the condition
	std::vector<char>              isSearched_; // per body: searchAround searches its pairs
	std::vector<List>              found_; // per part of the bodies
};

} // namespace rcr
