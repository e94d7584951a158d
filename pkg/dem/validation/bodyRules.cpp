// Rules of validation on bodies: materials, and obstacles that reach the plane of the grains.
#include "dem/shapes/planarShape.hpp"
#include "dem/validation/SceneView.hpp"

namespace yade::validation {

std::string materials(const View& v)
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

/// Obstacles without a finite size, or that never meet the plane of the grains.
std::string obstaclesOutOfPlane(const View& v)
{
	const Real z = planeOf(v.scene);
	if (math::isnan(z)) return {};
	for (const auto& b : *v.scene.bodies) {
		if (!b || !b->shape || isGrain(*b)) continue;
		if (const Box* box = dynamic_cast<const Box*>(b->shape.get())) {
			const Vector3r& half = box->extents;
			if (!(half[0] >= 0 && half[1] >= 0 && math::isfinite(half[0] + half[1])))
				return bodyNames({ b->getId() }) + " is a Box with the extents " + coordinates(half)
				        + ", so nothing would meet it; expected finite half widths ≥ 0.";
			if (!(math::abs(b->state->pos.z() - z) <= half[2]))
				return bodyNames({ b->getId() }) + " is a Box at z = " + text(b->state->pos.z())
				        + " that does not reach the plane z = " + text(z)
				        + " of the grains, so nothing would meet it; set its z, or its "
				          "extents.";
		}
		if (dynamic_cast<const Facet*>(b->shape.get())
		        && plane::shapeOf(*b->shape, *b->state, z).kind == rcr::PlanarShape::none)
			return bodyNames({ b->getId() }) + " is a Facet that does not cut the plane z = "
			        + text(z)
			        + " of the grains; a Facet is the segment in which it does: put a "
			          "corner on either side, or remove it.";
	}
	return {};
}

} // namespace yade::validation
