#include "parallel/crew.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <list>
#include <mutex>
#include <system_error>
#include <thread>

#include "parallel/shared_loop.hpp"

namespace rcr {

namespace {

	constexpr auto retirement = std::chrono::seconds(10); // without a call

	struct Helper {
		std::shared_ptr<SharedLoop> loop; // the last one it was called to: the next call to the same place finds it again
		int                         self  = 0;
		std::uint64_t               calls = 0;
		bool                        idle  = false; // it has left its loop, which may be open
		std::condition_variable     called;
	};

	class Crew {
	public:
		void call(const std::shared_ptr<SharedLoop>& loop)
		{
			const std::lock_guard<std::mutex> lock(mutex_);
			for (int self = 1; self < loop->threads(); ++self) {
				Helper* helper = find(loop, self);
				if (!helper) return;
				helper->loop = loop;
				helper->self = self;
				++helper->calls;
				helper->called.notify_one();
			}
		}

		int count()
		{
			const std::lock_guard<std::mutex> lock(mutex_);
			return int(helpers_.size());
		}

	private:
		using Place = std::list<Helper>::iterator;

		/// The helper that had this place last, or one that is free, or a new one; none where the system gives no more.
		Helper* find(const std::shared_ptr<SharedLoop>& loop, int self)
		{
			const auto same = [&](const Helper& h) { return h.loop == loop && h.self == self; };
			const auto free = [](const Helper& h) { return h.idle || !h.loop->isOpen(); };
			Place      at   = std::find_if(helpers_.begin(), helpers_.end(), same);
			if (at == helpers_.end()) at = std::find_if(helpers_.begin(), helpers_.end(), free);
			if (at == helpers_.end()) at = hire();
			if (at == helpers_.end()) return nullptr;
			at->idle = false;
			return &*at;
		}

		Place hire()
		{
			const Place place = helpers_.emplace(helpers_.end());
			try {
				std::thread([this, place] { serve(place); }).detach();
				return place;
			} catch (const std::system_error&) {
				helpers_.erase(place);
				return helpers_.end();
			}
		}

		void serve(Place place)
		{
			Helper&                      helper = *place;
			std::unique_lock<std::mutex> lock(mutex_);
			std::uint64_t                seen = 0;
			while (helper.called.wait_for(lock, retirement, [&] { return helper.calls != seen; })) {
				seen                                   = helper.calls;
				const std::shared_ptr<SharedLoop> loop = helper.loop;
				const int                         self = helper.self;
				lock.unlock();
				loop->help(self);
				lock.lock();
				helper.idle = helper.calls == seen;
			}
			helpers_.erase(place);
		}

		std::mutex        mutex_;
		std::list<Helper> helpers_;
	};

	/// Never destroyed: helpers may wait until the process ends. A child after fork() has none of them, and a mutex in any state.
	Crew* crew = [] {
		pthread_atfork(nullptr, nullptr, [] { crew = new Crew; });
		return new Crew;
	}();

} // namespace

void callHelpers(const std::shared_ptr<SharedLoop>& loop) { crew->call(loop); }
int  helperCount() { return crew->count(); }

} // namespace rcr
