#pragma once

#include "kernel/step/carry_forward.hpp"
#include "kernel/geometry/planar_shape.hpp"
#include "dem/shapes/RoundedPolygon.hpp"

namespace yade {

class RcrGeom : public GenericSpheresContact {
public:
	~RcrGeom() override;

	void          set(const rcr::Manifold&, const rcr::PlanarShape& one, const rcr::Pose& at1,
	                 const rcr::PlanarShape& two, const rcr::Pose& at2, Real z);
	rcr::Manifold manifold() const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(RcrGeom,GenericSpheresContact,
		"Contact points of two bodies in the plane (shadow overlap): 0, 1 or 2. Normals point from body 1 to body 2. "
		":yref:`normal<GenericSpheresContact.normal>` and :yref:`contactPoint<GenericSpheresContact.contactPoint>` belong to the deepest point.",
		((int,points,0,Attr::readonly,"Number of contact points: 0 (no longer detected), 1 or 2."))
		((int,type,0,Attr::readonly,"0 cap-cap, 1 cap-side, 2 side-side, 3 obstacle (wall, box, facet). A corner of a polygon is a cap. Contacts with fixed grains are 0 to 2."))
		((Vector2r,gap,Vector2r::Zero(),Attr::readonly,"Gap of each point [m]; negative = overlap."))
		((Vector2r,along,Vector2r::Zero(),Attr::readonly,"Position of each point along the tangent, from the middle between the centres, at an obstacle from the centre of the grain [m]."))
		((Vector2r,position1,Vector2r::Zero(),Attr::readonly,"First point [m]."))
		((Vector2r,position2,Vector2r::Zero(),Attr::readonly,"Second point [m]."))
		((Vector2r,normal1,Vector2r::Zero(),Attr::readonly,"Normal at the first point [-]."))
		((Vector2r,normal2,Vector2r::Zero(),Attr::readonly,"Normal at the second point [-]."))
		((Real,shadow,0,Attr::readonly,"Length of the shadow, from the end of one side to the end of the other [m]; 0 with one point."))
		((int,slide,0,Attr::readonly,"Change of the shadow per tangential displacement of body 2: 1, −1, or 0 where both ends belong to one body."))
		((Real,slope,0,Attr::readonly,"Change of the shallower gap per tangential displacement of body 2, at polygons whose normal is that of the other side [-].")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(RcrGeom, GenericSpheresContact);
};
REGISTER_SERIALIZABLE(RcrGeom);

// clang-format off
// Attributes of a FrictPhys with a force per point. A base class would change saved scenes.
#define RCR_POINT_FORCES \
	((int,points,0,Attr::readonly,"Number of contact points that carry the forces.")) \
	((Vector2r,along,Vector2r::Zero(),Attr::readonly,"Position of each point, as :yref:`RcrGeom.along` [m].")) \
	((Vector2r,force1,Vector2r::Zero(),Attr::readonly,"Force at the first point on body 2, (normal, tangential) [N]; the tangent is the normal rotated by +90°.")) \
	((Vector2r,force2,Vector2r::Zero(),Attr::readonly,"Force at the second point [N]."))
// clang-format on

/// Carries the forces of a contact from the points of the last step to those of this step. `Phys`:
/// CdPhys, or RcrFrictPhys.
template <class Phys> void carryForces(const RcrGeom& geom, Phys& phys)
{
	rcr::carryForward(phys.points, phys.along, geom.points, geom.along, phys.force1, phys.force2,
	        Vector2r(Vector2r::Zero()));
	phys.points = geom.points;
	phys.along  = geom.along;
}

/// Base of all Ig2 functors of rcr, which detect contact points in the same way.
class Ig2_Planar_RcrGeom : public IGeomFunctor {
public:
	~Ig2_Planar_RcrGeom() override;
	bool go(const shared_ptr<Shape>&, const shared_ptr<Shape>&, const State&, const State&,
	        const Vector3r&, const bool&, const shared_ptr<Interaction>&) override;
	bool goReverse(const shared_ptr<Shape>& shape1, const shared_ptr<Shape>& shape2,
	        const State& state1, const State& state2, const Vector3r& shift2, const bool& force,
	        const shared_ptr<Interaction>& interaction) override
	{
		interaction->swapOrder();
		return go(shape2, shape1, state2, state1, -shift2, force, interaction);
	}
	// clang-format off
	YADE_CLASS_BASE_DOC(Ig2_Planar_RcrGeom,IGeomFunctor,
		"Contact points of two bodies in the plane by shadow overlap; base of the functors for each pair of shapes. "
		"Body 1 is the obstacle; of two grains it is the :yref:`Sphere`, then the :yref:`Rcr`, then the :yref:`RoundedPolygon`.");
	// clang-format on
};
REGISTER_SERIALIZABLE(Ig2_Planar_RcrGeom);

#define RCR_IG2(Name, One, Two, Doc)                                                               \
	class Name : public Ig2_Planar_RcrGeom {                                                       \
	public:                                                                                        \
		~Name() override;                                                                          \
		FUNCTOR2D(One, Two);                                                                       \
		DEFINE_FUNCTOR_ORDER_2D(One, Two);                                                         \
		YADE_CLASS_BASE_DOC(Name, Ig2_Planar_RcrGeom, Doc);                                        \
	};                                                                                             \
	REGISTER_SERIALIZABLE(Name);

RCR_IG2(Ig2_Rcr_Rcr_RcrGeom, Rcr, Rcr, "Contact points of two :yref:`Rcrs<Rcr>`: the closest one, and the other end of the shadow of facing sides.")
RCR_IG2(Ig2_Wall_Rcr_RcrGeom, Wall, Rcr, "Contact points of an :yref:`Rcr` on a :yref:`Wall`: one per cap within the alert distance. With sense 0, the wall acts on the side of the centre.")
RCR_IG2(Ig2_Box_Rcr_RcrGeom, Box, Rcr, "Contact points of an :yref:`Rcr` and a :yref:`Box`, a rectangle in the plane.")
RCR_IG2(Ig2_Facet_Rcr_RcrGeom, Facet, Rcr, "Contact points of an :yref:`Rcr` and a :yref:`Facet`, a segment in the plane; both sides act.")
RCR_IG2(Ig2_Sphere_Rcr_RcrGeom, Sphere, Rcr, "Contact point of a disc (:yref:`Sphere`) and an :yref:`Rcr`. ``rcr.disc`` sets mass and inertia of a disc.")
RCR_IG2(Ig2_Sphere_Sphere_RcrGeom, Sphere, Sphere, "Contact point of two discs (:yref:`Spheres<Sphere>`) in the plane z = const.")
RCR_IG2(Ig2_Wall_Sphere_RcrGeom, Wall, Sphere, "Contact point of a disc (:yref:`Sphere`) on a :yref:`Wall` normal to x or y.")
RCR_IG2(Ig2_Box_Sphere_RcrGeom, Box, Sphere, "Contact point of a disc (:yref:`Sphere`) and a :yref:`Box`, a rectangle in the plane.")
RCR_IG2(Ig2_Facet_Sphere_RcrGeom, Facet, Sphere, "Contact point of a disc (:yref:`Sphere`) and a :yref:`Facet`, a segment in the plane.")
RCR_IG2(Ig2_RoundedPolygon_RoundedPolygon_RcrGeom, RoundedPolygon, RoundedPolygon, "Contact points of two :yref:`RoundedPolygons<RoundedPolygon>`: the closest one, and the end of the shadow on the flatter side.")
RCR_IG2(Ig2_Rcr_RoundedPolygon_RcrGeom, Rcr, RoundedPolygon, "Contact points of an :yref:`Rcr` and a :yref:`RoundedPolygon`.")
RCR_IG2(Ig2_Sphere_RoundedPolygon_RcrGeom, Sphere, RoundedPolygon, "Contact point of a disc (:yref:`Sphere`) and a :yref:`RoundedPolygon`.")
RCR_IG2(Ig2_Wall_RoundedPolygon_RcrGeom, Wall, RoundedPolygon, "Contact points of a :yref:`RoundedPolygon` on a :yref:`Wall`.")
RCR_IG2(Ig2_Box_RoundedPolygon_RcrGeom, Box, RoundedPolygon, "Contact points of a :yref:`RoundedPolygon` and a :yref:`Box`, a rectangle in the plane.")
RCR_IG2(Ig2_Facet_RoundedPolygon_RcrGeom, Facet, RoundedPolygon, "Contact points of a :yref:`RoundedPolygon` and a :yref:`Facet`, a segment in the plane; both sides act.")

#undef RCR_IG2

} // namespace yade
