#include "parallel/shared_loop.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace rcr {

namespace {

	using namespace std::chrono_literals;
	constexpr int maxSpins = 100; // of a waiting thread before it yields its core, about 1 µs
	// waiting time of a helper between two loops; few serial parts of a step last longer
	constexpr auto helperPatience = 5ms;
	/// Waiting time of the leader after its own work. One index takes less, so a helper that needs
	/// longer has lost its core.
	constexpr auto leaderStall = 1ms;

	constexpr int           indexBits = 20; // leaves 24 bits for the serial number
	constexpr std::uint64_t indexMask = (1u << indexBits) - 1;
	constexpr int           maxSlice  = int(indexMask); // indices of one slice

	constexpr std::uint64_t pack(std::uint64_t serial, std::uint64_t next, std::uint64_t end)
	{
		return serial << (2 * indexBits) | end << indexBits | next;
	}

	void pause()
	{
#if defined(__x86_64__)
		__builtin_ia32_pause();
#endif
	}

	/// Waits until ready() or until the time limit; returns ready().
	template <class Ready> bool wait(Ready ready, std::chrono::steady_clock::duration limit)
	{
		for (int i = 0; i < maxSpins; ++i) {
			if (ready()) return true;
			pause();
		}
		const auto start = std::chrono::steady_clock::now();
		while (!ready()) {
			std::this_thread::yield();
			if (std::chrono::steady_clock::now() - start > limit) return false;
		}
		return true;
	}

} // namespace

bool SharedLoop::lead(int begin, int end, void (*work)(void*, int), void* context)
{
	work_       = work;
	context_    = context;
	bool prompt = true;
	for (int count; begin < end; begin += count) {
		count  = std::min(end - begin, maxSlice);
		prompt = leadSlice(begin, count) && prompt;
	}
	return prompt;
}

bool SharedLoop::leadSlice(int begin, int count)
{
	const std::uint64_t size = count, threads = threads_;
	begin_ = begin;
	++serial_;
	done_.store(0, std::memory_order_relaxed);
	for (std::uint64_t t = 0; t < threads; ++t) {
		const std::uint64_t part = pack(serial_, size * t / threads, size * (t + 1) / threads);
		parts_[t].word.store(part, std::memory_order_release);
	}
	done_.fetch_add(work(0), std::memory_order_acq_rel);
	const auto complete = [&] { return done_.load(std::memory_order_acquire) == count; };
	if (wait(complete, leaderStall)) return true;
	wait(complete, std::chrono::steady_clock::duration::max());
	return false;
}

int SharedLoop::work(int self)
{
	int processed = 0;
	for (int k = 0; k < threads_; ++k) {
		std::atomic<std::uint64_t>& part = parts_[(self + k) % threads_].word;
		std::uint64_t               word = part.load(std::memory_order_acquire);
		while ((word & indexMask) < (word >> indexBits & indexMask)) {
			if (!part.compare_exchange_weak(
			            word, word + 1, std::memory_order_acq_rel, std::memory_order_acquire))
				continue;
			// work_ and context_ stay valid: the leader waits until this index counts as done
			work_(context_, begin_ + int(word & indexMask));
			++processed;
			word = part.load(std::memory_order_acquire);
		}
	}
	return processed;
}

void SharedLoop::help(int self)
{
	std::uint64_t seen = parts_[self].word.load(std::memory_order_acquire);
	while (isOpen()) {
		if (const int processed = work(self)) done_.fetch_add(processed, std::memory_order_acq_rel);
		const auto hasWork = [&] {
			return parts_[self].word.load(std::memory_order_acquire) != seen || !isOpen();
		};
		if (!wait(hasWork, helperPatience)) return;
		seen = parts_[self].word.load(std::memory_order_acquire);
	}
}

} // namespace rcr
