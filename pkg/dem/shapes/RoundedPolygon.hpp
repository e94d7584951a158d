#pragma once

#include "dem/shapes/Rcr.hpp"
#include "kernel/geometry/planar_shape.hpp"

namespace yade {

class RoundedPolygon : public Shape {
public:
	~RoundedPolygon() override;
	void postLoad(RoundedPolygon&); // throws if an attribute is invalid

	/// Message about an invalid attribute; empty: none.
	std::string attributeError() const;

	rcr::PlanarShape planar; // its shape in the plane, by postLoad

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RoundedPolygon,Shape,
		"Rounded convex polygon in the plane z = const: all points within :yref:`radius<RoundedPolygon.radius>` of a core polygon. "
		"``rcr.polygon`` makes a body with its centre of mass, mass and inertia.",
		((vector<Vector2r>,vertices,,Attr::triggerPostLoad,"Corners of the core, 1 to 64, convex and counter-clockwise, in the frame of the body about its centre of mass [m]."))
		((Real,radius,0,Attr::triggerPostLoad,"Rounding radius [m]; ≥ 0, and > 0 with less than three vertices.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RoundedPolygon, Shape);
};
REGISTER_SERIALIZABLE(RoundedPolygon);

class Bo1_RoundedPolygon_Aabb : public Bo1_Rcr_Aabb {
public:
	~Bo1_RoundedPolygon_Aabb() override;
	FUNCTOR1D(RoundedPolygon);
	// clang-format off
	YADE_CLASS_BASE_DOC(Bo1_RoundedPolygon_Aabb,Bo1_Rcr_Aabb,
		"Creates the :yref:`Aabb` of a :yref:`RoundedPolygon`: the box of its circumscribed circle, enlarged by its alert distance.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Bo1_RoundedPolygon_Aabb);

} // namespace yade
