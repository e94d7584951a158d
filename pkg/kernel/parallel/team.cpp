#include "parallel/team.hpp"

#include "parallel/crew.hpp"

namespace rcr {

namespace {
	using namespace std::chrono_literals;
	constexpr auto minAlone = 20ms, maxAlone = 2000ms; // that the leader goes on without helpers after a stall
}

void Team::begin(int threads)
{
	threads_ = threads;
	running_ = true;
	call();
}

/// Each call without a stall before it halves the time that the next stall costs.
void Team::call()
{
	if (threads_ == 1) return;
	if (helped_) alone_ = alone_ / 2;
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
	if (loop_->lead(begin, end, work, context)) return;
	alone_      = std::min<Clock::duration>(std::max<Clock::duration>(2 * alone_, minAlone), maxAlone);
	aloneUntil_ = Clock::now() + alone_;
	helped_     = false;
}

} // namespace rcr
