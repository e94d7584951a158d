#pragma once

#include <core/Dispatching.hpp>
#include <pkg/common/Box.hpp>
#include <pkg/common/Sphere.hpp>
#include <pkg/common/Wall.hpp>
#include <pkg/dem/DemXDofGeom.hpp>

#include "../kernel/geometry/shadow_overlap.hpp"
#include "Rcr.hpp"

namespace yade {

class RcrGeom : public GenericSpheresContact {
public:
	virtual ~RcrGeom() = default;

	static constexpr double slop = 1e-4; // of R₁ + R₂: overlaps below it are left as they are

	/// Takes over a manifold; `axis` is the line from `center` along which its points are sorted.
	void          set(const rcr::Manifold&, rcr::Vec2 center, rcr::Vec2 axis);
	rcr::Manifold manifold() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RcrGeom,GenericSpheresContact,"Contact geometry of two bodies in the plane, found by shadow overlap: 0, 1 or 2 contact points. Normals point from body 1 to body 2; a positive gap is open. :yref:`normal<GenericSpheresContact.normal>` and :yref:`contactPoint<GenericSpheresContact.contactPoint>` are those of the deepest point.",
		((int,points,0,Attr::readonly,"Number of contact points: 0 (about to be erased), 1 or 2"))
		((int,type,0,Attr::readonly,"0 cap-cap, 1 cap-side, 2 side-side, 3 wall or box"))
		((Vector2r,gap,Vector2r::Zero(),Attr::readonly,"Gap of each point [m]; negative = overlap"))
		((Vector2r,along,Vector2r::Zero(),Attr::readonly,"Place of each point along the axis of the particle (of the first one of a pair), from its centre [m]"))
		((Vector2r,position1,Vector2r::Zero(),Attr::readonly,"First point [m]"))
		((Vector2r,position2,Vector2r::Zero(),Attr::readonly,"Second point [m]"))
		((Vector2r,normal1,Vector2r::Zero(),Attr::readonly,"Normal at the first point [-]"))
		((Vector2r,normal2,Vector2r::Zero(),Attr::readonly,"Normal at the second point [-]")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RcrGeom, GenericSpheresContact);
};
REGISTER_SERIALIZABLE(RcrGeom);

#define RCR_IG2_GO                                                                                                                     \
	bool go(const shared_ptr<Shape>&,                                                                                              \
	        const shared_ptr<Shape>&,                                                                                              \
	        const State&,                                                                                                          \
	        const State&,                                                                                                          \
	        const Vector3r&,                                                                                                       \
	        const bool&,                                                                                                           \
	        const shared_ptr<Interaction>&) override;

#define RCR_IG2_GO_REVERSE                                                                                                             \
	bool goReverse(                                                                                                                \
	        const shared_ptr<Shape>&       shape1,                                                                                 \
	        const shared_ptr<Shape>&       shape2,                                                                                 \
	        const State&                   state1,                                                                                 \
	        const State&                   state2,                                                                                 \
	        const Vector3r&                shift2,                                                                                 \
	        const bool&                    force,                                                                                  \
	        const shared_ptr<Interaction>& interaction) override                                                                   \
	{                                                                                                                              \
		interaction->swapOrder();                                                                                              \
		return go(shape2, shape1, state2, state1, -shift2, force, interaction);                                                \
	}

class Ig2_Rcr_Rcr_RcrGeom : public IGeomFunctor {
public:
	RCR_IG2_GO
	FUNCTOR2D(Rcr, Rcr);
	DEFINE_FUNCTOR_ORDER_2D(Rcr, Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Rcr_Rcr_RcrGeom,IGeomFunctor,"Contact points of two :yref:`Rcrs<Rcr>` by shadow overlap: the closest point and, along facing sides, the other end of the shadow.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Rcr_Rcr_RcrGeom);

class Ig2_Wall_Rcr_RcrGeom : public IGeomFunctor {
public:
	RCR_IG2_GO
	RCR_IG2_GO_REVERSE
	FUNCTOR2D(Wall, Rcr);
	DEFINE_FUNCTOR_ORDER_2D(Wall, Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Wall_Rcr_RcrGeom,IGeomFunctor,"Contact points of a :yref:`Rcr` on a :yref:`Wall` normal to x or y: one for each cap within reach. With :yref:`Wall.sense` = 0 the wall acts on the side where the particle's centre is.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Wall_Rcr_RcrGeom);

class Ig2_Sphere_Rcr_RcrGeom : public IGeomFunctor {
public:
	RCR_IG2_GO
	RCR_IG2_GO_REVERSE
	FUNCTOR2D(Sphere, Rcr);
	DEFINE_FUNCTOR_ORDER_2D(Sphere, Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Sphere_Rcr_RcrGeom,IGeomFunctor,"Contact point of a :yref:`Sphere`, taken as a disc in the plane, and a :yref:`Rcr`. The sphere keeps the mass and inertia of its :yref:`State`.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Sphere_Rcr_RcrGeom);

class Ig2_Box_Rcr_RcrGeom : public IGeomFunctor {
public:
	RCR_IG2_GO
	RCR_IG2_GO_REVERSE
	FUNCTOR2D(Box, Rcr);
	DEFINE_FUNCTOR_ORDER_2D(Box, Rcr);
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Box_Rcr_RcrGeom,IGeomFunctor,"Contact points of a :yref:`Rcr` and a :yref:`Box`, seen in the plane as a rectangle that may be turned about z: a floor, a slope, an obstacle.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Box_Rcr_RcrGeom);

} // namespace yade
