#include "geometry/planar_shape.hpp"

#include "geometry/polygon_overlap.hpp"

namespace rcr {

static Stadium stadiumOf(const PlanarShape& s) { return { s.halfLength, s.rounding }; }

static Core coreOf(const PlanarShape& s, const Pose& body, Vec2 origin)
{
	return s.core ? coreOf(*s.core, s.rounding, body, origin)
	              : coreOf(stadiumOf(s), corePose(s, body), origin);
}

PlanarMoments momentsOf(const PlanarShape& s) { return momentsOf(coreVertices(s, {}), s.rounding); }

void setCore(PlanarShape& shape, const std::vector<Vec2>& vertices)
{
	shape.core.reset();
	if (vertices.size() > 2) {
		shape.core       = std::make_shared<const ConvexPolygon>(vertices);
		shape.halfLength = 0;
		return;
	}
	const Vec2 way   = 0.5 * (vertices.back() - vertices.front());
	shape.halfLength = norm(way);
	shape.offset     = 0.5 * (vertices.front() + vertices.back());
	shape.direction  = shape.halfLength > 0
	        ? Vec2 { way.x / shape.halfLength, way.y / shape.halfLength } : Vec2 { 1, 0 };
}

PlanarShape boxShape(Vec2 half)
{
	PlanarShape shape;
	shape.kind = PlanarShape::box;
	if (half.x > 0 && half.y > 0)
		setCore(shape, { half, { -half.x, half.y }, -half, { half.x, -half.y } });
	else
		setCore(shape, { -half, half }); // without thickness
	return shape;
}

PlanarShape stadiumShape(double halfLength, double rounding)
{
	PlanarShape shape;
	shape.kind       = halfLength > 0 ? PlanarShape::stadium : PlanarShape::disc;
	shape.halfLength = halfLength, shape.rounding = rounding;
	return shape;
}

std::vector<Vec2> coreVertices(const PlanarShape& shape, const Pose& body)
{
	if (shape.kind == PlanarShape::none || shape.kind == PlanarShape::wall) return {};
	const Core        core = coreOf(shape, body, {});
	std::vector<Vec2> vertices;
	for (int k = 0; k < core.count; ++k)
		vertices.push_back(core.vertex(k));
	return vertices;
}

BoundingBox boundsOf(const std::vector<Vec2>& points)
{
	Vec2 low = points.front(), high = low;
	for (const Vec2 v : points) {
		low  = { std::min(low.x, v.x), std::min(low.y, v.y) };
		high = { std::max(high.x, v.x), std::max(high.y, v.y) };
	}
	return { 0.5 * (low + high), 0.5 * (high - low) };
}

BoundingBox boundsOf(const PlanarShape& s, const Pose& body)
{
	constexpr double infinite = std::numeric_limits<double>::infinity();
	if (s.kind == PlanarShape::wall)
		return { body.center, s.axis == 0 ? Vec2 { 0, infinite } : Vec2 { infinite, 0 } };
	if (!s.core) {
		const Pose at = corePose(s, body);
		return { at.center, halfExtent(stadiumOf(s), at.axis) };
	}
	const auto [center, half] = boundsOf(coreVertices(s, body));
	return { center, half + Vec2 { s.rounding, s.rounding } };
}

static Manifold wallContact(const PlanarShape& wall, Vec2 origin, const PlanarShape& grain,
        const Pose& at, double maxGap)
{
	const double ahead  = wall.axis == 0 ? at.center.x - origin.x : at.center.y - origin.y;
	// a one-sided wall does not bear grains far behind it; the margin is for rounding
	if (std::abs(ahead) > 1.000001 * (grain.radius() + maxGap)) return {};
	const double    side = wall.sense != 0 ? wall.sense : ahead < 0 ? -1 : 1;
	const HalfPlane plane { origin, wall.axis == 0 ? Vec2 { side, 0 } : Vec2 { 0, side } };
	if (grain.core) return polygonOverlap(plane, coreOf(grain, at, {}), maxGap);
	return shadowOverlap(plane, stadiumOf(grain), corePose(grain, at), maxGap);
}

/// The manifold of both shapes, as of two grains.
static Manifold manifoldOf(const PlanarShape& one, const Pose& at1, const PlanarShape& two,
        const Pose& at2, double maxGap)
{
	if (one.kind == PlanarShape::wall) return wallContact(one, at1.center, two, at2, maxGap);
	if (!one.core && !two.core)
		return shadowOverlap(
		        stadiumOf(one), corePose(one, at1), stadiumOf(two), corePose(two, at2), maxGap);
	const Vec2 origin = at1.center; // coordinates of the order of the bodies
	Manifold   result
	        = polygonOverlap(coreOf(one, at1, origin), coreOf(two, at2, origin), maxGap);
	for (ManifoldPoint& point : result.points)
		point.position = origin + point.position;
	return result;
}

Manifold contactPoints(const PlanarShape& one, const Pose& at1, const PlanarShape& two,
        const Pose& at2, double maxGap)
{
	Manifold result = manifoldOf(one, at1, two, at2, maxGap);
	if (!one.grain()) {
		result.type = ContactType::obstacle;
		if (!two.core) result.sortAlong(corePose(two, at2).axis);
	}
	return result;
}

} // namespace rcr
