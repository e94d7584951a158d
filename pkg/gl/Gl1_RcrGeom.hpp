#pragma once

#include "dem/contacts/RcrGeom.hpp"

namespace yade {

class Gl1_RcrGeom : public GlIGeomFunctor {
public:
	void go(const shared_ptr<IGeom>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&,
	        const shared_ptr<Body>&, bool) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_RcrGeom,GlIGeomFunctor,"Draws the contact points of a "
			":yref:`RcrGeom` in the 3D view, coloured by type: cap-cap blue, cap-side green, "
			"side-side red, obstacles light grey.",
		((bool,normals,true,,"Draws the normal of each point, from body 1 to body 2."))
		((Real,length,0.5,,"Length of a normal over the smaller of the circumscribed radii [-]."))
		((Real,pointSize,5,,"Size of a point [pixels]."))
	);
	// clang-format on
	RENDERS(RcrGeom);
};
REGISTER_SERIALIZABLE(Gl1_RcrGeom);

} // namespace yade
