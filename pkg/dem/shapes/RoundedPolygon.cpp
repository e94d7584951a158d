#include "dem/shapes/RoundedPolygon.hpp"

#include "dem/errors/messages.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "kernel/problem/refuse.hpp"

namespace yade {

static std::vector<rcr::Vec2> coreOf(const RoundedPolygon& polygon)
{
	std::vector<rcr::Vec2> core;
	for (const Vector2r& v : polygon.vertices)
		core.push_back({ double(v[0]), double(v[1]) });
	return core;
}

std::string RoundedPolygon::attributeError() const
{
	const std::vector<rcr::Vec2> core  = coreOf(*this);
	std::string                  error = rcr::polygonError(core, double(radius));
	if (error.empty()) {
		const rcr::Vec2 centroid = rcr::momentsOf(core, double(radius)).centroid;
		double          size     = 0; // circumscribed radius of the core
		for (const rcr::Vec2 v : core)
			size = std::max(size, norm(v));
		if (norm(centroid) <= 1e-6 * (size + double(radius))) return {};
		error = "the vertices have their centroid at (" + errors::text(centroid.x) + ", "
		        + errors::text(centroid.y) + "); expected (0, 0), the centre of mass";
	}
	return error + ". rcr.polygon(center, vertices, radius) makes a body from any corners.";
}

void RoundedPolygon::postLoad(RoundedPolygon&)
{
	planar = {};
	if (vertices.empty()) return; // as constructed
	const std::string error = attributeError();
	if (!error.empty()) rcr::refuse("RoundedPolygon: ", error);
	planar.kind     = rcr::PlanarShape::polygon;
	planar.rounding = double(radius);
	rcr::setCore(planar, coreOf(*this));
}

} // namespace yade
