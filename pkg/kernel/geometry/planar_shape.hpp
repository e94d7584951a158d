// Shape of a body in the plane, and the contact points of a pair of shapes.
//
// A shape is a half plane, or a core with a rounding radius r: all points within r of the core.
//
// | kind    | shape                                         | vertices of the core | r  |
// |---------|-----------------------------------------------|----------------------|----|
// | wall    | half plane bounded by a line normal to x or y |                      |    |
// | box     | rectangle that rotates with its body          | 4                    | 0  |
// | segment | line without thickness, with two sides        | 2                    | 0  |
// | disc    | disc of radius R                              | 1                    | R  |
// | stadium | rounded-cap rectangle                         | 2                    | R' |
// | polygon | rounded convex polygon                        | 1 to 64              | r  |
//
// Walls, boxes and segments are obstacles, the others are grains. Obstacles touch grains only. The
// kind of body 1 comes first in this table, so normals point from an obstacle to a grain.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "geometry/convex_polygon.hpp"
#include "geometry/shadow_overlap.hpp"

namespace rcr {

struct PlanarShape {
	enum Kind : std::int8_t { none, wall, box, segment, disc, stadium, polygon };

	Kind        kind       = none;
	std::int8_t axis       = 0; // wall: axis of the normal, 0 for x, 1 for y
	std::int8_t sense      = 0; // wall: sign of the normal; 0: towards the grain
	double      halfLength = 0; // a of a core of two vertices, else 0 [m]
	double      rounding   = 0; // r [m]
	Vec2        offset;         // midpoint of a core of two vertices in the frame of the body [m]
	Vec2        direction { 1, 0 }; // its unit vector in this frame
	std::shared_ptr<const ConvexPolygon> core; // of three or more vertices

	bool grain() const { return kind >= disc; }

	/// Largest distance of a point from the centre of the body [m]; 0 for an infinite wall.
	double radius() const
	{
		return (core ? core->circumscribed : norm(offset) + halfLength) + rounding;
	}

	/// Radius of the inscribed circle about the centre [m], the scale of a grain's thickness.
	double inscribedRadius() const { return (core ? core->inscribed : 0) + rounding; }

	/// Circumscribed radius of a grain [m]; 0 for an obstacle.
	double circumscribedRadius() const { return grain() ? radius() : 0; }
};

/// Area, centroid and polar moment of a grain or a box, in the frame of its body.
PlanarMoments momentsOf(const PlanarShape&);

/// Sets the core of a shape to these vertices in the frame of the body.
void setCore(PlanarShape&, const std::vector<Vec2>& vertices);

/// A box with these half widths ≥ 0 [m].
PlanarShape boxShape(Vec2 half);

/// A rounded-cap rectangle, or a disc of the radius `rounding` without a half length [m].
PlanarShape stadiumShape(double halfLength, double rounding);

/// Vertices of the core in the plane, counter-clockwise; none of a wall.
std::vector<Vec2> coreVertices(const PlanarShape&, const Pose& body);

/// Midpoint and direction of a core of at most two vertices.
inline Pose corePose(const PlanarShape& s, const Pose& body)
{
	if (s.kind == PlanarShape::disc || s.kind == PlanarShape::stadium) return body;
	const auto rotated = [&](Vec2 v) { return v.x * body.axis + v.y * perp(body.axis); };
	return { body.center + rotated(s.offset), rotated(s.direction) };
}

/// Centre and half widths of an axis-aligned bounding box [m].
struct BoundingBox {
	Vec2 center, half;
};

/// The bounding box of one point or more.
BoundingBox boundsOf(const std::vector<Vec2>& points);

/// The bounding box of a shape. A wall is infinite along its line.
BoundingBox boundsOf(const PlanarShape&, const Pose& body);

/// R₁ + R₂ of a pair [m], the scale of overlaps. An obstacle has the radius of the grain.
inline double contactSize(const PlanarShape& one, const PlanarShape& two)
{
	const double r1 = one.circumscribedRadius(), r2 = two.circumscribedRadius();
	return (r1 > 0 ? r1 : r2) + r2;
}

/// Length that turns the moment of rolling resistance into an impulse: R₁ + R₂, or the R of a grain
/// at an obstacle [m]. `size`: contactSize.
inline double rollingLength(double size, bool atObstacle) { return (atObstacle ? 0.5 : 1) * size; }
inline double rollingLength(const PlanarShape& one, const PlanarShape& two)
{
	return rollingLength(contactSize(one, two), !(one.grain() && two.grain()));
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
	if (!one.grain()) return true;
	if (!one.core && !two.core)
		return mayTouch({ one.halfLength, one.rounding }, corePose(one, at1),
		        { two.halfLength, two.rounding }, corePose(two, at2), maxGap);
	const Vec2   apart = at2.center - at1.center;
	const double most  = one.radius() + two.radius() + maxGap;
	return dot(apart, apart) <= most * most;
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
