// Threads that share out loops of a few microseconds.
//
// One thread leads: it runs the algorithm and shares out loops (shared_loop.hpp); the others, borrowed from the process (crew.hpp),
// help. Waiting spins for about a microsecond, then yields the core; a helper that finds nothing for some milliseconds sleeps until the
// next run. When the leader had to wait long for a helper that lost its core in the midst of work, it goes on alone for a while.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <vector>

#include "parallel/shared_loop.hpp"
#include "parallel/trial.hpp"

namespace rcr {

class Team {
public:
	/// Calls lead() on this thread while up to threads − 1 others help. Within another run it is a part of that, for which
	/// helpers that have gone to sleep or were left alone are called again.
	template <class Lead> void run(int threads, Lead lead)
	{
		if (running_) {
			call();
			lead();
			return;
		}
		begin(threads);
		struct Run {
			Team& team;
			~Run() { team.end(); }
		} run { *this };
		lead();
	}

	/// Inside run: work(i) for begin ≤ i < end, each once, by any thread and in any order; returns when all are done. Where some
	/// throw, the exception of the least i is thrown on.
	template <class Work> void share(int begin, int end, Work work)
	{
		if (!helped_ || end - begin < 2) {
			for (int i = begin; i < end; ++i)
				work(i);
			return;
		}
		Guarded<Work> guarded { work };
		lead(begin, end, [](void* context, int i) { (*static_cast<Guarded<Work>*>(context))(i); }, &guarded);
		if (guarded.error) std::rethrow_exception(guarded.error);
	}

	/// Inside run: work(i) for 0 ≤ i < count, 512 at a time, for work too short to be shared out one by one. Where some throw,
	/// the exception of the least i is thrown on.
	template <class Work> void forEach(std::size_t count, Work work)
	{
		const int size = int(count);
		share(0, (size + atATime - 1) / atATime, [&](int part) {
			for (int i = part * atATime; i < std::min(size, (part + 1) * atATime); ++i)
				work(i);
		});
	}

	/// Inside run: the largest value(i) for 0 ≤ i < count, or 0 where none is above.
	template <class Value> double most(std::size_t count, Value value)
	{
		std::vector<double> ofPart(count / atATime + 1);
		forEach(count, [&](std::size_t i) {
			double& most = ofPart[i / atATime];
			most         = std::max(most, value(i));
		});
		return *std::max_element(ofPart.begin(), ofPart.end());
	}

	/// Inside run: lead() with helpers or alone, as the trial says, which books the time over `work`, the size of what is done.
	template <class Lead> void tryHelp(Trial& trial, double work, Lead lead)
	{
		if (!helped_) return lead();
		const bool helped = helped_ = trial.helped();
		const auto start = Clock::now();
		lead();
		trial.book(std::chrono::duration<double>(Clock::now() - start).count() / work);
		if (!helped) helped_ = true;
	}

private:
	using Clock = std::chrono::steady_clock;

	static constexpr int atATime = 512;

	/// Work whose exceptions stay on the thread that throws: of all, the one of the least index is kept.
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

	void begin(int threads);
	void end();
	void call();
	void lead(int begin, int end, void (*work)(void*, int), void* context);

	bool                        running_ = false;
	int                         threads_ = 1;     // of this run
	bool                        helped_  = false; // now
	std::shared_ptr<SharedLoop> loop_;            // helpers may still hold it after the run
	Clock::time_point           aloneUntil_; // after a stall
};

} // namespace rcr
