#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade {

class WallStress : public GlobalEngine {
public:
	void action() override;

	/// Message about an invalid attribute in a scene; empty: all are valid.
	std::string attributeError(const Scene&) const;
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(WallStress,GlobalEngine,
		"Constant stress on a mobile :yref:`Wall`, made by ``rcr.mobile_wall``. The force is stress × distance of the two walls that "
		"bound it. It must stand before :yref:`ContactDynamics` in ``O.engines``.",
		((int,wall,-1,,"Id of the wall."))
		((int,start,-1,,"Id of the wall at one end."))
		((int,end,-1,,"Id of the wall at the other end."))
		((Real,stress,0,,"Force on the wall per length, along its axis [Pa]. Use −p for a pressure p on a right or top wall, +p on a left or bottom wall."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(WallStress);

} // namespace yade
