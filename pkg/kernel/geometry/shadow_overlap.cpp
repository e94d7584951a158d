#include "geometry/shadow_overlap.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace rcr {

namespace {

	/// An end faces a side up to this multiple of the half length [-]. The excess of 1e-9 covers
	/// rounding: equal bodies that lie flush on each other need their second point.
	constexpr double sideReach = 1 + 1e-9;

	/// A point of core 1 that faces a point of core 2.
	struct Facing {
		Vec2   core1, core2;
		Vec2   normal;           // unit, from body 1 to body 2
		double distance = 0;     // of the points, along the normal
		bool   side     = false; // one of the points lies within a side, not at an end
	};

	/// Unit vector along `delta`, or `fallback` if delta is 0.
	Vec2 direction(Vec2 delta, Vec2 fallback)
	{
		const double length = norm(delta);
		return length > 0 ? (1 / length) * delta : fallback;
	}

	double sign(double x) { return x < 0 ? -1 : 1; }

	/// Projects `end` of a core onto the segment of half length a about `center`. The normal points
	/// from the segment to the end; if the end lies on the segment, to the side of `away`.
	Facing project(Vec2 end, Vec2 center, Vec2 axis, double a, Vec2 away)
	{
		const Vec2   q = end - center;
		const double s = dot(q, axis);
		if (a > 0 && std::abs(s) <= sideReach * a) {
			const double h = cross(axis, q);
			const Vec2   n = sign(h != 0 ? h : cross(axis, away)) * perp(axis);
			return { center + s * axis, end, n, std::abs(h), true };
		}
		const Vec2   foot = center + (s < 0 ? -a : a) * axis, gap = end - foot;
		const double distance = norm(gap);
		return { foot, end, distance > 0 ? (1 / distance) * gap : direction(away, perp(axis)),
			     distance, false };
	}

	Facing swapped(const Facing& f) { return { f.core2, f.core1, -f.normal, f.distance, f.side }; }

	/// Distances between the projections of two core segments along and across each segment.
	struct Separation {
		double along1, across1, along2, across2; // negative: the projections overlap

		Separation(Vec2 d, Vec2 axis1, double a1, Vec2 axis2, double a2)
		{
			const double sine = std::abs(cross(axis1, axis2)), cosine = std::abs(dot(axis1, axis2));
			along1  = std::abs(dot(axis1, d)) - a1 - a2 * cosine;
			across1 = std::abs(cross(axis1, d)) - a2 * sine;
			along2  = std::abs(dot(axis2, d)) - a2 - a1 * cosine;
			across2 = std::abs(cross(axis2, d)) - a1 * sine;
		}

		/// Lower bound of the distance of the segments.
		double lowerBound() const
		{
			return std::max(std::max(along1, across1), std::max(along2, across2));
		}

		/// True if the ends of each segment lie strictly on both sides of the other segment. For
		/// collinear segments the sides are rounding, so `along1` is tested too.
		bool crossing() const { return across1 < 0 && across2 < 0 && along1 < 0; }
	};

	ManifoldPoint manifoldPoint(const Facing& f, double radius1, double radius2)
	{
		const Vec2 surface1 = f.core1 + radius1 * f.normal, surface2 = f.core2 - radius2 * f.normal;
		return { 0.5 * (surface1 + surface2), f.normal, f.distance - radius1 - radius2 };
	}

	/// The closest pair of facing points, and the pair along a side that is farthest from it within
	/// the alert distance.
	Manifold manifold(
	        const Facing* facing, int count, double radius1, double radius2, double alertDistance,
	        Vec2 axis)
	{
		int closest = 0;
		for (int k = 1; k < count; ++k)
			if (facing[k].distance < facing[closest].distance) closest = k;
		Manifold result;
		result.points[0] = manifoldPoint(facing[closest], radius1, radius2);
		if (!(result.points[0].gap <= alertDistance)) return result;
		result.count = 1;
		result.type  = facing[closest].side ? ContactType::capSide : ContactType::capCap;

		const ManifoldPoint& first = result.points[0];
		double               reach = 1e-9 * (radius1 + radius2); // closer points are the same point
		for (int k = 0; k < count; ++k) {
			if (!facing[k].side || dot(facing[k].normal, first.normal) <= 0) continue;
			const ManifoldPoint other    = manifoldPoint(facing[k], radius1, radius2);
			const double        distance = norm(other.position - first.position);
			if (other.gap > alertDistance || distance <= reach) continue;
			reach            = distance;
			result.points[1] = other;
			result.count     = 2;
			result.type      = ContactType::sideSide;
		}
		if (result.count == 2
		    && dot(result.points[1].position - result.points[0].position, axis) < 0)
			std::swap(result.points[0], result.points[1]);
		return result;
	}

} // namespace

Manifold shadowOverlap(
        const Stadium& s1, const Pose& at1, const Stadium& s2, const Pose& at2,
        double alertDistance)
{
	const Vec2   d = at2.center - at1.center;
	const double reach
	        = s1.halfLength + s1.capRadius + s2.halfLength + s2.capRadius + alertDistance;
	if (dot(d, d) > reach * reach) return {};
	const Separation separation(d, at1.axis, s1.halfLength, at2.axis, s2.halfLength);
	if (separation.lowerBound() > s1.capRadius + s2.capRadius + alertDistance) return {};

	const Vec2 core1 = s1.halfLength * at1.axis, core2 = s2.halfLength * at2.axis;
	Facing     facing[4] = {
		    project(at2.center - core2, at1.center, at1.axis, s1.halfLength, d),
		    project(at2.center + core2, at1.center, at1.axis, s1.halfLength, d),
		    swapped(project(at1.center - core1, at2.center, at2.axis, s2.halfLength, -d)),
		    swapped(project(at1.center + core1, at2.center, at2.axis, s2.halfLength, -d)),
	};
	if (separation.crossing()) {
		// Moves the end of the smallest depth back to its side. Ends beyond the other core count
		// too, with their distance to its line: they also bound the translation.
		Facing least;
		least.distance = -std::numeric_limits<double>::infinity();
		for (int k = 0; k < 4; ++k) {
			const Pose&  at  = k < 2 ? at1 : at2;
			const Vec2   end = k < 2 ? facing[k].core2 : facing[k].core1;
			const double h   = cross(at.axis, end - at.center);
			if (-std::abs(h) <= least.distance) continue;
			const Vec2   side = perp(at.axis);
			const Facing back { end - h * side, end, -sign(h) * side, -std::abs(h), true };
			least = k < 2 ? back : swapped(back);
		}
		return manifold(&least, 1, s1.capRadius, s2.capRadius, alertDistance, at1.axis);
	}
	return manifold(facing, 4, s1.capRadius, s2.capRadius, alertDistance, at1.axis);
}

Manifold shadowOverlap(
        const HalfPlane& wall, const Stadium& s, const Pose& at, double alertDistance)
{
	Manifold result;
	result.type = ContactType::wall;
	for (double end : { -s.halfLength, s.halfLength }) {
		const Vec2   core = at.center + end * at.axis;
		const double gap  = dot(core - wall.origin, wall.normal) - s.capRadius;
		if (gap <= alertDistance)
			result.points[result.count++]
			        = { core - (s.capRadius + gap / 2) * wall.normal, wall.normal, gap };
		if (s.halfLength == 0) break;
	}
	return result;
}

Manifold shadowOverlap(
        const Rectangle& box, const Pose& boxAt, const Stadium& s, const Pose& at,
        double alertDistance)
{
	const Vec2 x = boxAt.axis, y = perp(x), h = box.halfExtent;
	const Vec2 d = at.center - boxAt.center;
	// centre and axis of the stadium in the frame of the box
	const Vec2 q { dot(d, x), dot(d, y) }, e { dot(at.axis, x), dot(at.axis, y) };
	const Vec2 ends[2]    = { q - s.halfLength * e, q + s.halfLength * e };
	const Vec2 corners[4] = { { -h.x, -h.y }, { h.x, -h.y }, { h.x, h.y }, { -h.x, h.y } };

	// Separating axes: the four faces of the box, then the two sides of the core segment.
	const Vec2 axes[6]    = { { 1, 0 }, { 0, 1 }, { -1, 0 }, { 0, -1 }, perp(e), -perp(e) };
	double     separation = -std::numeric_limits<double>::infinity();
	Vec2       axis;
	bool       face = true;
	for (int k = 0; k < (s.halfLength > 0 ? 6 : 4); ++k) {
		const Vec2   n       = axes[k];
		const double nearest = std::min(dot(ends[0], n), dot(ends[1], n));
		const double along   = nearest - std::abs(h.x * n.x) - std::abs(h.y * n.y);
		// A core parallel to a face gives the same axis up to rounding. The face wins: two points.
		if (along > separation + (k < 4 ? 0 : 1e-12 * (h.x + h.y))) {
			separation = along, axis = n, face = k < 4;
		}
	}

	Facing facing[6];
	int    count = 0;
	for (Vec2 end : ends) {
		Vec2 foot { std::clamp(end.x, -h.x, h.x), std::clamp(end.y, -h.y, h.y) };
		if (separation <= 0) { // core within the box: pushed out through the nearest face
			if (!face) break;
			const double depth = dot(end, axis) - std::abs(h.x * axis.x) - std::abs(h.y * axis.y);
			facing[count++]    = { end - depth * axis, end, axis, depth, true };
		} else {
			const bool faced = (foot.x == end.x) != (foot.y == end.y);
			facing[count++]  = { foot, end, direction(end - foot, axis), norm(end - foot), faced };
		}
		if (s.halfLength == 0) break;
	}
	if (separation <= 0 && !face) { // pushed out along the normal of the core
		const Vec2 corner = *std::max_element(
		        corners, corners + 4, [&](Vec2 a, Vec2 b) { return dot(a, axis) < dot(b, axis); });
		facing[count++] = { corner, corner + separation * axis, axis, separation, true };
	}
	for (Vec2 corner : corners) {
		if (separation <= 0 || s.halfLength == 0) break;
		const double along = dot(corner - q, e), across = cross(e, corner - q);
		if (std::abs(along) > sideReach * s.halfLength) continue;
		const Vec2 normal = -sign(across) * perp(e);
		// the core must be beyond the face on which the corner lies
		if (std::abs(normal.x) > std::abs(normal.y) ? normal.x * corner.x < 0
		                                            : normal.y * corner.y < 0)
			continue;
		facing[count++] = { corner, corner - across * perp(e), normal, std::abs(across), true };
	}
	if (count == 0) return {};
	for (int k = 0; k < count; ++k) { // from the frame of the box to the plane
		const auto toPlane = [&](Vec2 v) { return v.x * x + v.y * y; };
		facing[k].core1    = boxAt.center + toPlane(facing[k].core1);
		facing[k].core2    = boxAt.center + toPlane(facing[k].core2);
		facing[k].normal   = toPlane(facing[k].normal);
	}
	Manifold result = manifold(facing, count, 0, s.capRadius, alertDistance, at.axis);
	result.type     = ContactType::wall;
	return result;
}

} // namespace rcr
