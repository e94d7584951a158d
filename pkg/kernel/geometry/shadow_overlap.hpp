// Contact detection by shadow overlap: two bodies give a manifold of 0, 1 or 2 contact points.
//
// The shadow of one core segment on the other is the part where they face each other. Each of its
// two ends is an end of one segment, projected into the interior of the other. The manifold holds
// the closest point of the two cores. Along a side, it also holds the other end of the shadow, if
// the gap there is at most `maxGap`. No angle is tested: points appear and vanish with their gaps,
// so a side contact tips over its edge without a jump.
//
//   gap g      distance of the surfaces along the normal [m]; negative: overlap
//   normal n   unit, from body 1 to body 2
//   position   midway between the surfaces: both bodies feel the impulse on one line
//
// Crossing cores have the gap −depth − R'₁ − R'₂, where depth is the smallest translation that
// separates the segments. The points are ordered along the axis of the stadium, or of body 1 of two
// stadia. So they keep their order from step to step. Source: Saussine et al. 2006; Radjaï and
// Dubois 2011 (shadow overlap after Moreau). The rule of the second point is new, see
// pkg/README.md.
#pragma once

#include <algorithm>
#include <utility>

#include "geometry/stadium.hpp"

namespace rcr {

enum class ContactType { capCap = 0, capSide = 1, sideSide = 2, obstacle = 3 };

struct ManifoldPoint {
	Vec2   position;
	Vec2   normal;
	double gap = 0;
};

struct Manifold {
	int           count = 0;
	ContactType   type  = ContactType::capCap;
	ManifoldPoint points[2];
	double        shadow = 0; // its length; 0: one point [m]
	// changes per tangential displacement of body 2
	int    slide = 0; // of the shadow: 1, −1, or 0 where both ends belong to one body
	double slope = 0; // of the shallower gap; 0 where the normal is that of the side

	/// Deepest overlap of the points; 0 if all are open [m].
	double deepest() const
	{
		const double second = count > 1 ? -points[1].gap : 0;
		return std::max({ 0.0, count > 0 ? -points[0].gap : 0, second });
	}

	/// Sorts two points by their position along an axis.
	void sortAlong(Vec2 axis)
	{
		if (count == 2 && dot(points[1].position - points[0].position, axis) < 0)
			std::swap(points[0], points[1]);
	}
};

/// Wall along a line. The free side is (x − origin) · normal > 0.
struct HalfPlane {
	Vec2 origin;
	Vec2 normal;
};

/// Gaps between the projections of two cores, along and across each of them [m]; negative: overlap.
struct CoreGaps {
	double along1, across1, along2, across2;

	/// Lower bound of the distance of the cores.
	double largest() const
	{
		return std::max(std::max(along1, across1), std::max(along2, across2));
	}
};

inline CoreGaps coreGaps(const Stadium& s1, const Pose& at1, const Stadium& s2, const Pose& at2)
{
	const Vec2   d      = at2.center - at1.center;
	const double sine   = std::abs(cross(at1.axis, at2.axis)),
	             cosine = std::abs(dot(at1.axis, at2.axis));
	return { std::abs(dot(at1.axis, d)) - s1.halfLength - s2.halfLength * cosine,
		std::abs(cross(at1.axis, d)) - s2.halfLength * sine,
		std::abs(dot(at2.axis, d)) - s2.halfLength - s1.halfLength * cosine,
		std::abs(cross(at2.axis, d)) - s1.halfLength * sine };
}

/// Returns false if the gap of two stadia certainly exceeds `maxGap`.
inline bool mayTouch(const Stadium& s1, const Pose& at1, const Stadium& s2, const Pose& at2,
        double maxGap)
{
	const Vec2   d    = at2.center - at1.center;
	const double reach = s1.capRadius + s2.capRadius + maxGap,
	             ends  = s1.halfLength + s2.halfLength + reach;
	return dot(d, d) <= ends * ends && coreGaps(s1, at1, s2, at2).largest() <= reach;
}

/// Points with gaps up to `maxGap` [m].
Manifold shadowOverlap(const Stadium&, const Pose&, const Stadium&, const Pose&, double maxGap);
Manifold shadowOverlap(const HalfPlane&, const Stadium&, const Pose&, double maxGap);

} // namespace rcr
