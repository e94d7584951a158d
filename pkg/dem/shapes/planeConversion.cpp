#include "dem/shapes/planeConversion.hpp"

#include "dem/shapes/RoundedPolygon.hpp"

namespace yade::plane {

using Planar = rcr::PlanarShape;

/// Segment in which a facet cuts the plane; kind none if it does not cut it.
static Planar cut(const Facet& facet, const State& state, Real z)
{
	rcr::Vec2 ends[2];
	int       count = 0;
	for (int k = 0; k < 3; ++k) {
		const Vector3r a   = state.ori * facet.vertices[k],
		               b   = state.ori * facet.vertices[(k + 1) % 3];
		const double above = double(state.pos.z() + a.z() - z),
		             below = double(state.pos.z() + b.z() - z);
		if (above == below || above * below > 0) continue;
		const double    t  = above / (above - below);
		const rcr::Vec2 at = (1 - t) * toPlane(a) + t * toPlane(b);
		if (count == 0) ends[count++] = at;
		else if (count == 1 || norm(at - ends[0]) > norm(ends[1] - ends[0]))
			ends[1] = at, count = 2;
	}
	if (count < 2 || !(norm(ends[1] - ends[0]) > 0)) return {};
	Planar segment;
	segment.kind = Planar::segment;
	setCore(segment, { ends[0], ends[1] });
	return segment;
}

rcr::PlanarShape shapeOf(const Shape& shape, const State& state, Real z)
{
	const int index = shape.getClassIndex();
	Planar    planar;
	if (index == Rcr::getClassIndexStatic()) {
		const Rcr& rcr = static_cast<const Rcr&>(shape);
		planar.kind = Planar::stadium;
		planar.halfLength = double(rcr.halfLength), planar.rounding = double(rcr.capRadius);
	} else if (index == Sphere::getClassIndexStatic()) {
		planar.kind     = Planar::disc;
		planar.rounding = double(static_cast<const Sphere&>(shape).radius);
	} else if (index == RoundedPolygon::getClassIndexStatic()) {
		planar = static_cast<const RoundedPolygon&>(shape).planar;
	} else if (index == Wall::getClassIndexStatic()) {
		const Wall& wall = static_cast<const Wall&>(shape);
		planar.kind      = wall.axis < 2 ? Planar::wall : Planar::none;
		planar.axis = std::int8_t(wall.axis), planar.sense = std::int8_t(wall.sense);
	} else if (index == Box::getClassIndexStatic()) {
		planar = rcr::boxShape(toPlane(static_cast<const Box&>(shape).extents));
	} else if (index == Facet::getClassIndexStatic()) {
		planar = cut(static_cast<const Facet&>(shape), state, z);
	}
	return planar;
}

Matrix3r nextGradient(const Cell& cell)
{
	return cell.velGradChanged || cell.nextVelGrad != Matrix3r::Zero() ? cell.nextVelGrad
	                                                                   : cell.velGrad;
}

Vector3i cellsOf(const Cell& cell, rcr::Vec2 v)
{
	const rcr::Vec2 numbers = rcr::latticeVector(flowOf(cell.hSize).gradient, v);
	return { int(numbers.x), int(numbers.y), 0 };
}

rcr::PeriodicCell cellOf(const Scene& scene)
{
	rcr::PeriodicCell cell;
	if (!scene.isPeriodic) return cell;
	cell.periodic           = true;
	const Matrix3r& h       = scene.cell->hSize;
	const Matrix3r gradient = nextGradient(*scene.cell);
	for (int i = 0; i < 2; ++i)
		for (int j = 0; j < 2; ++j)
			cell.h[i][j] = double(h(i, j)), cell.gradient[i][j] = double(gradient(i, j));
	const double determinant = cell.h[0][0] * cell.h[1][1] - cell.h[0][1] * cell.h[1][0];
	cell.inverse[0][0]       = cell.h[1][1] / determinant,
	cell.inverse[0][1]       = -cell.h[0][1] / determinant;
	cell.inverse[1][0]       = -cell.h[1][0] / determinant,
	cell.inverse[1][1]       = cell.h[0][0] / determinant;
	cell.imageSpeed          = cell.largestDrift();
	return cell;
}

} // namespace yade::plane
