#include "Gl1_RcrGeom.hpp"

#include "overlay.hpp"

namespace yade {

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
