#include "Law2_RcrGeom_CdPhys_SignoriniCoulomb.hpp"

#include "carryForces.hpp"
#include "plane.hpp"

namespace yade {

YADE_PLUGIN((Law2_RcrGeom_CdPhys_SignoriniCoulomb));

namespace {

	double approach(const rcr::ManifoldPoint& at, const State& state1, const State& state2)
	{
		rcr::ContactPoint point;
		point.normal = at.normal;
		point.arm1   = at.position - plane::toPlane(state1.pos);
		point.arm2   = at.position - plane::toPlane(state2.pos);
		return relativeVelocity(point, plane::twist(state1), plane::twist(state2)).n;
	}

	/// b_n of one point. An open gap may close within the step but not more.
	double plasticBias(double gap, double dt) { return gap > 0 ? gap / dt : 0; }

	/// Where a bounce falls into this step, the velocity of approach is returned by the factor e (Newton, Moreau 1999); in a
	/// lasting contact it is zero.
	double elasticBias(double gap, double restitution, double approach, double dt)
	{
		return approach < 0 && gap + dt * approach < 0 ? restitution * approach : plasticBias(gap, dt);
	}

} // namespace

bool Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction* interaction)
{
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	CdPhys&        phys = static_cast<CdPhys&>(*iphys);
	if (geom.points == 0) return false;
	carryForces(geom, phys);

	const double dt = double(scene->dt), restitution = double(phys.restitution);
	if (restitution > 0) {
		const State&        state1   = *Body::byId(interaction->getId1(), scene)->state;
		const State&        state2   = *Body::byId(interaction->getId2(), scene)->state;
		const rcr::Manifold manifold = geom.manifold();
		for (int k = 0; k < manifold.count; ++k)
			phys.bias[k] = elasticBias(manifold.points[k].gap, restitution, approach(manifold.points[k], state1, state2), dt);
	} else {
		for (int k = 0; k < geom.points; ++k)
			phys.bias[k] = plasticBias(double(geom.gap[k]), dt);
	}
	return true;
}

} // namespace yade
