#include "dem/shapes/RoundedPolygon.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "kernel/problem/refuse.hpp"

namespace yade {

void RoundedPolygon::postLoad(RoundedPolygon&)
{
	planar = {};
	if (vertices.empty()) return; // as constructed
	std::vector<rcr::Vec2> core;
	for (const Vector2r& v : vertices)
		core.push_back({ double(v[0]), double(v[1]) });
	const double      rounding = double(radius);
	const std::string error    = rcr::polygonError(core, rounding);
	const char*       remedy   = " rcr.polygon(center, vertices, radius) makes a body from any corners.";
	if (!error.empty()) rcr::refuse("RoundedPolygon: ", error, '.', remedy);
	rcr::PlanarShape shape;
	shape.kind     = rcr::PlanarShape::polygon;
	shape.rounding = rounding;
	rcr::setCore(shape, core);
	const rcr::Vec2 centroid = rcr::momentsOf(core, rounding).centroid;
	if (norm(centroid) > 1e-6 * shape.radius())
		rcr::refuse("RoundedPolygon.vertices have their centroid at (", centroid.x, ", ", centroid.y,
		        "); expected (0, 0), the centre of mass.", remedy);
	planar = shape;
}

} // namespace yade
