// Pairs of bodies that are near enough to touch within some steps.
//
// A pair is a contact of a step where its gap is within the reach of both bodies, e₁ + e₂ (step/missed_contacts.hpp). The list holds
// all pairs of a gap up to e₁ + e₂ + 2 s. It serves while no body has gone further than s, its reach having grown included:
//
//   |x − x₀| + a |t − t₀| + e − e₀ ≤ s        a |t − t₀|: way of the ends of its core as it turns
//
// The margin s is what all but the fastest bodies go in some steps, within bounds. Candidates come from a grid of cells as wide as all
// but the widest bodies with their margins; these few, and the obstacles, look around themselves. Where few bodies have gone further
// than s, the list is mended: they, too, look around themselves, and their pairs take the place of those that they had.
#pragma once

#include <utility>
#include <vector>

#include "parallel/thread_team.hpp"
#include "step/step.hpp"

namespace rcr {

/// Told from their centres alone: are the surfaces of two bodies further apart than `reach`? A wall reaches no grain that lies beyond it.
inline bool apart(const PlanarShape& one, Vec2 at1, const PlanarShape& two, Vec2 at2, double reach)
{
	const Vec2   between = at2 - at1;
	const double most    = 1.000001 * (one.radius() + two.radius() + reach); // the margin is for rounding
	if (one.kind == PlanarShape::wall) return std::abs(one.axis == 0 ? between.x : between.y) > most;
	return one.grain() && dot(between, between) > most * most;
}

class Neighbours {
public:
	using List = std::vector<std::pair<std::int32_t, std::int32_t>>; // (body 1, body 2)

	/// Makes the list one that serves the step; false if it stays as it is. Clumps and periodic cells are not served.
	bool update(const Step&, ThreadTeam&);

	/// Sorted by body 1, then body 2.
	const List& list() const { return list_; }

private:
	struct Place { // of a body when the list was made
		PlanarShape shape;
		Pose        pose;
		double      reach; // e₀
	};
	struct Box {
		Vec2 low, high;
	};

	void  find(const Step&, ThreadTeam&);
	void  mend(const Step&, ThreadTeam&);
	bool  findStrays(const Step&, ThreadTeam&);
	Place placeOf(const StepBody&) const;
	double extent(std::size_t id) const; // radius of the circle in which a grain looks
	Box    box(std::size_t id, double more) const;
	int    column(double x) const;
	int    row(double y) const;
	void   chooseMargin(const Step&);
	void   sortIntoCells(const Step&);
	bool   near(std::int32_t body1, std::int32_t body2) const;
	template <class Visit> void forEachGrain(const Box&, Visit) const;
	void   amongNarrow(const Step&, ThreadTeam&);
	void   lookAround(const std::vector<std::int32_t>& strays, ThreadTeam&);

	double             margin_ = 0; // s [m]
	std::vector<Place> at_;
	List               list_;
	// the grid
	Vec2                           origin_;
	double                         width_ = 1; // of a cell [m]
	int                            columns_ = 1, rows_ = 1;
	std::vector<std::int32_t>      firstIn_, inCells_; // a cell: its first grain; grains by cell
	std::vector<std::int32_t>      wide_; // grains wider than a cell or that have left theirs, and obstacles
	std::vector<char>              isWide_;
	std::size_t                    wideAtFirst_ = 0; // of these, when the list was made
	std::vector<std::int32_t>      strays_; // bodies that have gone too far
	std::vector<char>              isStray_;
	std::vector<List>              found_; // by parts of the bodies
};

} // namespace rcr
