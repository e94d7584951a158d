// What tests need of the threads: trials, teams and their helpers.
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "kernel_arrays.hpp"
#include "parallel/crew.hpp"
#include "parallel/team.hpp"
#include "parallel/trial.hpp"

namespace rcr {

namespace {

	/// How often each index is worked on, in `loops` loops after each other; those in `failing` throw, the message is their number.
	std::vector<int> shareCounts(Team& team, int threads, int count, int loops, const std::vector<int>& failing, bool each, bool nested)
	{
		const py::gil_scoped_release  release;
		std::vector<std::atomic<int>> counts(count);
		const auto                    work = [&](int i) {
                        counts[i].fetch_add(1, std::memory_order_relaxed);
                        if (std::find(failing.begin(), failing.end(), i) != failing.end()) throw std::runtime_error(std::to_string(i));
		};
		const auto loop = [&] { each ? team.forEach(count, work) : team.share(0, count, work); };
		team.run(threads, [&] {
			for (int k = 0; k < loops; ++k)
				nested ? team.run(threads, loop) : loop();
		});
		return { counts.begin(), counts.end() };
	}

	/// Whether a helper takes its part in a loop of a run within a run, `rest` ms after it has kept the leader waiting for `stall` ms in as many loops.
	bool helpsAfterStalls(Team& team, int stalls, int stall, int rest)
	{
		using namespace std::chrono_literals;
		const py::gil_scoped_release release;
		const auto                   leader = std::this_thread::get_id();
		std::atomic<int>             arrived { 0 };
		const auto                   meet = [&](std::chrono::milliseconds patience) { // of all who come, each waits for a second one
                        ++arrived;
                        for (const auto end = std::chrono::steady_clock::now() + patience; arrived < 2 && std::chrono::steady_clock::now() < end;)
                                std::this_thread::yield();
                        return arrived == 2;
		};
		std::atomic<bool> met { false };
		team.run(2, [&] {
			for (int k = 0; k < stalls; ++k) {
				arrived = 0;
				team.run(2, [&] {
					team.share(0, 2, [&](int) {
						if (meet(1000ms) && std::this_thread::get_id() != leader) std::this_thread::sleep_for(std::chrono::milliseconds(stall));
					});
				});
				std::this_thread::sleep_for(std::chrono::milliseconds(rest));
			}
			arrived = 0;
			team.run(2, [&] { team.share(0, 2, [&](int) { met = meet(1000ms); }); });
		});
		return met;
	}

} // namespace

void bindThreads(py::module_& m)
{
	py::class_<Trial>(m, "Trial", "Whether help makes a loop faster, from its times.")
	        .def(py::init<>())
	        .def_property_readonly("helped", &Trial::helped)
	        .def("book", &Trial::book, py::arg("time"));
	py::class_<Team>(m, "Team", "Threads that share out loops.")
	        .def(py::init<>())
	        .def("share_counts", shareCounts, py::arg("threads"), py::arg("count"), py::arg("loops") = 1, py::arg("failing") = std::vector<int>(),
	             py::arg("each") = false, py::arg("nested") = false, "How often each index of a loop is worked on; those in `failing` throw.");
	m.def("helps_after_stalls", helpsAfterStalls, py::arg("team"), py::arg("stalls"), py::arg("stall"), py::arg("rest"),
	      "Whether a helper that has kept the leader waiting `stalls` times for `stall` ms is called again within the same run, `rest` ms after each.");
	m.def("helper_count", helperCount, "Helper threads that the process has now.");
}

} // namespace rcr
