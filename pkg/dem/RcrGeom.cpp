#include "RcrGeom.hpp"

#include "AlertDistance.hpp"
#include "MissingFunctor.hpp"
#include "prefetch.hpp"
#include "refuseLater.hpp"

namespace yade {

YADE_PLUGIN((RcrGeom)(Ig2_Rcr_Rcr_RcrGeom)(Ig2_Wall_Rcr_RcrGeom)(Ig2_Sphere_Rcr_RcrGeom)(Ig2_Box_Rcr_RcrGeom));

namespace {

	constexpr double anywhere = std::numeric_limits<double>::max(); // the reach of an interaction that is forced

	double alert(const Rcr& particle, const State& state, double dt)
	{
		return alertDistance(particle, plane::twist(state), dt);
	}

	/// Stores a manifold in the interaction. An empty one creates nothing; where there was a contact, the Law2 erases it.
	bool
	store(const rcr::Manifold& manifold, const rcr::Pose& at, Real radius1, Real radius2, const shared_ptr<Interaction>& interaction, const Scene& scene)
	{
		if (!interaction->geom) {
			if (manifold.count == 0) return false;
			const std::string missing = missingFunctor(scene);
			if (!missing.empty()) {
				if (!livingEngine<ContactDynamics>(scene)) refuseLater(missing);
				return false;
			}
			interaction->geom = boost::make_shared<RcrGeom>();
		}
		RcrGeom& geom = static_cast<RcrGeom&>(*interaction->geom);
		geom.refR1    = radius1;
		geom.refR2    = radius2;
		geom.set(manifold, at.center, at.axis);
		return true;
	}

} // namespace

void RcrGeom::set(const rcr::Manifold& m, rcr::Vec2 center, rcr::Vec2 axis)
{
	points = m.count;
	type   = int(m.type);
	if (points == 0) return;
	const auto vector = [](rcr::Vec2 v) { return Vector2r(v.x, v.y); };
	for (int k = 0; k < 2; ++k) {
		gap[k]   = m.points[k].gap;
		along[k] = dot(m.points[k].position - center, axis);
	}
	position1 = vector(m.points[0].position), normal1 = vector(m.points[0].normal);
	position2 = vector(m.points[1].position), normal2 = vector(m.points[1].normal);
	const rcr::ManifoldPoint& deepest = m.points[points == 2 && gap[1] < gap[0] ? 1 : 0];
	normal                            = plane::toSpace(deepest.normal);
	contactPoint                      = plane::toSpace(deepest.position);
}

rcr::Manifold RcrGeom::manifold() const
{
	const auto vector = [](const Vector2r& v) { return rcr::Vec2 { double(v[0]), double(v[1]) }; };
	return { points,
		 rcr::ContactType(type),
		 { { vector(position1), vector(normal1), double(gap[0]) }, { vector(position2), vector(normal2), double(gap[1]) } } };
}

bool Ig2_Rcr_Rcr_RcrGeom::go(
        const shared_ptr<Shape>&       shape1,
        const shared_ptr<Shape>&       shape2,
        const State&                   state1,
        const State&                   state2,
        const Vector3r&                shift2,
        const bool&                    force,
        const shared_ptr<Interaction>& interaction)
{
	prefetchPair(*scene, interaction->linIx); // for pairs to come
	const Rcr&    one = static_cast<const Rcr&>(*shape1);
	const Rcr&    two = static_cast<const Rcr&>(*shape2);
	rcr::Pose     at1 = plane::pose(state1), at2 = plane::pose(state2);
	const double  dt    = double(scene->dt);
	const double  reach = force ? anywhere : alert(one, state1, dt) + alert(two, state2, dt);
	at2.center          = at2.center + plane::toPlane(shift2);
	return store(
	        rcr::shadowOverlap(one.stadium(), at1, two.stadium(), at2, reach),
	        at1,
	        one.circumscribedRadius(),
	        two.circumscribedRadius(),
	        interaction,
	        *scene);
}

bool Ig2_Wall_Rcr_RcrGeom::go(
        const shared_ptr<Shape>&       shape1,
        const shared_ptr<Shape>&       shape2,
        const State&                   state1,
        const State&                   state2,
        const Vector3r&                shift2,
        const bool&                    force,
        const shared_ptr<Interaction>& interaction)
{
	const Wall& wall     = static_cast<const Wall&>(*shape1);
	const Rcr&  particle = static_cast<const Rcr&>(*shape2);
	if (wall.axis > 1) return store({}, {}, 0, 0, interaction, *scene); // parallel to the plane: never met
	rcr::Pose at           = plane::pose(state2);
	at.center              = at.center + plane::toPlane(shift2);
	const rcr::Vec2 origin = plane::toPlane(state1.pos);
	const double    ahead  = wall.axis == 0 ? at.center.x - origin.x : at.center.y - origin.y;
	const double    side   = wall.sense != 0 ? wall.sense : ahead < 0 ? -1 : 1;
	const rcr::Vec2 normal = wall.axis == 0 ? rcr::Vec2 { side, 0 } : rcr::Vec2 { 0, side };
	const double    R      = particle.circumscribedRadius();
	const double    speed  = wall.axis == 0 ? double(state1.vel[0]) : double(state1.vel[1]);
	const double    reach  = force ? anywhere : alert(particle, state2, double(scene->dt)) + 2 * double(scene->dt) * std::abs(speed);
	return store(rcr::shadowOverlap(rcr::HalfPlane { origin, normal }, particle.stadium(), at, reach), at, R, R, interaction, *scene);
}

bool Ig2_Sphere_Rcr_RcrGeom::go(
        const shared_ptr<Shape>&       shape1,
        const shared_ptr<Shape>&       shape2,
        const State&                   state1,
        const State&                   state2,
        const Vector3r&                shift2,
        const bool&                    force,
        const shared_ptr<Interaction>& interaction)
{
	const double radius   = double(static_cast<const Sphere&>(*shape1).radius);
	const Rcr&   particle = static_cast<const Rcr&>(*shape2);
	rcr::Pose    at1 = plane::pose(state1), at2 = plane::pose(state2);
	at2.center          = at2.center + plane::toPlane(shift2);
	const double dt     = double(scene->dt);
	const double reach  = force ? anywhere : alert(particle, state2, dt) + 2 * dt * plane::speed(plane::twist(state1), radius);
	const auto   result = rcr::shadowOverlap(rcr::Stadium { 0, radius }, at1, particle.stadium(), at2, reach);
	return store(result, at2, radius, particle.circumscribedRadius(), interaction, *scene);
}

bool Ig2_Box_Rcr_RcrGeom::go(
        const shared_ptr<Shape>&       shape1,
        const shared_ptr<Shape>&       shape2,
        const State&                   state1,
        const State&                   state2,
        const Vector3r&                shift2,
        const bool&                    force,
        const shared_ptr<Interaction>& interaction)
{
	const rcr::Rectangle box { plane::toPlane(static_cast<const Box&>(*shape1).extents) };
	const Rcr&           particle = static_cast<const Rcr&>(*shape2);
	rcr::Pose            at1 = plane::pose(state1), at2 = plane::pose(state2);
	at2.center         = at2.center + plane::toPlane(shift2);
	const double R     = particle.circumscribedRadius();
	const double speed = plane::speed(plane::twist(state1), norm(box.halfExtent));
	const double reach = force ? anywhere : alert(particle, state2, double(scene->dt)) + 2 * double(scene->dt) * speed;
	return store(rcr::shadowOverlap(box, at1, particle.stadium(), at2, reach), at2, R, R, interaction, *scene);
}

} // namespace yade
