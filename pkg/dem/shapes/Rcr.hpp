#pragma once

#include <core/Dispatching.hpp>
#include <core/Shape.hpp>
#include <pkg/common/Bo1_Aabb.hpp>

#include "kernel/geometry/stadium.hpp"

namespace yade {

class Rcr : public Shape {
public:
	virtual ~Rcr() = default;
	void postLoad(Rcr&); // refuses what is no stadium

	rcr::Stadium stadium() const { return { double(halfLength), double(capRadius) }; }
	double       circumscribedRadius() const { return double(halfLength + capRadius); }

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(Rcr,Shape,"Rounded-cap rectangle in the plane z = const: all points within :yref:`capRadius<Rcr.capRadius>` of a core segment of half length :yref:`halfLength<Rcr.halfLength>` along the local x axis. The circumscribed radius is $R=a+R'$, the elongation $\\eta=a/R$; a half length of 0 is a disc. ``rcr.particle`` makes a body of it from $R$ and $\\eta$ with the right mass and inertia.",
		((Real,capRadius,NaN,Attr::triggerPostLoad,"Radius R' of the caps [m]; > 0"))
		((Real,halfLength,0,Attr::triggerPostLoad,"Half length a of the core segment [m]; ≥ 0")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(Rcr, Shape);
};
REGISTER_SERIALIZABLE(Rcr);

class Bo1_Rcr_Aabb : public BoundFunctor {
public:
	void go(const shared_ptr<Shape>&, shared_ptr<Bound>&, const Se3r&, const Body*) override;
	FUNCTOR1D(Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Bo1_Rcr_Aabb,BoundFunctor,"Creates the :yref:`Aabb` of a :yref:`Rcr`: the box of its circumscribed circle, which a rotation between two runs of the collider does not leave, enlarged by the distance within which the contact law needs to see it (``kernel/step/missed_contacts.hpp``). :yref:`InsertionSortCollider.verletDist` is added by YADE; set it to a positive value, since YADE finds one by itself for spheres only.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Bo1_Rcr_Aabb);

class Bo1_Disc_Aabb : public Bo1_Sphere_Aabb {
public:
	void go(const shared_ptr<Shape>&, shared_ptr<Bound>&, const Se3r&, const Body*) override;
	// clang-format off
	YADE_CLASS_BASE_DOC(Bo1_Disc_Aabb,Bo1_Sphere_Aabb,"Creates the :yref:`Aabb` of a :yref:`Sphere` that is a disc of a scene with :yref:`ContactDynamics`: enlarged by the distance within which the contact law needs to see it, as :yref:`Bo1_Rcr_Aabb` does. ContactDynamics puts it in the place of a :yref:`Bo1_Sphere_Aabb`.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Bo1_Disc_Aabb);

} // namespace yade
