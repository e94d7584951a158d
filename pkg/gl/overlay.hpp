// Drawing in the plane of the contacts: on top of the grains, without lighting.
#pragma once

#include <GL/gl.h>

#include "dem/contacts/RcrGeom.hpp"

namespace yade::overlay {

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
inline void colorOfType(int type)
{
	static const double colors[4][3] = {
		{ 0.12, 0.47, 0.71 }, { 0.17, 0.63, 0.17 }, { 0.84, 0.15, 0.16 }, { 0.8, 0.8, 0.8 }
	};
	glColor3dv(colors[type >= 0 && type < 3 ? type : 3]);
}

/// Colour of a number from 0 to 1: blue, yellow, red.
inline void colorOfNumber(double x)
{
	x = std::min(std::max(x, 0.0), 1.0);
	glColor3d(std::min(2 * x, 1.0), x < 0.5 ? 0.4 + 1.2 * x : 2 - 2 * x, std::max(1 - 2 * x, 0.0));
}

/// Shift of a contact into the periodic cell.
inline Vector3r intoCell(const Scene& scene, const Vector3r& point)
{
	return scene.isPeriodic ? Vector3r(scene.cell->wrapShearedPt(point) - point)
	                        : Vector3r(Vector3r::Zero());
}

inline Vector3r inSpace(const Vector2r& v, Real z) { return Vector3r(v[0], v[1], z); }

inline void vertex(const Vector3r& v) { glVertex3d(double(v[0]), double(v[1]), double(v[2])); }

/// A line of width 2 h in the plane.
inline void ribbon(const Vector3r& from, const Vector3r& to, Real h)
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

} // namespace yade::overlay
