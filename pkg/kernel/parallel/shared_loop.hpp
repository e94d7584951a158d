// A loop shared among threads by work stealing. Each thread takes indices from its own part, then
// from the parts of other threads.
//
// One thread leads, the others help. A thread has the same part in every loop, so its data stay in
// its cache. The leader never waits for helpers that have not started: on busy cores it does all
// the work.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace rcr {

class SharedLoop {
public:
	explicit SharedLoop(int threads) : threads_(threads), parts_(std::make_unique<Part[]>(threads))
	{
	}

	int threads() const { return threads_; }

	/// Helpers stay while the loop is open. Between two loops they spin, then yield their core,
	/// then leave after some milliseconds.
	void open() { open_.store(true, std::memory_order_release); }
	void close() { open_.store(false, std::memory_order_release); }
	bool isOpen() const { return open_.load(std::memory_order_acquire); }

	/// Leader: calls work(context, i) once for each begin ≤ i < end and returns when all calls are
	/// done. Returns false after a stall: a helper lost its core during its work.
	bool lead(int begin, int end, void (*work)(void*, int), void* context);

	/// Helper `self`, 1 … threads − 1: takes part in loops until it finds none for some time.
	void help(int self);

private:
	/// Remaining indices of one part: serial number of the loop, end, next. Helpers detect a new
	/// loop by the serial number.
	struct alignas(128) Part {
		std::atomic<std::uint64_t> word { 0 };
	};

	bool leadSlice(int begin, int count);
	int  work(int self); // claims and processes indices, own part first; returns their number

	const int                     threads_;
	const std::unique_ptr<Part[]> parts_; // of the leader, then of the helpers
	std::uint64_t                 serial_ = 0;

	// the current loop
	int begin_                = 0;
	void (*work_)(void*, int) = nullptr;
	void* context_            = nullptr;

	alignas(128) std::atomic<int> done_ { 0 };
	alignas(128) std::atomic<bool> open_ { false };
};

} // namespace rcr
