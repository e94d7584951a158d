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
	yade::OpenGLRenderer::initDone = false; // an open view then finds the new functors
#endif
}

/// A class layout of another version would corrupt memory, so nothing is registered then.
void checkVersion()
{
	const std::string running = boost::python::extract<std::string>(boost::python::import("yade.config").attr("version"));
	if (running == RCR_YADE_VERSION) return;
	const std::string message = "rcr was built for YADE " RCR_YADE_VERSION ", but YADE " + running
	        + " is running. Rebuild rcr: scripts/yade-rcr does so when it starts.";
	PyErr_SetString(PyExc_ImportError, message.c_str());
	boost::python::throw_error_already_set();
}

std::string refusal()
{
	const yade::Scene& scene = *yade::Omega::instance().getScene();
	const std::string  message = yade::validation::refusal(scene);
	if (message.empty()) {
		yade::validation::replaceSphereBounds(scene);
		yade::validation::registerBodiesWithCollider(scene);
	}
	return message;
}

bool usesRcrClasses() { return yade::validation::usesRcrClasses(*yade::Omega::instance().getScene()); }

boost::python::list advice()
{
	const yade::Scene&  scene = *yade::Omega::instance().getScene();
	boost::python::list warnings;
	for (const std::string& text : { yade::validation::massWarning(scene), yade::validation::overlapWarning(scene) })
		if (!text.empty()) warnings.append(text);
	return warnings;
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
	boost::python::def("refusal", refusal, "Message about the first problem of the scene, with a remedy; empty if the scene is valid.");
	boost::python::def("take_error", yade::takeError, "Returns and clears the message of the exception that ended the last run; empty: none.");
	boost::python::def("await_end", awaitEnd, "Waits until a paused run is over.");
	boost::python::def("serves", usesRcrClasses, "The scene has a law of rcr.");
	boost::python::def("advice", advice, "Warnings about suspicious scenes, a list of texts.");
	boost::python::def("planar_clump", yade::planarClump, "Joins bodies (ids, x, y, mass, inertia about z) into a clump; returns its id.");
}
