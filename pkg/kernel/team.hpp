// Threads that share out loops of a few microseconds.
//
// One thread leads: it runs the algorithm and shares out loops; the others help. Every thread has its own part of each
// loop, in the same place each time, so its data stay in its cache; who runs dry takes from the others. Nobody waits for
// a helper that has not started: where cores are busy with other work the leader does all of it. Waiting spins for under
// a microsecond, then yields the core; a helper that finds nothing for a millisecond leaves until the next run.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace rcr {

class Team {
public:
	/// Calls lead() on this thread while up to threads − 1 others help; returns when all are done.
	template <class Lead> void run(int threads, Lead lead)
	{
		Call<Lead> call { &lead };
		run(threads, &Call<Lead>::lead, &call);
	}

	/// Inside run: work(i) for begin ≤ i < end, each once, by any thread and in any order; returns when all are done.
	template <class Work> void share(int begin, int end, Work work)
	{
		if (threads_ == 1 || end - begin < 2) {
			for (int i = begin; i < end; ++i)
				work(i);
			return;
		}
		Call<Work> call { &work };
		share(begin, end, &Call<Work>::work, &call);
	}

private:
	template <class Function> struct Call {
		Function*   function;
		static void lead(void* self) { (*static_cast<Call*>(self)->function)(); }
		static void work(void* self, int i) { (*static_cast<Call*>(self)->function)(i); }
	};

	/// What is left of one thread's part: serial number of the loop, end and next index in one word.
	struct alignas(128) Part {
		std::atomic<std::uint64_t> word { 0 };
	};

	void run(int threads, void (*lead)(void*), void* context);
	void share(int begin, int end, void (*work)(void*, int), void* context);
	void help(int self);
	int  work(int self); // takes what it can, own part first; returns how many

	int                        threads_ = 1, room_ = 0;
	std::unique_ptr<Part[]>    parts_;
	std::uint64_t              serial_ = 0;
	int                        begin_  = 0;
	void (*work_)(void*, int)          = nullptr;
	void*                         context_ = nullptr;
	alignas(128) std::atomic<int> done_ { 0 };
	alignas(128) std::atomic<bool> open_ { false };
};

} // namespace rcr
