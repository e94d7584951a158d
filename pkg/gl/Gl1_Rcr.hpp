#pragma once

#include "dem/shapes/Rcr.hpp"

namespace yade {

class Gl1_Rcr : public GlShapeFunctor {
public:
	void go(const shared_ptr<Shape>&, const shared_ptr<State>&, bool, const GLViewInfo&) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_Rcr,GlShapeFunctor,"Draws a :yref:`Rcr` in the 3D view: a "
			"plate with sides and caps, in its :yref:`color<Shape.color>`.",
		((bool,wire,false,,"Draws the outlines only."))
		((bool,mark,true,,"Draws a line from the centre to one end, which shows rotations."))
		((Real,depth,0.5,,"Thickness of the plate over the diameter of the caps [-]; 0: flat."))
		((int,slices,12,,"Number of straight pieces of each cap."))
	);
	// clang-format on
	RENDERS(Rcr);
};
REGISTER_SERIALIZABLE(Gl1_Rcr);

} // namespace yade
