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

void bindStateMachines(py::module_& m)
{
	py::class_<ProximalParameter>(m, "ProximalParameter", "ρ of proximal steps.")
	        .def(py::init<>())
	        .def_property_readonly("rho", &ProximalParameter::rho)
	        .def("step_converged", &ProximalParameter::stepConverged)
	        .def("step_failed", &ProximalParameter::stepFailed);
	py::class_<Momentum>(m, "Momentum", "Nesterov momentum and its restart.")
	        .def(py::init<>())
	        .def_property_readonly("beta", &Momentum::beta)
	        .def("advance", &Momentum::advance, "error"_a);
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
	                "overlap"_a, "yielded"_a = false,
	                "Add the deepest overlap of a step over R₁ + R₂ [-]. Returns 'none', 'jam' or\n"
	                "'not converged'.");
	py::class_<StepCounts>(
	        m, "StepCounts", "Counts of steps and their warnings (watch/step_counts.hpp).")
	        .def(py::init<>())
	        .def_readonly("steps", &StepCounts::steps)
	        .def_readonly("missed", &StepCounts::missed)
	        .def_readonly("yielded", &StepCounts::yielded)
	        .def_readonly("intruded", &StepCounts::intruded)
	        .def_readonly("deepest", &StepCounts::deepest)
	        .def("count", &StepCounts::count, "missed"_a, "yielded"_a, "overlap"_a,
	                "removes_overlaps"_a = false, "intruded"_a = false,
	                "Count a step. Returns true if a message is due.")
	        .def("message", &StepCounts::message);
	py::class_<StopTest>(m, "StopTest", "Stop criteria of sweeps; settings as in `solve`.")
	        .def(py::init([](double tolerance, double accuracy, double meanForceChange,
	                              int checkInterval, int minIterations, int maxIterations,
	                              int stallSweeps) {
		        return StopTest(stopSettings(tolerance, accuracy, meanForceChange,
		                checkInterval, minIterations, maxIterations, stallSweeps));
	        }),
	                "tolerance"_a = 1e-4, "accuracy"_a = 0.01, "mean_force_change"_a = 0,
	                "check_interval"_a = 10, "min_iterations"_a = 0, "max_iterations"_a = 1000,
	                "stall_sweeps"_a = 0)
	        .def(
	                "must_stop",
	                [](StopTest& test, const std::function<std::array<double, 3>()>& measure,
	                        bool early) {
		                return test.mustStop(early, [&] {
			                const auto [residual, estimate, change] = measure();
			                return Criteria { residual, 0, estimate, change };
		                });
	                },
	                "measure"_a, "early"_a = false,
	                "`measure()` returns (residual, error estimate, mean force change).")
	        .def_property_readonly("sweeps", &StopTest::sweeps);
}

} // namespace rcr
