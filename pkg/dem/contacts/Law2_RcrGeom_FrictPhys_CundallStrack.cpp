#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"

#include "dem/errors/deferredError.hpp"
#include "dem/errors/messages.hpp"
#include "kernel/problem/coulomb.hpp"

namespace yade {

CREATE_LOGGER(Law2_RcrGeom_FrictPhys_CundallStrack);

RcrFrictPhys::RcrFrictPhys(const FrictPhys& yadePhys) : RcrFrictPhys()
{
	FrictPhys::operator=(yadePhys);
}

void Law2_RcrGeom_FrictPhys_CundallStrack::postLoad(Law2_RcrGeom_FrictPhys_CundallStrack&)
{
	if (!(damping >= 0 && math::isfinite(damping)))
		rcr::refuse("Law2_RcrGeom_FrictPhys_CundallStrack.damping = ", errors::text(damping),
		        "; expected a fraction of the critical damping, 0 (none) or more.");
	if (!(adhesion >= 0 && math::isfinite(adhesion)))
		rcr::refuse("Law2_RcrGeom_FrictPhys_CundallStrack.adhesion = ", errors::text(adhesion),
		        "; expected a pull of 0 N (none) or more.");
	if (!(rollingFriction >= 0 && math::isfinite(rollingFriction)))
		rcr::refuse("Law2_RcrGeom_FrictPhys_CundallStrack.rollingFriction = ",
		        errors::text(rollingFriction), "; expected a coefficient of 0 (none) or more.");
}

/// Inverse mass of a body or its clump; 0 if its motion is prescribed.
static double inverseMass(Body::id_t id, Scene* scene)
{
	const shared_ptr<Body>& b = Body::byId(id, scene);
	const State& s = *(b->isClumpMember() ? Body::byId(b->clumpId, scene) : b)->state;
	return s.blockedDOFs == State::DOF_ALL || s.mass == 0 ? 0 : 1 / double(s.mass);
}

static std::string physError(const FrictPhys& phys)
{
	const auto number = [](const char* name, Real value) {
		return std::string(name) + " = " + errors::text(value);
	};
	if (dynamic_cast<const CdPhys*>(&phys))
		return "a CdPhys, made for ContactDynamics; use Ip2_FrictMat_FrictMat_FrictPhys, and "
		       "O.interactions.clear() after a change of laws.";
	if (!(phys.kn > 0 && math::isfinite(phys.kn)))
		return number("kn", phys.kn) + "; expected a stiffness > 0: set FrictMat.young, or kn of "
		          "Ip2_FrictMat_FrictMat_FrictPhys.";
	if (!(phys.ks >= 0 && math::isfinite(phys.ks)))
		return number("ks", phys.ks)
		        + "; expected a stiffness ≥ 0: set FrictMat.poisson (ks/kn), or ks of "
		          "Ip2_FrictMat_FrictMat_FrictPhys.";
	if (!(phys.tangensOfFrictionAngle >= 0))
		return "the friction coefficient " + errors::text(phys.tangensOfFrictionAngle)
		        + "; expected a friction angle from 0 to below π/2.";
	return {};
}

constexpr double fadingLength = 0.1; // shadow below which a point loses weight, over the smaller R
constexpr double checkedOverlap = 0.02; // least overlap that is checked, over R₁ + R₂
constexpr double deepFraction   = 0.1;  // least overlap that counts, over a cap radius

/// Half the smallest width of a grain; infinite for an obstacle.
static double halfWidth(const Body& b)
{
	const rcr::PlanarShape shape = plane::shapeOf(*b.shape, *b.state, b.state->pos.z());
	return shape.grain() ? shape.inscribedRadius() : std::numeric_limits<double>::infinity();
}

/// Replaces the FrictPhys of a new contact by one with a force per point. Returns false if the
/// law cannot use it.
static bool prepare(shared_ptr<IPhys>& phys, const Interaction& interaction)
{
	if (dynamic_cast<RcrFrictPhys*>(phys.get())) return true;
	const FrictPhys&  yadePhys = static_cast<const FrictPhys&>(*phys);
	const std::string message  = physError(yadePhys);
	if (message.empty())
		phys = boost::make_shared<RcrFrictPhys>(yadePhys);
	else
		deferError("Law2_RcrGeom_FrictPhys_CundallStrack: the contact of "
		        + errors::bodyNames({ interaction.getId1(), interaction.getId2() })
		        + " has " + message);
	return message.empty();
}

namespace {
	/// The shallower of two points, which loses its weight as the shadow ends.
	struct Fading {
		int    point  = -1; // none
		double weight = 1;  // [-]
		double growth = 0;  // of the weight per tangential displacement of body 2 [1/m]
		double slope  = 0;  // growth of the gap [-]

		Fading(const rcr::Manifold& m, double radius)
		{
			const double length = fadingLength * radius, s = m.shadow / length;
			if (m.count < 2) return;
			point = m.points[1].gap < m.points[0].gap ? 0 : 1;
			slope = m.slope;
			if (s >= 1) return;
			weight = s * s * (3 - 2 * s);
			growth = m.slide * 6 * s * (1 - s) / length;
		}

		/// Tangential force on body 2 by the energy of the point.
		double edgeForce(double stiffness, double pull, double overlap) const
		{
			return -growth * (0.5 * stiffness * overlap - pull) * overlap
			        + slope * weight * (stiffness * overlap - pull);
		}
	};
} // namespace

bool Law2_RcrGeom_FrictPhys_CundallStrack::go(
        shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction* interaction)
{
	const RcrGeom& geom = static_cast<const RcrGeom&>(*igeom);
	if (geom.points == 0 || !prepare(iphys, *interaction)) return false;
	const Body::id_t id1 = interaction->getId1(), id2 = interaction->getId2();
	const Body &     one = *Body::byId(id1, scene), &two = *Body::byId(id2, scene);
	if (one.isClumpMember() && one.clumpId == two.clumpId) return false; // a clump has joined them
	RcrFrictPhys& phys = static_cast<RcrFrictPhys&>(*iphys);
	phys.force1[1] -= phys.edge[0], phys.force2[1] -= phys.edge[1];
	carryForces(geom, phys);

	const State &       state1 = *one.state, &state2 = *two.state;
	const rcr::Manifold manifold = geom.manifold();
	const Fading        fading(manifold, double(std::min(geom.refR1, geom.refR2)));
	const double        inverse  = inverseMass(id1, scene) + inverseMass(id2, scene);
	const double        dashpot  = damping > 0 && inverse > 0
	               ? 2 * double(damping) * std::sqrt(double(phys.kn) / inverse)
	               : 0;
	const rcr::PlanarVector v1 = plane::velocityOf(state1), v2 = plane::velocityOf(state2);
	rcr::Vec2               shift, drift; // of the image of body 2
	if (scene->isPeriodic) {
		shift = plane::toPlane(scene->cell->intrShiftPos(interaction->cellDist));
		drift = plane::toPlane(scene->cell->intrShiftVel(interaction->cellDist));
	}
	rcr::PlanarVector onBody1, onBody2; // forces and moments
	rcr::Vec2         normalForce, shearForce;
	for (int k = 0; k < manifold.count; ++k) {
		const rcr::ManifoldPoint& at    = manifold.points[k];
		Vector2r&                 force = k == 0 ? phys.force1 : phys.force2;
		phys.edge[k]                    = 0;
		if (at.gap >= 0) {
			force = Vector2r::Zero();
			continue;
		}
		rcr::ContactPoint point;
		point.normal = at.normal;
		point.arm1   = at.position - plane::toPlane(state1.pos);
		point.arm2   = at.position - (plane::toPlane(state2.pos) + shift);
		point.drift  = drift;
		const rcr::LocalVector u = relativeVelocity(point, v1, v2);
		const bool             fades  = k == fading.point;
		const double           weight = fades ? fading.weight : 1;
		rcr::LocalVector       f = pointForce(phys, dashpot, -at.gap, weight, u, double(force[1]));
		if (fades) {
			phys.edge[k] = fading.edgeForce(double(phys.kn), double(adhesion), -at.gap);
			f.t += double(phys.edge[k]);
		}
		force                    = Vector2r(f.n, f.t);
		normalForce              = normalForce + f.n * at.normal;
		shearForce               = shearForce + f.t * perp(at.normal);
		applyImpulse(point, f, { 1, 1, 1 }, { 1, 1, 1 }, onBody1, onBody2);
	}
	phys.rollingMoment = rollingMoment(geom, phys, v2.rotation - v1.rotation, double(phys.force1[0]));
	onBody1.rotation -= double(phys.rollingMoment);
	onBody2.rotation += double(phys.rollingMoment);
	watchOverlap(geom, phys, *interaction);
	phys.normalForce = plane::toSpace(normalForce);
	phys.shearForce  = plane::toSpace(shearForce);
	applyForce(id1, onBody1), applyForce(id2, onBody2);
	return true;
}

/// Force at a point with this overlap [m], weight [-] and relative velocity, without the edge force.
/// `tangential`: force before the step.
rcr::LocalVector Law2_RcrGeom_FrictPhys_CundallStrack::pointForce(const FrictPhys& phys,
        double dashpot, double overlap, double weight, const rcr::LocalVector& u, double tangential)
{
	dashpot *= weight;
	const double dt = double(scene->dt), kn = weight * double(phys.kn), ks = double(phys.ks),
	             mu = double(phys.tangensOfFrictionAngle), pull = weight * double(adhesion);
	const double n    = std::max(0.0, kn * overlap - dashpot * u.n);
	const double free = tangential - ks * u.t * dt;
	const double t    = rcr::clampTo(free, mu * n);
	if (scene->trackEnergy) {
		const double stored = (0.5 * kn * overlap - pull) * overlap + (ks > 0 ? 0.5 * t * t / ks : 0);
		const double slip   = ks > 0 ? (free - t) / ks : -u.t * dt; // of the slider
		scene->energy->add(stored, "elastPotential", elasticIx, /*reset every step*/ true);
		scene->energy->add(t * slip, "plastDissip", plasticIx, false);
		scene->energy->add((kn * overlap - n) * u.n * dt, "viscDissip", viscousIx, false);
	}
	return { n - pull, t };
}

/// Moment on body 2 at this relative spin [1/s]. A contact that gains a second point, or opens,
/// loses its moment.
Real Law2_RcrGeom_FrictPhys_CundallStrack::rollingMoment(
        const RcrGeom& geom, const RcrFrictPhys& phys, double spin, double normalForce)
{
	if (rollingFriction == 0 && phys.rollingMoment == 0) return 0;
	const bool   obstacle  = geom.type == int(rcr::ContactType::obstacle);
	const bool   resists   = geom.points == 1 && geom.gap[0] < 0;
	const double radius    = double(std::min(geom.refR1, geom.refR2)),
	             length    = rcr::rollingLength(double(geom.refR1 + geom.refR2), obstacle),
	             stiffness = double(phys.ks) * radius * radius,
	             before    = double(phys.rollingMoment),
	             bearing   = resists ? normalForce + double(adhesion) : 0,
	             free      = before - stiffness * spin * double(scene->dt),
	             moment    = rcr::clampTo(free, double(rollingFriction) * length * bearing);
	if (!scene->trackEnergy || stiffness == 0) return moment;
	const double lost = resists ? moment * (free - moment) : 0.5 * before * before;
	scene->energy->add(
	        0.5 * moment * moment / stiffness, "elastPotential", elasticIx, /*reset every step*/ true);
	scene->energy->add(lost / stiffness, "plastDissip", plasticIx, false);
	return moment;
}

/// Applies the force of a contact. Enters its work on prescribed motion into O.energy; it is
/// negative if that motion drives the grains.
void Law2_RcrGeom_FrictPhys_CundallStrack::applyForce(Body::id_t id, const rcr::PlanarVector& force)
{
	scene->forces.addForce(id, Vector3r(force.x, force.y, 0));
	scene->forces.addTorque(id, Vector3r(0, 0, force.rotation));
	if (!scene->trackEnergy) return;
	const Body&  body = *Body::byId(id, scene);
	const State &s    = *body.state,
	            &owner = body.isClumpMember() ? *Body::byId(body.clumpId, scene)->state : s;
	rcr::PlanarVector onOwner = force;
	onOwner.rotation += cross(plane::toPlane(s.pos - owner.pos), rcr::Vec2 { force.x, force.y });
	const rcr::PlanarVector v    = plane::velocityOf(owner);
	const double            dt   = double(scene->dt);
	double                  work = 0;
	if (owner.blockedDOFs & State::DOF_X) work += onOwner.x * v.x * dt;
	if (owner.blockedDOFs & State::DOF_Y) work += onOwner.y * v.y * dt;
	if (owner.blockedDOFs & State::DOF_RZ) work += onOwner.rotation * v.rotation * dt;
	if (work != 0) scene->energy->add(work, "driveWork", driveIx, false);
}

/// Counts contacts that overlap by more than a tenth of the smaller cap radius and 0.02 (R₁ + R₂).
/// The first one prints a warning.
void Law2_RcrGeom_FrictPhys_CundallStrack::watchOverlap(
        const RcrGeom& geom, const FrictPhys& phys, const Interaction& contact)
{
	const double overlap = geom.manifold().deepest();
	if (overlap <= checkedOverlap * double(geom.refR1 + geom.refR2)) return;
	const double least = std::min(halfWidth(*Body::byId(contact.getId1(), scene)),
	        halfWidth(*Body::byId(contact.getId2(), scene)));
	if (overlap <= deepFraction * least) return;
	int before;
#pragma omp atomic capture
	before = deepOverlapCount++;
	if (before > 0) return;
	LOG_WARN("step " << scene->iter << ": bodies #" << contact.getId1() << " and #"
	                 << contact.getId2() << " overlap by " << overlap
	                 << " m, more than a tenth of the cap radius of the thinner one, " << least
	                 << " m: springs of k_n = " << phys.kn
	                 << " N/m are too soft for these forces. A second, deep point may appear and add "
	                    "energy; bodies may pass through each other. Set a larger FrictMat.young or "
	                    "slower bodies. deepOverlapCount counts further cases.");
}

} // namespace yade
