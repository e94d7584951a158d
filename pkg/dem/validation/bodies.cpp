#include <algorithm>

#include "dem/validation/validation.hpp"
#include "dem/shapes/Rcr.hpp"
#include "dem/shapes/planarShape.hpp"

namespace yade::validation {

namespace {

	constexpr unsigned outOfPlane   = State::DOF_Z | State::DOF_RX | State::DOF_RY;
	// x, y components of a quaternion from which on a body is tilted
	constexpr double   tilted       = 1e-9;
	constexpr double   sameHeight   = 1e-9; // difference of z over 1 m + |z|
	// µ up to which the residual resolves u_n beside µ |u_t|
	constexpr double   mostFriction = 1e3;

	bool finite(const Vector3r& v)
	{
		return math::isfinite(v[0]) && math::isfinite(v[1]) && math::isfinite(v[2]);
	}

	rcr::PlanarShape shapeOf(const Body& b, Real z)
	{
		return b.shape && !b.isClump() ? plane::shapeOf(*b.shape, *b.state, z)
		                               : rcr::PlanarShape {};
	}
	bool finite(const Quaternionr& q)
	{
		return math::isfinite(q.w()) && math::isfinite(q.x()) && math::isfinite(q.y())
		        && math::isfinite(q.z());
	}
	bool upright(const State& s)
	{
		return math::abs(s.ori.x()) <= tilted && math::abs(s.ori.y()) <= tilted;
	}
	/// The shape turns with its body about z only. Walls never turn; Facets may be tilted.
	bool planar(const Body& b, const rcr::PlanarShape& shape)
	{
		return b.isClump() || shape.grain() || shape.kind == rcr::PlanarShape::box;
	}
	bool inPlane(const State& s, const rcr::PlanarShape& shape, Real z)
	{
		return !shape.grain() || math::abs(s.pos.z() - z) <= sameHeight * (1 + math::abs(z));
	}
	bool staysInPlane(const State& s)
	{
		return s.vel[2] == 0 && s.angVel[0] == 0 && s.angVel[1] == 0;
	}
	/// A Wall stays normal to its axis, whatever its angular velocity.
	bool canTurn(const State& s, const rcr::PlanarShape& shape)
	{
		return shape.kind != rcr::PlanarShape::wall || s.angVel == Vector3r::Zero();
	}
	bool shaped(const rcr::PlanarShape& shape) { return !shape.grain() || shape.halfWidth > 0; }
	bool keepsToPlane(const State& s)
	{
		return s.blockedDOFs == State::DOF_ALL || (s.blockedDOFs & outOfPlane) == outOfPlane;
	}
	bool moves(const State& s)
	{
		return (s.blockedDOFs & (State::DOF_X | State::DOF_Y)) != (State::DOF_X | State::DOF_Y);
	}
	bool turns(const State& s) { return !(s.blockedDOFs & State::DOF_RZ); }
	bool heavy(const State& s) { return !moves(s) || (s.mass > 0 && math::isfinite(s.mass)); }
	bool inert(const State& s)
	{
		return !turns(s) || (s.inertia[2] > 0 && math::isfinite(s.inertia[2]));
	}

} // namespace

std::string coordinates(const Vector3r& v)
{
	return '(' + text(v[0]) + ", " + text(v[1]) + ", " + text(v[2]) + ')';
}

std::string named(const std::vector<Body::id_t>& ids)
{
	if (ids.empty()) return {};
	std::string list = ids.size() == 1 ? "body" : "bodies";
	for (std::size_t k = 0; k < ids.size(); ++k)
		list += (k == 0 ? " #" : k + 1 < ids.size() ? ", #" : " and #")
		        + std::to_string(ids[k]);
	return list;
}

void refuse(const std::string& message) { throw std::invalid_argument("rcr: " + message); }

bool isGrain(const Body& b)
{
	if (!b.shape) return false;
	const int index = b.shape->getClassIndex();
	return index == Rcr::getClassIndexStatic() || index == Sphere::getClassIndexStatic();
}

Real planeOf(const Scene& scene)
{
	for (const auto& b : *scene.bodies)
		if (b && isGrain(*b)) return b->state->pos.z();
	return std::numeric_limits<Real>::quiet_NaN();
}

bool isValid(const Body& b, const rcr::PlanarShape& shape, Real z)
{
	const State& s = *b.state;
	if (!finite(s.pos) || !finite(s.vel) || !finite(s.angVel) || !finite(s.ori)) return false;
	const bool flat = planar(b, shape);
	if (flat && (!upright(s) || !inPlane(s, shape, z) || !shaped(shape))) return false;
	if (!canTurn(s, shape)) return false;
	if (b.isClumpMember()) return true;
	return (!shape.grain() || staysInPlane(s)) && (!flat || keepsToPlane(s)) && heavy(s)
	        && inert(s);
}

std::string defectOf(const Body& b, Real z)
{
	const State&      s      = *b.state;
	const std::string name   = named({ b.getId() });
	const auto        vector = [&](const char* what, const Vector3r& v, const char* remedy) {
            return name + " has the " + what + ' ' + coordinates(v)
                    + "; expected finite numbers: " + remedy;
	};
	const rcr::PlanarShape shape = shapeOf(b, z);
	if (!shaped(shape))
		return name + " has the cap radius " + text(shape.halfWidth)
		        + "; expected a length > 0: set b.shape.capRadius, or radius of a disc.";
	if (!finite(s.pos)) return vector("position", s.pos, "set b.state.pos.");
	if (!finite(s.vel)) return vector("velocity", s.vel, "set b.state.vel.");
	if (!finite(s.angVel)) return vector("angular velocity", s.angVel, "set b.state.angVel.");
	if (!finite(s.ori))
		return name
		        + " has an orientation that is not finite; set b.state.ori = Quaternion((0, 0, "
		          "1), angle).";
	const bool flat = planar(b, shape);
	if (flat && !upright(s))
		return name + " is tilted out of the plane z = const; turn it about z only"
		        + (b.isClump() ? ": make the clump by rcr.clump, which YADE's own "
		                         "appendClumped turns to principal axes."
		                       : ".");
	if (!inPlane(s, shape, z))
		return name + " lies at z = " + text(s.pos.z()) + ", other grains at z = " + text(z)
		        + ", so they would not meet in the plane; give all the same z.";
	if (!canTurn(s, shape))
		return name + " is a Wall with the angular velocity " + coordinates(s.angVel)
		        + ", but Walls cannot turn: use a Box or rcr.segment.";
	if (b.isClumpMember()) return {};
	if (flat && !keepsToPlane(s))
		return name + " is free to leave the plane (blockedDOFs = '" + s.blockedDOFs_vec_get()
		        + "'); expected z, X and Y blocked. "
		        + (dynamic_cast<const Sphere*>(b.shape.get()) ? "Make a disc by rcr.disc."
		                        : dynamic_cast<const Box*>(b.shape.get())
		                        ? "Make an obstacle by utils.box(…, fixed=True)."
		                        : "Set b.state.blockedDOFs = 'zXY', as rcr.particle and "
		                          "rcr.clump do.");
	if (shape.grain() && !staysInPlane(s))
		return name + " has the velocity " + coordinates(s.vel) + " and the angular velocity "
		        + coordinates(s.angVel)
		        + ", which lead out of the plane; expected b.state.vel[2], b.state.angVel[0] "
		          "and b.state.angVel[1] to be 0.";
	if (!heavy(s))
		return name + " is free but has the mass " + text(s.mass)
		        + "; give it a mass > 0 or block its degrees of freedom.";
	if (!inert(s))
		return name + " is free to turn but has the moment of inertia " + text(s.inertia[2])
		        + " about z; give it one > 0 or block Z.";
	return {};
}

void refuseBody(const Body& b, Scene& scene, Real z)
{
	const std::string wrong = defectOf(b, z);
	if (!wrong.empty()) refuse(wrong);
	const Body::id_t id = b.getId();
	refuse(named({ id }) + " has the force " + coordinates(scene.forces.getForce(id))
	        + " and the torque " + coordinates(scene.forces.getTorque(id))
	        + "; expected finite numbers: find the engine, or the O.forces of a script, that "
	          "gave them.");
}

std::string firstInvalidBody(const Scene& scene)
{
	const Real z = planeOf(scene);
	for (const auto& b : *scene.bodies) {
		if (!b || isValid(*b, shapeOf(*b, z), z)) continue;
		const std::string wrong = defectOf(*b, z);
		if (!wrong.empty()) return wrong;
	}
	return {};
}

/// Finds a Sphere with the mass of a ball among Rcrs, whose masses are per unit depth.
std::string massWarning(const Scene& scene)
{
	bool        rcrs = false;
	const Body* ball = nullptr;
	for (const auto& b : *scene.bodies) {
		if (!b || !b->shape || !b->material) continue;
		rcrs = rcrs || dynamic_cast<const Rcr*>(b->shape.get());
		const Sphere* sphere = b->state->blockedDOFs == State::DOF_ALL
		        ? nullptr
		        : dynamic_cast<const Sphere*>(b->shape.get());
		if (!sphere) continue;
		const Real mass
		        = 4 * Mathr::PI / 3 * math::pow(sphere->radius, 3) * b->material->density;
		if (math::abs(b->state->mass - mass) <= 1e-9 * mass && !ball) ball = b.get();
	}
	if (!rcrs || !ball) return {};
	return named({ ball->getId() }) + " is a Sphere with the mass of a ball, "
	        + text(ball->state->mass)
	        + " kg, among Rcrs, whose masses are per unit depth; make it by rcr.disc(center, "
	          "R), which sets the mass of a disc.";
}

void checkPhys(const CdPhys& phys, Body::id_t id1, Body::id_t id2)
{
	const bool friction
	        = phys.tangensOfFrictionAngle >= 0 && phys.tangensOfFrictionAngle <= mostFriction;
	const bool restitution = phys.restitution >= 0 && phys.restitution <= 1;
	if (friction && restitution) return;
	const std::string pair = "contact of " + named({ id1, id2 });
	if (!friction)
		refuse(pair + " has the friction coefficient " + text(phys.tangensOfFrictionAngle)
		        + "; expected a friction angle from 0 to below π/2, and a coefficient of at "
		          "most "
		        + text(mostFriction) + ".");
	refuse(pair + " has the restitution " + text(phys.restitution) + "; expected 0 to 1.");
}

} // namespace yade::validation
