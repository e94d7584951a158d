// Rules of validation on bodies: motion, inertia, materials, obstacles in the plane of the grains.

#include "dem/shapes/RoundedPolygon.hpp"
#include "dem/validation/SceneQuery.hpp"
#include "kernel/problem/residual.hpp"

namespace yade::validation {

constexpr unsigned outOfPlane = State::DOF_Z | State::DOF_RX | State::DOF_RY;
constexpr double   tilted     = 1e-9; // least x or y of the quaternion of a tilted body
constexpr double   sameHeight = 1e-9; // difference of z over 1 m + |z|

/// Message about a position or velocity that is not finite; empty: all are finite.
static std::string motionError(const Body& b)
{
	const State& s = *b.state;
	const auto message = [&](const char* what, const Vector3r& v, const char* name) {
		return bodyNames({ b.getId() }) + " has the " + what + ' ' + coordinates(v)
		        + "; expected finite numbers: set b.state." + name + '.';
	};
	if (!s.pos.allFinite()) return message("position", s.pos, "pos");
	if (!s.vel.allFinite()) return message("velocity", s.vel, "vel");
	if (!s.angVel.allFinite()) return message("angular velocity", s.angVel, "angVel");
	if (math::abs(s.ori.norm() - 1) < 1e-3) return {};
	return bodyNames({ b.getId() }) + " has an orientation of the norm " + text(s.ori.norm())
	        + "; expected 1: set b.state.ori = Quaternion((0, 0, 1), angle).";
}

/// Message about an invalid mass or moment of inertia of a free body; empty: both are valid.
static std::string inertiaError(const Body& b)
{
	const State&       s     = *b.state;
	constexpr unsigned shift = State::DOF_X | State::DOF_Y;
	const auto         valid = [](Real m) { return m > 0 && math::isfinite(m); };
	if ((s.blockedDOFs & shift) != shift && !valid(s.mass))
		return bodyNames({ b.getId() }) + " is free but has the mass " + text(s.mass)
		        + "; give it a mass > 0 or block its degrees of freedom.";
	if (!(s.blockedDOFs & State::DOF_RZ) && !valid(s.inertia[2]))
		return bodyNames({ b.getId() }) + " is free to turn but has the moment of inertia "
		        + text(s.inertia[2]) + " about z; give it one > 0 or block Z.";
	return {};
}

bool isGrain(const Body& b)
{
	if (!b.shape) return false;
	const int index = b.shape->getClassIndex();
	return index == Rcr::getClassIndexStatic() || index == Sphere::getClassIndexStatic()
	        || index == RoundedPolygon::getClassIndexStatic();
}

Real planeOf(const Scene& scene)
{
	for (const auto& b : *scene.bodies)
		if (b && isGrain(*b)) return b->state->pos.z();
	return std::numeric_limits<Real>::quiet_NaN();
}

std::string materialError(const Scene& scene, Body::id_t id1, Body::id_t id2)
{
	for (Body::id_t id : { id1, id2 }) {
		const Material* material = (*scene.bodies)[id]->material.get();
		// FrictMats whose cohesion or rolling resistance would have no effect
		static const std::set<std::string> cohesive { "CohFrictMat", "InelastCohFrictMat",
			"MortarMat", "ViscElCapMat", "JCFpmMat", "CpmMat", "WireMat" };
		if (dynamic_cast<const FrictMat*>(material) && !cohesive.count(material->getClassName()))
			continue;
		return bodyNames({ id }) + " has "
		        + (material ? "the material " + material->getClassName()
		                    : std::string("no material"))
		        + " and touches #" + std::to_string(id == id1 ? id2 : id1)
		        + "; give it a FrictMat.";
	}
	return {};
}

/// Rejects an obstacle that grains in the plane at z cannot meet. `shape`: in this plane.
static std::string obstacleError(const Body& b, const rcr::PlanarShape& shape, Real z)
{
	const auto name = [&] { return bodyNames({ b.getId() }); };
	if (shape.kind == rcr::PlanarShape::box) {
		const Vector3r& half = static_cast<const Box&>(*b.shape).extents;
		if (!(half[0] >= 0 && half[1] >= 0 && math::isfinite(half[0] + half[1])))
			return name() + " is a Box with the extents " + coordinates(half)
			        + ", so nothing would meet it; expected finite half widths ≥ 0.";
		if (!(math::abs(b.state->pos.z() - z) <= half[2]))
			return name() + " is a Box at z = " + text(b.state->pos.z())
			        + " that does not reach the plane z = " + text(z)
			        + " of the grains, so nothing would meet it; set its z, or its extents.";
	}
	if (shape.kind == rcr::PlanarShape::none && dynamic_cast<const Facet*>(b.shape.get()))
		return name() + " is a Facet that does not cut the plane z = " + text(z)
		        + " of the grains; a Facet is the segment in which it does: put a corner on either "
		          "side, or remove it.";
	return {};
}

std::string bodyError(const Body& b, const rcr::PlanarShape& shape, Real z)
{
	const State& s    = *b.state;
	const auto   name = [&] { return bodyNames({ b.getId() }); };
	if (shape.grain() && !(shape.inscribedRadius() > 0))
		return name() + " has the cap radius " + text(shape.inscribedRadius())
		        + "; expected a length > 0: set b.shape.capRadius, or radius of a disc.";
	if (const auto* polygon = dynamic_cast<const RoundedPolygon*>(b.shape.get());
	        polygon && shape.kind == rcr::PlanarShape::none)
		return name() + " is a RoundedPolygon"
		        + (polygon->vertices.empty() ? " without vertices; make it by rcr.polygon."
		                                     : ": " + polygon->attributeError());
	if (const std::string error = motionError(b); !error.empty()) return error;
	// the shape turns with its body about z only; Walls never turn, Facets may be tilted
	const bool flat = b.isClump() || shape.grain() || shape.kind == rcr::PlanarShape::box;
	if (flat && (math::abs(s.ori.x()) > tilted || math::abs(s.ori.y()) > tilted))
		return name() + " is tilted out of the plane z = const; turn it about z only"
		        + (b.isClump() ? ": make a clump of free grains by rcr.clump, and leave obstacles "
		                         "single. YADE's appendClumped turns clumps to principal axes."
		                       : ".");
	if (shape.grain() && !(math::abs(s.pos.z() - z) <= sameHeight * (1 + math::abs(z))))
		return name() + " lies at z = " + text(s.pos.z()) + ", other grains at z = " + text(z)
		        + ", so they would not meet in the plane; give all the same z.";
	if (!math::isnan(z)) // of grains
		if (const std::string error = obstacleError(b, shape, z); !error.empty()) return error;
	if (shape.kind == rcr::PlanarShape::wall && std::abs(shape.sense) > 1)
		return name() + " is a Wall with sense = " + std::to_string(shape.sense)
		        + "; expected +1, −1, or 0 for both sides.";
	if (shape.kind == rcr::PlanarShape::wall && s.angVel != Vector3r::Zero())
		return name() + " is a Wall with the angular velocity " + coordinates(s.angVel)
		        + ", but Walls cannot turn: use a Box or rcr.segment.";
	if (b.isClumpMember()) return {};
	if (flat && (s.blockedDOFs & outOfPlane) != outOfPlane)
		return name() + " is free to leave the plane (blockedDOFs = '" + s.blockedDOFs_vec_get()
		        + "'); expected z, X and Y blocked. "
		        + (shape.kind == rcr::PlanarShape::box
		                        ? "Make an obstacle by utils.box(…, fixed=True)."
		                        : "Set b.state.blockedDOFs = 'zXY', as rcr.disc, rcr.particle and "
		                          "rcr.clump do.");
	if (shape.grain() && (s.vel[2] != 0 || s.angVel[0] != 0 || s.angVel[1] != 0))
		return name() + " has the velocity " + coordinates(s.vel) + " and the angular velocity "
		        + coordinates(s.angVel)
		        + ", which lead out of the plane; expected b.state.vel[2], b.state.angVel[0] and "
		          "b.state.angVel[1] to be 0.";
	return inertiaError(b);
}

std::string invalidBodies(const SceneQuery& v)
{
	const Real z = planeOf(v.scene);
	for (const auto& b : *v.scene.bodies) {
		if (!b) continue;
		const auto shape = b->shape ? plane::shapeOf(*b->shape, *b->state, z) : rcr::PlanarShape {};
		if (const std::string error = bodyError(*b, shape, z); !error.empty()) return error;
	}
	return {};
}

bool isNoSphere(const Body& b)
{
	return isGrain(b) && !dynamic_cast<const Sphere*>(b.shape.get());
}

std::string sphereEngineWarning(const Scene& scene)
{
	for (const auto& engine : scene.engines) {
		const std::string name = engine->getClassName();
		if (name == "DomainLimiter")
			for (const auto& b : *scene.bodies)
				if (b && isNoSphere(*b) && b->isStandalone()
				        && b->isDynamic())
					return name + " never deletes " + bodyNames({ b->getId() })
					        + ", which is no Sphere; delete it by a PyRunner: O.bodies.erase(id).";
		if (name == "SpheresFactory" || name == "BoxFactory" || name == "CircularFactory")
			return name + " makes Spheres with the mass of balls, not of discs of unit depth; make "
			       "discs by a PyRunner: O.bodies.append(rcr.disc(…)).";
		if (name != "DragEngine" && name != "LinearDragEngine" && name != "HydroForceEngine")
			continue;
		for (const Body::id_t id : static_cast<const PartialEngine&>(*engine).ids)
			if (scene.bodies->exists(id)
			    && isNoSphere(*(*scene.bodies)[id]))
				return name + " exerts no force on " + bodyNames({ id })
				        + ", which is no Sphere; add the drag by a PyRunner before ContactDynamics: "
				          "O.forces.addF(id, force).";
	}
	return {};
}

std::string turningWarning(const Scene& scene)
{
	const SceneQuery view(scene);
	const auto*      collider = view.first<InsertionSortCollider>();
	if (view.law != springs || !collider || collider->verletDist == 0) return {};
	std::set<Body::id_t> turned; // by an engine
	for (const auto& engine : scene.engines)
		for (const Engine* part : livePartsOf(*engine)) {
			if (!dynamic_cast<const RotationEngine*>(part)) continue;
			const auto& ids = static_cast<const PartialEngine&>(*engine).ids; // not of the part
			turned.insert(ids.begin(), ids.end());
		}
	for (const auto& b : *scene.bodies) {
		if (!b || !b->shape || b->isClump()) continue;
		const State&           s     = *b->state;
		const rcr::PlanarShape shape = plane::shapeOf(*b->shape, s, s.pos.z());
		const bool turns = s.angVel.z() != 0 || turned.count(b->getId());
		if (shape.grain() || shape.kind < rcr::PlanarShape::box || !turns
		    || s.vel.norm() > math::abs(s.angVel.z()) * shape.radius())
			continue;
		return bodyNames({ b->getId() })
		        + " turns about its own centre. YADE's collider sees displacements only, so grains "
		          "can pass through it; put a new InsertionSortCollider(…, verletDist=0) into O.engines.";
	}
	return {};
}

/// Material that gives the mass of a body: of a clump its own, or that of its first member.
static const Material* materialOf(const Body& b, const Scene& scene)
{
	if (!b.isClump() || b.material) return b.material.get();
	const auto& members = static_cast<const Clump&>(*b.shape).members;
	return members.empty() ? nullptr : (*scene.bodies)[members.begin()->first]->material.get();
}

/// Mass of a free body by its area [kg per unit depth]. 0: unknown, or any mass is valid.
static Real planarMass(const Body& b, const Scene& scene, const UnionArea& unionArea)
{
	const Material* material = materialOf(b, scene);
	if (b.isClumpMember() || b.state->blockedDOFs == State::DOF_ALL || !b.shape || !material)
		return 0;
	if (b.isClump()) {
		std::vector<Body::id_t> ids;
		for (const auto& member : static_cast<const Clump&>(*b.shape).members) {
			if (!isGrain(*(*scene.bodies)[member.first])) return 0;
			ids.push_back(member.first);
		}
		return material->density * unionArea(ids);
	}
	const rcr::PlanarShape s = plane::shapeOf(*b.shape, *b.state, b.state->pos.z());
	if (!s.grain() && s.kind != rcr::PlanarShape::box) return 0;
	const Real mass = material->density * rcr::momentsOf(s).area;
	if (s.grain()) return mass;
	const Real block = 2 * static_cast<const Box&>(*b.shape).extents[2] * mass;
	// a Box is an obstacle, whose mass a script may choose
	return math::abs(b.state->mass - block) <= 1e-9 * block ? mass : 0;
}

/// What to do about a body of this class whose mass is not that of its area.
static std::string remedyOfMass(const std::string& shape)
{
	if (shape == "Sphere") return "make it by rcr.disc, or change the density of its material.";
	if (shape == "Box") return "give utils.box the half width 0.5 along z.";
	if (shape == "RoundedPolygon")
		return "make it by rcr.polygon, or change the density of its material.";
	if (shape == "Rcr") return "make it by rcr.particle, or change the density of its material.";
	return "join new bodies by rcr.clump, since YADE's functions on clumps give or keep other "
	       "masses.";
}

std::string massWarning(const Scene& scene, const UnionArea& unionArea)
{
	constexpr double same = 1e-3; // relative difference that has no effect
	if (SceneQuery(scene).law == neither) return {};
	const Body* first    = nullptr;
	Real        expected = 0;
	long        count    = 0;
	for (const auto& b : *scene.bodies) {
		const Real mass = b ? planarMass(*b, scene, unionArea) : Real(0);
		if (mass == 0 || math::abs(b->state->mass - mass) <= same * mass || ++count > 1) continue;
		first = b.get(), expected = mass;
	}
	if (!first) return {};
	const std::string shape = first->shape->getClassName();
	const std::string further = count > 1
	        ? " (further bodies that differ: " + std::to_string(count - 1) + ')'
	        : "";
	return bodyNames({ first->getId() }) + (shape == "Rcr" ? ", an " : ", a ") + shape
	        + ", has the mass " + text(first->state->mass, 6) + ", and density × area is "
	        + text(expected, 6) + " kg per unit depth" + further
	        + ". Its weight and motion follow the former: " + remedyOfMass(shape);
}

void checkPhys(const CdPhys& phys, Body::id_t id1, Body::id_t id2)
{
	const Real friction = phys.tangensOfFrictionAngle, restitution = phys.restitution;
	if (!(friction >= 0 && friction <= rcr::maxFriction))
		refuse("contact of ", bodyNames({ id1, id2 }), " has the friction coefficient ",
		        text(friction),
		        "; expected a friction angle from 0 to below π/2 [rad], and a coefficient of at "
		        "most ",
		        text(rcr::maxFriction),
		        ". Mend the material or Ip2 functor, then call O.interactions.clear().");
	const auto checkCoefficient = [&](const char* name, const char* unit, Real value) {
		if (value >= 0 && math::isfinite(value)) return;
		refuse("contact of ", bodyNames({ id1, id2 }), " has the ", name, " ", text(value),
		        "; expected a finite number ≥ 0 ", unit,
		        ". Mend the Ip2 functor, then call O.interactions.clear(). Materials have none: a "
		        "MatchMaker needs algo='val', or a match for each pair.");
	};
	checkCoefficient("adhesion", "[N]", phys.adhesion);
	checkCoefficient("rolling friction", "[-]", phys.rollingFriction);
	if (!(restitution >= 0 && restitution <= 1))
		refuse("contact of ", bodyNames({ id1, id2 }), " has the restitution ", text(restitution),
		        "; expected 0 to 1. Mend the Ip2 functor, then call O.interactions.clear(). Materials "
		        "have no restitution: a MatchMaker needs algo='val', or a match for each pair.");
}

std::string materials(const SceneQuery& v)
{
	const Material* valid = nullptr; // material of the last body; most bodies share one
	for (const auto& b : *v.scene.bodies) {
		const Material* material = b && b->shape && !b->isClump() ? b->material.get() : nullptr;
		if (!material || material == valid) continue;
		const FrictMat* rough = dynamic_cast<const FrictMat*>(material);
		if (!rough)
			return bodyNames({ b->getId() }) + " has the material " + material->getClassName()
			        + ", which has no friction; give it a FrictMat.";
		if (!(rough->frictionAngle >= 0 && rough->frictionAngle < 0.5 * Mathr::PI))
			return bodyNames({ b->getId() }) + " has the friction angle "
			        + text(rough->frictionAngle)
			        + "; expected radians from 0 to below π/2, such as radians(26).";
		valid = material;
	}
	return {};
}

} // namespace yade::validation
