#include "parallel/team.hpp"

#include <algorithm>

namespace rcr {

namespace {

	using namespace std::chrono_literals;
	constexpr int  spins    = 100;   // about a microsecond
	constexpr auto patience = 1ms;   // of a helper: no serial part of a solver lasts longer
	constexpr auto stall    = 100us; // a chunk takes one: the helper has lost its core
	constexpr auto minAlone = 20ms, maxAlone = 2000ms;

	constexpr int           indexBits = 20;
	constexpr std::uint64_t indexMask = (1u << indexBits) - 1;

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

	/// Waits until ready(), for a limited time; true if ready.
	template <class Ready> bool wait(Ready ready, std::chrono::steady_clock::duration limit)
	{
		for (int i = 0; i < spins; ++i) {
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

void Team::begin(int threads)
{
	running_ = true;
	if (threads - 1 != int(helpers_.size())) {
		dismiss();
		hire(threads);
	}
	helped_ = threads > 1 && Clock::now() >= aloneUntil_;
	if (!helped_) return;
	open_ = true;
	wake();
}

void Team::wake()
{
	if (!helped_) return;
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		++calls_;
	}
	call_.notify_all();
}

/// Helpers find out by themselves; none holds work any more.
void Team::end()
{
	if (helped_) alone_ = alone_ / 2;
	helped_  = false;
	open_    = false;
	running_ = false;
}

void Team::hire(int threads)
{
	parts_ = std::make_unique<Part[]>(threads);
	calls_ = 0;
	for (int self = 1; self < threads; ++self)
		helpers_.emplace_back([this, self] {
			for (std::uint64_t seen = 0;;) {
				{
					std::unique_lock<std::mutex> lock(mutex_);
					call_.wait(lock, [&] { return calls_ != seen; });
					seen = calls_;
				}
				if (seen == over) return;
				help(self);
			}
		});
}

void Team::dismiss()
{
	{
		const std::lock_guard<std::mutex> lock(mutex_);
		calls_ = over;
	}
	call_.notify_all();
	for (std::thread& helper : helpers_)
		helper.join();
	helpers_.clear();
}

void Team::share(int begin, int end, void (*work)(void*, int), void* context)
{
	const std::uint64_t count = end - begin, threads = helpers_.size() + 1;
	begin_                    = begin;
	work_                     = work;
	context_                  = context;
	++serial_;
	done_.store(0, std::memory_order_relaxed);
	for (std::uint64_t t = 0; t < threads; ++t)
		parts_[t].word.store(pack(serial_, count * t / threads, count * (t + 1) / threads), std::memory_order_release);
	done_.fetch_add(this->work(0), std::memory_order_acq_rel);
	const auto complete = [&] { return done_.load(std::memory_order_acquire) == int(count); };
	if (wait(complete, stall)) return;
	wait(complete, Clock::duration::max());
	alone_      = std::min<Clock::duration>(std::max<Clock::duration>(2 * alone_, minAlone), maxAlone);
	aloneUntil_ = Clock::now() + alone_;
	helped_     = false;
}

int Team::work(int self)
{
	int taken = 0;
	const int threads = int(helpers_.size()) + 1;
	for (int k = 0; k < threads; ++k) {
		std::atomic<std::uint64_t>& part = parts_[(self + k) % threads].word;
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
		if (!wait(news, patience)) return;
		seen = parts_[self].word.load(std::memory_order_acquire);
	}
}

} // namespace rcr
