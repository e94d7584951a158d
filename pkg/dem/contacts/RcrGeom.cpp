#include "dem/contacts/RcrGeom.hpp"

#include "dem/contacts/sceneRules.hpp"
#include "dem/shapes/planeConversion.hpp"

namespace yade {

void RcrGeom::set(const rcr::Manifold& m, const rcr::PlanarShape& one, const rcr::Pose& at1,
        const rcr::PlanarShape& two, const rcr::Pose& at2, Real z)
{
	const double r1 = one.circumscribedRadius(), r2 = two.circumscribedRadius();
	refR1  = r1 > 0 ? r1 : r2;
	refR2  = r2;
	points = m.count;
	type   = int(m.type);
	shadow = m.shadow, slide = m.slide, slope = m.slope;
	if (points == 0) return;
	const auto vector = [](rcr::Vec2 v) { return Vector2r(v.x, v.y); };
	for (int k = 0; k < 2; ++k) {
		gap[k]   = m.points[k].gap;
		along[k] = rcr::positionAlong(one, at1, at2, m.points[k]);
	}
	position1 = vector(m.points[0].position), normal1 = vector(m.points[0].normal);
	position2 = vector(m.points[1].position), normal2 = vector(m.points[1].normal);
	const rcr::ManifoldPoint& deepest = m.points[points == 2 && gap[1] < gap[0] ? 1 : 0];
	normal                            = plane::toSpace(deepest.normal);
	contactPoint                      = Vector3r(deepest.position.x, deepest.position.y, z);
}

rcr::Manifold RcrGeom::manifold() const
{
	const auto vector = [](const Vector2r& v) { return rcr::Vec2 { double(v[0]), double(v[1]) }; };
	return { points, rcr::ContactType(type),
		{ { vector(position1), vector(normal1), double(gap[0]) },
		        { vector(position2), vector(normal2), double(gap[1]) } },
		double(shadow), slide, double(slope) };
}

/// An empty manifold creates nothing; where there was a contact, the Law2 erases it.
bool Ig2_Planar_RcrGeom::go(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,
        const State& state1, const State& state2, const Vector3r& shift2, const bool& force,
        const shared_ptr<Interaction>& interaction)
{
	const rcr::PlanarShape one = plane::shapeOf(*shape1, state1, state2.pos.z()),
	                       two = plane::shapeOf(*shape2, state2, state2.pos.z());
	Vector3r shift = shift2;
	if (scene->isPeriodic) { // the collider keeps the image at which it listed the pair
		const rcr::Vec2 way   = plane::toPlane(state1.pos - state2.pos) + one.offset - two.offset;
		interaction->cellDist = plane::cellsOf(*scene->cell, way);
		shift                 = scene->cell->intrShiftPos(interaction->cellDist);
	}
	const rcr::Pose        at1 { plane::toPlane(state1.pos), plane::turnOf(one, state1).axis() },
	        at2 { plane::toPlane(state2.pos) + plane::toPlane(shift),
		        plane::turnOf(two, state2).axis() };
	rcr::Manifold manifold;
	if (rcr::canTouch(one.kind, two.kind)) {
		const bool   image = shift != Vector3r::Zero();
		const double speed = image ? plane::cellOf(*scene).imageSpeed : 0, dt = double(scene->dt);
		const auto   alert = [&](const rcr::PlanarShape& shape, const State& s) {
			return rcr::alertDistance(shape, plane::velocityOf(s), dt)
			        + (image ? rcr::imageReach(shape, speed, dt) : 0);
		};
		const double maxGap = force ? std::numeric_limits<double>::max()
		                            : alert(one, state1) + alert(two, state2);
		manifold            = rcr::contactPoints(one, at1, two, at2, maxGap);
	}
	if (!interaction->geom) {
		if (manifold.count == 0 || !validation::acceptContact(*interaction, *scene)) return false;
		interaction->geom = boost::make_shared<RcrGeom>();
	}
	static_cast<RcrGeom&>(*interaction->geom).set(manifold, one, at1, two, at2, state2.pos.z());
	return true;
}

} // namespace yade
