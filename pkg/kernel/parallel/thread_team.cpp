#include "parallel/thread_team.hpp"

#include "parallel/thread_pool.hpp"

namespace rcr {

using namespace std::chrono_literals;

/// Time that the leader works alone after a stall, over the length of the stall. Stalls cost at
/// most a tenth of the run time.
constexpr int  aloneFactor = 10;
constexpr auto maxAlone    = 400ms; // upper bound of this time

void ThreadTeam::request()
{
	if (threads_ == 1) return;
	helped_ = Clock::now() >= aloneUntil_;
	if (!helped_) return;
	if (!loop_ || loop_->threads() != threads_) loop_ = std::make_shared<SharedLoop>(threads_);
	loop_->open();
	requestHelpers(loop_);
}

/// Does not wait for helpers: none of them holds work.
void ThreadTeam::end()
{
	if (loop_) loop_->close();
	helped_  = false;
	running_ = false;
}

void ThreadTeam::lead(int begin, int end, void (*work)(void*, int), void* context)
{
	const auto start = Clock::now();
	if (loop_->lead(begin, end, work, context)) return;
	const auto now = Clock::now();
	aloneUntil_    = now + std::min<Clock::duration>(aloneFactor * (now - start), maxAlone);
	helped_        = false;
}

} // namespace rcr
