#include "parallel/team.hpp"

#include "parallel/crew.hpp"

namespace rcr {

namespace {
	using namespace std::chrono_literals;
	constexpr auto minAlone = 20ms, maxAlone = 2000ms; // that the leader goes on without helpers after a stall: twice as long after each …
	constexpr int  calm     = 10;                      // … until there has been none for so many times as long
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
	const auto now = Clock::now();
	if (now > aloneUntil_ + calm * alone_) alone_ = {};
	helped_ = now >= aloneUntil_;
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
