#include "geometry/polygon_overlap.hpp"

#include <limits>

namespace rcr {

namespace {

	constexpr double infinity = std::numeric_limits<double>::infinity();
	constexpr double rounding = 1e-9; // relative tolerance of coordinates

	int next(const Core& c, int k) { return k + 1 < c.count ? k + 1 : 0; }
	int previous(const Core& c, int k) { return k > 0 ? k - 1 : c.count - 1; }

	/// A side of a core and the vertex of the other core that is nearest along its normal.
	struct Face {
		double distance = -infinity; // of the vertex from the line of the side
		int    side = 0, vertex = 0;
		bool   ofOne = true; // the side belongs to core 1
	};

	/// Place of the foot of a vertex along a side, from its first vertex.
	double footAlong(const Core& c, int side, Vec2 vertex)
	{
		return dot(vertex - c.vertex(side), c.along(side));
	}

	bool onSide(const Core& c, int side, Vec2 vertex)
	{
		const double foot = footAlong(c, side, vertex), reach = rounding * c.length[side];
		return foot >= -reach && foot <= c.length[side] + reach;
	}

	/// The side of `c` from which the other core is farthest, if that is farther than `best`.
	/// Returns false if its distance exceeds `most`, which no distance of the cores then undercuts.
	bool findFace(const Core& c, const Core& other, bool ofOne, double most, Face& best)
	{
		if (c.count < 2) return true;
		int vertex = 0; // the nearest to the side; it moves on counter-clockwise with the normal
		for (int side = 0; side < c.count; ++side) {
			const Vec2 normal = outward(c.along(side));
			const auto height = [&](int k) { return dot(other.vertex(k), normal); };
			double     nearest = height(vertex);
			if (side == 0)
				for (int k = 1; k < other.count; ++k)
					if (const double h = height(k); h < nearest) nearest = h, vertex = k;
			for (int steps = 1; steps < other.count; ++steps) {
				const double h = height(next(other, vertex));
				if (h > nearest) break;
				nearest = h, vertex = next(other, vertex);
			}
			const double distance = nearest - dot(c.vertex(side), normal);
			if (distance > most) return false;
			if (distance > best.distance) best = { distance, side, vertex, ofOne };
		}
		return true;
	}

	/// Of two parallel sides, selects an end of one that lies on the other. Returns false if the
	/// vertex of the face lies beside its side.
	bool settle(const Core& one, const Core& two, Face& face)
	{
		const Core &c = face.ofOne ? one : two, &other = face.ofOne ? two : one;
		if (onSide(c, face.side, other.vertex(face.vertex))) return true;
		const Vec2   normal = outward(c.along(face.side));
		const double level  = dot(c.vertex(face.side), normal);
		for (int side : { face.vertex, previous(other, face.vertex) }) {
			if (other.count < 2 || dot(other.along(side), c.along(face.side)) > 0) continue;
			const int    k     = side == face.vertex ? next(other, side) : side; // its other end
			const double reach = rounding * std::max(c.length[face.side], other.length[side]);
			if (dot(other.vertex(k), normal) - level > face.distance + reach) continue;
			if (onSide(c, face.side, other.vertex(k))) {
				face.vertex = k;
				return true;
			}
			for (int end : { face.side, next(c, face.side) })
				if (onSide(other, side, c.vertex(end))) {
					face = { face.distance, side, end, !face.ofOne };
					return true;
				}
		}
		return false;
	}

	/// The closest points of two cores.
	struct Closest {
		Vec2   point1, point2, normal; // from core 1 to core 2
		double distance;               // along the normal; negative: overlap
		// end of the outline from the point in the direction of the tangent, [0], and against it
		Vec2 end1[2], end2[2];
		int side = 0; // core on whose side one of the points lies; 0: both are vertices
	};

	/// Ends of the two sides at a vertex: along the tangent counter-clockwise around the core first.
	void endsOfVertex(const Core& c, int vertex, Vec2 (&ends)[2])
	{
		ends[0] = c.vertex(next(c, vertex)), ends[1] = c.vertex(previous(c, vertex));
	}

	Closest closestOf(const Core& one, const Core& two, const Face& face)
	{
		const Core  &c = face.ofOne ? one : two, &other = face.ofOne ? two : one;
		const Vec2   normal = outward(c.along(face.side)), vertex = other.vertex(face.vertex);
		Closest      found;
		found.distance = face.distance, found.side = face.ofOne ? 1 : 2;
		found.normal   = face.ofOne ? normal : -normal;
		(face.ofOne ? found.point1 : found.point2) = vertex - face.distance * normal;
		(face.ofOne ? found.point2 : found.point1) = vertex;
		Vec2(&ends)[2]      = face.ofOne ? found.end1 : found.end2;
		Vec2(&otherEnds)[2] = face.ofOne ? found.end2 : found.end1;
		ends[0] = c.vertex(next(c, face.side)), ends[1] = c.vertex(face.side);
		endsOfVertex(other, face.vertex, otherEnds);
		std::swap(found.end2[0], found.end2[1]); // core 2 lies on the other side of the tangent
		return found;
	}

	Closest closestVertices(const Core& one, const Core& two)
	{
		double least = infinity;
		int    i = 0, j = 0;
		for (int k = 0; k < one.count; ++k)
			for (int l = 0; l < two.count; ++l) {
				const Vec2   between = two.vertex(l) - one.vertex(k);
				const double squared = dot(between, between);
				if (squared < least) least = squared, i = k, j = l;
			}
		Closest found;
		found.point1 = one.vertex(i), found.point2 = two.vertex(j);
		found.distance = std::sqrt(least);
		found.normal   = 1 / found.distance * (found.point2 - found.point1);
		endsOfVertex(one, i, found.end1), endsOfVertex(two, j, found.end2);
		std::swap(found.end2[0], found.end2[1]);
		return found;
	}

	/// End of the shadow in one direction from the closest points.
	struct ShadowEnd {
		double length = 0; // of the shadow; 0: none
		Vec2   point1, point2;
		double distance = 0; // along the normal of the closest points
		// changes per tangential displacement of core 2
		int    slide = 0; // of the length
		double slope = 0; // of the distance
	};

	ShadowEnd shadowEnd(const Closest& from, int direction)
	{
		const Vec2   tangent = (direction == 0 ? 1 : -1) * perp(from.normal);
		const Vec2   way1 = from.end1[direction] - from.point1, way2 = from.end2[direction] - from.point2;
		const double reach1 = dot(way1, tangent), reach2 = dot(way2, tangent);
		if (!(reach1 > 0 && reach2 > 0)) return {};
		ShadowEnd end;
		end.length   = std::min(reach1, reach2);
		end.point1   = from.point1 + end.length / reach1 * way1;
		end.point2   = from.point2 + end.length / reach2 * way2;
		end.distance = dot(end.point2 - end.point1, from.normal);
		// a vertex of the core that ends first moves along a side of the other one
		const int side     = reach2 <= (1 + rounding) * reach1 ? 1 : 2,
		          sign     = direction == 0 ? 1 : -1;
		const double reach = side == 1 ? reach1 : reach2;
		if (from.side != side) end.slide = side == 1 ? sign : -sign;
		end.slope = -sign * dot(side == 1 ? way1 : way2, from.normal) / reach;
		return end;
	}

	ManifoldPoint pointBetween(Vec2 core1, Vec2 core2, Vec2 normal, double distance, double radius1,
	        double radius2)
	{
		const Vec2 surface1 = core1 + radius1 * normal, surface2 = core2 - radius2 * normal;
		return { 0.5 * (surface1 + surface2), normal, distance - radius1 - radius2 };
	}

	Manifold manifoldOf(const Closest& closest, double radius1, double radius2, double maxGap)
	{
		Manifold     result;
		const double radii = radius1 + radius2;
		if (!(closest.distance - radii <= maxGap)) return result;
		result.count     = 1;
		result.type      = closest.side ? ContactType::capSide : ContactType::capCap;
		result.points[0] = pointBetween(closest.point1, closest.point2, closest.normal,
		        closest.distance, radius1, radius2);
		double flattest  = infinity; // opening of the gap per length
		for (int direction = 0; direction < 2; ++direction) {
			const ShadowEnd end  = shadowEnd(closest, direction);
			const double    size = norm(closest.end1[direction] - closest.point1) + radii;
			if (!(end.length > rounding * size) || end.distance - radii > maxGap) continue;
			const double opening = (end.distance - closest.distance) / end.length;
			if (!(opening < flattest)) continue;
			flattest         = opening;
			result.points[1] = pointBetween(
			        end.point1, end.point2, closest.normal, end.distance, radius1, radius2);
			result.count     = 2;
			result.type      = ContactType::sideSide;
			result.shadow    = end.length;
			result.slide     = end.slide;
			result.slope     = end.slope;
		}
		result.sortAlong(perp(closest.normal));
		return result;
	}

} // namespace

Core coreOf(const ConvexPolygon& polygon, double radius, const Pose& at, Vec2 origin)
{
	Core       core;
	const Vec2 center = at.center - origin;
	const auto turned = [&](Vec2 v) { return v.x * at.axis + v.y * perp(at.axis); };
	core.count = int(polygon.vertices.size()), core.rounding = radius;
	for (int k = 0; k < core.count; ++k) {
		core.setVertex(k, center + turned(polygon.vertices[k]));
		core.setSide(k, turned(polygon.along[k]), polygon.length[k]);
	}
	return core;
}

Core coreOf(const Stadium& s, const Pose& at, Vec2 origin)
{
	Core       core;
	const Vec2 center = at.center - origin, half = s.halfLength * at.axis;
	core.count = s.halfLength > 0 ? 2 : 1, core.rounding = s.capRadius;
	core.setVertex(0, center - half), core.setVertex(1, center + half);
	core.setSide(0, at.axis, 2 * s.halfLength), core.setSide(1, -at.axis, 2 * s.halfLength);
	return core;
}

Manifold polygonOverlap(const Core& one, const Core& two, double maxGap)
{
	const double most = one.rounding + two.rounding + maxGap;
	Face         face;
	if (!findFace(one, two, true, most, face) || !findFace(two, one, false, most, face)) return {};
	if (settle(one, two, face) || face.distance <= 0)
		return manifoldOf(closestOf(one, two, face), one.rounding, two.rounding, maxGap);
	const Closest corners = closestVertices(one, two);
	// corners that coincide have no direction
	const double size = std::max(one.length[0], two.length[0]);
	const bool   same = corners.distance <= 1e-12 * size;
	return manifoldOf(same ? closestOf(one, two, face) : corners, one.rounding, two.rounding, maxGap);
}

Manifold polygonOverlap(const HalfPlane& wall, const Core& core, double maxGap)
{
	const auto height = [&](int k) { return dot(core.vertex(k) - wall.origin, wall.normal); };
	int        lowest = 0;
	for (int k = 1; k < core.count; ++k)
		if (height(k) < height(lowest)) lowest = k;
	Closest closest;
	closest.distance = height(lowest), closest.normal = wall.normal, closest.side = 1;
	closest.point2 = core.vertex(lowest);
	closest.point1 = closest.point2 - closest.distance * wall.normal;
	endsOfVertex(core, lowest, closest.end2);
	std::swap(closest.end2[0], closest.end2[1]);
	for (int direction : { 0, 1 }) // beneath the end of the side
		closest.end1[direction] = closest.end2[direction]
		        - dot(closest.end2[direction] - wall.origin, wall.normal) * wall.normal;
	return manifoldOf(closest, 0, core.rounding, maxGap);
}

} // namespace rcr
