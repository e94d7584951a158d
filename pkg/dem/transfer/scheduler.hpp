// YADE's scheduler, for steps in arrays.
//
// YADE takes a step in one call of Scene::moveToNextTimeStep, and Omega ends a run. Steps in arrays
// replace this call, so they do the rest of its work: move the cell, reset forces, call engines
// that are due, count. YADE has no functions for these parts. They are written here and nowhere
// else; compare them with YADE's core/Scene.cpp and pkg/common/PeriodicEngines.hpp.
#pragma once

#include "dem/yadeHeaders.hpp"

namespace yade::scheduler {

/// Engines of a scene that act in steps in arrays.
struct Schedule {
	std::vector<Engine*>    before, after; // the InteractionLoop
	bool                    movesAfter = false; // `after` holds a kinematic engine
	std::vector<Body::id_t> bodies; // that they load or drive
	std::string             foreign; // name of an engine that may read any object; empty: none
};

/// The schedule of a scene, without engines that are dead or periodic.
Schedule scheduleOf(const Scene&);

/// Reason for which YADE must take the next step: the end of the run, a periodic engine that is due,
/// or a change of O.engines. Empty: none. Call it in ContactDynamics.
std::string reasonToStop(const Scene&);

/// Ends a step and begins the next one: updates O.iter, O.time, O.speed and the counts of
/// O.timingEnabled, moves the cell and resets forces.
void beginNextStep(Scene&);

/// Calls the engines that are active.
void run(Scene&, const std::vector<Engine*>&);

} // namespace yade::scheduler
