// List of all pairs of bodies that may touch within some steps (Verlet list).
//
// A step has a contact where the gap of a pair is at most e₁ + e₂, the reaches of its bodies
// (detection/missed_contacts.hpp). The list holds all pairs with a gap up to e₁ + e₂ + 2 margin. It
// is valid while every body satisfies
//
//   |x − x₀| + a |τ − τ₀| + e − e₀ ≤ margin   τ: unit axis of its core, a: half length of the core
//
// The margin is the path of all but the fastest bodies in 12 steps, within 0.05 to 0.4 mean cap
// radii. Candidates come from a grid. A cell is as wide as the search circles of all but the widest
// grains. Wide grains and obstacles search their surroundings. If few bodies violate the condition,
// the list is repaired: only their pairs are searched again.
#pragma once

#include <utility>
#include <vector>

#include "parallel/thread_team.hpp"
#include "step/step.hpp"

namespace rcr {

class Neighbours {
public:
	using List = std::vector<std::pair<std::int32_t, std::int32_t>>; // (body 1, body 2)

	/// Makes the list valid for the step; returns false if it did not change. Not for clumps and
	/// periodic cells.
	bool update(const Step&, ThreadTeam&);

	/// The pairs, sorted by body 1, then body 2.
	const List& list() const { return list_; }

private:
	struct Place { // state of a body when the list was made
		PlanarShape shape;
		Pose        pose;
		double      reach; // e₀
	};
	struct Box {
		Vec2 low, high;
	};

	void  find(const Step&, ThreadTeam&);
	void  repair(const Step&, ThreadTeam&);
	bool  findMovedBodies(const Step&, ThreadTeam&);
	Place placeOf(const StepBody&) const;
	Box    box(std::size_t id, double more) const;
	int    column(double x) const;
	int    row(double y) const;
	void   chooseMargin(const Step&);
	void   sortIntoCells(const Step&);
	bool   near(std::int32_t body1, std::int32_t body2) const;
	template <class Visit> void forEachGrain(const Box&, Visit) const;
	void   searchNarrow(const Step&, ThreadTeam&);
	void   searchAround(const std::vector<std::int32_t>& bodies, ThreadTeam&);

	double             margin_ = 0; // [m]
	std::vector<Place> at_;
	List               list_;
	// the grid
	Vec2                           origin_;
	double                         width_ = 1; // of a cell [m]
	int                            columns_ = 1, rows_ = 1;
	std::vector<std::int32_t>      firstIn_, inCells_; // per cell: its first grain; grains by cell
	std::vector<std::int32_t>      wide_; // grains wider than a cell or moved, and obstacles
	std::vector<char>              isWide_;
	std::size_t                    wideAtFirst_ = 0; // their number when the list was made
	std::vector<std::int32_t>      moved_; // bodies that violate the condition
	std::vector<char>              isMoved_;
	std::vector<List>              found_; // per part of the bodies
};

} // namespace rcr
