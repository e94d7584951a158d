// Shape of a body in the plane, and the contact points of a pair of shapes.
//
// | kind    | shape                                         | contacts with |
// |---------|-----------------------------------------------|---------------|
// | wall    | half plane bounded by a line normal to x or y | grains        |
// | box     | rectangle that rotates with its body          | grains        |
// | segment | line without thickness, with two sides        | grains        |
// | disc    | stadium whose core is a point                 | all           |
// | stadium | rounded-cap rectangle                         | all           |
//
// Walls, boxes and segments are obstacles; discs and stadia are grains. The kind of body 1 comes
// first in this table, so normals point from an obstacle to a grain.
#pragma once

#include <cstdint>
#include <limits>

#include "geometry/shadow_overlap.hpp"

namespace rcr {

struct PlanarShape {
	enum Kind : std::int8_t { none, wall, box, segment, disc, stadium };

	Kind        kind       = none;
	std::int8_t axis       = 0; // wall: axis of the normal, 0 for x, 1 for y
	std::int8_t sense      = 0; // wall: sign of the normal; 0: towards the grain
	double      halfLength = 0; // stadium: a; disc: 0; box: half extent; segment: half length [m]
	double      halfWidth  = 0; // stadium: R'; disc: R; box: half extent; segment: 0 [m]
	Vec2        offset;         // segment: its midpoint in the frame of the body [m]
	Vec2        direction { 1, 0 }; // segment: its unit vector in the frame of the body

	bool grain() const { return kind >= disc; }

	/// Largest distance of a point from the centre of the body [m]; 0 for an infinite wall.
	double radius() const
	{
		if (grain()) return halfLength + halfWidth;
		if (kind == box) return norm(Vec2 { halfLength, halfWidth });
		return kind == segment ? norm(offset) + halfLength : 0;
	}

	/// Circumscribed radius of a grain [m]; 0 for an obstacle.
	double circumscribedRadius() const { return grain() ? radius() : 0; }
};

inline Pose segmentPose(const PlanarShape& segment, const Pose& body)
{
	const auto rotated = [&](Vec2 v) { return v.x * body.axis + v.y * perp(body.axis); };
	return { body.center + rotated(segment.offset), rotated(segment.direction) };
}

/// Centre and half widths of an axis-aligned bounding box [m].
struct BoundingBox {
	Vec2 center, half;
};

/// The bounding box of a parallelogram with these half edges [m].
inline BoundingBox boundsOf(Vec2 center, Vec2 along, Vec2 across)
{
	return { center,
		{ std::abs(along.x) + std::abs(across.x), std::abs(along.y) + std::abs(across.y) } };
}

/// The bounding box of a shape. A wall is infinite along its line.
inline BoundingBox boundsOf(const PlanarShape& s, const Pose& body)
{
	constexpr double infinite = std::numeric_limits<double>::infinity();
	if (s.kind == PlanarShape::wall)
		return { body.center, s.axis == 0 ? Vec2 { 0, infinite } : Vec2 { infinite, 0 } };
	if (s.grain())
		return { body.center, halfExtent(Stadium { s.halfLength, s.halfWidth }, body.axis) };
	const auto [center, axis] = s.kind == PlanarShape::segment ? segmentPose(s, body) : body;
	return boundsOf(center, s.halfLength * axis, s.halfWidth * perp(axis));
}

/// R₁ + R₂ of a pair [m], the scale of overlaps. An obstacle has the radius of the grain.
inline double contactSize(const PlanarShape& one, const PlanarShape& two)
{
	const double r1 = one.circumscribedRadius(), r2 = two.circumscribedRadius();
	return (r1 > 0 ? r1 : r2) + r2;
}

/// Length that turns the moment of rolling resistance into an impulse: R₁ + R₂, or the R of a grain
/// at an obstacle [m].
inline double rollingLength(const PlanarShape& one, const PlanarShape& two)
{
	return (one.grain() && two.grain() ? 1 : 0.5) * contactSize(one, two);
}

/// Returns true if shapes of these kinds may be body 1 and body 2 of a pair.
inline bool canTouch(PlanarShape::Kind one, PlanarShape::Kind two)
{
	return one != PlanarShape::none && two >= PlanarShape::disc && one <= two;
}

/// Returns true if the first body is body 1 of the pair: by its kind, then by its number.
inline bool comesFirst(const PlanarShape& one, int id1, const PlanarShape& two, int id2)
{
	return one.kind != two.kind ? one.kind < two.kind : id1 < id2;
}

/// Returns false if two bodies have no contact points with gaps up to `maxGap` [m]. Tests kinds and,
/// of grains, bounds. It takes less time than contactPoints.
inline bool mayTouch(const PlanarShape& one, const Pose& at1, const PlanarShape& two,
        const Pose& at2, double maxGap)
{
	if (!canTouch(one.kind, two.kind)) return false;
	return !one.grain()
	        || mayTouch({ one.halfLength, one.halfWidth }, at1, { two.halfLength, two.halfWidth },
	                at2, maxGap);
}

/// Contact points of two bodies with gaps up to `maxGap` [m]. Requires canTouch.
Manifold contactPoints(const PlanarShape& one, const Pose& at1, const PlanarShape& two,
        const Pose& at2, double maxGap);

/// Position of a contact point along its tangent [m], from the middle between the centres. At an
/// obstacle it starts at the centre of the grain.
inline double positionAlong(
        const PlanarShape& one, const Pose& at1, const Pose& at2, const ManifoldPoint& point)
{
	const Vec2 from = one.kind < PlanarShape::disc ? at2.center : 0.5 * (at1.center + at2.center);
	return cross(point.normal, point.position - from);
}

} // namespace rcr
