#include "dem/shapes/Rcr.hpp"

#include "dem/errors/messages.hpp"
#include "dem/shapes/planeConversion.hpp"

namespace yade {

void Rcr::postLoad(Rcr&)
{
	const auto reject = [](const char* name, Real given, const char* expected) {
		rcr::refuse("Rcr.", name, " = ", errors::text(given), "; expected ", expected,
		        ". rcr.particle(center, R, eta) computes both from the circumscribed radius and "
		        "the elongation.");
	};
	const bool unset = math::isnan(capRadius) && halfLength == 0; // as constructed
	if (!unset && !(capRadius > 0 && math::isfinite(capRadius)))
		reject("capRadius", capRadius, "a finite length > 0");
	if (!(halfLength >= 0 && math::isfinite(halfLength)))
		reject("halfLength", halfLength, "a finite length ≥ 0");
}

Vector3r boxWidening(const Scene& scene)
{
	Vector3r wider = Vector3r::Ones();
	if (!scene.isPeriodic || !scene.cell->hasShear()) return wider;
	for (int axis = 0; axis < 3; ++axis)
		for (int other : { (axis + 1) % 3, (axis + 2) % 3 })
			wider[axis] += 0.5 * (1 / scene.cell->getCos()[other] - 1);
	return wider;
}

/// Box around a circle of `factor` × (circumscribed radius + alert distance). In a sheared cell its
/// coordinates are those of unsheared space. YADE's collider ends the process if a box spans half
/// of a cell, so the look-ahead is limited there. The step then detects the other contacts.
static void setBox(const Shape& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body& body,
        Real factor, const Scene& scene)
{
	const rcr::PlanarShape planar = plane::shapeOf(shape, *body.state, body.state->pos.z());
	const Real             radius = factor * planar.radius();
	Real ahead
	        = factor * rcr::alertDistance(planar, plane::velocityOf(*body.state), double(scene.dt));
	if (!bound) bound = boost::make_shared<Aabb>();
	const Vector3r wider  = boxWidening(scene);
	Vector3r       center = se3.position;
	if (scene.isPeriodic) {
		ahead += factor * rcr::imageReach(planar, plane::cellOf(scene).imageSpeed, double(scene.dt));
		const Real most = largestBoxShare * scene.cell->getSize().minCoeff() / wider.maxCoeff();
		ahead           = math::max(Real(0), math::min(ahead, most - radius));
		center          = scene.cell->unshearPt(center);
	}
	const Vector3r half = (radius + ahead) * wider;
	bound->min = center - half;
	bound->max = center + half;
}

void Bo1_Rcr_Aabb::go(
        const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body* body)
{
	setBox(*shape, bound, se3, *body, 1, *scene);
}

void Bo1_Disc_Aabb::go(
        const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body* body)
{
	setBox(*shape, bound, se3, *body, math::max(Real(1), aabbEnlargeFactor), *scene);
}

} // namespace yade
