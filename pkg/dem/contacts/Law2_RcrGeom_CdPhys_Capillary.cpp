// Rigid contacts with liquid bridges: the adhesion of a contact acts over a distance.
//
//   p_n + f_a dt ≥ 0 replaces p_n ≥ 0 at each point with g ≤ `rupture`, while there is a bridge
//
// f_a: CdPhys.adhesion, the capillary force of a point; g: its gap. A bridge forms when a point of
// the contact touches, and breaks when all gaps exceed `rupture`. It lasts beyond the range of
// detection: Ig2 functors leave a contact without points to its law.
#include "dem/contacts/CdPhys.hpp"
#include "dem/errors/messages.hpp"
#include "kernel/step/step.hpp"

namespace yade {

class CapillaryCdPhys : public CdPhys {
public:
	CapillaryCdPhys(const CdPhys& dry) : CapillaryCdPhys() { CdPhys::operator=(dry); }
	rcr::ContactLaw law() const override
	{
		rcr::ContactLaw law = CdPhys::law();
		law.adhesionRange   = double(bridge);
		return law;
	}
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS_CTOR(CapillaryCdPhys,CdPhys,
		"Rigid contact that can hold a liquid bridge; :yref:`Law2_RcrGeom_CdPhys_Capillary` "
		"creates it.",
		((Real,bridge,0,Attr::readonly,"Gap at which the bridge breaks [m]; 0: no bridge.")),
		createIndex();
	);
	// clang-format on
	REGISTER_CLASS_INDEX(CapillaryCdPhys, CdPhys);
};
REGISTER_SERIALIZABLE(CapillaryCdPhys);

class Law2_RcrGeom_CdPhys_Capillary : public Law2_RcrGeom_CdPhys_SignoriniCoulomb {
public:
	void postLoad(Law2_RcrGeom_CdPhys_Capillary&)
	{
		if (!(rupture >= 0 && math::isfinite(rupture)))
			rcr::refuse("Law2_RcrGeom_CdPhys_Capillary.rupture = ", errors::text(rupture),
			        "; expected a length of 0 m (no bridges) or more.");
	}
	bool go(shared_ptr<IGeom>& igeom, shared_ptr<IPhys>& iphys, Interaction* contact) override
	{
		RcrGeom&         geom = static_cast<RcrGeom&>(*igeom);
		CapillaryCdPhys* phys = dynamic_cast<CapillaryCdPhys*>(iphys.get());
		const bool       near = geom.points > 0;
		if (phys && phys->bridge > 0) detectAtAnyDistance(*contact);
		if (!Law2_RcrGeom_CdPhys_SignoriniCoulomb::go(igeom, iphys, contact)) return false;
		if (!phys) { // the first step of the contact
			auto made = boost::make_shared<CapillaryCdPhys>(static_cast<CdPhys&>(*iphys));
			phys      = made.get();
			iphys     = made;
		}
		bool       touches = false, inReach = false;
		const Real slop = rcr::contactSlop * (geom.refR1 + geom.refR2);
		for (int k = 0; k < geom.points; ++k) {
			const Real last = (k == 0 ? phys->force1 : phys->force2)[0];
			touches |= geom.gap[k] <= slop || last > 0; // or it rebounded in the last step
			inReach |= geom.gap[k] <= rupture;
		}
		phys->bridge = touches || (phys->bridge > 0 && inReach) ? rupture : Real(0);
		return near || phys->bridge > 0;
	}
	FUNCTOR2D(RcrGeom, CdPhys);
	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(
		Law2_RcrGeom_CdPhys_Capillary,Law2_RcrGeom_CdPhys_SignoriniCoulomb,
		"Rigid contacts with liquid bridges: :yref:`CdPhys.adhesion` is the capillary force of "
		"each point. A bridge forms on contact. It pulls with this force at all points whose gap "
		"is at most the rupture length, and breaks when all gaps exceed this length.",
		((Real,rupture,0,Attr::triggerPostLoad,"Largest gap of a bridge [m]."))
	);
	// clang-format on

private:
	void detectAtAnyDistance(const Interaction& contact)
	{
		const Body&        one = *Body::byId(contact.getId1(), scene);
		const Body&        two = *Body::byId(contact.getId2(), scene);
		Ig2_Planar_RcrGeom detection;
		detection.scene = scene;
		detection.go(one.shape, two.shape, *one.state, *two.state, Vector3r::Zero(), true,
		        (*scene->interactions)[contact.linIx]);
	}
};
REGISTER_SERIALIZABLE(Law2_RcrGeom_CdPhys_Capillary);
YADE_PLUGIN((CapillaryCdPhys)(Law2_RcrGeom_CdPhys_Capillary));

} // namespace yade
