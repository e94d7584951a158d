// Rules of validation on the periodic cell.
#include "dem/loads/CellStress.hpp"
#include "dem/validation/SceneQuery.hpp"

namespace yade::validation {

std::string wallsInCell(const SceneQuery& v)
{
	const Body* wall = v.scene.isPeriodic ? v.body<Wall>() : nullptr;
	if (!wall) return {};
	return bodyNames({ wall->getId() })
	        + " is a Wall in a periodic cell, which has no boundary; remove it, or use rcr.segment or "
	          "fixed grains.";
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
	        + " is a Box in a sheared periodic cell; use rcr.segment or fixed grains, or leave the cell "
	          "rectangular.";
}

/// Half the box of a body in any direction, at most. That of a Facet is not that of its segment.
static Real halfBox(const Body& b)
{
	const auto* facet = dynamic_cast<const Facet*>(b.shape.get());
	if (!facet) return plane::shapeOf(*b.shape, *b.state, b.state->pos.z()).radius();
	Real longest = 0; // edge
	for (int k = 0; k < 3; ++k)
		longest = math::max(longest, (facet->vertices[k] - facet->vertices[(k + 1) % 3]).norm());
	return longest / 2;
}

/// Largest distance of the outlines of two members, at most.
static Real lengthOf(const Body& clump, const Scene& scene)
{
	Real        length = 0;
	const auto& members = static_cast<const Clump&>(*clump.shape).members;
	for (const auto& [id1, place1] : members)
		for (const auto& [id2, place2] : members)
			length = math::max(length,
			        (place1.position - place2.position).norm() + halfBox(*(*scene.bodies)[id1])
			                + halfBox(*(*scene.bodies)[id2]));
	return length;
}

static std::string longClump(const Body& clump, const Scene& scene, Real wider)
{
	const Vector3r size    = scene.cell->getSize();
	const Real     inPlane = math::min(size[0], size[1]);
	Real           radius  = 0; // a bound that costs less
	for (const auto& [id, place] : static_cast<const Clump&>(*clump.shape).members)
		radius = math::max(radius, place.position.norm() + halfBox(*(*scene.bodies)[id]));
	if (wider * 2 * radius < inPlane) return {};
	const Real length = lengthOf(clump, scene);
	if (wider * length < inPlane) return {};
	return "the clump " + bodyNames({ clump.getId() }) + " is up to " + text(length)
	        + " long and the periodic cell is " + text(inPlane)
	        + " wide at its narrowest, so the clump would meet its own image; expected a larger "
	          "cell: O.cell.setBox(…).";
}

/// Least radius of a Sphere; 0 without one.
static Real smallestSphere(const Scene& scene)
{
	Real least = std::numeric_limits<Real>::infinity();
	for (const auto& b : *scene.bodies)
		if (const auto* sphere = b ? dynamic_cast<const Sphere*>(b->shape.get()) : nullptr)
			least = math::min(least, sphere->radius);
	return math::isinf(least) ? Real(0) : least;
}

/// Rejects cells in which YADE's collider would end the process, since a body spans half of the
/// cell.
std::string smallCell(const SceneQuery& v)
{
	if (!v.scene.isPeriodic) return {};
	// YADE ends at half boxes of 0.25 cells; 0.24 leaves a margin for shrinking
	constexpr Real most = 0.24;
	const auto* collider = v.first<InsertionSortCollider>();
	const Real wider = boxWidening(v.scene).maxCoeff();
	const Real size  = v.scene.cell->getSize().minCoeff();
	Real       margin = collider ? collider->verletDist : Real(0);
	if (margin < 0) margin *= -smallestSphere(v.scene); // as the collider does
	for (const auto& b : *v.scene.bodies) {
		if (!b || !b->shape) continue;
		if (b->isClump()) {
			const std::string error = longClump(*b, v.scene, wider);
			if (!error.empty()) return error;
			continue;
		}
		const auto* box = dynamic_cast<const Box*>(b->shape.get());
		if (box && !(box->extents[2] + margin < most * v.scene.cell->getSize()[2]))
			return bodyNames({ b->getId() }) + " is a Box with the half width "
			        + text(box->extents[2]) + " along z in a periodic cell of the depth "
			        + text(v.scene.cell->getSize()[2])
			        + "; expected a depth of more than 4.2 times half width + verletDist: "
			          "O.cell.setBox(…).";
		const Real half = halfBox(*b);
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
