// Rules of validation on pairs of bodies: functors of all pairs that could collide, and overlaps
// before the first step.
#include <set>

#include "dem/validation/SceneQuery.hpp"
#include "kernel/detection/neighbors.hpp"

namespace yade::validation {

namespace {

	constexpr double deepOverlap = 0.01; // over R₁ + R₂; beds at rest and flows stay below 5e-3

	/// Properties of a body that decide which bodies it could collide with.
	struct Partner {
		const Body* body;
		bool        isBoundary; // fixed, or a Wall; two of them do not collide
	};

	Partner partnerOf(const Body& b, const Scene& scene)
	{
		const Body& moved = b.isClumpMember() ? *(*scene.bodies)[b.clumpId] : b;
		const bool  wall  = !isGrain(b) && dynamic_cast<const Wall*>(b.shape.get());
		return { &b, wall || moved.state->blockedDOFs == State::DOF_ALL };
	}

	/// Returns true if YADE allows a contact and the bodies are not both boundaries.
	bool couldCollide(const Scene& scene, Collider* collider, const Partner& one, const Partner& two)
	{
		return collider && one.body != two.body && !(one.isBoundary && two.isBoundary)
		        && mayCollide(scene, *collider, one.body->getId(), two.body->getId());
	}

	bool takesPart(const shared_ptr<Body>& b)
	{
		return b && b->shape && !b->isClump() && b->isBounded();
	}

	/// "Sphere and Rcr (bodies #1, #2)"
	std::string shapesOf(const Body& one, const Body& two)
	{
		return one.shape->getClassName() + " and " + two.shape->getClassName() + " (bodies #"
		        + std::to_string(one.getId()) + ", #" + std::to_string(two.getId()) + ')';
	}

	/// Name of the functor of rcr for two shapes in any order; empty: none.
	std::string functorFor(std::string shape1, std::string shape2)
	{
		const std::vector<std::string> supported { "Wall", "Box", "Facet", "Sphere", "Rcr",
			"RoundedPolygon" };
		const std::size_t              firstGrain = 3; // obstacles stand before it
		const auto                     rank       = [&](const std::string& shape) {
                return std::size_t(
                        std::find(supported.begin(), supported.end(), shape) - supported.begin());
		};
		if (rank(shape1) > rank(shape2)) std::swap(shape1, shape2);
		const bool exists = rank(shape2) >= firstGrain && rank(shape2) < supported.size();
		return exists ? "Ig2_" + shape1 + '_' + shape2 + "_RcrGeom" : std::string();
	}

	/// Pairs that overlap before their first step.
	class InitialOverlaps {
	public:
		InitialOverlaps(const SceneQuery& v, Real z)
		        : scene_(v.scene), collider_(v.first<Collider>())
		{
			step_.cell = plane::cellOf(scene_);
			step_.bodies.resize(scene_.bodies->size());
			for (const auto& b : *scene_.bodies) {
				if (!takesPart(b)) continue;
				rcr::StepBody& body = step_.bodies[b->getId()];
				body.shape  = plane::shapeOf(*b->shape, *b->state, z);
				body.center = plane::toPlane(b->state->pos);
				body.turn   = plane::turnOf(body.shape, *b->state);
				body.owner  = b->isClumpMember() ? b->clumpId : b->getId();
			}
			rcr::Neighbors  neighbors;
			rcr::ThreadTeam team;
			team.run(1, [&] { neighbors.update(step_, team); });
			for (const auto& [one, two] : neighbors.list())
				if (!isWall(one)) check(one, two);
			// a wall lists no grains far behind it
			for (Body::id_t id = 0; id < Body::id_t(step_.bodies.size()); ++id)
				for (Body::id_t other = 0; isWall(id) && other < Body::id_t(step_.bodies.size());
				        ++other)
					if (step_.bodies[other].shape.grain()) check(id, other);
		}

		long       pairs = 0, behind = 0; // all; with a grain on the inactive side of a wall
		double     depth = 0, share = 0;  // deepest overlap [m]; the same over R₁ + R₂
		Body::id_t one = 0, two = 0;      // the deepest pair
		Body::id_t wall = 0, grain = 0;   // the first grain behind a wall

	private:
		bool isWall(Body::id_t id) const
		{
			return step_.bodies[id].shape.kind == rcr::PlanarShape::wall;
		}

		void check(Body::id_t id1, Body::id_t id2)
		{
			const rcr::StepBody &a = step_.bodies[id1], &b = step_.bodies[id2];
			const auto&          bodies = *scene_.bodies;
			if (!couldCollide(scene_, collider_, partnerOf(*bodies[id1], scene_),
			            partnerOf(*bodies[id2], scene_)))
				return;
			const rcr::Pose     at2 = shifted(b.pose(), step_.nearestShift(a, b));
			const rcr::Manifold m   = rcr::contactPoints(a.shape, a.pose(), b.shape, at2,
			          isWall(id1) ? std::numeric_limits<double>::max() : 0); // also far behind it
			const double deepest = m.deepest();
			const double part    = deepest / rcr::contactSize(a.shape, b.shape);
			if (part <= deepOverlap) return;
			const shared_ptr<Interaction> known = scene_.interactions->find(id1, id2);
			if (known && known->isReal()) return;
			++pairs;
			const rcr::Vec2 way      = at2.center - a.center;
			const bool      isBehind = isWall(id1)
			        && a.shape.sense * (a.shape.axis == 0 ? way.x : way.y) < 0;
			if (isBehind && behind++ == 0) wall = id1, grain = id2;
			if (part <= share) return;
			depth = deepest, share = part;
			std::tie(one, two) = std::minmax({ id1, id2 });
		}

		const Scene& scene_;
		Collider*    collider_;
		rcr::Step    step_;
	};

} // namespace

std::string unsupportedPairs(const SceneQuery& v)
{
	if (!v.loop) return {};
	// two bodies of each kind, not of one clump, represent all
	std::map<std::tuple<int, bool, mask_t>, std::vector<Partner>> kinds;
	for (const auto& b : *v.scene.bodies) {
		if (!takesPart(b)) continue;
		const Partner partner = partnerOf(*b, v.scene);
		auto&      some = kinds[{ b->shape->getClassIndex(), partner.isBoundary, b->groupMask }];
		const auto ofOneClump = [&](const Body& other) {
			return b->isClumpMember() && b->clumpId == other.clumpId;
		};
		if (some.empty() || (some.size() == 1 && !ofOneClump(*some[0].body)))
			some.push_back(partner);
	}
	std::string           pairs, functors;
	std::set<std::string> reported;
	const auto            report = [&](const Body& one, const Body& two) {
		shared_ptr<Shape> shape1 = one.shape, shape2 = two.shape;
		bool              swap;
		const std::string functor = functorFor(shape1->getClassName(), shape2->getClassName());
		if (functor.empty() || v.loop->geomDispatcher->getFunctor2D(shape1, shape2, swap)
		        || !reported.insert(functor).second)
			return;
		pairs += (pairs.empty() ? "" : ", ") + shapesOf(one, two);
		functors += (functors.empty() ? "" : ", ") + functor + "()";
	};
	for (auto kind = kinds.begin(); kind != kinds.end(); ++kind)
		for (auto other = kind; other != kinds.end(); ++other)
			for (const Partner& one : kind->second)
				for (const Partner& two : other->second)
					if (couldCollide(v.scene, v.first<Collider>(), one, two))
						report(*one.body, *two.body);
	if (pairs.empty()) return {};
	return "no Ig2 functor of the InteractionLoop handles " + pairs
	        + ", so they would pass through each other. Add " + functors
	        + " to its first list, or give bodies that must not meet a Body.mask without a "
	          "common bit.";
}

/// Rejects contacts of YADE's functors between shapes that functors of rcr handle now.
std::string foreignContacts(const SceneQuery& v)
{
	if (!v.loop) return {};
	for (const auto& i : *v.scene.interactions) {
		if (!i->isReal() || dynamic_cast<const RcrGeom*>(i->geom.get())) continue;
		const shared_ptr<Body>&one = (*v.scene.bodies)[i->getId1()], &two
		        = (*v.scene.bodies)[i->getId2()];
		if (!one || !two || !one->shape || !two->shape) continue;
		shared_ptr<Shape> shape1 = one->shape, shape2 = two->shape;
		bool              swap;
		const auto functor = v.loop->geomDispatcher->getFunctor2D(shape1, shape2, swap);
		if (!dynamic_cast<const Ig2_Planar_RcrGeom*>(functor.get())) continue;
		return "the contact of " + bodyNames({ one->getId(), two->getId() }) + " has the geometry "
		        + i->geom->getClassName()
		        + " of other functors; call O.interactions.clear() after a change of functors.";
	}
	return {};
}

void forgetFunctors(const Scene& scene)
{
	for (const auto& i : *scene.interactions) {
		if (i->isReal()) continue;
		i->functorCache            = {};
		i->functorCache.geomExists = true; // unknown yet
	}
}

void refuseUnsupported(const Scene& scene, Body::id_t id1, Body::id_t id2)
{
	const Body &one = *(*scene.bodies)[id1], &two = *(*scene.bodies)[id2];
	if (partnerOf(one, scene).isBoundary && partnerOf(two, scene).isBoundary) return;
	const std::string functor = functorFor(one.shape->getClassName(), two.shape->getClassName());
	refuse("no Ig2 functor of the InteractionLoop handles ", shapesOf(one, two),
	        ", so they would pass through each other. ",
	        functor.empty() ? "Obstacles meet grains only: make a grain by rcr.disc, rcr.particle or "
	                          "rcr.polygon, an obstacle from Wall, Box or Facet."
	                        : "Add " + functor + " to its first list.");
}

std::string overlapWarning(const Scene& scene)
{
	const SceneQuery v(scene);
	const Real z = planeOf(scene);
	if ((v.law != rigid && v.law != springs) || math::isnan(z)) return {};
	const InitialOverlaps found(v, z);
	if (found.pairs == 0) return {};
	if (found.behind > 0) {
		const Wall& wall = static_cast<const Wall&>(*(*scene.bodies)[found.wall]->shape);
		return bodyNames({ found.grain })
		        + (found.behind > 1 ? " and " + std::to_string(found.behind - 1) + " more lie"
		                            : " lies")
		        + " behind a wall, " + bodyNames({ found.wall }) + ", which acts towards "
		        + (wall.sense > 0 ? '+' : '-') + "xy"[wall.axis] + " only (sense="
		        + std::to_string(wall.sense)
		        + "): it does not hold such a grain, or pushes it across. Set sense="
		        + std::to_string(-wall.sense) + ", or 0 for both sides, or move them.";
	}
	return bodyNames({ found.one, found.two }) + " overlap by " + text(found.depth, 3) + " m, "
	        + text(found.share, 3) + " of R₁ + R₂, before their first step"
	        + (found.pairs > 1 ? ", and " + std::to_string(found.pairs - 1)
	                                + " more pairs less deeply. "
	                           : std::string(". "))
	        + (v.law == rigid
	                        ? "Rigid contacts take back at most 1e-4 R of it in a step"
	                        : "Springs begin with the force of it, and throw the bodies apart")
	        + ": place them apart, or join them by rcr.clump.";
}

} // namespace yade::validation
