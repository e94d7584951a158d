// What a body looks like in the plane, and the contact points of two bodies of any kinds that are served.
//
// | kind    | is                                                    | meets          |
// |---------|-------------------------------------------------------|----------------|
// | wall    | the free side of a line normal to x or y              | grains         |
// | box     | a rectangle, turned with its body                     | grains         |
// | segment | a line without thickness, both sides act              | grains         |
// | disc    | a stadium whose core is a point                       | everything     |
// | stadium | a rounded-cap rectangle                               | everything     |
//
// Walls, boxes and segments are obstacles, discs and stadia are grains. In a pair the kind that stands higher in the table is
// body 1, so that normals point from an obstacle to a grain.
#pragma once

#include <algorithm>
#include <cstdint>

#include "geometry/shadow_overlap.hpp"

namespace rcr {

struct PlanarShape {
	enum Kind : std::int8_t { none, wall, box, segment, disc, stadium };

	Kind        kind = none;
	std::int8_t axis = 0, sense = 0;          // wall: axis of the normal (0 x, 1 y), side that acts (0: where the grain is)
	double      halfLength = 0, halfWidth = 0; // stadium: a, R'; disc: 0, R; box: half extents; segment: half length, 0 [m]
	Vec2        offset;                        // segment: its middle in the frame of the body [m]
	Vec2        along { 1, 0 };                // segment: its direction there

	bool grain() const { return kind >= disc; }

	/// Greatest distance of a point from the centre of the body [m]; 0 for a wall, which has none.
	double radius() const
	{
		switch (kind) {
			case disc:
			case stadium: return halfLength + halfWidth;
			case box: return norm(Vec2 { halfLength, halfWidth });
			case segment: return norm(offset) + halfLength;
			default: return 0;
		}
	}
	/// Radius by which a contact of it is sized, R in R₁ + R₂ [m]; 0 for an obstacle, which counts as the grain that it meets.
	double contactRadius() const { return grain() ? halfLength + halfWidth : 0; }
};

/// Half widths of the axis-aligned bounding box of a box or a grain about its centre, of a segment about its middle [m].
inline Vec2 halfExtent(const PlanarShape& s, Vec2 axis)
{
	if (s.grain()) return halfExtent(Stadium { s.halfLength, s.halfWidth }, axis);
	return { std::abs(axis.x) * s.halfLength + std::abs(axis.y) * s.halfWidth, std::abs(axis.y) * s.halfLength + std::abs(axis.x) * s.halfWidth };
}

/// Where a segment stands: its middle and direction.
inline Pose middleOf(const PlanarShape& segment, const Pose& body)
{
	const auto turned = [&](Vec2 v) { return v.x * body.axis + v.y * perp(body.axis); };
	return { body.center + turned(segment.offset), turned(segment.along) };
}

/// R₁ + R₂ of a pair [m], by which overlaps are judged; an obstacle counts as the grain that it meets.
inline double contactSize(const PlanarShape& one, const PlanarShape& two)
{
	const double r1 = one.contactRadius(), r2 = two.contactRadius();
	return (r1 > 0 ? r1 : r2) + (r2 > 0 ? r2 : r1);
}

/// Do contacts of the two kinds exist, in this order?
inline bool meet(PlanarShape::Kind one, PlanarShape::Kind two) { return one != PlanarShape::none && two >= PlanarShape::disc && one <= two; }

/// Contact points of body 1 and body 2, none if their gap exceeds `reach`; `meet` must hold for the kinds.
Manifold contactPoints(const PlanarShape& one, const Pose& at1, const PlanarShape& two, const Pose& at2, double reach);

/// The body along whose axis the points of a pair are sorted: the first one of two grains, else the grain.
inline const Pose& sortedAlong(const PlanarShape& one, const Pose& at1, const Pose& at2) { return one.kind == PlanarShape::stadium ? at1 : at2; }

} // namespace rcr
