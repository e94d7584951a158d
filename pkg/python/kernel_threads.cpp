// Bindings of the thread team, for tests.
#include <pybind11/stl.h>

#include <stdexcept>
#include <thread>

#include "kernel_arrays.hpp"
#include "parallel/thread_pool.hpp"
#include "parallel/thread_team.hpp"

namespace rcr {

namespace {

	/// Number of calls for each index after `loops` loops. Indices in `failing` throw their number.
	std::vector<int> loopCounts(ThreadTeam& team, int threads, int count, int loops,
	        const std::vector<int>& failing, bool chunks, bool nested)
	{
		const py::gil_scoped_release  release;
		std::vector<std::atomic<int>> counts(count);
		const auto                    work = [&](int i) {
            counts[i].fetch_add(1, std::memory_order_relaxed);
            if (std::find(failing.begin(), failing.end(), i) != failing.end())
                throw std::runtime_error(std::to_string(i));
		};
		const auto loop
		        = [&] { chunks ? team.forEach(count, work) : team.parallelFor(0, count, work); };
		team.run(threads, [&] {
			for (int k = 0; k < loops; ++k)
				nested ? team.run(threads, loop) : loop();
		});
		return { counts.begin(), counts.end() };
	}

	/// Stalls the leader `stalls` times for `stall` ms, with `rest` ms after each. Returns true if
	/// a helper then takes part in a loop of a nested run.
	bool helpsAfterStalls(ThreadTeam& team, int stalls, int stall, int rest)
	{
		using namespace std::chrono_literals;
		const py::gil_scoped_release release;
		const auto                   leader = std::this_thread::get_id();
		std::atomic<int>             arrived { 0 };
		const auto                   meet = [&] { // two threads wait for each other, up to 1 s
            ++arrived;
            const auto end = std::chrono::steady_clock::now() + 1000ms;
            while (arrived < 2 && std::chrono::steady_clock::now() < end)
                std::this_thread::yield();
            return arrived == 2;
		};
		std::atomic<bool> met { false };
		team.run(2, [&] {
			for (int k = 0; k < stalls; ++k) {
				arrived = 0;
				team.run(2, [&] {
					team.parallelFor(0, 2, [&](int) {
						if (meet() && std::this_thread::get_id() != leader)
							std::this_thread::sleep_for(std::chrono::milliseconds(stall));
					});
				});
				std::this_thread::sleep_for(std::chrono::milliseconds(rest));
			}
			arrived = 0;
			team.run(2, [&] { team.parallelFor(0, 2, [&](int) { met = meet(); }); });
		});
		return met;
	}

} // namespace

void bindThreads(py::module_& m)
{
	py::class_<ParallelChoice>(m, "ParallelChoice", "Serial or parallel execution by timing.")
	        .def(py::init<>())
	        .def_property_readonly("parallel", &ParallelChoice::parallel, "Mode of the next round.")
	        .def("record", &ParallelChoice::record, "time"_a, "Add the time of a round.");
	py::class_<ThreadTeam>(m, "ThreadTeam", "Threads for parallel loops.")
	        .def(py::init<>())
	        .def("loop_counts", loopCounts, "threads"_a, "count"_a, "loops"_a = 1,
	                "failing"_a = std::vector<int>(), "chunks"_a = false, "nested"_a = false,
	                "Number of calls for each index of a loop; indices in `failing` throw.");
	m.def("helps_after_stalls", helpsAfterStalls, "team"_a, "stalls"_a, "stall"_a, "rest"_a,
	        "True if a helper takes part again after it has stalled the leader `stalls` times for\n"
	        "`stall` ms, with `rest` ms after each stall.");
	m.def("helper_count", helperCount, "Number of helper threads of the process.");
}

} // namespace rcr
