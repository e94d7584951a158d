#include "overlay.hpp"

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

YADE_PLUGIN((Gl1_RcrGeom));

bool Gl1_RcrGeom::normals;
Real Gl1_RcrGeom::length;
Real Gl1_RcrGeom::pointSize;

void Gl1_RcrGeom::go(const shared_ptr<IGeom>& ig, const shared_ptr<Interaction>&,
        const shared_ptr<Body>&, const shared_ptr<Body>&, bool)
{
	const RcrGeom& geom = static_cast<const RcrGeom&>(*ig);
	if (geom.points == 0) return;
	const overlay::Flat flat;
	const Vector3r      shift = overlay::intoCell(*scene, geom.contactPoint);
	const Real          arrowLength = length * math::min(geom.refR1, geom.refR2);
	overlay::colorOfType(geom.type);
	glPointSize(float(pointSize));
	for (int k = 0; k < geom.points; ++k) {
		const Vector3r at = shift
		        + overlay::inSpace(k == 0 ? geom.position1 : geom.position2, geom.contactPoint[2]);
		glBegin(GL_POINTS);
		overlay::vertex(at);
		glEnd();
		if (!normals) continue;
		glBegin(GL_LINES);
		overlay::vertex(at);
		const Vector2r& normal = k == 0 ? geom.normal1 : geom.normal2;
		overlay::vertex(at + arrowLength * overlay::inSpace(normal, 0));
		glEnd();
	}
}

} // namespace yade
