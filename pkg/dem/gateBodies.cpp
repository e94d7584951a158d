#include <algorithm>

#include <core/Clump.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/Sphere.hpp>

#include "Gate.hpp"
#include "Rcr.hpp"

namespace yade {
namespace gate {

	namespace {

		constexpr unsigned outOfPlane  = State::DOF_Z | State::DOF_RX | State::DOF_RY;
		constexpr double   tilted      = 1e-9; // of a quaternion
		constexpr double   sameHeight  = 1e-9; // of 1 m, and of z
		constexpr double   mostFriction = 1e6; // µ beyond which the residual, in which µ |u_t| stands beside u_n, sees no normal velocity

		std::string body(Body::id_t id) { return "body #" + std::to_string(id); }
		std::string coordinates(const Vector3r& v) { return '(' + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + ')'; }
		bool        finite(const Vector3r& v) { return math::isfinite(v[0]) && math::isfinite(v[1]) && math::isfinite(v[2]); }

		bool isGrain(const Body& b) { return b.shape && (dynamic_cast<const Rcr*>(b.shape.get()) || dynamic_cast<const Sphere*>(b.shape.get())); }
		bool upright(const State& s) { return math::abs(s.ori.x()) <= tilted && math::abs(s.ori.y()) <= tilted && math::isfinite(s.ori.w() + s.ori.z()); }
		bool inPlane(const Body& b, Real z) { return !isGrain(b) || math::abs(b.state->pos.z() - z) <= sameHeight * (1 + math::abs(z)); }
		bool shaped(const Body& b) { return !dynamic_cast<const Rcr*>(b.shape.get()) || static_cast<const Rcr&>(*b.shape).capRadius > 0; }
		bool keepsToPlane(const State& s) { return s.blockedDOFs == State::DOF_ALL || (s.blockedDOFs & outOfPlane) == outOfPlane; }
		bool moves(const State& s) { return (s.blockedDOFs & (State::DOF_X | State::DOF_Y)) != (State::DOF_X | State::DOF_Y); }
		bool turns(const State& s) { return !(s.blockedDOFs & State::DOF_RZ); }
		bool heavy(const State& s) { return !moves(s) || (s.mass > 0 && math::isfinite(s.mass)); }
		bool inert(const State& s) { return !turns(s) || (s.inertia[2] > 0 && math::isfinite(s.inertia[2])); }

		void checkFinite(const Body& b, const char* what, const Vector3r& v, const char* remedy)
		{
			if (!finite(v)) refuse(body(b.getId()) + " has the " + what + ' ' + coordinates(v) + "; wanted finite numbers: " + remedy);
		}

	} // namespace

	void refuse(const std::string& message) { throw std::invalid_argument("rcr: " + message); }

	Real planeOf(const Scene& scene)
	{
		for (const auto& b : *scene.bodies)
			if (b && isGrain(*b)) return b->state->pos.z();
		return std::numeric_limits<Real>::quiet_NaN();
	}

	bool fine(const Body& b, Real z)
	{
		const State& s = *b.state;
		if (!finite(s.pos) || !finite(s.vel) || !finite(s.angVel) || !upright(s) || !inPlane(b, z) || !shaped(b)) return false;
		return b.isClumpMember() || (keepsToPlane(s) && heavy(s) && inert(s));
	}

	void refuseBody(const Body& b, Scene& scene, Real z)
	{
		const State& s = *b.state;
		if (!shaped(b)) refuse(body(b.getId()) + " has a Rcr shape without a cap radius; set it.");
		checkFinite(b, "position", s.pos, "set b.state.pos.");
		checkFinite(b, "velocity", s.vel, "set b.state.vel.");
		checkFinite(b, "angular velocity", s.angVel, "set b.state.angVel.");
		checkFinite(b, "force", scene.forces.getForce(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
		checkFinite(b, "torque", scene.forces.getTorque(b.getId()), "find the engine, or the O.forces of a script, that gave it.");
		if (!math::isfinite(s.ori.w() + s.ori.x() + s.ori.y() + s.ori.z()))
			refuse(body(b.getId()) + " has an orientation that is not finite; set b.state.ori = Quaternion((0, 0, 1), angle).");
		if (!upright(s))
			refuse(body(b.getId()) + " is tilted out of the plane z = const; turn it about z only"
			       + (b.isClump() ? ": make the clump by rcr.clump, which YADE's own appendClumped turns to principal axes." : "."));
		if (!inPlane(b, z))
			refuse(body(b.getId()) + " lies at z = " + text(s.pos.z()) + ", other grains at z = " + text(z)
			       + ", so they would not meet in the plane; give all the same z.");
		if (!keepsToPlane(s))
			refuse(body(b.getId()) + " is free to leave the plane (blockedDOFs = '" + s.blockedDOFs_vec_get()
			       + "'); wanted z, X and Y blocked: b.state.blockedDOFs = 'zXY', as rcr.particle, rcr.disc and rcr.clump set it.");
		if (!heavy(s))
			refuse(body(b.getId()) + " is free but has the mass " + text(s.mass) + "; give it a mass > 0 or block its degrees of freedom.");
		refuse(body(b.getId()) + " is free to turn but has the moment of inertia " + text(s.inertia[2]) + " about z; give it one > 0 or block Z.");
	}

	/// A Sphere among Rcrs that has the mass of a ball: those of Rcrs are per unit depth.
	std::string advice(const Scene& scene)
	{
		bool        rcrs = false;
		const Body* ball = nullptr;
		for (const auto& b : *scene.bodies) {
			if (!b || !b->shape || !b->material) continue;
			rcrs = rcrs || dynamic_cast<const Rcr*>(b->shape.get());
			const Sphere* sphere = b->state->blockedDOFs == State::DOF_ALL ? nullptr : dynamic_cast<const Sphere*>(b->shape.get());
			if (!sphere) continue;
			const Real mass = 4 * Mathr::PI / 3 * math::pow(sphere->radius, 3) * b->material->density;
			if (math::abs(b->state->mass - mass) <= 1e-9 * mass && !ball) ball = b.get();
		}
		if (!rcrs || !ball) return {};
		return body(ball->getId()) + " is a Sphere with the mass of a ball, " + text(ball->state->mass)
		        + " kg, among Rcrs, whose masses are per unit depth; make it by rcr.disc(center, R), which gives it that of a disc.";
	}

	void checkServed(const Interaction& i, const Scene& scene)
	{
		const Body &one = *(*scene.bodies)[i.getId1()], &two = *(*scene.bodies)[i.getId2()];
		const auto  wall   = [](const Body& b) { return b.shape->getClassName() == "Wall" || b.shape->getClassName() == "Facet"; };
		const auto  driven = [](const Body& b) { return b.state->blockedDOFs == State::DOF_ALL && !b.isClumpMember(); };
		if ((driven(one) || wall(one)) && (driven(two) || wall(two))) return;
		const auto rank = [](const std::string& shape) { // obstacles first
			const std::vector<std::string> served { "Wall", "Box", "Facet", "Sphere", "Rcr" };
			return std::find(served.begin(), served.end(), shape) - served.begin();
		};
		std::string shape1 = one.shape->getClassName(), shape2 = two.shape->getClassName();
		std::string told   = "no Ig2 functor of the InteractionLoop serves " + shape1 + " and " + shape2 + " (bodies #" + std::to_string(i.getId1())
		        + ", #" + std::to_string(i.getId2()) + "), so they would pass through each other. ";
		if (rank(shape1) > rank(shape2)) std::swap(shape1, shape2);
		const bool exists = rank(shape2) < 5 && rank(shape2) > 2;
		refuse(told + (exists ? "Add Ig2_" + shape1 + "_" + shape2 + "_RcrGeom to its first list." : "Make such shapes from Wall, Box, Facet, Sphere or Rcr; obstacles meet Spheres and Rcrs."));
	}

	void checkPhys(const CdPhys& phys, Body::id_t id1, Body::id_t id2)
	{
		const bool friction = phys.tangensOfFrictionAngle >= 0 && phys.tangensOfFrictionAngle <= mostFriction;
		const bool restitution = phys.restitution >= 0 && phys.restitution <= 1;
		if (friction && restitution) return;
		const std::string pair = "contact of bodies #" + std::to_string(id1) + " and #" + std::to_string(id2);
		if (!friction)
			refuse(pair + " has the friction coefficient " + text(phys.tangensOfFrictionAngle)
			       + "; wanted a friction angle from 0 to below π/2, and a coefficient of at most " + text(mostFriction) + ".");
		refuse(pair + " has the restitution " + text(phys.restitution) + "; wanted 0 to 1.");
	}

} // namespace gate
} // namespace yade
