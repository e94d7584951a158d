#include "SceneCheck.hpp"

#include <core/InteractionLoop.hpp>

#include "ContactDynamics.hpp"
#include "MissingFunctor.hpp"

namespace yade {

namespace {

	constexpr unsigned outOfPlane = State::DOF_Z | State::DOF_RX | State::DOF_RY;

	std::string body(Body::id_t id) { return "body #" + std::to_string(id); }

	template <class EngineType> int place(const std::vector<shared_ptr<Engine>>& engines)
	{
		for (std::size_t k = 0; k < engines.size(); ++k)
			if (dynamic_cast<const EngineType*>(engines[k].get()) && !engines[k]->dead) return int(k);
		return -1;
	}

	std::string text(const Vector3r& v)
	{
		std::ostringstream out;
		out << '(' << v[0] << ", " << v[1] << ", " << v[2] << ')';
		return out.str();
	}

	void checkFinite(const Body& b, const char* what, const Vector3r& v, const char* remedy)
	{
		if (math::isfinite(v[0]) && math::isfinite(v[1]) && math::isfinite(v[2])) return;
		refuse(body(b.getId()) + " has the " + what + ' ' + text(v) + "; wanted finite numbers: " + remedy);
	}

} // namespace

void refuse(const std::string& message) { throw std::invalid_argument("ContactDynamics: " + message); }

Engines checkedEngines(const Scene& scene)
{
	if (!(scene.dt > 0 && math::isfinite(scene.dt)))
		refuse("O.dt = " + boost::lexical_cast<std::string>(scene.dt) + "; wanted a finite time step > 0.");
	if (scene.isPeriodic) refuse("O.periodic = True; periodic cells are not served. Bound the scene by walls.");
	const auto& engines    = scene.engines;
	const int   integrator = place<NewtonIntegrator>(engines), loop = place<InteractionLoop>(engines), self = place<ContactDynamics>(engines);
	if (integrator < 0) refuse("O.engines holds no NewtonIntegrator, so nothing would move; append NewtonIntegrator(damping=0).");
	if (loop < 0) refuse("O.engines holds no InteractionLoop, so there are no contacts; put one before ContactDynamics.");
	if (self < loop) refuse("stands before the InteractionLoop, so it would solve the contacts of the step before; put it after.");
	if (self > integrator) refuse("stands after the NewtonIntegrator, so its forces would come too late; put it before.");
	const auto& newton = static_cast<const NewtonIntegrator&>(*engines[integrator]);
	if (newton.damping != 0)
		refuse("NewtonIntegrator.damping = " + boost::lexical_cast<std::string>(newton.damping)
		       + " would damp the contact forces; set damping=0 (restitution below 1 dissipates by itself).");
	if (newton.densityScaling) refuse("NewtonIntegrator.densityScaling is on; switch it off, the time step is not bound by a stiffness.");
	const std::string missing = missingFunctor(scene);
	if (!missing.empty()) refuse(missing);
	return { newton, static_cast<const InteractionLoop&>(*engines[loop]) };
}

void checkParticle(const Body& b, const Rcr& particle, Scene& scene)
{
	if (!(particle.capRadius > 0)) refuse(body(b.getId()) + " has a Rcr shape without a cap radius; set it.");
	checkBody(b, scene);
}

void checkBody(const Body& b, Scene& scene)
{
	const State& s = *b.state;
	checkFinite(b, "position", s.pos, "set b.state.pos.");
	checkFinite(b, "velocity", s.vel, "set b.state.vel.");
	checkFinite(b, "angular velocity", s.angVel, "set b.state.angVel.");
	checkFinite(b, "force", scene.forces.getForce(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
	checkFinite(b, "torque", scene.forces.getTorque(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
	if (b.isClump() || b.isClumpMember())
		refuse(body(b.getId()) + " belongs to a clump; clumps are not served. Use single bodies, or a smooth law.");
	if (math::abs(s.ori.x()) > 1e-9 || math::abs(s.ori.y()) > 1e-9)
		refuse(body(b.getId()) + " is tilted out of the plane z = const; turn it about z only.");
	if (s.blockedDOFs == State::DOF_ALL) return;
	if ((s.blockedDOFs & outOfPlane) != outOfPlane)
		refuse(body(b.getId()) + " is free to leave the plane (blockedDOFs = '" + s.blockedDOFs_vec_get()
		       + "'); wanted z, X and Y blocked: b.state.blockedDOFs = 'zXY', as rcr.particle sets it.");
	const bool moves = (s.blockedDOFs & (State::DOF_X | State::DOF_Y)) != (State::DOF_X | State::DOF_Y);
	if (moves && !(s.mass > 0 && math::isfinite(s.mass)))
		refuse(body(b.getId()) + " is free but has the mass " + boost::lexical_cast<std::string>(s.mass)
		       + "; give it a mass > 0 or block its degrees of freedom.");
	if (!(s.blockedDOFs & State::DOF_RZ) && !(s.inertia[2] > 0 && math::isfinite(s.inertia[2])))
		refuse(body(b.getId()) + " is free to turn but has the moment of inertia " + boost::lexical_cast<std::string>(s.inertia[2])
		       + " about z; give it one > 0 or block Z.");
}

void checkServed(const Interaction& i, const Scene& scene)
{
	const Shape& shape1 = *(*scene.bodies)[i.getId1()]->shape;
	const Shape& shape2 = *(*scene.bodies)[i.getId2()]->shape;
	if (!dynamic_cast<const Rcr*>(&shape1) && !dynamic_cast<const Rcr*>(&shape2)) return;
	refuse("no Ig2 functor of the InteractionLoop serves " + shape1.getClassName() + " and " + shape2.getClassName() + " (bodies #"
	       + std::to_string(i.getId1()) + ", #" + std::to_string(i.getId2())
	       + "), so they would pass through each other. Add Ig2_Rcr_Rcr_RcrGeom, Ig2_Wall_Rcr_RcrGeom, Ig2_Box_Rcr_RcrGeom or "
	         "Ig2_Sphere_Rcr_RcrGeom; make other shapes from Wall, Box or Rcr.");
}

void checkPhys(const CdPhys& phys, Body::id_t id1, Body::id_t id2)
{
	const bool friction = phys.tangensOfFrictionAngle >= 0, restitution = phys.restitution >= 0 && phys.restitution <= 1;
	if (friction && restitution) return;
	const std::string pair = "contact of bodies #" + std::to_string(id1) + " and #" + std::to_string(id2);
	if (!friction)
		refuse(pair + " has the friction coefficient " + boost::lexical_cast<std::string>(phys.tangensOfFrictionAngle)
		       + "; wanted a friction angle from 0 to below π/2.");
	refuse(pair + " has the restitution " + boost::lexical_cast<std::string>(phys.restitution) + "; wanted 0 to 1.");
}

} // namespace yade
