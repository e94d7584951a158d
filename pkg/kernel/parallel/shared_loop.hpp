// A loop shared out among threads: indices are taken from a part of each thread's own, then from those of the others.
//
// One thread leads, the others help. Each thread has the same part of every loop, so that its data stay in its cache. Nobody
// waits for a helper that has not started: where the cores are busy with other work the leader does all of it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace rcr {

class SharedLoop {
public:
	explicit SharedLoop(int threads) : threads_(threads), parts_(std::make_unique<Part[]>(threads)) { }

	int threads() const { return threads_; }

	/// Helpers stay while the loop is open; between two loops they spin, then yield, for some milliseconds.
	void open() { open_.store(true, std::memory_order_release); }
	void close() { open_.store(false, std::memory_order_release); }
	bool isOpen() const { return open_.load(std::memory_order_acquire); }

	/// By the leader: work(context, i) for begin ≤ i < end, each once; returns when all are done. False where the leader had to
	/// wait long for a helper that lost its core in the midst of work.
	bool lead(int begin, int end, void (*work)(void*, int), void* context);

	/// By helper `self`, 1 … threads − 1: works on loops as they come.
	void help(int self);

private:
	/// The indices left of one thread's part, end and next, below the serial number of the loop, by which helpers see a new one.
	struct alignas(128) Part {
		std::atomic<std::uint64_t> word { 0 };
	};

	bool leadSlice(int begin, int count);
	int  take(int self); // does what it can get, own part first; returns how much

	const int                     threads_;
	const std::unique_ptr<Part[]> parts_; // the leader's and one a helper
	std::uint64_t                 serial_ = 0;

	// the present loop
	int begin_                = 0;
	void (*work_)(void*, int) = nullptr;
	void* context_            = nullptr;

	alignas(128) std::atomic<int> done_ { 0 };
	alignas(128) std::atomic<bool> open_ { false };
};

} // namespace rcr
