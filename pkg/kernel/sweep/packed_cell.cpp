// A cell that may stretch. All its pairs form one island.
//
// Usually the stretch rate lags: it follows from the impulses after each sweep. Records hold
// velocities with the stretch, and pairs of free bodies have slots. In a light cell, sweeps with
// this lag would diverge. There each impulse changes the rate at once, all pairs are overflow, and
// records hold no stretch. Layout::cellLags chooses.
#include "problem/coulomb.hpp"
#include "sweep/packed_island.hpp"

namespace rcr {

Delassus PackedProblem::delassusInCell(const ContactProblem& problem, const ContactPoint& c)
{
	const Vec2  arm  = problem.stretchArm(c);
	const Vec2  cell = componentwise(problem.inverseStretchMass, componentwise(arm, arm));
	InverseMass m2   = problem.inverseMass[c.body2];
	m2.x += cell.x, m2.y += cell.y;
	return delassus(c, problem.inverseMass[c.body1], m2);
}

Vec2 PackedProblem::carriedPlace(const ContactProblem& problem, int body) const
{
	if (!cellLags_) return {};
	const InverseMass& m = problem.inverseMass[body];
	const Vec2         r = problem.placeOf(body) - cellOrigin_;
	return { m.x > 0 ? r.x : 0, m.y > 0 ? r.y : 0 };
}

void PackedProblem::loadCell(const ContactProblem& problem)
{
	inverseStretchMass_ = problem.inverseStretchMass;
	stretchRate_ = cellOrigin_ = freeMoment_ = carriedInertia_ = {};
	if (!stretches_) return;
	if (!problem.points.empty()) cellOrigin_ = problem.placeOf(problem.points[0].body1);
	carried_.assign(layout_.records(), {});
	for (int i = 0; i < int(problem.inverseMass.size()); ++i) {
		if (layout_.island(i) == none) continue;
		const InverseMass&  m     = problem.inverseMass[i];
		const PlanarVector& v     = problem.freeVelocity[i];
		const Vec2          place = carriedPlace(problem, i);
		const Vec2 moment { m.x > 0 ? place.x / m.x : 0, m.y > 0 ? place.y / m.y : 0 };
		carried_[layout_.record(i)] = { place, moment };
		freeMoment_                 = freeMoment_ + componentwise(moment, { v.x, v.y });
		carriedInertia_             = carriedInertia_ + componentwise(moment, place);
	}
}

/// Sets the stretch rate that the impulses cause, M_c⁻¹ Σ f ∘ (r₂ + s − r₁), if it lags. The
/// impulses on free bodies follow from their velocities.
void PackedIsland::updateStretchRate()
{
	if (!packed_.cellLags_) return;
	const Vec2 rate   = packed_.stretchRate_;
	Vec2       moment = -1 * packed_.freeMoment_ - componentwise(rate, packed_.carriedInertia_);
	forEachCarried([&](const double* v, const PackedProblem::Carried& of) {
		moment.x += of.moment.x * v[record::x];
		moment.y += of.moment.y * v[record::y];
	});
	forEachOverflowPoint([&](const OverflowPoint& c) {
		moment = moment + componentwise(c.stretchArm, toCartesian(c.normal, c.p));
	});
	packed_.stretchRate_ = componentwise(packed_.inverseStretchMass_, moment);
	const Vec2 change    = packed_.stretchRate_ - rate;
	forEachCarried([&](double* v, const PackedProblem::Carried& of) {
		v[record::x] += change.x * of.place.x;
		v[record::y] += change.y * of.place.y;
	});
}

} // namespace rcr
