// Module rcr._plugin. Its import registers the classes of this plugin with the running YADE.
//
// YADE loads plugins at its start and registers every name in ClassFactory::pluginClasses. A second
// call would register all classes of YADE again. The list therefore holds only unregistered names
// while Omega::loadPlugins runs.
#include "dem/records/Published.hpp"
#include "dem/shapes/planarClump.hpp"
#include "dem/validation/deferredError.hpp"
#include "dem/validation/validation.hpp"

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
	boost::python::list classes;
	for (const std::string& name : added)
		classes.append(name);
	boost::python::scope().attr("classes") = classes;
#ifdef RCR_OPENGL
	yade::OpenGLRenderer::initDone = false; // an open view searches functors at its next frame
#endif
}

/// Error if another version of YADE is running, since its class layouts would corrupt memory; else
/// empty.
std::string versionError()
{
	const std::string running = boost::python::extract<std::string>(
	        boost::python::import("yade.config").attr("version"));
	if (running == RCR_YADE_VERSION) return {};
	return "rcr was built for YADE " RCR_YADE_VERSION ", but YADE " + running
	        + " is running. Start scripts/yade-rcr to rebuild it.";
}

std::string refusal()
{
	const yade::Scene& scene  = *yade::Omega::instance().getScene();
	const std::string  reason = yade::validation::refusal(scene);
	if (reason.empty()) {
		yade::validation::replaceSphereBounds(scene);
		yade::validation::registerBodiesWithCollider(scene);
	}
	return reason;
}

bool usesRcr() { return yade::validation::usesRcrClasses(*yade::Omega::instance().getScene()); }

boost::python::list advice()
{
	const yade::Scene&  scene = *yade::Omega::instance().getScene();
	boost::python::list warnings;
	for (const std::string& text :
	        { yade::validation::massWarning(scene), yade::validation::overlapWarning(scene) })
		if (!text.empty()) warnings.append(text);
	return warnings;
}

void awaitEnd()
{
	Py_BEGIN_ALLOW_THREADS;
	yade::awaitEnd();
	Py_END_ALLOW_THREADS;
}

} // namespace

BOOST_PYTHON_MODULE(_plugin)
{
	// Python raises it: Boost.Python 1.74 loses exceptions of an import
	const std::string error = versionError();
	boost::python::scope().attr("version_error") = error;
	if (!error.empty()) return;
	boost::python::scope().attr("yade_version") = RCR_YADE_VERSION;
	yade::Published<bool>::registerConverters();
	yade::Published<int>::registerConverters();
	yade::Published<double>::registerConverters();
	registerClasses();
	boost::python::def(
	        "refusal", refusal,
	        "Reason why the scene is not supported, with a remedy; empty if it is supported.");
	boost::python::def(
	        "take_error", yade::takeError,
	        "Message of the error that stopped ContactDynamics, returned once; empty without "
	        "error.");
	boost::python::def("await_end", awaitEnd, "Wait until a paused run has stopped.");
	boost::python::def("usesRcr", usesRcr, "True if the scene contains a law of this plugin.");
	boost::python::def("advice", advice, "Warnings for suspicious scenes, a list of texts.");
	boost::python::def(
	        "planar_clump", yade::planarClump,
	        "Join bodies to a clump (ids, x, y, mass, inertia about z); returns its id.");
}
