// rcr._plugin: importing it registers our classes with the YADE that runs.
//
// YADE itself loads plugins only once, at its start, and registers every name in ClassFactory::pluginClasses. Doing that a
// second time would register all of YADE's own classes anew, so only the names that YADE does not know yet are left in
// that list while Omega::loadPlugins runs.
#include <boost/python.hpp>

#include <core/Omega.hpp>
#include <lib/factory/ClassFactory.hpp>

#ifdef RCR_OPENGL
#include <pkg/common/OpenGLRenderer.hpp>
#endif

#include "dem/validation/validation.hpp"
#include "dem/shapes/planarClump.hpp"
#include "dem/validation/deferredError.hpp"

namespace {

void registerOwnClasses()
{
	std::list<std::string>& names = yade::ClassFactory::instance().pluginClasses;
	const auto&             known = yade::Omega::instance().getDynlibsDescriptor();
	std::list<std::string>  ours, all = names;
	for (const std::string& name : names)
		if (!known.count(name)) ours.push_back(name);
	names = ours;
	yade::Omega::instance().loadPlugins({});
	names = all;
	boost::python::list classes;
	for (const std::string& name : ours)
		classes.append(name);
	boost::python::scope().attr("classes") = classes;
#ifdef RCR_OPENGL
	yade::OpenGLRenderer::initDone = false; // a view that is open already looks for functors anew when it draws next
#endif
}

/// A class layout of another version would corrupt memory, so nothing is registered then.
void checkVersion()
{
	const std::string running = boost::python::extract<std::string>(boost::python::import("yade.config").attr("version"));
	if (running == RCR_YADE_VERSION) return;
	const std::string message = "rcr was built for YADE " RCR_YADE_VERSION ", but YADE " + running
	        + " is running. Build it anew: scripts/yade-rcr does so when it starts.";
	PyErr_SetString(PyExc_ImportError, message.c_str());
	boost::python::throw_error_already_set();
}

std::string refusal()
{
	const yade::Scene& scene = *yade::Omega::instance().getScene();
	const std::string  told  = yade::validation::refusal(scene);
	if (told.empty()) {
		yade::validation::replaceSphereBounds(scene);
		yade::validation::registerBodiesWithCollider(scene);
	}
	return told;
}

bool usesRcrClasses() { return yade::validation::usesRcrClasses(*yade::Omega::instance().getScene()); }

boost::python::list advice()
{
	const yade::Scene&  scene = *yade::Omega::instance().getScene();
	boost::python::list told;
	for (const std::string& text : { yade::validation::massWarning(scene), yade::validation::overlapWarning(scene) })
		if (!text.empty()) told.append(text);
	return told;
}

} // namespace

namespace {

void awaitEnd()
{
	Py_BEGIN_ALLOW_THREADS;
	yade::awaitEnd();
	Py_END_ALLOW_THREADS;
}

} // namespace

BOOST_PYTHON_MODULE(_plugin)
{
	checkVersion();
	boost::python::scope().attr("yade_version") = RCR_YADE_VERSION;
	registerOwnClasses();
	boost::python::def("refusal", refusal, "What of the scene is not served, and what to do; empty where all is.");
	boost::python::def("take_error", yade::takeError, "What ended the last step of ContactDynamics, once; empty where nothing did.");
	boost::python::def("await_end", awaitEnd, "Waits for a run that was paused to be over.");
	boost::python::def("usesRcrClasses", usesRcrClasses, "Whether a law of ours is in the scene.");
	boost::python::def("advice", advice, "What of the scene is served but hardly meant, a list of texts.");
	boost::python::def("planar_clump", yade::planarClump, "Joins bodies of the scene, (ids, x, y, mass, inertia about z); returns the id of the clump.");
}
