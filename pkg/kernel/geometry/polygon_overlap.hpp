// Contact points of two rounded cores of which one is a polygon, by shadow overlap.
//
// The gap is the signed distance of the cores less both rounding radii: the distance of two cores
// apart, minus the least depth along the normal of a side of two that overlap. The first point is
// where the cores are closest. The tangent there divides both outlines. In either direction, the
// sides that begin at the point face each other up to the end of the shorter one, the end of the
// shadow. The second point is the end on the flatter side, where the gap opens by less per length.
// Its gap is measured along the normal of the first point.
#pragma once

#include "geometry/convex_polygon.hpp"
#include "geometry/shadow_overlap.hpp"

namespace rcr {

/// Convex core in the plane, relative to an origin, with its rounding radius.
struct Core {
	int    count    = 0; // vertices; side k leads from vertex k to the next
	double rounding = 0;
	double x[mostVertices], y[mostVertices];           // of the vertices [m]
	double alongX[mostVertices], alongY[mostVertices]; // unit vectors of the sides
	double length[mostVertices];                       // of the sides [m]

	Vec2 vertex(int k) const { return { x[k], y[k] }; }
	Vec2 along(int side) const { return { alongX[side], alongY[side] }; }
	void setVertex(int k, Vec2 v) { x[k] = v.x, y[k] = v.y; }
	void setSide(int k, Vec2 unit, double size)
	{
		alongX[k] = unit.x, alongY[k] = unit.y, length[k] = size;
	}
};

/// Core of the polygon at a pose, relative to `origin`.
Core coreOf(const ConvexPolygon&, double rounding, const Pose&, Vec2 origin);

/// Core of a stadium or, without length, of a disc.
Core coreOf(const Stadium&, const Pose&, Vec2 origin);

/// Points with gaps up to `maxGap` [m], relative to the origin of both cores, in the order of the
/// tangent. One core at least has three vertices.
Manifold polygonOverlap(const Core&, const Core&, double maxGap);

/// Contact points of a core on a half plane.
Manifold polygonOverlap(const HalfPlane&, const Core&, double maxGap);

} // namespace rcr
