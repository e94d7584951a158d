// Threads that share out loops of a few microseconds.
//
// One thread leads: it runs the algorithm and shares out loops; the others help. Every thread has its own part of each
// loop, in the same place each time, so its data stay in its cache; who runs dry takes from the others. Nobody waits for
// a helper that has not started: where cores are busy with other work the leader does all of it. Waiting spins for about
// a microsecond, then yields the core; a helper that finds nothing for a millisecond sleeps until the next run. When the
// leader had to wait long for a helper that lost its core in the midst of work, it goes on alone for a while.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace rcr {

class Team {
public:
	Team() = default;
	~Team() { dismiss(); }

	/// Calls lead() on this thread while up to threads − 1 others help. Within another run it is a part of that, for which
	/// helpers that have gone to sleep are woken.
	template <class Lead> void run(int threads, Lead lead)
	{
		if (running_) {
			wake();
			lead();
			return;
		}
		struct Run {
			Team& team;
			Run(Team& t, int threads) : team(t) { team.begin(threads); }
			~Run() { team.end(); }
		} run(*this, threads);
		lead();
	}

	/// Inside run: work(i) for begin ≤ i < end, each once, by any thread and in any order; returns when all are done.
	template <class Work> void share(int begin, int end, Work work)
	{
		if (!helped_ || end - begin < 2) {
			for (int i = begin; i < end; ++i)
				work(i);
			return;
		}
		share(begin, end, [](void* context, int i) { (*static_cast<Work*>(context))(i); }, &work);
	}

	/// Inside run: work(i) for 0 ≤ i < count, 512 at a time, for work too short to be shared out one by one. Where some throw,
	/// the exception of the least i is thrown on.
	template <class Work> void forEach(std::size_t count, Work work)
	{
		constexpr int      atATime = 512;
		const int          size    = int(count);
		std::mutex         mutex;
		std::exception_ptr error;
		int                errorPart = size;
		share(0, (size + atATime - 1) / atATime, [&](int part) {
			try {
				for (int i = part * atATime; i < std::min(size, (part + 1) * atATime); ++i)
					work(i);
			} catch (...) {
				const std::lock_guard<std::mutex> lock(mutex);
				if (part < errorPart) errorPart = part, error = std::current_exception();
			}
		});
		if (error) std::rethrow_exception(error);
	}

private:
	using Clock = std::chrono::steady_clock;

	/// What is left of one thread's part: serial number of the loop, end and next index in one word.
	struct alignas(128) Part {
		std::atomic<std::uint64_t> word { 0 };
	};

	void begin(int threads);
	void end();
	void wake();
	void hire(int threads);
	void dismiss();
	void share(int begin, int end, void (*work)(void*, int), void* context);
	void help(int self);
	int  work(int self); // takes what it can, own part first; returns how many

	// the leader's
	bool              running_ = false;
	bool              helped_  = false; // in this run
	std::uint64_t     serial_ = 0;
	Clock::time_point aloneUntil_;
	Clock::duration   alone_ { 0 }; // how long after the next stall

	// the present loop
	int begin_                = 0;
	void (*work_)(void*, int) = nullptr;
	void* context_            = nullptr;

	std::vector<std::thread>      helpers_;
	std::unique_ptr<Part[]>       parts_; // the leader's and one a helper
	std::mutex                    mutex_;
	std::condition_variable       call_;
	std::uint64_t                 calls_ = 0; // under the mutex; the helpers leave at `over`
	static constexpr std::uint64_t over = ~0ull;
	alignas(128) std::atomic<int> done_ { 0 };
	alignas(128) std::atomic<bool> open_ { false };
};

} // namespace rcr
