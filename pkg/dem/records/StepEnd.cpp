#include "dem/records/StepEnd.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "dem/validation/validation.hpp"

namespace yade {

constexpr double largestPath = 1e-4; // of an unseen change in a step, over the smallest radius

/// Largest distance of a point of a body or a clump from its centre [m].
static double radiusOf(const Body& b, const Scene& scene, Real z)
{
	if (!b.shape) return 0;
	if (!b.isClump()) return plane::shapeOf(*b.shape, *b.state, z).radius();
	double radius = 0;
	for (const auto& [id, place] : static_cast<const Clump&>(*b.shape).members)
		radius = std::max(radius,
		        double(place.position.norm()) + radiusOf(*(*scene.bodies)[id], scene, z));
	return radius;
}

std::string changeSince(
        const Scene& scene, double dt, const std::vector<rcr::PlanarVector>& velocity)
{
	if (double(scene.dt) != dt)
		return "O.dt is " + validation::text(scene.dt) + ", but was " + validation::text(Real(dt));
	const Real z        = validation::planeOf(scene);
	double     smallest = std::numeric_limits<double>::infinity();
	for (const auto& b : *scene.bodies)
		if (b && validation::isGrain(*b)) smallest = std::min(smallest, radiusOf(*b, scene, z));
	for (const auto& b : *scene.bodies) {
		// new bodies have no forces yet
		if (!b || b->isClumpMember() || std::size_t(b->getId()) >= velocity.size()) continue;
		const rcr::PlanarVector change = plane::velocityOf(*b->state) - velocity[b->getId()];
		if (dt * rcr::maxSpeed(change, radiusOf(*b, scene, z)) > largestPath * smallest)
			return "the velocity of " + validation::bodyNames({ b->getId() })
			        + " differs from that";
	}
	return {};
}

void StepEnd::record(const Scene& scene)
{
	if (isOf(scene)) return;
	scene_ = scene.weak_from_this();
	iter_  = scene.iter;
	dt_    = double(scene.dt);
	velocity_.assign(scene.bodies->size(), {});
	for (const auto& b : *scene.bodies)
		if (b) velocity_[b->getId()] = plane::velocityOf(*b->state);
}

bool StepEnd::isOf(const Scene& scene) const
{
	return iter_ > 0 && iter_ == scene.iter && scene_.lock().get() == &scene;
}

std::string StepEnd::change(const Scene& scene) const
{
	return isOf(scene) ? changeSince(scene, dt_, velocity_) : std::string();
}

} // namespace yade
