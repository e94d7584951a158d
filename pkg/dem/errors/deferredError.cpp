#include "dem/errors/deferredError.hpp"

#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "dem/yadeHeaders.hpp"

namespace yade {

// YADE's run thread and its lock are private. An explicit template instantiation may name private
// members.
shared_ptr<ThreadRunner> runThread(Omega&);
std::mutex&              runMutex(ThreadRunner&);
template <shared_ptr<ThreadRunner> Omega::*member> struct RunThread {
	friend shared_ptr<ThreadRunner> runThread(Omega& omega) { return omega.*member; }
};
template <std::mutex ThreadRunner::*member> struct RunMutex {
	friend std::mutex& runMutex(ThreadRunner& run) { return run.*member; }
};
template struct RunThread<&Omega::simulationLoop>;
template struct RunMutex<&ThreadRunner::m_runmutex>;

namespace {

	std::mutex  mutex;
	std::string pending;   // message of the first deferred error; empty: none
	std::string stepError; // message of the exception that ended the last step

	// error of a scene that was found in a parallel loop, and its step
	std::string  sceneError;
	const Scene* errorScene = nullptr;
	long         errorStep  = 0;

	int raise(void*)
	{
		const std::lock_guard<std::mutex> lock(mutex);
		PyErr_SetString(PyExc_ValueError, pending.c_str());
		pending.clear();
		return -1;
	}

} // namespace

void deferError(const std::string& message)
{
	const std::lock_guard<std::mutex> lock(mutex);
	if (!pending.empty()) return;
	// if the queue is full, a later step finds the error again
	if (Py_AddPendingCall(raise, nullptr) != 0) return;
	pending = message;
	Omega::instance().getScene()->stopAtIter = Omega::instance().getScene()->iter + 1;
}

void leaveSceneError(const Scene& scene, const std::string& message)
{
	const std::lock_guard<std::mutex> lock(mutex);
	sceneError = message, errorScene = &scene, errorStep = scene.iter;
}

std::string takeSceneError(const Scene& scene)
{
	const std::lock_guard<std::mutex> lock(mutex);
	const bool isOfStep = errorScene == &scene && errorStep == scene.iter;
	errorScene          = nullptr;
	return isOfStep ? sceneError : std::string();
}

void rememberError(const std::string& message)
{
	const std::lock_guard<std::mutex> lock(mutex);
	stepError = message;
}

std::string takeError()
{
	const std::lock_guard<std::mutex> lock(mutex);
	const auto                        run = runThread(Omega::instance());
	const std::string thrown
	        = run->workerThrew.exchange(false) ? run->workerException.what() : "";
	return stepError.empty() ? thrown : std::exchange(stepError, {});
}

void awaitStart()
{
	const auto run = runThread(Omega::instance());
	Py_BEGIN_ALLOW_THREADS;
	while (run->looping() && runMutex(*run).try_lock()) { // the run holds its lock to its end
		runMutex(*run).unlock();
		std::this_thread::sleep_for(std::chrono::microseconds(20));
	}
	Py_END_ALLOW_THREADS;
}

void awaitEnd()
{
	if (Omega::instance().isRunning()) return;
	const auto run = runThread(Omega::instance());
	Py_BEGIN_ALLOW_THREADS;
	{
		const std::lock_guard<std::mutex> untilRunEnds(runMutex(*run));
	}
	Py_END_ALLOW_THREADS;
}

} // namespace yade
