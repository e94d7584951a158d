#include "Rcr.hpp"

#include <core/Aabb.hpp>

#include "planarShape.hpp"

namespace yade {

YADE_PLUGIN((Rcr)(Bo1_Rcr_Aabb)(Bo1_Disc_Aabb));

void Rcr::postLoad(Rcr&)
{
	const auto refuse = [](const char* name, Real given, const char* wanted) {
		throw std::invalid_argument(
		        std::string("Rcr.") + name + " = " + boost::lexical_cast<std::string>(given) + "; wanted " + wanted
		        + ". rcr.particle(center, R, eta) computes both from the circumscribed radius and the elongation.");
	};
	const bool unset = math::isnan(capRadius) && halfLength == 0; // as constructed, before a file or a script fills it in
	if (!unset && !(capRadius > 0 && math::isfinite(capRadius))) refuse("capRadius", capRadius, "a finite length > 0");
	if (!(halfLength >= 0 && math::isfinite(halfLength))) refuse("halfLength", halfLength, "a finite length ≥ 0");
}

namespace {

	/// The box of a circle; in a sheared cell that of the unsheared space, wide enough for the circle seen there.
	void setBox(shared_ptr<Bound>& bound, const Se3r& se3, Real radius, const Scene& scene)
	{
		if (!bound) bound = boost::make_shared<Aabb>();
		Vector3r half = Vector3r::Constant(radius), center = se3.position;
		if (scene.isPeriodic) {
			const Cell& cell = *scene.cell;
			center           = cell.unshearPt(center);
			for (int axis = 0; cell.hasShear() && axis < 3; ++axis) {
				const Real wider = 0.5 * radius * (1 / cell.getCos()[axis] - 1);
				half[(axis + 1) % 3] += wider;
				half[(axis + 2) % 3] += wider;
			}
		}
		bound->min = center - half;
		bound->max = center + half;
	}

	Real reach(const Shape& shape, const Body& body, const Scene& scene)
	{
		const rcr::PlanarShape planar = plane::shapeOf(shape, *body.state, body.state->pos.z());
		return planar.radius() + rcr::alertDistance(planar, plane::twist(*body.state), double(scene.dt));
	}

} // namespace

void Bo1_Rcr_Aabb::go(const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body* body)
{
	setBox(bound, se3, reach(*shape, *body, *scene), *scene);
}

void Bo1_Disc_Aabb::go(const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body* body)
{
	setBox(bound, se3, math::max(Real(1), aabbEnlargeFactor) * reach(*shape, *body, *scene), *scene);
}

} // namespace yade
