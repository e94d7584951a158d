#include "geometry/planar_shape.hpp"

namespace rcr {

static Stadium stadiumOf(const PlanarShape& s) { return { s.halfLength, s.halfWidth }; }

static Manifold wallContact(const PlanarShape& wall, Vec2 origin, const PlanarShape& grain,
        const Pose& at, double maxGap)
{
	const double ahead  = wall.axis == 0 ? at.center.x - origin.x : at.center.y - origin.y;
	// a one-sided wall does not bear grains far behind it; the margin is for rounding
	if (std::abs(ahead) > 1.000001 * (grain.radius() + maxGap)) return {};
	const double side   = wall.sense != 0 ? wall.sense : ahead < 0 ? -1 : 1;
	const Vec2   normal = wall.axis == 0 ? Vec2 { side, 0 } : Vec2 { 0, side };
	return shadowOverlap(HalfPlane { origin, normal }, stadiumOf(grain), at, maxGap);
}

/// A segment is a stadium of cap radius 0.
static Manifold segmentContact(const PlanarShape& segment, const Pose& body,
        const PlanarShape& grain, const Pose& at, double maxGap)
{
	Manifold result = shadowOverlap(stadiumOf(segment), segmentPose(segment, body),
	        stadiumOf(grain), at, maxGap);
	result.sortAlong(at.axis);
	result.type = ContactType::obstacle;
	return result;
}

Manifold contactPoints(const PlanarShape& one, const Pose& at1, const PlanarShape& two,
        const Pose& at2, double maxGap)
{
	switch (one.kind) {
		case PlanarShape::wall: return wallContact(one, at1.center, two, at2, maxGap);
		case PlanarShape::box:
			return shadowOverlap(Rectangle { { one.halfLength, one.halfWidth } }, at1,
			        stadiumOf(two), at2, maxGap);
		case PlanarShape::segment: return segmentContact(one, at1, two, at2, maxGap);
		case PlanarShape::none:
		case PlanarShape::disc:
		case PlanarShape::stadium: break;
	}
	return shadowOverlap(stadiumOf(one), at1, stadiumOf(two), at2, maxGap);
}

} // namespace rcr
