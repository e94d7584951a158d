#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "dem/validation/validation.hpp"
#include "overlay.hpp"

namespace yade {

class Gl1_CdPhys : public GlIPhysFunctor {
public:
	void go(const shared_ptr<IPhys>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&,
	        const shared_ptr<Body>&, bool) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_CdPhys,GlIPhysFunctor,"Draws the force of a :yref:`CdPhys` "
			"in the 3D view: from centre to contact to centre, as thick as the normal force. "
			":yref:`Gl1_RcrFrictPhys` draws forces of springs in the same way.",
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

YADE_PLUGIN((Gl1_CdPhys)(Gl1_RcrFrictPhys));

std::string Gl1_CdPhys::color;
Real        Gl1_CdPhys::maxForce;
Real        Gl1_CdPhys::width;

namespace {

	/// Point of application of the resultant force.
	template <class Phys> Vector3r pointOfApplication(const RcrGeom& geom, const Phys& phys)
	{
		const Real one = phys.force1[0], two = geom.points > 1 ? Real(phys.force2[0]) : Real(0);
		if (!(one + two > 0)) return geom.contactPoint;
		return overlay::inSpace(
		        (one * geom.position1 + two * geom.position2) / (one + two), geom.contactPoint[2]);
	}

	void chooseColor(const FrictPhys& phys, const RcrGeom& geom, Real normal)
	{
		if (Gl1_CdPhys::color == "type") return overlay::colorOfType(geom.type);
		if (Gl1_CdPhys::color == "mobilization") {
			const Real limit = phys.tangensOfFrictionAngle * normal;
			return overlay::colorOfNumber(limit > 0 ? double(phys.shearForce.norm() / limit) : 0);
		}
		overlay::colorOfNumber(double(normal / Gl1_CdPhys::maxForce));
	}

	template <class Phys>
	void drawForce(const Phys& phys, const Interaction& i, const Body* one, const Body* two,
	        const Scene& scene)
	{
		const RcrGeom* geom   = dynamic_cast<const RcrGeom*>(i.geom.get());
		const Real     normal = phys.normalForce.norm();
		if (!geom || geom->points == 0 || !one || !two || !(normal > 0)) return;
		Gl1_CdPhys::maxForce = math::max(Gl1_CdPhys::maxForce, normal);
		const overlay::Flat flat;
		const Real          half = Gl1_CdPhys::width * math::min(geom->refR1, geom->refR2) * normal
		        / Gl1_CdPhys::maxForce;
		const Vector3r contact = pointOfApplication(*geom, phys);
		const Vector3r shift   = overlay::intoCell(scene, contact);
		const Vector3r image   = scene.isPeriodic ? Vector3r(scene.cell->intrShiftPos(i.cellDist))
		                                          : Vector3r(Vector3r::Zero());
		chooseColor(phys, *geom, normal);
		if (validation::isGrain(*one))
			overlay::ribbon(shift + one->state->pos, shift + contact, half);
		if (validation::isGrain(*two))
			overlay::ribbon(shift + contact, shift + two->state->pos + image, half);
	}

} // namespace

void Gl1_CdPhys::go(const shared_ptr<IPhys>& phys, const shared_ptr<Interaction>& i,
        const shared_ptr<Body>& one, const shared_ptr<Body>& two, bool)
{
	drawForce(static_cast<const CdPhys&>(*phys), *i, one.get(), two.get(), *scene);
}

void Gl1_RcrFrictPhys::go(const shared_ptr<IPhys>& phys, const shared_ptr<Interaction>& i,
        const shared_ptr<Body>& one, const shared_ptr<Body>& two, bool)
{
	drawForce(static_cast<const RcrFrictPhys&>(*phys), *i, one.get(), two.get(), *scene);
}

} // namespace yade
