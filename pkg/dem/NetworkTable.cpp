#include "NetworkTable.hpp"

#include <core/Interaction.hpp>
#include <core/Scene.hpp>

#include "CdPhys.hpp"
#include "Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "Rcr.hpp"
#include "RcrGeom.hpp"
#include "plane.hpp"

namespace yade {

namespace {

	rcr::Vec2 placeOfForces(const Body& b, const Scene& scene) { return plane::toPlane(b.state->pos - scene.dt * b.state->vel); }

	template <class Phys> NetworkTable::Pair row(const Interaction& i, const Phys& phys, const Scene& scene)
	{
		const RcrGeom& geom    = static_cast<const RcrGeom&>(*i.geom);
		const Body&    first   = *(*scene.bodies)[i.getId1()];
		const Body&    second  = *(*scene.bodies)[i.getId2()];
		const bool     wall    = !dynamic_cast<const Rcr*>(first.shape.get());
		const double   weight1 = double(phys.force1[0]), weight2 = geom.points > 1 ? double(phys.force2[0]) : 0;
		const rcr::Vec2 point  = 1 / (weight1 + weight2)
		        * (weight1 * rcr::Vec2 { double(geom.position1[0]), double(geom.position1[1]) }
		           + weight2 * rcr::Vec2 { double(geom.position2[0]), double(geom.position2[1]) });
		const double    sign   = wall ? -1 : 1;
		const rcr::Vec2 force  = sign * plane::toPlane(phys.normalForce + phys.shearForce);
		const rcr::Vec2 normal = sign * plane::toPlane(phys.normalForce.normalized());
		const rcr::Vec2 branch = wall ? point - placeOfForces(second, scene) : placeOfForces(second, scene) - placeOfForces(first, scene);
		const auto      ids    = wall ? std::make_pair(i.getId2(), i.getId1()) : std::make_pair(i.getId1(), i.getId2());
		return { { ids.first, ids.second, geom.type, geom.points }, { normal.x, normal.y, branch.x, branch.y, force.x, force.y, point.x, point.y } };
	}

} // namespace

NetworkTable networkTable(const Scene& scene)
{
	NetworkTable table;
	for (const auto& i : *scene.interactions) {
		if (!i->isReal() || !dynamic_cast<const RcrGeom*>(i->geom.get())) continue;
		const auto add = [&](const auto* phys) {
			if (phys && phys->normalForce.squaredNorm() > 0) table.pairs.push_back(row(*i, *phys, scene));
		};
		add(dynamic_cast<const CdPhys*>(i->phys.get()));
		add(dynamic_cast<const RcrFrictPhys*>(i->phys.get()));
	}
	for (const auto& b : *scene.bodies) {
		const Rcr* shape = b ? dynamic_cast<const Rcr*>(b->shape.get()) : nullptr;
		if (!shape) continue;
		const rcr::Vec2  at    = placeOfForces(*b, scene);
		const rcr::Twist v     = plane::twist(*b->state);
		const double     angle = 2 * std::atan2(double(b->state->ori.z()), double(b->state->ori.w()));
		table.particles.push_back(
		        { b->getId(),
		          { at.x, at.y, angle, double(shape->halfLength), double(shape->capRadius), double(b->state->mass), v.x, v.y, v.rotation } });
	}
	return table;
}

} // namespace yade
