#include "dem/validation/PairExclusions.hpp"

namespace yade {

/// Returns true if an edge of a cell has changed by half an edge or more, as in O.cell.flipCell.
static bool isFlipped(const Matrix3r& before, const Matrix3r& now)
{
	const Matrix3r inEdges = before.inverse() * now; // not finite without a cell before
	return !((inEdges - Matrix3r::Identity()).array().abs().maxCoeff() < 0.5);
}

std::vector<Body::id_t> PairExclusions::restartIfChanged(Scene& scene, Collider& collider)
{
	const mask_t avoided = collider.avoidSelfInteractionMask;
	const Matrix3r edges = scene.isPeriodic ? scene.cell->hSize : Matrix3r(Matrix3r::Zero());
	const bool     all   = collider_.lock().get() != &collider || avoided != avoided_
	        || (edges != edges_ && isFlipped(edges_, edges));
	edges_ = edges;
	collider_ = collider.weak_from_this(), avoided_ = avoided;
	bodies_.resize(scene.bodies->size());
	hasReplaced_ = false;
	std::vector<Body::id_t> changed;
	for (const auto& b : *scene.bodies) {
		if (!b) continue;
		const Properties now { { b.get(), b->iterBorn }, b->groupMask, b->clumpId,
			b->isBounded() };
		Properties&      last = bodies_[b->getId()];
		const Identity before = std::get<0>(last);
		const bool     isSame = before == std::get<0>(now);
		hasReplaced_ |= before.first && !isSame;
		// the collider lists the pairs of a new body
		if (all || (isSame && now != last)) changed.push_back(b->getId());
		last = now;
	}
	if (changed.empty()) return changed;
	collider.invalidatePersistentData();
	scene.bodies->checkedByCollider = false;
	scene.doSort                    = true;
	return changed;
}

} // namespace yade
