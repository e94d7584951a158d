#include <GL/gl.h>

#include "dem/shapes/planeConversion.hpp"
#include "dem/shapes/RoundedPolygon.hpp"

namespace yade {

class Gl1_Rcr : public GlShapeFunctor {
public:
	void go(const shared_ptr<Shape>&, const shared_ptr<State>&, bool, const GLViewInfo&) override;
	// clang-format off
	YADE_CLASS_BASE_DOC_STATICATTRS(Gl1_Rcr,GlShapeFunctor,"Draws a :yref:`Rcr` in the 3D view: a "
			"plate with sides and caps, in its :yref:`color<Shape.color>`.",
		((bool,wire,false,,"Draws the outlines only."))
		((bool,mark,true,,"Draws a line from the centre to one end, which shows rotations."))
		((Real,depth,0.5,,"Thickness of the plate over that of the grain, twice its inscribed radius [-]; 0: flat."))
		((int,slices,12,,"Number of straight pieces of half a circle."))
	);
	// clang-format on
	RENDERS(Rcr);
};
REGISTER_SERIALIZABLE(Gl1_Rcr);

class Gl1_RoundedPolygon : public Gl1_Rcr {
public:
	// clang-format off
	YADE_CLASS_BASE_DOC(Gl1_RoundedPolygon,Gl1_Rcr,"Draws a :yref:`RoundedPolygon` as :yref:`Gl1_Rcr` draws a grain, with the same attributes.");
	// clang-format on
	RENDERS(RoundedPolygon);
};
REGISTER_SERIALIZABLE(Gl1_RoundedPolygon);

YADE_PLUGIN((Gl1_Rcr)(Gl1_RoundedPolygon));

bool Gl1_Rcr::wire;
bool Gl1_Rcr::mark;
Real Gl1_Rcr::depth;
int  Gl1_Rcr::slices;

namespace {

	struct OutlinePoint {
		double x, y;   // from the centre, along the axes of the grain [m]
		double nx, ny; // outward normal
	};

	/// Points of the outline, counter-clockwise. `slices`: straight pieces of half a circle.
	std::vector<OutlinePoint> outline(const rcr::PlanarShape& shape, int slices)
	{
		const std::vector<rcr::Vec2> core  = rcr::coreVertices(shape, {});
		const int                    count = int(core.size());
		std::vector<OutlinePoint>    points;
		for (int k = 0; k < count; ++k) {
			const rcr::Vec2 before = core[k] - core[(k + count - 1) % count],
			                after  = core[(k + 1) % count] - core[k];
			const double from = std::atan2(-before.x, before.y), // of the outward normal
			        turn = count < 3 ? 2 * M_PI / count
			                         : std::atan2(cross(before, after), dot(before, after));
			const int pieces = std::max(1, int(std::ceil(slices * turn / M_PI)));
			for (int piece = 0; piece <= pieces; ++piece) {
				const double angle = from + turn * piece / pieces, c = std::cos(angle),
				             s = std::sin(angle);
				points.push_back({ core[k].x + shape.rounding * c, core[k].y + shape.rounding * s, c, s });
			}
		}
		return points;
	}

	/// A face of the plate, or its outline as a line.
	void drawFace(const std::vector<OutlinePoint>& points, double z, bool wire)
	{
		glBegin(wire ? GL_LINE_LOOP : GL_POLYGON);
		glNormal3d(0, 0, z < 0 ? -1 : 1);
		for (const OutlinePoint& p : points)
			glVertex3d(p.x, p.y, z);
		glEnd();
	}

	void drawRim(const std::vector<OutlinePoint>& points, double z)
	{
		glBegin(GL_QUAD_STRIP);
		for (std::size_t k = 0; k <= points.size(); ++k) {
			const OutlinePoint& p = points[k % points.size()];
			glNormal3d(p.nx, p.ny, 0);
			glVertex3d(p.x, p.y, z);
			glVertex3d(p.x, p.y, -z);
		}
		glEnd();
	}

	/// A line along the long axis from the centre to one end, just above each face.
	void drawMark(double length, double z)
	{
		glDisable(GL_LIGHTING);
		glBegin(GL_LINES);
		for (const double side : { z, -z }) {
			glVertex3d(0, 0, side);
			glVertex3d(length, 0, side);
		}
		glEnd();
	}

} // namespace

void Gl1_Rcr::go(const shared_ptr<Shape>& shape, const shared_ptr<State>&, bool wireOfView,
        const GLViewInfo&)
{
	const rcr::PlanarShape          grain  = plane::shapeOf(*shape, State(), 0);
	const std::vector<OutlinePoint> points = outline(grain, std::max(slices, 1));
	const Vector3r&                 color  = shape->color;
	const double                    z      = double(depth) * grain.inscribedRadius();
	const bool                      lines  = wire || wireOfView;
	glEnable(GL_NORMALIZE); // remains on, as for a Sphere; else the boxes of YADE are white
	glPushAttrib(GL_ENABLE_BIT | GL_LINE_BIT | GL_CURRENT_BIT);
	glDisable(GL_CULL_FACE);
	glColor3d(double(color[0]), double(color[1]), double(color[2]));
	for (const double side : { z, -z })
		drawFace(points, side, lines);
	if (!lines && z > 0) drawRim(points, z);
	if (mark) {
		const double shade = lines ? 1 : 0.3;
		glColor3d(shade * double(color[0]), shade * double(color[1]), shade * double(color[2]));
		glLineWidth(2);
		drawMark(grain.radius(), z + (lines ? 0 : 0.01 * grain.inscribedRadius()));
	}
	glPopAttrib();
}

} // namespace yade
