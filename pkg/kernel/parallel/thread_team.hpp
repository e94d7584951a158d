// A team of threads for parallel loops of a few microseconds.
//
// The leader runs the algorithm and shares loops (shared_loop.hpp) with helpers from the pool of
// the process (thread_pool.hpp). After a stall, the leader works alone for some time. A stall is a
// long wait for a helper that lost its core during its work.
#pragma once

#include <chrono>
#include <cstddef>
#include <exception>
#include <mutex>
#include <vector>

#include "parallel/parallel_choice.hpp"
#include "parallel/shared_loop.hpp"

namespace rcr {

class ThreadTeam {
public:
	/// Calls algorithm() on this thread while up to threads − 1 helpers are available for its
	/// loops. Within another run, `threads` is ignored. Every run requests helpers that sleep or
	/// were released after a stall.
	template <class Algorithm> void run(int threads, Algorithm algorithm)
	{
		if (running_) {
			request();
			algorithm();
			return;
		}
		threads_ = threads, running_ = true;
		struct Run {
			ThreadTeam& team;
			~Run() { team.end(); }
		} run { *this };
		request();
		algorithm();
	}

	/// Within run, but not within `work`: calls work(i) once for each begin ≤ i < end, on any thread
	/// and in any order. Returns when all calls are done. Rethrows the exception of the smallest i.
	template <class Work> void parallelFor(int begin, int end, Work work)
	{
		if (!helped_ || end - begin < 2) {
			for (int i = begin; i < end; ++i)
				work(i);
			return;
		}
		Guarded<Work> guarded { work };
		const auto call = [](void* context, int i) { (*static_cast<Guarded<Work>*>(context))(i); };
		lead(begin, end, call, &guarded);
		if (guarded.error) std::rethrow_exception(guarded.error);
	}

	/// Within run: calls work(i) once for each 0 ≤ i < count, in chunks of 512. For work that is
	/// too short to share index by index. Rethrows the exception of the smallest i.
	template <class Work> void forEach(std::size_t count, Work work)
	{
		const int size = int(count);
		parallelFor(0, (size + chunk - 1) / chunk, [&](int part) {
			for (int i = part * chunk; i < std::min(size, (part + 1) * chunk); ++i)
				work(i);
		});
	}

	/// Within run: the largest value(i) for 0 ≤ i < count, at least 0.
	template <class Value> double maximum(std::size_t count, Value value)
	{
		std::vector<double> ofChunk(count / chunk + 1);
		forEach(count, [&](std::size_t i) {
			double& largest = ofChunk[i / chunk];
			largest         = std::max(largest, value(i));
		});
		return *std::max_element(ofChunk.begin(), ofChunk.end());
	}

	/// Within run: calls loops(), which ask choice.parallel() whether to share. Records their time
	/// divided by `work`, the amount of work done. Without helpers nothing is recorded.
	template <class Loops> void runTimed(ParallelChoice& choice, double work, Loops loops)
	{
		if (!helped_) return loops();
		const auto start = Clock::now();
		loops();
		choice.record(std::chrono::duration<double>(Clock::now() - start).count() / work);
	}

private:
	using Clock = std::chrono::steady_clock;

	static constexpr int chunk = 512;

	/// Work whose exceptions are caught. The one of the smallest index is kept.
	template <class Work> struct Guarded {
		Work&              work;
		std::mutex         mutex = {};
		std::exception_ptr error = nullptr;
		int                least = 0;

		void operator()(int i)
		{
			try {
				work(i);
			} catch (...) {
				const std::lock_guard<std::mutex> lock(mutex);
				if (!error || i < least) least = i, error = std::current_exception();
			}
		}
	};

	void end();
	void request();
	void lead(int begin, int end, void (*work)(void*, int), void* context);

	bool                        running_ = false;
	int                         threads_ = 1;     // of this run
	bool                        helped_  = false; // helpers take part in loops
	std::shared_ptr<SharedLoop> loop_;            // helpers may hold it after the run
	Clock::time_point           aloneUntil_;      // after a stall
};

} // namespace rcr
