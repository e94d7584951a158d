// Stadium, or rounded-cap rectangle (RCR): all points within the cap radius R' of a core segment of
// half length a.
//
//   circumscribed radius  R = a + R'
//   elongation            η = (R − R') / R = a / R       0 = disc   [paper, eq. 1]
//
// Quantities are per unit depth. The centre of mass is the centre of the core segment.
#pragma once

#include "geometry/vec2.hpp"

namespace rcr {

struct Stadium {
	double halfLength = 0; // a [m], 0 = disc
	double capRadius  = 0; // R' [m]
};

/// Centre [m] and unit axis (cos θ, sin θ) of a body.
struct Pose {
	Vec2 center;
	Vec2 axis { 1, 0 };
};

inline Pose shifted(const Pose& at, Vec2 by) { return { at.center + by, at.axis }; }

/// Area of the rectangle 2a × 2R' and two half discs [m²].
inline double area(const Stadium& s)
{
	return M_PI * s.capRadius * s.capRadius + 4 * s.halfLength * s.capRadius;
}

/// ∫ |x|² dA about the centre [m⁴]; times the mass per area, the moment of inertia about z.
inline double polarMoment(const Stadium& s)
{
	const double a = s.halfLength, r = s.capRadius;
	const double rectangle = 4 * a * r * (a * a + r * r) / 3;
	// the centroid of a half disc is 4r/3π from its cut
	const double halfDiscs = M_PI * r * r * (r * r / 2 + a * a) + 8 * a * r * r * r / 3;
	return rectangle + halfDiscs;
}

/// Half widths of the axis-aligned bounding box [m].
inline Vec2 halfExtent(const Stadium& s, Vec2 axis)
{
	return { std::abs(axis.x) * s.halfLength + s.capRadius,
		     std::abs(axis.y) * s.halfLength + s.capRadius };
}

} // namespace rcr
