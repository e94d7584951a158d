#include "Rcr.hpp"

#include <core/Aabb.hpp>

#include "AlertDistance.hpp"

namespace yade {

YADE_PLUGIN((Rcr)(Bo1_Rcr_Aabb));

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

void Bo1_Rcr_Aabb::go(const shared_ptr<Shape>& shape, shared_ptr<Bound>& bound, const Se3r& se3, const Body* body)
{
	const Rcr& particle = static_cast<const Rcr&>(*shape);
	if (!bound) bound = boost::make_shared<Aabb>();
	const double   half  = particle.circumscribedRadius() + alertDistance(particle, plane::twist(*body->state), double(scene->dt));
	const Vector3r reach = Vector3r::Constant(half);
	bound->min           = se3.position - reach;
	bound->max           = se3.position + reach;
}

} // namespace yade
