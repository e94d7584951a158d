// Finds late contacts. A late contact is one that the detection before the step did not list, and
// that closes beyond the slop within the step.
//
// Detection covers gaps up to ℓ₁ + ℓ₂, the sum of the detection reaches of the two bodies. The
// reach is the alert distance, which follows from the velocity at the beginning of the step. R and
// R' are the circumscribed and the inscribed radius:
//
//   ℓ = 2 dt (|v| + |ω| R), for a grain at least 0.01 R'
//
// For a wall, |v| is its speed along its normal. In a cell that deforms, an image moves relative to
// its body by up to the speed v_i. Between a body and an image of another, each reaches further by
//
//   ℓ_i = dt v_i, for a grain 0.01 R' more
//
// A body that is released or hit may move further, and CellStress may change v_i in the solve.
// After the solve, the reach of each body whose path exceeds it is widened by 1.5 paths. If any of
// their contacts is late, all contacts within the widened reaches are added. The step is then
// solved again, up to its limit of passes. If images move further than 2 dt v_i plus 0.01 R', all
// bodies reach further by the new v_i. Whether a gap closes is tested on its tangent plane, and with
// a large displacement also on the curved paths of the bodies.
#pragma once

#include <functional>

#include "detection/neighbors.hpp"

namespace rcr {

/// Alert distance ℓ of a body with this velocity [m].
inline double alertDistance(const PlanarShape& shape, const PlanarVector& v, double dt)
{
	if (shape.kind == PlanarShape::wall)
		return 2 * dt * std::abs(shape.axis == 0 ? v.x : v.y);
	const double alert = 2 * dt * maxSpeed(v, shape.radius());
	return shape.grain() ? std::max(0.01 * shape.inscribedRadius(), alert) : alert;
}

/// Part ℓ_i of the reach of a body to images of others [m]. `imageSpeed`: v_i.
inline double imageReach(const PlanarShape& shape, double imageSpeed, double dt)
{
	return dt * imageSpeed + (shape.grain() ? 0.01 * shape.inscribedRadius() : 0);
}

/// Largest gap at which two bodies with these reaches have a contact [m]. `shift`: to the image of
/// body 2.
inline double largestGap(const Step& step, const StepBody& one, double reach1, const StepBody& two,
        double reach2, Vec2 shift)
{
	const bool image  = shift.x != 0 || shift.y != 0;
	const auto beyond = [&](const StepBody& body) {
		return image ? imageReach(body.shape, step.cell.imageSpeed, step.dt) : 0;
	};
	return (reach1 + beyond(one)) + (reach2 + beyond(two));
}

/// Returns true if masks, clumps and engines of the simulation allow a new contact of two bodies.
using ContactFilter = std::function<bool(int body1, int body2)>;

/// What a simulation decides about new contacts.
struct NewContacts {
	ContactFilter                       allows;
	std::function<ContactLaw(int, int)> law; // of two bodies
};

/// Means of a search for contacts.
struct Search {
	Neighbors&           neighbors;
	ThreadTeam&          team;
	const ContactFilter& allows;
};

/// Before the solve, detects contacts of bodies whose pairs in the simulation may be incomplete.
/// Collects them in step.found and returns true if there are any. Call addFoundContacts then.
bool findUnlistedContacts(Step&, const std::vector<std::int32_t>& bodies, const Search&);

/// Distance within which contacts of a body are detected, with its widening in this step [m].
double detectionReach(const Step&, std::size_t id);

/// Collects in step.found the contacts within the widened reach of the solved step. Returns
/// true if one of them is late. A further solve requires addFoundContacts.
bool findLateContacts(Step&, const Search&);

/// Returns true if the sum of radii and paths of two bodies exceeds half the smallest height of the
/// cell, so that they may meet at two images.
bool spansHalfCell(const Step&);

/// Returns contacts that the step lacks, without points: those found earlier, and those of bodies
/// whose path and displacement exceed their reach. Widens the reach of these bodies.
std::vector<StepContact> contactsOfDisplaced(Step&, const Search&);

/// Adds step.found to the contacts, points and forces of the step, and moves it to
/// step.added. Requires friction and restitution of new contacts.
void addFoundContacts(Step&);

} // namespace rcr
