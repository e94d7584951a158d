#pragma once

#include "dem/contacts/CdPhys.hpp"
#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"

namespace yade {

class Gl1_CdPhys : public GlIPhysFunctor {
public:
	void go(const shared_ptr<IPhys>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&,
	        const shared_ptr<Body>&, bool) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_CdPhys,GlIPhysFunctor,"Draws the force of a :yref:`CdPhys` "
			"in the 3D view: from centre to contact to centre, as thick as the normal force. "
			":yref:`Gl1_RcrFrictPhys` draws forces of the smooth law in the same way.",
		((std::string,color,"force",,"Quantity shown by the colour: ``force`` (blue to red, up to "
				":yref:`maxForce<Gl1_CdPhys.maxForce>`), ``type`` (cap-cap blue, cap-side green, "
				"side-side red, obstacles light grey) or ``mobilization`` ($|f_t|/\\mu f_n$, blue "
				"to red)."))
		((Real,maxForce,0,,"Normal force of the thickest line [N]; larger forces raise it. Set 0 "
				"to reset it."))
		((Real,width,0.2,,"Half thickness of the thickest line over the smaller of the "
				"circumscribed radii [-]."))
	);
	// clang-format on
	RENDERS(CdPhys);
};
REGISTER_SERIALIZABLE(Gl1_CdPhys);

class Gl1_RcrFrictPhys : public GlIPhysFunctor {
public:
	void go(const shared_ptr<IPhys>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&,
	        const shared_ptr<Body>&, bool) override;
	// clang-format off
	YADE_CLASS_BASE_DOC(Gl1_RcrFrictPhys,GlIPhysFunctor,"Draws the force of a contact of "
			":yref:`Law2_RcrGeom_FrictPhys_CundallStrack` in the 3D view, with the attributes of "
			":yref:`Gl1_CdPhys`.");
	// clang-format on
	RENDERS(RcrFrictPhys);
};
REGISTER_SERIALIZABLE(Gl1_RcrFrictPhys);

} // namespace yade
