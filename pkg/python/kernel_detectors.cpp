// Bindings of small state machines for tests.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <array>

#include "exact/proximal_parameter.hpp"
#include "kernel_arrays.hpp"
#include "sweep/momentum.hpp"
#include "sweep/stop_test.hpp"
#include "watch/jam_detector.hpp"
#include "watch/step_counts.hpp"

namespace rcr {

namespace {

	/// A stop test that owns its settings.
	struct OwnStopTest {
		Settings settings;
		StopTest test;

		template <class... Given>
		explicit OwnStopTest(Given... given) : settings(stopSettings(given...)), test(settings)
		{
		}
		OwnStopTest(const OwnStopTest&) = delete;
	};

} // namespace

void bindDetectors(py::module_& m)
{
	py::class_<ProximalParameter>(m, "ProximalParameter", "ρ of proximal steps.")
	        .def(py::init([](double start, double min, double max, double rise, double fall,
	                         int maxPatience) {
		             return ProximalParameter({ start, min, max, rise, fall, maxPatience });
	             }),
	             py::arg("start"), py::arg("min"), py::arg("max"), py::arg("rise"), py::arg("fall"),
	             py::arg("max_patience"))
	        .def_property_readonly("rho", &ProximalParameter::rho)
	        .def("step_converged", &ProximalParameter::stepConverged)
	        .def("step_failed", &ProximalParameter::stepFailed);

	py::class_<Momentum>(m, "Momentum", "Nesterov momentum and its restart.")
	        .def(py::init<>())
	        .def_property_readonly("beta", &Momentum::beta)
	        .def("advance", &Momentum::advance, py::arg("error"));
	py::class_<JamDetector>(m, "JamDetector", "Detector of jams (watch/jam_detector.hpp).")
	        .def(py::init<>())
	        .def_readwrite("new_maxima", &JamDetector::newMaxima)
	        .def_readwrite("deepest", &JamDetector::deepest)
	        .def_readwrite("yielded", &JamDetector::yielded)
	        .def_readonly_static("jam_overlap", &JamDetector::jamOverlap)
	        .def_readonly_static("patience", &JamDetector::patience)
	        .def(
	                "update",
	                [](JamDetector& detector, double overlap, bool yielded) {
		                constexpr const char* names[] = { "none", "jam", "not converged" };
		                return names[int(detector.update(overlap, yielded))];
	                },
	                py::arg("overlap"), py::arg("yielded") = false,
	                "Add the deepest overlap of a step over R₁ + R₂ [-]. Returns 'none', 'jam' or\n"
	                "'not converged'.");
	py::class_<StepCounts>(
	        m, "StepCounts", "Counts of steps and their warnings (watch/step_counts.hpp).")
	        .def(py::init<>())
	        .def_readonly("steps", &StepCounts::steps)
	        .def_readonly("missed", &StepCounts::missed)
	        .def_readonly("yielded", &StepCounts::yielded)
	        .def_readonly("deepest", &StepCounts::deepest)
	        .def("count", &StepCounts::count, py::arg("missed"), py::arg("yielded"),
	             py::arg("overlap"), py::arg("removes_overlaps") = false,
	             "Count a step. Returns true if a message is due.")
	        .def("message", &StepCounts::message);
	py::class_<OwnStopTest>(m, "StopTest", "Stop criteria of sweeps; settings as in `solve`.")
	        .def(py::init<double, double, double, int, int, int, int>(), py::arg("tolerance") = 1e-4,
	             py::arg("kinematic_tolerance") = 0.01, py::arg("mean_force_change") = 0,
	             py::arg("check_interval") = 10, py::arg("min_iterations") = 0,
	             py::arg("max_iterations") = 1000, py::arg("stall_sweeps") = 0)
	        .def(
	                "must_stop",
	                [](OwnStopTest& own, const std::function<std::array<double, 3>()>& measure,
	                   bool early) {
		                return own.test.mustStop(early, [&] {
			                const auto [residual, kinematicError, change] = measure();
			                return Criteria { residual, kinematicError, change };
		                });
	                },
	                py::arg("measure"), py::arg("early") = false,
	                "`measure()` returns (residual, kinematic error, mean force change).")
	        .def_property_readonly(
	                "sweeps", [](const OwnStopTest& own) { return own.test.sweeps(); });
}

} // namespace rcr
