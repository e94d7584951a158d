#include "geometry/shadow_overlap.hpp"

#include <limits>

namespace rcr {

namespace {

	/// An end faces a side up to this multiple of the half length [-]. The excess of 1e-9 covers
	/// rounding: equal bodies that lie flush on each other need their second point.
	constexpr double sideReach = 1 + 1e-9;

	/// A point of core 1 that faces a point of core 2.
	struct Facing {
		Vec2   core1, core2;
		Vec2   normal;       // unit, from body 1 to body 2
		double distance = 0; // of the points, along the normal
		int    side     = 0; // body on whose side one of the points lies; 0: both are ends
	};

	/// Unit vector along `delta`, or `fallback` if delta is 0.
	Vec2 direction(Vec2 delta, Vec2 fallback)
	{
		const double length = norm(delta);
		return length > 0 ? (1 / length) * delta : fallback;
	}

	double sign(double x) { return x < 0 ? -1 : 1; }

	/// Projects `end` of a core onto the segment of half length a about `center`. The normal of a
	/// side points from the segment to the end; if the end lies on the segment, to the side of
	/// `away`. The normal of two ends is left to the caller.
	Facing project(Vec2 end, Vec2 center, Vec2 axis, double a, Vec2 away)
	{
		const Vec2   q = end - center;
		const double s = dot(q, axis);
		if (a > 0 && std::abs(s) <= sideReach * a) {
			const double h = cross(axis, q);
			const Vec2   n = sign(h != 0 ? h : cross(axis, away)) * perp(axis);
			return { center + s * axis, end, n, std::abs(h), 1 };
		}
		const Vec2 foot = center + (s < 0 ? -a : a) * axis;
		return { foot, end, {}, norm(end - foot), 0 };
	}

	Facing swapped(const Facing& f)
	{
		return { f.core2, f.core1, -f.normal, f.distance, f.side == 0 ? 0 : 3 - f.side };
	}

	ManifoldPoint manifoldPoint(const Facing& f, double radius1, double radius2)
	{
		const Vec2 surface1 = f.core1 + radius1 * f.normal, surface2 = f.core2 - radius2 * f.normal;
		return { 0.5 * (surface1 + surface2), f.normal, f.distance - radius1 - radius2 };
	}

	const Facing& closestOf(const Facing* facing, int count)
	{
		return *std::min_element(facing, facing + count,
		        [](const Facing& a, const Facing& b) { return a.distance < b.distance; });
	}

	/// Length of the shadow along the side of the second point, and how it slides. Seen from the body
	/// of that side, an end of the other body moves along it.
	void setShadow(Manifold& result, const Facing& first, const Facing& second)
	{
		const bool   ofOne = second.side == 1;
		const Vec2   from  = ofOne ? first.core1 : first.core2,
		             end   = ofOne ? second.core1 : second.core2;
		const double along = dot(end - from, perp(second.normal));
		result.shadow      = std::abs(along);
		if (first.side != second.side) // else `from` moves with `end`
			result.slide = (along > 0) == ofOne ? 1 : -1;
	}

	/// The closest pair of facing points, and the farthest one from it along a side with a gap up
	/// to `maxGap`.
	Manifold manifold(const Facing* facing, int count, const Facing& closest, double radius1,
	        double radius2, double maxGap, Vec2 axis)
	{
		Manifold result;
		if (!(closest.distance - radius1 - radius2 <= maxGap)) return result;
		result.points[0] = manifoldPoint(closest, radius1, radius2);
		result.count     = 1;
		result.type      = closest.side ? ContactType::capSide : ContactType::capCap;

		const ManifoldPoint& first  = result.points[0];
		const Facing*        second = nullptr;
		double farthest = 1e-9 * (radius1 + radius2); // closer points are the same point
		for (int k = 0; k < count; ++k) {
			if (!facing[k].side || dot(facing[k].normal, first.normal) <= 0) continue;
			const ManifoldPoint other    = manifoldPoint(facing[k], radius1, radius2);
			const double        distance = norm(other.position - first.position);
			if (other.gap > maxGap || distance <= farthest) continue;
			farthest         = distance;
			result.points[1] = other;
			result.count     = 2;
			result.type      = ContactType::sideSide;
			second           = &facing[k];
		}
		if (second) setShadow(result, closest, *second);
		result.sortAlong(axis);
		return result;
	}

} // namespace

Manifold shadowOverlap(const Stadium& s1, const Pose& at1, const Stadium& s2, const Pose& at2,
        double maxGap)
{
	if (!mayTouch(s1, at1, s2, at2, maxGap)) return {};
	const Vec2 d = at2.center - at1.center;
	const Vec2 core1 = s1.halfLength * at1.axis, core2 = s2.halfLength * at2.axis;
	Facing     facing[4] = {
		    project(at2.center - core2, at1.center, at1.axis, s1.halfLength, d),
		    project(at2.center + core2, at1.center, at1.axis, s1.halfLength, d),
		    swapped(project(at1.center - core1, at2.center, at2.axis, s2.halfLength, -d)),
		    swapped(project(at1.center + core1, at2.center, at2.axis, s2.halfLength, -d)),
	};
	// The ends of each core lie strictly on both sides of the other. Rounding decides the sides of
	// collinear cores, so along1 is tested too.
	const CoreGaps gaps = coreGaps(s1, at1, s2, at2);
	if (gaps.across1 < 0 && gaps.across2 < 0 && gaps.along1 < 0) {
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
			const Facing back { end - h * side, end, -sign(h) * side, -std::abs(h), 1 };
			least = k < 2 ? back : swapped(back);
		}
		return manifold(nullptr, 0, least, s1.capRadius, s2.capRadius, maxGap, at1.axis);
	}
	Facing closest = closestOf(facing, 4);
	if (!closest.side)
		closest.normal = direction(closest.core2 - closest.core1, direction(d, perp(at1.axis)));
	return manifold(facing, 4, closest, s1.capRadius, s2.capRadius, maxGap, at1.axis);
}

Manifold shadowOverlap(const HalfPlane& wall, const Stadium& s, const Pose& at, double maxGap)
{
	Manifold result;
	result.type = ContactType::obstacle;
	for (double end : { -s.halfLength, s.halfLength }) {
		const Vec2   core = at.center + end * at.axis;
		const double gap  = dot(core - wall.origin, wall.normal) - s.capRadius;
		if (gap <= maxGap)
			result.points[result.count++]
			        = { core - (s.capRadius + gap / 2) * wall.normal, wall.normal, gap };
		if (s.halfLength == 0) break;
	}
	if (result.count == 2)
		result.shadow = 2 * s.halfLength * std::abs(cross(wall.normal, at.axis));
	return result;
}

} // namespace rcr
