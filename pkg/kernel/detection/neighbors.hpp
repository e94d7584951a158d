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
//
// In a periodic cell, ℓ contains the reach to images, and the grid divides the cell along its edges
// h. The list holds the pairs that may meet at the image that will be nearest. Bodies that move
// with the cell keep their places in it: F = h h₀⁻¹ carries x₀, and the condition becomes
//
//   (1 + ε) (|x − F x₀| + a |τ − τ₀|) + ℓ − ℓ₀ + ε (R + ℓ) ≤ margin,   ε = ‖F⁻¹ − 1‖
//
// The list holds no pairs within a clump.
#pragma once

#include <utility>

#include "parallel/thread_team.hpp"
#include "step/step.hpp"

namespace rcr {

class Neighbors {
public:
	using List = std::vector<std::pair<std::int32_t, std::int32_t>>; // (body 1, body 2)

	/// Makes the list valid for the step. Returns false if it was still valid.
	bool update(const Step&, ThreadTeam&);

	const List& list() const { return list_; } // sorted by body 1, then body 2

	/// Call it when bodies have moved without an update.
	void expire() { current_ = false; }

	/// Calls visit(body, other) for each pair of these bodies with any body whose shapes, enlarged
	/// by reach(body) [m], may meet. The list may have expired. Pairs of obstacles and grains have
	/// no order; a pair may come twice.
	template <class Reach, class Visit>
	void forEachAround(const Step&, ThreadTeam&, const std::vector<std::int32_t>& bodies,
	        Reach reach, Visit visit);

private:
	struct Reference { // state of a body at the time of the list
		PlanarShape shape;
		Pose        pose;
		double      alertDistance; // ℓ₀
		std::int32_t owner;
	};
	struct Range { // of rows or columns; it continues at 0 after the last one
		int first, count;
	};

	static double displacement(const Reference&, const StepBody&);
	static double reach(const Step&, const StepBody&);
	double movedDistance(const Reference&, const Step&, const StepBody&) const;
	void   findAll(const Step&, ThreadTeam&);
	void   repair(const Step&, ThreadTeam&);
	bool   findMovedBodies(const Step&, ThreadTeam&);
	void   setReference(std::size_t id, const Step&);
	double extent(const Reference& body) const
	{
		return body.shape.radius() + body.alertDistance + margin_;
	}
	void   deform(const PeriodicCell& now);
	/// x₀ of a body that is at x now.
	Vec2   toReference(Vec2 x) const { return cell_.periodic ? product(backward_, x) : x; }
	Vec2   place(Vec2 x0) const; // in the grid, in columns and rows
	Range  range(double low, double high, int count) const;
	void chooseMargin();
	void sortIntoCells();
	bool near(std::int32_t body1, std::int32_t body2) const;
	bool nearImage(const Reference&, const Reference&, Vec2 shift) const;
	template <class Visit> void forEachGrain(const BoundingBox&, Visit) const;
	void searchNarrow(ThreadTeam&);
	void searchAround(const std::vector<std::int32_t>& bodies, ThreadTeam&);

	double                 margin_ = 0; // [m]
	std::vector<Reference> reference_;
	List                   list_;
	bool                   current_ = false; // valid for the present poses
	// the cell at the time of the list, F and F⁻¹ and ε of the present cell
	PeriodicCell           cell_;
	double                 forward_[2][2] {}, backward_[2][2] {}, strain_ = 0;
	// edges by which two centres may be apart at their nearest image
	Vec2                   mostEdges_;
	// the grid
	Vec2                           origin_;
	double                         width_ = 1; // least width of a grid cell [m]
	int                            columns_ = 1, rows_ = 1;
	std::vector<std::int32_t>      firstIn_, inCells_; // per cell: its first grain; grains by cell
	std::vector<std::int32_t>      wide_; // grains wider than a cell or moved, and obstacles
	std::vector<char>              isWide_;
	std::size_t                    wideAtFirst_ = 0; // their number when the list was made
	std::vector<std::int32_t>      moved_; // bodies that violate the condition
	std::vector<char>              isSearched_; // per body: a search includes its pairs
	std::vector<List>              found_; // per part of the bodies
};

/// Calls visit(grain) for all narrow grains in the grid cells that a box around x₀ touches.
template <class Visit> void Neighbors::forEachGrain(const BoundingBox& box, Visit visit) const
{
	const Vec2 at = place(box.center);
	Vec2       half { box.half.x / width_, box.half.y / width_ };
	if (cell_.periodic) {
		const auto& i = cell_.inverse;
		half = { (std::abs(i[0][0]) * box.half.x + std::abs(i[0][1]) * box.half.y) * columns_,
			(std::abs(i[1][0]) * box.half.x + std::abs(i[1][1]) * box.half.y) * rows_ };
	}
	const Range columns = range(at.x - half.x, at.x + half.x, columns_),
	            rows    = range(at.y - half.y, at.y + half.y, rows_);
	for (int r = 0; r < rows.count; ++r) {
		const int row = (rows.first + r) % rows_ * columns_;
		for (int column = columns.first, left = columns.count; left > 0; column = 0) {
			const int count = std::min(left, columns_ - column);
			for (std::int32_t k = firstIn_[row + column]; k < firstIn_[row + column + count]; ++k)
				if (!isWide_[inCells_[k]]) visit(inCells_[k]);
			left -= count;
		}
	}
}

template <class Reach, class Visit>
void Neighbors::forEachAround(const Step& step, ThreadTeam& team,
        const std::vector<std::int32_t>& bodies, Reach reach, Visit visit)
{
	if (!current_) update(step, team);
	isSearched_.assign(step.bodies.size(), false);
	for (std::int32_t id : bodies)
		isSearched_[id] = true;
	const auto isGrain = [&](std::int32_t id) { return step.bodies[id].shape.grain(); };
	const auto extent  = [&](std::int32_t id) { return step.bodies[id].radius + reach(id); };
	for (std::int32_t id : bodies) {
		const StepBody& b   = step.bodies[id];
		const double    own = extent(id);
		if (b.shape.kind == PlanarShape::none) continue;
		const auto      take = [&](std::int32_t other) {
            if (!isGrain(id) || !isGrain(other)) {
				if (isGrain(id) || (isGrain(other) && !isSearched_[other])) visit(id, other);
				return;
			}
			// of two searched grains, the larger one finds the other
			const double its = extent(other), most = own + its;
			if (isSearched_[other] && (its > own || (its == own && other <= id))) return;
			const Vec2 apart = b.center - step.bodies[other].center
			        - step.nearestShift(b, step.bodies[other]);
			if (dot(apart, apart) <= most * most) visit(id, other);
		};
		std::for_each(wide_.begin(), wide_.end(), take);
		const double around
		        = isGrain(id) ? own + std::max(own + margin_, 0.5 * width_) : reach(id) + 0.5 * width_;
		const auto [center, half] = isGrain(id) ? BoundingBox { b.center, {} }
		                                        : boundsOf(b.shape, b.pose());
		const double grown = (1 + strain_) * around + (strain_ > 0 ? strain_ * norm(half) : 0);
		forEachGrain({ toReference(center), half + Vec2 { grown, grown } }, take);
	}
}

} // namespace rcr
