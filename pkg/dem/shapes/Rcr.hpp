#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade {

class Rcr : public Shape {
public:
	~Rcr() override;
	void postLoad(Rcr&); // throws if an attribute is invalid

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(Rcr,Shape,
		"Rounded-cap rectangle in the plane z = const: all points within capRadius of a core segment along the local x axis. "
		"``rcr.particle`` makes a body from the circumscribed radius $R=a+R'$ and the elongation $\\eta=a/R$.",
		((Real,capRadius,NaN,Attr::triggerPostLoad,"Radius R' of the caps [m]; > 0."))
		((Real,halfLength,0,Attr::triggerPostLoad,"Half length a of the core segment [m]; ≥ 0.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(Rcr, Shape);
};
REGISTER_SERIALIZABLE(Rcr);

/// Largest half box of a body over the size of a periodic cell. YADE's collider needs boxes of
/// less than half a cell, with its margin (verletDist).
constexpr double largestBoxShare = 0.2;

/// Factor by which the box of a circle grows along each axis in the unsheared space of YADE's
/// collider; 1 without shear.
Vector3r boxWidening(const Scene&);

class Bo1_Rcr_Aabb : public BoundFunctor {
public:
	~Bo1_Rcr_Aabb() override;
	void go(const shared_ptr<Shape>&, shared_ptr<Bound>&, const Se3r&, const Body*) override;
	FUNCTOR1D(Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Bo1_Rcr_Aabb,BoundFunctor,
		"Creates the :yref:`Aabb` of an :yref:`Rcr`: the box of its circumscribed circle, enlarged by its alert distance. "
		"Set :yref:`InsertionSortCollider.verletDist` to a positive length, since YADE derives it for spheres only.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Bo1_Rcr_Aabb);

class Bo1_Disc_Aabb : public Bo1_Sphere_Aabb {
public:
	~Bo1_Disc_Aabb() override;
	void go(const shared_ptr<Shape>&, shared_ptr<Bound>&, const Se3r&, const Body*) override;
	// clang-format off
	YADE_CLASS_BASE_DOC(Bo1_Disc_Aabb,Bo1_Sphere_Aabb,
		"Creates the :yref:`Aabb` of a disc (:yref:`Sphere`), enlarged by its alert distance. "
		":yref:`ContactDynamics` replaces a :yref:`Bo1_Sphere_Aabb` by it.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Bo1_Disc_Aabb);

} // namespace yade
