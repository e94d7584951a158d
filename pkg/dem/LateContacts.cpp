#include "LateContacts.hpp"

#include <core/Interaction.hpp>
#include <pkg/common/Collider.hpp>

#include "AlertDistance.hpp"
#include "CdPhys.hpp"
#include "RcrGeom.hpp"

namespace yade {

namespace {

	constexpr double ahead = 1.5; // of the distance found: solving once more may lengthen it

	/// What InteractionLoop does for one pair; false if they do not meet.
	bool interact(const shared_ptr<Interaction>& i, Scene& scene, const InteractionLoop& loop)
	{
		auto& cache = i->functorCache;
		if (!cache.geomExists) return false;
		bool swap = false;
		if (!cache.geom) cache.geom = loop.geomDispatcher->getFunctor2D((*scene.bodies)[i->getId1()]->shape, (*scene.bodies)[i->getId2()]->shape, swap);
		cache.geomExists = bool(cache.geom);
		if (!cache.geomExists) return false;
		if (swap) i->swapOrder();
		Body& one = *(*scene.bodies)[i->getId1()];
		Body& two = *(*scene.bodies)[i->getId2()];
		if (!cache.geom->go(one.shape, two.shape, *one.state, *two.state, Vector3r::Zero(), false, i)) return false;
		if (!cache.phys) cache.phys = loop.physDispatcher->getFunctor2D(one.material, two.material, swap);
		if (!cache.phys) return false; // InteractionLoop will say it in the next step
		const bool wasReal = i->isReal();
		cache.phys->go(one.material, two.material, i);
		if (!wasReal) i->iterMadeReal = scene.iter;
		if (!cache.constLaw) cache.constLaw = loop.lawDispatcher->getFunctor2D(i->geom, i->phys, swap);
		return cache.constLaw && cache.constLaw->go(i->geom, i->phys, i.get());
	}

} // namespace

bool LateContacts::find(Scene& scene, const InteractionLoop& loop, const std::vector<StepBody>& bodies, const rcr::ContactProblem& solved)
{
	const double      dt    = double(scene.dt);
	const std::size_t known = fast_.size();
	for (std::size_t id = 0; id < bodies.size(); ++id) {
		const double distance = dt * plane::speed(solved.velocity[id], bodies[id].radius);
		if (distance <= bodies[id].expected) continue;
		const shared_ptr<Body>& b = (*scene.bodies)[id];
		if (const Rcr* particle = bodies[id].particle) {
			if (distance > particle->foreseen) foresee(b, distance, dt);
		} else {
			for (const auto& [other, i] : b->intrs) // a wall: those beside it look further
				if (bodies[other].particle) foresee((*scene.bodies)[other], distance, dt);
		}
	}
	if (fast_.size() == known) return false;
	if (std::any_of(fast_.begin() + known, fast_.end(), [this](const auto& b) { return outOfBox(*b); })) {
		scene.doSort = true;
		for (const auto& engine : scene.engines)
			if (dynamic_cast<Collider*>(engine.get())) engine->action();
	}
	bool missed = false;
	for (std::size_t k = known; k < fast_.size(); ++k)
		for (const auto& [id, i] : fast_[k]->intrs)
			missed |= wasMissed(i, scene, loop, solved);
	return missed;
}

void LateContacts::foresee(const shared_ptr<Body>& b, double distance, double dt)
{
	Rcr& particle     = static_cast<Rcr&>(*b->shape);
	particle.foreseen = alertDistance(particle, plane::twist(*b->state), dt) + ahead * distance;
	fast_.push_back(b);
}

bool LateContacts::outOfBox(const Body& b) const
{
	if (!b.bound) return true;
	const Rcr&     particle = static_cast<const Rcr&>(*b.shape);
	const Vector3r moved    = b.state->pos - b.bound->refPos;
	const double   reach    = particle.circumscribedRadius() + particle.foreseen;
	return std::max(std::abs(double(moved[0])), std::abs(double(moved[1]))) + reach > 0.5 * double(b.bound->max[0] - b.bound->min[0]);
}

bool LateContacts::wasMissed(const shared_ptr<Interaction>& i, Scene& scene, const InteractionLoop& loop, const rcr::ContactProblem& solved) const
{
	if (i->isReal() && !dynamic_cast<const CdPhys*>(i->phys.get())) return false; // of another law
	const int before = i->isReal() ? static_cast<const RcrGeom&>(*i->geom).points : 0;
	if (!interact(i, scene, loop) || !dynamic_cast<const CdPhys*>(i->phys.get())) return false;
	const RcrGeom& geom = static_cast<const RcrGeom&>(*i->geom);
	if (geom.points == before) return false;
	if (before > 0) return true; // a known pair with other points than those gathered: the step is gathered anew
	const Body::id_t    id1 = i->getId1(), id2 = i->getId2();
	const rcr::Vec2     center1  = plane::toPlane((*scene.bodies)[id1]->state->pos), center2 = plane::toPlane((*scene.bodies)[id2]->state->pos);
	const rcr::Manifold manifold = geom.manifold();
	for (int k = 0; k < manifold.count; ++k) {
		rcr::ContactPoint c;
		c.normal            = manifold.points[k].normal;
		c.arm1              = manifold.points[k].position - center1;
		c.arm2              = manifold.points[k].position - center2;
		const double gap    = manifold.points[k].gap, u = relativeVelocity(c, solved.velocity[id1], solved.velocity[id2]).n;
		if (gap + double(scene.dt) * u < -RcrGeom::slop * double(geom.refR1 + geom.refR2)) return true;
	}
	return false;
}

void LateContacts::forget()
{
	for (const auto& b : fast_)
		static_cast<Rcr&>(*b->shape).foreseen = 0;
	fast_.clear();
}

} // namespace yade
