// Draws contacts in the plane: on top of the grains, without lighting.
#include <GL/gl.h>

#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "dem/validation/validation.hpp"

namespace yade {

class Gl1_RcrGeom : public GlIGeomFunctor {
public:
	void go(const shared_ptr<IGeom>&, const shared_ptr<Interaction>&, const shared_ptr<Body>&,
	        const shared_ptr<Body>&, bool) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_RcrGeom,GlIGeomFunctor,"Draws the contact points of a "
			":yref:`RcrGeom` in the 3D view, coloured by type: cap-cap blue, cap-side green, "
			"side-side red, obstacles light grey.",
		((bool,normals,true,,"Draws the normal of each point, from body 1 to body 2."))
		((Real,length,0.5,,"Length of a normal over the smaller of the circumscribed radii [-]."))
		((Real,pointSize,5,,"Size of a point [pixels]."))
	);
	// clang-format on
	RENDERS(RcrGeom);
};
REGISTER_SERIALIZABLE(Gl1_RcrGeom);

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

YADE_PLUGIN((Gl1_RcrGeom)(Gl1_CdPhys)(Gl1_RcrFrictPhys));

bool        Gl1_RcrGeom::normals;
Real        Gl1_RcrGeom::length;
Real        Gl1_RcrGeom::pointSize;
std::string Gl1_CdPhys::color;
Real        Gl1_CdPhys::maxForce;
Real        Gl1_CdPhys::width;

namespace {

	/// OpenGL state for lines and ribbons on top of all grains. Restores the previous state.
	class Flat {
	public:
		Flat()
		{
			glPushAttrib(GL_ENABLE_BIT | GL_LINE_BIT | GL_POINT_BIT | GL_CURRENT_BIT);
			glDisable(GL_LIGHTING);
			glDisable(GL_DEPTH_TEST);
			glDisable(GL_CULL_FACE);
		}
		~Flat() { glPopAttrib(); }
		Flat(const Flat&) = delete;
	};

	/// Colours of contact types; rcr.plot draws obstacles darker.
	void colorOfType(int type)
	{
		static const double colors[4][3] = {
			{ 0.12, 0.47, 0.71 }, { 0.17, 0.63, 0.17 }, { 0.84, 0.15, 0.16 }, { 0.8, 0.8, 0.8 }
		};
		glColor3dv(colors[type >= 0 && type < 3 ? type : 3]);
	}

	/// Colour of a number from 0 to 1: blue, yellow, red.
	void colorOfNumber(double x)
	{
		x = std::min(std::max(x, 0.0), 1.0);
		const double green = x < 0.5 ? 0.4 + 1.2 * x : 2 - 2 * x;
		glColor3d(std::min(2 * x, 1.0), green, std::max(1 - 2 * x, 0.0));
	}

	/// Shift of a contact into the periodic cell.
	Vector3r intoCell(const Scene& scene, const Vector3r& point)
	{
		return scene.isPeriodic ? Vector3r(scene.cell->wrapShearedPt(point) - point)
		                        : Vector3r(Vector3r::Zero());
	}

	Vector3r inSpace(const Vector2r& v, Real z) { return Vector3r(v[0], v[1], z); }

	void vertex(const Vector3r& v) { glVertex3d(double(v[0]), double(v[1]), double(v[2])); }

	/// A line of width 2 h in the plane.
	void ribbon(const Vector3r& from, const Vector3r& to, Real h)
	{
		const Vector3r along  = to - from;
		const Real     length = along.norm();
		if (!(length > 0)) return;
		const Vector3r across = h / length * Vector3r(-along[1], along[0], 0);
		glBegin(GL_QUADS);
		vertex(from - across);
		vertex(to - across);
		vertex(to + across);
		vertex(from + across);
		glEnd();
	}

	/// Point of application of the resultant force.
	template <class Phys> Vector3r pointOfApplication(const RcrGeom& geom, const Phys& phys)
	{
		const Real one = phys.force1[0], two = geom.points > 1 ? Real(phys.force2[0]) : Real(0);
		if (!(one + two > 0)) return geom.contactPoint;
		return inSpace(
		        (one * geom.position1 + two * geom.position2) / (one + two), geom.contactPoint[2]);
	}

	void chooseColor(const FrictPhys& phys, const RcrGeom& geom, Real normal)
	{
		if (Gl1_CdPhys::color == "type") return colorOfType(geom.type);
		if (Gl1_CdPhys::color == "mobilization") {
			const Real limit = phys.tangensOfFrictionAngle * normal;
			return colorOfNumber(limit > 0 ? double(phys.shearForce.norm() / limit) : 0);
		}
		colorOfNumber(double(normal / Gl1_CdPhys::maxForce));
	}

	template <class Phys>
	void drawForce(const Phys& phys, const Interaction& i, const Body* one, const Body* two,
	        const Scene& scene)
	{
		const RcrGeom* geom   = dynamic_cast<const RcrGeom*>(i.geom.get());
		const Real     normal = phys.normalForce.norm();
		if (!geom || geom->points == 0 || !one || !two || !(normal > 0)) return;
		Gl1_CdPhys::maxForce = math::max(Gl1_CdPhys::maxForce, normal);
		const Flat flat;
		const Real half = Gl1_CdPhys::width * math::min(geom->refR1, geom->refR2) * normal
		        / Gl1_CdPhys::maxForce;
		const Vector3r contact = pointOfApplication(*geom, phys);
		const Vector3r shift   = intoCell(scene, contact);
		const Vector3r image   = scene.isPeriodic ? Vector3r(scene.cell->intrShiftPos(i.cellDist))
		                                          : Vector3r(Vector3r::Zero());
		chooseColor(phys, *geom, normal);
		if (validation::isGrain(*one)) ribbon(shift + one->state->pos, shift + contact, half);
		if (validation::isGrain(*two))
			ribbon(shift + contact, shift + two->state->pos + image, half);
	}

} // namespace

void Gl1_RcrGeom::go(const shared_ptr<IGeom>& ig, const shared_ptr<Interaction>&,
        const shared_ptr<Body>&, const shared_ptr<Body>&, bool)
{
	const RcrGeom& geom = static_cast<const RcrGeom&>(*ig);
	if (geom.points == 0) return;
	const Flat     flat;
	const Vector3r shift       = intoCell(*scene, geom.contactPoint);
	const Real     arrowLength = length * math::min(geom.refR1, geom.refR2);
	colorOfType(geom.type);
	glPointSize(float(pointSize));
	for (int k = 0; k < geom.points; ++k) {
		const Vector3r at = shift
		        + inSpace(k == 0 ? geom.position1 : geom.position2, geom.contactPoint[2]);
		glBegin(GL_POINTS);
		vertex(at);
		glEnd();
		if (!normals) continue;
		glBegin(GL_LINES);
		vertex(at);
		const Vector2r& normal = k == 0 ? geom.normal1 : geom.normal2;
		vertex(at + arrowLength * inSpace(normal, 0));
		glEnd();
	}
}

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
