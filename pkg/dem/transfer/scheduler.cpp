#include "dem/transfer/scheduler.hpp"

#include <set>

#include "dem/loads/CellStress.hpp"
#include "dem/loads/WallStress.hpp"
#include "dem/validation/validation.hpp"

namespace yade::scheduler {

/// Returns true if a PeriodicEngine will act at this iteration and time. Its own isActivated()
/// would count the call.
static bool isDue(const PeriodicEngine& engine, long iter, Real time)
{
	// the first call starts the counts of the engine
	if (engine.nDone == 0) return engine.firstIterRun <= 0 || engine.firstIterRun == iter;
	if (iter < engine.iterLast) return true;
	if (engine.nDo >= 0 && engine.nDone >= engine.nDo) return false;
	return (engine.virtPeriod > 0 && time - engine.virtLast >= engine.virtPeriod)
	        || (engine.realPeriod > 0
	                && PeriodicEngine::getClock() - engine.realLast >= engine.realPeriod)
	        || (engine.iterPeriod > 0 && iter - engine.iterLast >= engine.iterPeriod);
}

/// Adds the bodies that an engine loads or drives; returns false if it may read other bodies.
static bool addLoadedBodies(const Engine& engine, std::vector<Body::id_t>& ids)
{
	if (dynamic_cast<const CellStress*>(&engine)) return true;
	if (const auto* stress = dynamic_cast<const WallStress*>(&engine)) {
		ids.insert(ids.end(), { stress->wall, stress->start, stress->end });
		return true;
	}
	static const std::set<std::string> forces { "ForceEngine",
		"InterpolatingDirectedForceEngine", "RadialForceEngine", "TorqueEngine", "DragEngine",
		"LinearDragEngine" };
	if (!validation::isKinematic(engine) && !forces.count(engine.getClassName()))
		return false;
	const auto& more = static_cast<const PartialEngine&>(engine).ids;
	ids.insert(ids.end(), more.begin(), more.end());
	return true;
}

static bool isCoreEngine(const Engine& engine)
{
	return dynamic_cast<const ForceResetter*>(&engine) || dynamic_cast<const Collider*>(&engine)
	        || dynamic_cast<const InteractionLoop*>(&engine)
	        || dynamic_cast<const RigidSolver*>(&engine)
	        || dynamic_cast<const NewtonIntegrator*>(&engine);
}

Schedule scheduleOf(const Scene& scene)
{
	Schedule all;
	bool     looped = false, solved = false;
	for (const auto& engine : scene.engines) {
		// periodic engines are checked in each step
		if (engine->dead || dynamic_cast<const PeriodicEngine*>(engine.get())) continue;
		looped |= bool(dynamic_cast<const InteractionLoop*>(engine.get()));
		solved |= bool(dynamic_cast<const RigidSolver*>(engine.get()));
		if (isCoreEngine(*engine)) continue;
		if ((solved || !addLoadedBodies(*engine, all.bodies)) && all.foreign.empty())
			all.foreign = engine->getClassName();
		(looped ? all.after : all.before).push_back(engine.get());
		all.movesAfter |= looped && validation::isKinematic(*engine);
	}
	return all;
}

std::string reasonToStop(const Scene& scene)
{
	if (!Omega::instance().isRunning() || scene.subStepping) return "a single step";
	const long iter = scene.iter + 1;
	const Real time = scene.time + scene.dt;
	if ((scene.stopAtIter > 0 && iter >= scene.stopAtIter)
	        || (scene.stopAtTime > 0 && time >= scene.stopAtTime))
		return "the end of the run";
	if (!scene._nextEngines.empty()) return "a change of O.engines";
	bool solved = false;
	for (const auto& engine : scene.engines) {
		if (engine->dead) continue;
		solved |= bool(dynamic_cast<const RigidSolver*>(engine.get()));
		const auto* periodic = dynamic_cast<const PeriodicEngine*>(engine.get());
		if (periodic && isDue(*periodic, solved ? scene.iter : iter, solved ? scene.time : time))
			return "the engine " + engine->getClassName();
	}
	return {};
}

void beginNextStep(Scene& scene)
{
	const auto now      = boost::posix_time::microsec_clock::local_time();
	const long duration = (now - scene.prevTime).total_microseconds();
	scene.prevTime      = now;
	scene.SpeedElements(scene.iter % Scene::nSpeedIter, 0) = 1e6 / std::max(duration, 1L);
	scene.speed                                            = scene.SpeedElements.mean();
	if (TimingInfo::enabled)
		for (const auto& engine : scene.engines)
			engine->timingInfo.nExec
			        += !engine->dead && !dynamic_cast<const PeriodicEngine*>(engine.get());
	++scene.iter;
	scene.time += scene.dt;
	if (scene.isPeriodic) {
		scene.cell->integrateAndUpdate(scene.dt);
		if (scene.cell->flipFlippable) scene.cell->flipCell();
	}
	// as the ForceResetter
	scene.forces.reset(scene.iter);
	if (scene.trackEnergy) scene.energy->resetResettables();
}

void run(Scene& scene, const std::vector<Engine*>& engines)
{
	for (Engine* engine : engines) {
		engine->scene = &scene;
		if (!engine->dead && engine->isActivated()) engine->action();
	}
	scene.forces.sync();
}

} // namespace yade::scheduler
