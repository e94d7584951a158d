#include "parallel/thread_pool.hpp"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <system_error>
#include <thread>

#include "parallel/shared_loop.hpp"

namespace rcr {

namespace {

	constexpr auto idleLimit = std::chrono::seconds(10); // then a helper ends

	struct Helper {
		std::shared_ptr<SharedLoop> loop;         // last assigned
		int                         self     = 0; // its part of the loop
		std::uint64_t               requests = 0;
		bool                        idle     = false; // has left its loop, which may still be open
		std::condition_variable     requested;
	};

	class ThreadPool {
	public:
		void assign(const std::shared_ptr<SharedLoop>& loop)
		{
			const std::lock_guard<std::mutex> lock(mutex_);
			for (int self = 1; self < loop->threads(); ++self) {
				Helper* helper = find(loop, self);
				if (!helper) return;
				helper->loop = loop;
				helper->self = self;
				++helper->requests;
				helper->requested.notify_one();
			}
		}

		int count()
		{
			const std::lock_guard<std::mutex> lock(mutex_);
			return int(helpers_.size());
		}

	private:
		using Position = std::list<Helper>::iterator;

		/// The last helper of this part of the loop, else a free one, else a new one; or nullptr if
		/// the system provides no more threads.
		Helper* find(const std::shared_ptr<SharedLoop>& loop, int self)
		{
			const auto same = [&](const Helper& h) { return h.loop == loop && h.self == self; };
			const auto free = [](const Helper& h) { return h.idle || !h.loop->isOpen(); };
			Position   at   = std::find_if(helpers_.begin(), helpers_.end(), same);
			if (at == helpers_.end()) at = std::find_if(helpers_.begin(), helpers_.end(), free);
			if (at == helpers_.end()) at = start();
			if (at == helpers_.end()) return nullptr;
			at->idle = false;
			return &*at;
		}

		Position start()
		{
			const Position position = helpers_.emplace(helpers_.end());
			try {
				std::thread([this, position] { serve(position); }).detach();
				return position;
			} catch (const std::system_error&) {
				helpers_.erase(position);
				return helpers_.end();
			}
		}

		void serve(Position position)
		{
			Helper&                      helper = *position;
			std::unique_lock<std::mutex> lock(mutex_);
			std::uint64_t                seen = 0;
			while (helper.requested.wait_for(
			        lock, idleLimit, [&] { return helper.requests != seen; })) {
				seen                                   = helper.requests;
				const std::shared_ptr<SharedLoop> loop = helper.loop;
				const int                         self = helper.self;
				lock.unlock();
				loop->help(self);
				lock.lock();
				helper.idle = helper.requests == seen;
			}
			helpers_.erase(position);
		}

		std::mutex        mutex_;
		std::list<Helper> helpers_;
	};

	/// Never destroyed: helpers may wait until the process ends. After fork(), the child has no
	/// helpers and a mutex in an unknown state, so it gets a new pool.
	ThreadPool* pool = [] {
		pthread_atfork(nullptr, nullptr, [] { pool = new ThreadPool; });
		return new ThreadPool;
	}();

} // namespace

void requestHelpers(const std::shared_ptr<SharedLoop>& loop) { pool->assign(loop); }
int  helperCount() { return pool->count(); }

} // namespace rcr
