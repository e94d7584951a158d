// Convex polygon as the core of a rounded polygon: all points within a rounding radius r of the core.
//
//   circumscribed radius  distance of the farthest point from the centre
//   inscribed radius      distance of the nearest side from the centre, plus r
//
// Vertices are counter-clockwise, relative to the centre of mass of the rounded shape. Quantities
// are per unit depth.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec2.hpp"

namespace rcr {

constexpr int mostVertices = 64;

/// Outward normal of a side of a counter-clockwise polygon.
inline Vec2 outward(Vec2 along) { return -perp(along); }

struct ConvexPolygon {
	/// Requires polygonError(vertices, 0) to be empty and three vertices or more.
	explicit ConvexPolygon(std::vector<Vec2> vertices);

	std::vector<Vec2>   vertices;      // [m]
	std::vector<Vec2>   along;         // unit vector of the side from each vertex to the next
	std::vector<double> length;        // of this side [m]
	double              inscribed;     // least distance of a side from the centre [m]
	double              circumscribed; // largest distance of a vertex from the centre [m]

	bool operator==(const ConvexPolygon& other) const;
};

/// What is wrong with a core and its rounding radius; empty: nothing. A core has 1 to 64 vertices,
/// convex and counter-clockwise. With less than three it needs a rounding.
std::string polygonError(const std::vector<Vec2>& vertices, double rounding);

struct PlanarMoments {
	double area = 0;        // [m²]
	Vec2   centroid;        // [m]
	double polarMoment = 0; // ∫ |x − centroid|² dA [m⁴]; times the mass per area, about z
};

/// Moments of a rounded polygon of one vertex or more.
PlanarMoments momentsOf(const std::vector<Vec2>& vertices, double rounding);

} // namespace rcr
