#include "team.hpp"

#include <chrono>
#include <thread>

#ifdef _OPENMP
#include <omp.h>
#endif
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace rcr {

namespace {

	constexpr int  spins    = 100;                            // about a microsecond
	constexpr auto patience = std::chrono::milliseconds(1);   // no serial part of a solver lasts longer

	constexpr int           indexBits = 20;
	constexpr std::uint64_t indexMask = (1u << indexBits) - 1;

	constexpr std::uint64_t pack(std::uint64_t serial, std::uint64_t next, std::uint64_t end)
	{
		return serial << (2 * indexBits) | end << indexBits | next;
	}

	void pause()
	{
#if defined(__x86_64__)
		_mm_pause();
#endif
	}

	/// Waits until ready() or until nothing happened for too long; true if ready.
	template <class Ready> bool wait(Ready ready, bool forever)
	{
		for (int i = 0; i < spins; ++i) {
			if (ready()) return true;
			pause();
		}
		const auto start = std::chrono::steady_clock::now();
		while (!ready()) {
			std::this_thread::yield();
			if (!forever && std::chrono::steady_clock::now() - start > patience) return false;
		}
		return true;
	}

} // namespace

void Team::run(int threads, void (*lead)(void*), void* context)
{
#ifdef _OPENMP
	threads_ = threads;
	if (room_ < threads) {
		parts_ = std::make_unique<Part[]>(threads);
		room_  = threads;
	}
	if (threads_ > 1) {
		open_ = true;
#pragma omp parallel num_threads(threads)
		{
			if (omp_get_thread_num() > 0) help(omp_get_thread_num());
			else {
				lead(context);
				open_ = false;
			}
		}
		threads_ = 1;
		return;
	}
#endif
	(void)threads;
	lead(context);
}

void Team::share(int begin, int end, void (*work)(void*, int), void* context)
{
	const std::uint64_t count = end - begin;
	begin_                    = begin;
	work_                     = work;
	context_                  = context;
	++serial_;
	done_.store(0, std::memory_order_relaxed);
	for (int t = 0; t < threads_; ++t)
		parts_[t].word.store(pack(serial_, count * t / threads_, count * (t + 1) / threads_), std::memory_order_release);
	done_.fetch_add(this->work(0), std::memory_order_acq_rel);
	wait([&] { return done_.load(std::memory_order_acquire) == int(count); }, true);
}

int Team::work(int self)
{
	int taken = 0;
	for (int k = 0; k < threads_; ++k) {
		std::atomic<std::uint64_t>& part = parts_[(self + k) % threads_].word;
		std::uint64_t               word = part.load(std::memory_order_acquire);
		while ((word & indexMask) < (word >> indexBits & indexMask)) {
			if (!part.compare_exchange_weak(word, word + 1, std::memory_order_acq_rel, std::memory_order_acquire)) continue;
			work_(context_, begin_ + int(word & indexMask)); // the loop stands until this index is counted as done
			++taken;
			word = part.load(std::memory_order_acquire);
		}
	}
	return taken;
}

void Team::help(int self)
{
	std::uint64_t seen = parts_[self].word.load(std::memory_order_acquire);
	while (open_.load(std::memory_order_acquire)) {
		if (const int taken = work(self)) done_.fetch_add(taken, std::memory_order_acq_rel);
		const auto news = [&] { return parts_[self].word.load(std::memory_order_acquire) != seen || !open_.load(std::memory_order_acquire); };
		if (!wait(news, false)) return;
		seen = parts_[self].word.load(std::memory_order_acquire);
	}
}

} // namespace rcr
