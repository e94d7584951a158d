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

/// Of all grains; infinity without grains [m].
static double smallestRadius(const Scene& scene, Real z)
{
	double smallest = std::numeric_limits<double>::infinity();
	for (const auto& b : *scene.bodies)
		if (b && validation::isGrain(*b)) smallest = std::min(smallest, radiusOf(*b, scene, z));
	return smallest;
}

std::string changeSince(
        const Scene& scene, double dt, const std::vector<rcr::PlanarVector>& velocity)
{
	if (double(scene.dt) != dt)
		return "O.dt is " + errors::text(scene.dt) + ", but was " + errors::text(Real(dt));
	const Real   z    = validation::planeOf(scene);
	const double most = largestPath * smallestRadius(scene, z);
	for (const auto& b : *scene.bodies) {
		// new bodies have no forces yet
		if (!b || b->isClumpMember() || std::size_t(b->getId()) >= velocity.size()) continue;
		const rcr::PlanarVector change = plane::velocityOf(*b->state) - velocity[b->getId()];
		if (dt * rcr::maxSpeed(change, radiusOf(*b, scene, z)) > most)
			return "the velocity of " + errors::bodyNames({ b->getId() })
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
	// new bodies have no forces yet; comparisons with NaN find no change
	constexpr double none = std::numeric_limits<double>::quiet_NaN();
	velocity_.assign(scene.bodies->size(), { none, none, none });
	place_.assign(scene.bodies->size(), { Vector3r::Constant(none), Quaternionr::Identity() });
	for (const auto& b : *scene.bodies) {
		if (!b) continue;
		velocity_[b->getId()] = plane::velocityOf(*b->state);
		place_[b->getId()]    = { b->state->pos, b->state->ori };
	}
}

void StepEnd::adaptCell(Scene& scene) const
{
	const bool isMidStep = scene.subStep >= 0; // after an error, or under O.subStepping
	if (!isOf(scene) || !scene.isPeriodic || isMidStep || double(scene.dt) == dt_) return;
	Cell&          cell = *scene.cell;
	const Matrix3r unit = Matrix3r::Identity();
	const Matrix3r back = (unit + scene.dt * cell.velGrad).inverse()
	        * (unit + Real(dt_) * cell.velGrad);
	cell.hSize = back * cell.hSize;
	cell.trsf  = back * cell.trsf;
	cell.integrateAndUpdate(0); // updates its derived data
}

bool StepEnd::isOf(const Scene& scene) const
{
	const bool isLast = iter_ == scene.iter || scene.iter == 0; // after O.resetTime()
	return iter_ > 0 && isLast && scene_.lock().get() == &scene;
}

std::string StepEnd::change(const Scene& scene) const
{
	if (!isOf(scene)) return {};
	const std::string error = changeSince(scene, dt_, velocity_);
	if (!error.empty()) return error;
	const Real z        = validation::planeOf(scene);
	const double most = largestPath * smallestRadius(scene, z);
	for (const auto& b : *scene.bodies) {
		if (!b || std::size_t(b->getId()) >= place_.size()) continue;
		const auto& [center, turn] = place_[b->getId()];
		const double moved         = double((b->state->pos - center).norm());
		if (math::isnan(moved)) continue;
		const double angle = double(b->state->ori.angularDistance(turn));
		if (moved > most || angle * radiusOf(*b, scene, z) > most)
			return "the place of " + errors::bodyNames({ b->getId() }) + " differs from that";
	}
	return {};
}

} // namespace yade
