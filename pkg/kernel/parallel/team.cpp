#include "parallel/team.hpp"

#include "parallel/crew.hpp"

namespace rcr {

namespace {
	using namespace std::chrono_literals;
	constexpr int  priceOfStall = 10; // times what a stall took, that the leader then goes on alone: stalls cost a tenth of all time at most …
	constexpr auto mostAlone    = 400ms; // … and after a long one helpers are soon tried again
}

void Team::begin(int threads)
{
	threads_ = threads;
	running_ = true;
	call();
}

void Team::call()
{
	if (threads_ == 1) return;
	helped_ = Clock::now() >= aloneUntil_;
	if (!helped_) return;
	if (!loop_ || loop_->threads() != threads_) loop_ = std::make_shared<SharedLoop>(threads_);
	loop_->open();
	callHelpers(loop_);
}

/// Helpers find out by themselves; none holds work any more.
void Team::end()
{
	if (loop_) loop_->close();
	helped_  = false;
	running_ = false;
}

void Team::lead(int begin, int end, void (*work)(void*, int), void* context)
{
	const auto start = Clock::now();
	if (loop_->lead(begin, end, work, context)) return;
	const auto now = Clock::now();
	aloneUntil_    = now + std::min<Clock::duration>(priceOfStall * (now - start), mostAlone);
	helped_        = false;
}

} // namespace rcr
