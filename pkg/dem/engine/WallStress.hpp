#pragma once

#include <core/GlobalEngine.hpp>

namespace yade {

class WallStress : public GlobalEngine {
public:
	void action() override;

	/// What is wrong with its walls in a scene; empty: nothing.
	std::string wrong(const Scene&) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(WallStress,GlobalEngine,"Presses a mobile :yref:`Wall` with a constant stress: each step the force stress × length, the length being the present distance of the two walls that bound it. The wall is a body with a mass and one degree of freedom: ``rcr.mobile_wall`` makes it, ``rcr.wall`` one that forces do not move. Stands before :yref:`ContactDynamics` in ``O.engines``.",
		((int,wall,-1,,"Id of the wall"))
		((int,start,-1,,"Id of the wall at one end of it"))
		((int,end,-1,,"Id of the wall at the other end"))
		((Real,stress,0,,"Force on the wall a unit length [N/m, per unit depth: Pa], a component along its axis and no pressure: negative pushes towards smaller coordinates. A right or top wall presses on its grains with the pressure p by ``stress=-p``, a left or bottom one by ``stress=+p``; the other sign pulls it off them."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(WallStress);

} // namespace yade
