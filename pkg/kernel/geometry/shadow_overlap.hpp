// Contact detection by shadow overlap: two bodies give a manifold of 0, 1 or 2 contact points.
//
// The shadow of one core segment on the other is the stretch where they face each other; its two ends are end points of
// one segment projected into the interior of the other. The manifold is the closest point of the two cores and, where
// they face each other along a side, the other end of the shadow if its gap is within the alert distance. No angle
// decides: two points come and go through their gaps alone, so a side contact tips over its edge without a jump.
//
//   gap g      distance of the surfaces along the normal [m]; negative = overlap
//   normal n   unit, from body 1 to body 2
//   position   half way between the two surfaces, so that both bodies feel the impulse on one line
//
// Crossing cores have the gap −depth − R'₁ − R'₂, depth being the smallest translation that separates the segments.
// The points of a manifold are sorted along the axis of the stadium (the first one of a pair), so that they keep their
// places from step to step.
// Source: Saussine et al. 2006 and Radjaï and Dubois 2011 (shadow overlap after Moreau); the rule of the second point is
// ours, see pkg/README.md.
#pragma once

#include "geometry/stadium.hpp"

namespace rcr {

enum class ContactType { capCap = 0, capSide = 1, sideSide = 2, wall = 3 };

struct ManifoldPoint {
	Vec2   position;
	Vec2   normal;
	double gap = 0;
};

struct Manifold {
	int           count = 0;
	ContactType   type  = ContactType::capCap;
	ManifoldPoint points[2];
};

/// The free side of a line: points x with (x − origin) · normal > 0.
struct HalfPlane {
	Vec2 origin;
	Vec2 normal;
};

/// A box seen in the plane; its pose's axis is the local x.
struct Rectangle {
	Vec2 halfExtent;
};

Manifold shadowOverlap(const Stadium&, const Pose&, const Stadium&, const Pose&, double alertDistance);
Manifold shadowOverlap(const HalfPlane&, const Stadium&, const Pose&, double alertDistance);
Manifold shadowOverlap(const Rectangle&, const Pose&, const Stadium&, const Pose&, double alertDistance);

} // namespace rcr
