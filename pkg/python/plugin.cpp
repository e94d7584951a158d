// Module rcr._plugin. Its import registers the classes of this plugin with the running YADE.
//
// YADE loads plugins at its start and registers every name in ClassFactory::pluginClasses. A second
// call would register all classes of YADE again. The list therefore holds only unregistered names
// while Omega::loadPlugins runs.
#include "dem/engine/ContactDynamics.hpp"
#include "dem/errors/deferredError.hpp"
#include "dem/records/StepEnd.hpp"
#include "dem/validation/SceneQuery.hpp"

namespace py = boost::python;

namespace yade {
boost::python::tuple sceneColumns();
boost::python::tuple shapeColumns(const boost::python::list&);
}

namespace {

void registerClasses()
{
	std::list<std::string>& names = yade::ClassFactory::instance().pluginClasses;
	const auto&             known = yade::Omega::instance().getDynlibsDescriptor();
	std::list<std::string>  added, all = names;
	for (const std::string& name : names)
		if (!known.count(name)) added.push_back(name);
	names = added;
	yade::Omega::instance().loadPlugins({});
	names = all;
	py::list classes;
	for (const std::string& name : added)
		classes.append(name);
	py::scope().attr("classes") = classes;
#ifdef RCR_OPENGL
	yade::OpenGLRenderer::initDone = false; // an open view searches functors at its next frame
#endif
}

/// Error if another version of YADE is running; empty: none. Its class layouts would corrupt
/// memory.
std::string versionError()
{
	const std::string running = py::extract<std::string>(py::import("yade.config").attr("version"));
	if (running == RCR_YADE_VERSION) return {};
	return "rcr was built for YADE " RCR_YADE_VERSION ", but YADE " + running
	        + " is running. Start scripts/yade-rcr to rebuild it.";
}

yade::Scene& scene() { return *yade::Omega::instance().getScene(); }

yade::StepEnd lastEnd; // of the last run, or after O.load

/// Fingerprint of all masses, which functions of YADE may change.
double totalMass()
{
	double sum = 0;
	for (const auto& b : *scene().bodies)
		if (b) sum += double(b->state->mass);
	return sum;
}

py::list advice(const py::object& unionArea)
{
	const auto area = [&](const std::vector<yade::Body::id_t>& ids) -> double {
		py::list members;
		for (const yade::Body::id_t id : ids)
			members.append(id);
		return py::extract<double>(unionArea(members));
	};
	py::list warnings;
	using namespace yade::validation;
	for (const std::string& text : { massWarning(scene(), area), overlapWarning(scene()),
	             sphereEngineWarning(scene()), turningWarning(scene()) })
		if (!text.empty()) warnings.append(text);
	return warnings;
}

/// Joins bodies into a clump with a centre [m], a mass [kg] and a moment of inertia about z
/// [kg m²], per unit depth. Returns its id. YADE's own function rotates clumps to principal axes
/// that may lie out of the plane.
int planarClump(const py::list& ids, double x, double y, double mass, double inertia)
{
	auto body   = boost::make_shared<yade::Body>();
	auto clump  = boost::make_shared<yade::Clump>();
	body->shape = clump;
	body->setBounded(false);
	const yade::Body::id_t id = scene().bodies->insert(body);
	yade::State&           s  = *body->state;
	for (int k = 0; k < py::len(ids); ++k) {
		const yade::shared_ptr<yade::Body>& member
		        = yade::Body::byId(py::extract<yade::Body::id_t>(ids[k])(), &scene());
		if (k == 0) s.pos = yade::Vector3r(x, y, member->state->pos.z());
		yade::Clump::add(body, member);
		yade::Se3r& place = clump->members[member->getId()];
		place.position    = member->state->pos - s.pos;
		place.orientation = member->state->ori;
	}
	s.refPos      = s.pos;
	s.mass        = mass;
	s.inertia     = yade::Vector3r::Constant(inertia);
	s.blockedDOFs = yade::State::DOF_Z | yade::State::DOF_RX | yade::State::DOF_RY;
	return id;
}

void recordEnd()
{
	lastEnd.record(scene());
	for (const auto& engine : scene().engines)
		if (auto* solver = dynamic_cast<yade::ContactDynamics*>(engine.get()))
			solver->endRun(scene());
}

} // namespace

BOOST_PYTHON_MODULE(_plugin)
{
	// Python raises it, since Boost.Python 1.74 loses exceptions of an import
	const std::string error = versionError();
	py::scope().attr("version_error") = error;
	if (!error.empty()) return;
	py::scope().attr("yade_version") = RCR_YADE_VERSION;
	yade::Published<bool>::registerConverters();
	yade::Published<int>::registerConverters();
	yade::Published<double>::registerConverters();
	registerClasses();
	py::def(
	        "prepare_run", +[] {
		        // a call of O.run during a run changes O.stopAtIter only
		        if (yade::Omega::instance().isRunning()) return std::string();
		        const std::string error = yade::validation::prepareRun(scene());
		        if (!error.empty()) return error;
		        if (yade::validation::SceneQuery(scene()).law != yade::validation::neither)
			        lastEnd.adaptCell(scene());
		        lastEnd = {}; // O.iter stays the same within the next step
		        return error;
	        },
	        "Prepare a run. Returns the error of an unsupported scene, with a remedy; else ''.");
	py::def("take_error", yade::takeError,
	        "Message of the error that stopped ContactDynamics, returned once; empty without "
	        "error.");
	py::def("await_start", yade::awaitStart, "Wait until the thread of a run has begun.");
	py::def("await_end", yade::awaitEnd, "Wait until a paused run has stopped.");
	py::def("uses_rcr",
	        +[] { return yade::validation::SceneQuery(scene()).law != yade::validation::neither; },
	        "True if the scene holds a law, ContactDynamics or Ip2 of rcr.");
	py::def("advice", advice,
	        "Warnings for suspicious scenes, a list of texts. `union_area(ids)`: area of the union\n"
	        "of grains [m²].");
	py::def("total_mass", totalMass, "Sum of the masses of all bodies, a fingerprint of them.");
	py::def("record_end", recordEnd,
	        "Record time step, velocities and places at the end of a step.");
	py::def("change_since_end", +[] { return lastEnd.change(scene()); },
	        "What differs from the record of this step; empty: nothing, or no record.");
	py::def("scene_columns", yade::sceneColumns,
	        "Rows of grains, contacts, obstacles and outlines, see rcr._yade.scene_arrays.");
	py::def("shape_columns", yade::shapeColumns,
	        "Rows of lengths of shapes (a list) and of outlines, see rcr._yade.scene_arrays.");
	py::def("planar_clump", planarClump,
	        "Join bodies to a clump (ids, x, y, mass, inertia about z); returns its id.");
}
