#include "dem/records/StepObserver.hpp"

#include "dem/shapes/planeConversion.hpp"

namespace yade {

namespace py = boost::python;

static void checkIds(
        const std::vector<int>& ids, const rcr::Step& step, const SceneHandles& handles)
{
	for (int id : ids) {
		const std::string given = "ContactDynamics.observe holds " + std::to_string(id);
		if (id < 0 || std::size_t(id) >= step.bodies.size())
			errors::refuse(given + "; expected ids of bodies, of which the scene has "
			        + std::to_string(step.bodies.size()) + ".");
		if (!handles.state[id])
			errors::refuse(given + ", a body that was erased; remove the id.");
		const int owner = step.bodies[id].owner;
		if (owner != id)
			errors::refuse(given + ", a member of clump " + std::to_string(owner)
			        + "; its contacts act on the clump, so give that id.");
	}
}

void StepObserver::setLastPositions(
        const std::function<std::optional<rcr::Vec2>(int id)>& positionOf)
{
	if (intervals_.empty() || std::exchange(intervals_.back().placed, true)) return;
	for (int id : intervals_.back().sums.ids)
		if (const std::optional<rcr::Vec2> at = positionOf(id))
			intervals_.back().position[id] = *at;
}

void StepObserver::record(const StepOutcome& outcome, const std::vector<int>& ids, int interval,
        const std::vector<rcr::PlanarVector>& impulses, const rcr::Step& step,
        const SceneHandles& handles)
{
	checkIds(ids, step, handles);
	const std::lock_guard<std::mutex> lock(mutex_);
	setLastPositions([&](int id) -> std::optional<rcr::Vec2> {
		if (std::size_t(id) >= step.bodies.size() || !handles.state[id]) return {};
		return step.bodies[id].center;
	});
	add(means_, outcome, ids, 0, impulses, step.dt);
	if (interval == 0) {
		entry_ = {};
		return;
	}
	add(entry_, outcome, ids, interval, impulses, step.dt);
	if (entry_.steps < interval) return;
	intervals_.push_back({ std::exchange(entry_, {}), outcome, {}, false });
	means_ = {};
}

void StepObserver::add(Sums& sums, const StepOutcome& outcome, const std::vector<int>& ids,
        int interval, const std::vector<rcr::PlanarVector>& impulses, double dt)
{
	if (sums.ids != ids || sums.interval != interval) {
		sums          = {};
		sums.ids      = ids;
		sums.interval = interval;
		for (int id : ids)
			sums.force[id] = {};
	}
	++sums.steps;
	sums.iterations += outcome.sweeps;
	sums.yielded += outcome.yielded;
	sums.residual = std::max(sums.residual, outcome.residual);
	if (outcome.missed) {
		++sums.missed;
		sums.ratioSum += outcome.missedError;
		sums.largestRatio = std::max(sums.largestRatio, outcome.missedError);
	}
	for (auto& [id, sum] : sums.force)
		sum = sum + impulses[id] / dt;
}

void StepObserver::restart()
{
	const std::lock_guard<std::mutex> lock(mutex_);
	means_ = entry_ = {};
}

py::dict StepObserver::takeMeans(const std::vector<int>& ids)
{
	const std::lock_guard<std::mutex> lock(mutex_);
	return dictOf(std::exchange(means_, {}), ids);
}

void StepObserver::setLastPositions(const Scene& scene)
{
	const std::lock_guard<std::mutex> lock(mutex_);
	setLastPositions([&](int id) -> std::optional<rcr::Vec2> {
		if (!scene.bodies->exists(id)) return {};
		return plane::toPlane((*scene.bodies)[id]->state->pos);
	});
}

py::list StepObserver::takeIntervals()
{
	const Scene& scene = *Omega::instance().getScene();
	if (!Omega::instance().isRunning()) setLastPositions(scene);
	const std::lock_guard<std::mutex> lock(mutex_);
	const bool                        open = !intervals_.empty() && !intervals_.back().placed;
	const auto end = intervals_.end() - open;
	py::list   all;
	for (auto interval = intervals_.begin(); interval != end; ++interval) {
		py::dict entry = dictOf(interval->sums, interval->sums.ids), positions;
		for (const auto& [id, at] : interval->position)
			positions[id] = py::make_tuple(at.x, at.y);
		entry["step"]            = interval->last.iteration + 1; // O.iter at its end
		entry["time"]            = interval->last.endTime;
		entry["points"]          = interval->last.points;
		entry["last_iterations"] = interval->last.sweeps;
		entry["last_residual"]   = interval->last.residual;
		entry["positions"]       = positions;
		all.append(entry);
	}
	intervals_.erase(intervals_.begin(), end);
	return all;
}

py::dict StepObserver::dictOf(const Sums& sums, const std::vector<int>& ids)
{
	py::dict observed, forces;
	for (int id : sums.steps > 0 ? sums.ids : ids) {
		const auto              sum  = sums.force.find(id);
		const rcr::PlanarVector mean = sum == sums.force.end() ? rcr::PlanarVector {} : sum->second;
		const double            over = double(std::max(1L, sums.steps));
		forces[id] = py::make_tuple(mean.x / over, mean.y / over, mean.rotation / over);
	}
	observed["steps"]          = sums.steps;
	observed["iterations"]     = sums.iterations;
	observed["residual"]       = sums.residual;
	observed["missed"]         = sums.missed;
	observed["yielded"]        = sums.yielded;
	observed["missed_sum"]     = sums.ratioSum;
	observed["missed_largest"] = sums.largestRatio;
	observed["forces"]         = forces;
	return observed;
}

} // namespace yade
