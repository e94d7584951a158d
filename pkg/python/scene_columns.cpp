// Bodies and contacts of the scene as rows of numbers, which rcr._yade.scene_arrays makes columns.
//
// Conventions of rcr.table: an obstacle is body 2, and so is a grain with prescribed motion in
// contact with a free one. Forces, normals and branch vectors point from body 1 to body 2.
#include "dem/contacts/Law2_RcrGeom_FrictPhys_CundallStrack.hpp"
#include "dem/contacts/CdPhys.hpp"
#include "dem/shapes/planeConversion.hpp"

namespace py = boost::python;

namespace yade {
namespace {

struct Rows {
	std::vector<std::int64_t> integers;
	std::vector<double>       reals;

	void add(std::initializer_list<std::int64_t> whole, std::initializer_list<double> numbers)
	{
		integers.insert(integers.end(), whole);
		reals.insert(reals.end(), numbers);
	}
	py::tuple bytes() const
	{
		const auto made = [](const auto& row) {
			const char* first = reinterpret_cast<const char*>(row.data());
			return py::object(py::handle<>(
			        PyBytes_FromStringAndSize(first, Py_ssize_t(row.size() * sizeof(row[0])))));
		};
		return py::make_tuple(made(integers), made(reals));
	}
};

/// Lengths of grains, and the outlines of their polygons over R, equal ones once.
class Outlines {
public:
	struct Lengths {
		double half, cap;  // R − R' and R' [m]
		int    shape = -1; // row of a polygon in the table of outlines
	};

	Lengths of(const rcr::PlanarShape& grain)
	{
		const double R = grain.radius(), inscribed = grain.inscribedRadius();
		if (grain.kind != rcr::PlanarShape::polygon) return { grain.halfLength, inscribed };
		const auto core = rcr::coreVertices(grain, {});
		std::vector<long long> key { digits(grain.rounding / R) };
		for (const rcr::Vec2 v : core)
			key.insert(key.end(), { digits(v.x / R), digits(v.y / R) });
		const auto [known, isNew] = rows.insert({ key, int(rows.size()) });
		if (isNew) {
			shapes.add({ std::int64_t(core.size()) }, { grain.rounding / R });
			for (const rcr::Vec2 v : core)
				corners.add({ known->second }, { v.x / R, v.y / R });
		}
		return { R - inscribed, inscribed, known->second };
	}
	Rows shapes, corners;

private:
	/// Outlines of one shape in several sizes differ by rounding errors.
	static long long digits(double length) { return std::llround(1e9 * length); }

	std::map<std::vector<long long>, int> rows;
};

struct Grain {
	bool      known = false, fixed = false;
	rcr::Vec2 center; // of mass, of the body or its clump, at the time of the forces [m]
};

double angleOf(const State& state)
{
	return 2 * std::atan2(double(state.ori.z()), double(state.ori.w()));
}

/// Adds a row if the body is a grain.
Grain addGrain(Rows& rows, Outlines& outlines, const Body& body, const Scene& scene, double& z)
{
	const State& state = *body.state;
	const auto   shape = plane::shapeOf(*body.shape, state, 0);
	if (!shape.grain()) return {};
	const auto   lengths = outlines.of(shape);
	const bool   clump = body.clumpId >= 0;
	const State& whole = clump ? *(*scene.bodies)[body.clumpId]->state : state;
	const auto   fixed = State::DOF_X | State::DOF_Y | State::DOF_RZ;
	const Vector3r moved = scene.dt * whole.vel, center = whole.pos - moved;
	const Grain  grain { true, (whole.blockedDOFs & fixed) == fixed, plane::toPlane(center) };
	const auto&  color = body.shape->color;
	z                  = double(state.pos.z());
	rows.add({ body.id, clump ? body.clumpId : -1, grain.fixed, lengths.shape },
	        { double(state.pos.x()), double(state.pos.y()), angleOf(state), lengths.half,
	                lengths.cap, double(whole.mass), double(state.vel.x()), double(state.vel.y()),
	                double(state.angVel.z()), double(color[0]), double(color[1]), double(color[2]),
	                grain.center.x, grain.center.y });
	return grain;
}

/// Adds a row if the body is an obstacle that reaches the plane at z: kind and corners [m].
void addObstacle(Rows& rows, const Body& body, double z)
{
	const State&           state = *body.state;
	const rcr::PlanarShape shape = plane::shapeOf(*body.shape, state, z);
	const rcr::Vec2        at    = plane::toPlane(state.pos);
	if (shape.grain()) return;
	if (shape.kind == rcr::PlanarShape::wall)
		rows.add({ body.id, 0, shape.axis }, { shape.axis ? at.y : at.x, 0, 0, 0, 0, 0, 0, 0 });
	auto corners = rcr::coreVertices(shape, { at, plane::turnOf(shape, state).axis() });
	corners.resize(4, corners.empty() ? at : corners.back()); // a box without thickness has two
	const rcr::Vec2 &p = corners[0], &q = corners[1], &r = corners[2], &s = corners[3];
	if (shape.kind == rcr::PlanarShape::box)
		rows.add({ body.id, 1, 0 }, { p.x, p.y, q.x, q.y, r.x, r.y, s.x, s.y });
	if (shape.kind == rcr::PlanarShape::segment)
		rows.add({ body.id, 2, 0 }, { p.x, p.y, q.x, q.y, 0, 0, 0, 0 });
}

struct Resultant {
	rcr::Vec2 position;
	int       type = 0, points = 1;
	double    moments[4] = {}; // Σ f ⊗ (x − position) over two points [N]
};

/// Resultant of a contact of rcr. Of two points, one without a force does not count, since
/// detection reaches further for faster grains: sides that press at one end are a cap on a side.
Resultant resultantOf(const RcrGeom& geom, const Vector2r& force1, const Vector2r& force2)
{
	const auto plain = [](const Vector2r& v) { return rcr::Vec2 { double(v[0]), double(v[1]) }; };
	Resultant  found { plane::toPlane(geom.contactPoint), geom.type, geom.points };
	if (found.points < 2) return found;
	const double    one = double(force1[0]), two = double(force2[0]);
	const rcr::Vec2 at[2] = { plain(geom.position1), plain(geom.position2) },
	                normal[2] = { plain(geom.normal1), plain(geom.normal2) };
	const double    weight = std::abs(one) + std::abs(two); // adhesion bears tension
	if (weight > 0) {
		found.position = { (std::abs(one) * at[0].x + std::abs(two) * at[1].x) / weight,
			(std::abs(one) * at[0].y + std::abs(two) * at[1].y) / weight };
	}
	if (one == 0 || two == 0) {
		found.type   = found.type == 2 ? 1 : found.type;
		found.points = 1;
		return found;
	}
	for (int k = 0; k < 2; ++k) {
		const Vector2r& local = k ? force2 : force1;
		const rcr::Vec2 arm   = at[k] - found.position,
		                force = double(local[0]) * normal[k] + double(local[1]) * perp(normal[k]);
		found.moments[0] += force.x * arm.x, found.moments[1] += force.x * arm.y;
		found.moments[2] += force.y * arm.x, found.moments[3] += force.y * arm.y;
	}
	return found;
}

/// Pull of each point under springs [N].
double springAdhesion(const Scene& scene)
{
	for (const auto& engine : scene.engines)
		if (const auto* loop = dynamic_cast<const InteractionLoop*>(engine.get()))
			for (const auto& law : loop->lawDispatcher->functors)
				if (const auto* springs
				        = dynamic_cast<const Law2_RcrGeom_FrictPhys_CundallStrack*>(law.get()))
					return double(springs->adhesion);
	return 0;
}

/// Adds the row of a contact between bodies of rcr or of YADE's spheres, under any law.
void addContact(Rows& rows, const Interaction& contact, const std::vector<Grain>& grains,
        const Scene& scene, double adhesionOfSprings)
{
	const auto* geom = dynamic_cast<const GenericSpheresContact*>(contact.geom.get());
	const auto* phys = dynamic_cast<const NormPhys*>(contact.phys.get());
	if (!geom || !phys) return;
	Resultant found { plane::toPlane(geom->contactPoint) };
	double    adhesion = 0, rollingMoment = 0;
	if (const auto* ours = dynamic_cast<const RcrGeom*>(geom)) {
		if (ours->points == 0) return;
		const Vector2r none = Vector2r::Zero();
		const auto*    rigid = dynamic_cast<const CdPhys*>(phys);
		const auto*    spring = dynamic_cast<const RcrFrictPhys*>(phys);
		found = resultantOf(*ours, rigid ? rigid->force1 : spring ? spring->force1 : none,
		        rigid ? rigid->force2 : spring ? spring->force2 : none);
		adhesion = found.points * (rigid ? double(rigid->adhesion) : spring ? adhesionOfSprings : 0);
		rollingMoment = double(rigid ? rigid->rollingMoment : spring ? spring->rollingMoment : Real(0));
	}
	const auto* shear    = dynamic_cast<const NormShearPhys*>(phys);
	const auto* friction = dynamic_cast<const FrictPhys*>(phys);
	const Vector3r total = shear ? Vector3r(phys->normalForce + shear->shearForce)
	                             : phys->normalForce;
	Vector3r shift = Vector3r::Zero();
	if (scene.isPeriodic) shift = scene.cell->hSize * contact.cellDist.cast<Real>();
	const Body::id_t ids[2] = { contact.getId1(), contact.getId2() };
	const Grain      ends[2] = { grains[ids[0]], grains[ids[1]] };
	if (!ends[0].known && !ends[1].known) return;
	const rcr::Vec2  arms[2] = { found.position - ends[0].center,
		found.position - ends[1].center - plane::toPlane(shift) };
	const auto free    = [&](int k) { return ends[k].known && !ends[k].fixed; };
	const int  first   = free(0) || (!free(1) && ends[0].known) ? 0 : 1, second = 1 - first;
	const double sign  = first ? -1 : 1;
	const rcr::Vec2 force = sign * plane::toPlane(total),
	                normal = sign * plane::toPlane(geom->normal),
	                branch = ends[second].known ? arms[first] - arms[second] : arms[first],
	                // beside body 1, also across an edge of the cell
	        position = ends[first].center + arms[first];
	rows.add({ ids[first], ids[second], free(0) && free(1) ? found.type : 3, found.points },
	        { position.x, position.y, normal.x, normal.y, force.x, force.y, branch.x, branch.y,
	                friction ? double(friction->tangensOfFrictionAngle) : std::nan(""),
	                sign * found.moments[0], sign * found.moments[1], sign * found.moments[2],
	                sign * found.moments[3], adhesion, sign * rollingMoment });
}

} // namespace

/// Rows of grains, contacts, obstacles, outlines and their corners, each as bytes of whole numbers
/// and of doubles.
py::tuple sceneColumns()
{
	const Scene&       scene = *Omega::instance().getScene();
	Rows               grainRows, contactRows, obstacleRows;
	Outlines           outlines;
	std::vector<Grain> grains(scene.bodies->size());
	double             z = 0;
	const double       pull = springAdhesion(scene);
	for (const auto& body : *scene.bodies)
		if (body && body->shape)
			grains[body->id] = addGrain(grainRows, outlines, *body, scene, z);
	for (const auto& body : *scene.bodies)
		if (body && body->shape) addObstacle(obstacleRows, *body, z);
	for (const auto& contact : *scene.interactions)
		if (contact->isReal()) addContact(contactRows, *contact, grains, scene, pull);
	return py::make_tuple(grainRows.bytes(), contactRows.bytes(), obstacleRows.bytes(),
	        outlines.shapes.bytes(), outlines.corners.bytes());
}

/// Rows of half length, cap radius and outline of these shapes of grains, which may be of bodies
/// outside the scene; outlines and their corners.
py::tuple shapeColumns(const py::list& shapes)
{
	Rows     rows;
	Outlines outlines;
	for (int k = 0; k < py::len(shapes); ++k) {
		const auto shape   = py::extract<shared_ptr<Shape>>(shapes[k])();
		const auto lengths = outlines.of(plane::shapeOf(*shape, State(), 0));
		rows.add({ lengths.shape }, { lengths.half, lengths.cap });
	}
	return py::make_tuple(rows.bytes(), outlines.shapes.bytes(), outlines.corners.bytes());
}

} // namespace yade
