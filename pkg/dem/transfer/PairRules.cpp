#include "dem/transfer/PairRules.hpp"

namespace yade {

std::vector<Body::id_t> PairRules::update(Scene& scene, Collider& collider)
{
	const mask_t avoided = collider.avoidSelfInteractionMask;
	if (collider_.lock().get() != &collider || avoided != avoided_) bodies_.clear();
	collider_ = collider.weak_from_this(), avoided_ = avoided;
	bodies_.resize(scene.bodies->size());
	std::vector<Body::id_t> changed;
	for (const auto& b : *scene.bodies) {
		if (!b) continue;
		const Properties now { b.get(), b->groupMask, b->clumpId, b->isBounded() };
		if (now == bodies_[b->getId()]) continue;
		bodies_[b->getId()] = now;
		changed.push_back(b->getId());
	}
	if (changed.empty()) return changed;
	collider.invalidatePersistentData();
	scene.bodies->checkedByCollider = false;
	scene.doSort                    = true;
	return changed;
}

} // namespace yade
