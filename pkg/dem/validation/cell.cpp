// Rules of validation on the periodic cell.
#include "dem/engine/CellStress.hpp"
#include "dem/validation/SceneQuery.hpp"

namespace yade::validation {

std::string wallsInCell(const SceneQuery& v)
{
	const Body* wall = v.scene.isPeriodic ? v.body<Wall>() : nullptr;
	if (!wall) return {};
	return bodyNames({ wall->getId() })
	        + " is a Wall in a periodic cell, which has no boundary; remove it, or use rcr.segment or "
	          "fixed Rcrs.";
}

std::string cellStress(const SceneQuery& v)
{
	if (v.law == springs && v.indexOf<CellStress>() >= 0)
		return "CellStress presses the cell of ContactDynamics, and contacts are springs; take "
		       "PeriTriaxController(dynCell=True).";
	if (v.indexOf<CellStress>() >= 0 && !v.scene.isPeriodic)
		return "CellStress has no cell to press; set O.periodic = True and O.cell.setBox(…), "
		       "or remove it.";
	if (v.law != rigid) return {};
	const int controller = std::max({ v.indexOf<PeriTriaxController>(),
	        v.indexOf<PeriIsoCompressor>(), v.indexOf<Peri3dController>() });
	if (controller < 0) return {};
	return v.engines[controller]->getClassName()
	        + " moves the cell by stiffnesses or by last stresses, which rigid contacts do not have or "
	          "answer without bound; use rcr.CellStress.";
}

std::string velocityGradient(const SceneQuery& v)
{
	if (!v.scene.isPeriodic) return {};
	const Matrix3r gradient = plane::nextGradient(*v.scene.cell);
	if (!math::isfinite(gradient.sum()))
		return "O.cell.velGrad is not finite; expected a velocity gradient in 1/s.";
	const bool sheared = v.scene.cell->hasShear()
	        || gradient != Matrix3r(gradient.diagonal().asDiagonal());
	const Body* box = sheared ? v.body<Box>() : nullptr; // YADE ends the process
	if (!box) return {};
	return bodyNames({ box->getId() })
	        + " is a Box in a sheared periodic cell; use rcr.segment or fixed Rcrs, or leave the cell "
	          "rectangular.";
}

/// Bounds the half box of a Facet in any direction.
static Real halfLongestEdge(const Facet& facet)
{
	Real longest = 0;
	for (int k = 0; k < 3; ++k)
		longest = math::max(longest, (facet.vertices[k] - facet.vertices[(k + 1) % 3]).norm());
	return longest / 2;
}

/// Rejects cells in which YADE's collider would end the process, since a body spans half of the
/// cell.
std::string smallCell(const SceneQuery& v)
{
	if (!v.scene.isPeriodic) return {};
	// YADE ends at half boxes of 0.25 cells; 0.24 leaves a margin for shrinking
	constexpr Real most = 0.24;
	const auto* collider = v.first<InsertionSortCollider>();
	const Real     margin   = collider ? math::max(Real(0), collider->verletDist) : Real(0),
	           wider        = boxWidening(v.scene).maxCoeff();
	const Real  size   = v.scene.cell->getSize().minCoeff();
	for (const auto& b : *v.scene.bodies) {
		if (!b || !b->shape || b->isClump()) continue;
		const Real half = b->shape->getClassIndex() == Facet::getClassIndexStatic()
		        ? halfLongestEdge(static_cast<const Facet&>(*b->shape)) // not of its segment
		        : plane::shapeOf(*b->shape, *b->state, b->state->pos.z()).radius();
		if (wider * half + margin < most * size && largestBoxShare * size + margin < most * size)
			continue;
		return "the periodic cell is " + text(size) + " wide at its narrowest, "
		        + bodyNames({ b->getId() }) + " has the radius " + text(half)
		        + " and the collider a verletDist of " + text(margin)
		        + "; expected a cell of more than 4.2 times radius + verletDist, and 25 times "
		          "verletDist, along all three axes: O.cell.setBox(…)."
		        + (wider > 1 ? " The cell is sheared, so that radii count " + text(wider)
		                                + " times: O.cell.flipCell()."
		                     : std::string());
	}
	return {};
}

} // namespace yade::validation
