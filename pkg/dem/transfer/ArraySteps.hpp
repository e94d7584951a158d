// Takes steps in flat arrays, without YADE's objects.
//
// YADE allocates bodies, shapes, states and interactions one by one, and a loop over them takes
// longer than a solve. While no engine reads these objects, `advance` takes the next step in
// arrays. It moves bodies like NewtonIntegrator and applies the loads. It detects contacts like the
// collider and InteractionLoop. `writeBack` then copies the state at the beginning of the last step
// to YADE's objects. Results have the same bits as steps by YADE's engines.
//
// YADE's engines complete the last step of a run. They take a step after 100 steps in arrays, which
// updates YADE's objects, and steps in which an engine is due that may read any object. They take
// all steps of scenes that the arrays do not support (`sceneReason`, `bodiesReason`).
//
// Obstacles and bodies that engines load or drive (kinematic engines, force engines, WallStress)
// are synced: each step reads and writes YADE's objects of them.
#pragma once

#include <array>

#include "kernel/step/leapfrog.hpp"
#include "kernel/detection/pairs.hpp"
#include "dem/transfer/gather.hpp"

namespace yade {

class ArraySteps {
public:
	/// Advances from a solved step to the next one and gathers it. `impulses`: sum of the contact
	/// impulses on each body. If YADE's engines must take the next step, returns false and changes
	/// neither bodies nor step; enginesReason() is then the reason.
	bool advance(Scene&, const validation::Engines&, rcr::ThreadTeam&, SceneHandles&,
	        const std::vector<rcr::PlanarVector>& impulses, rcr::Step&);

	/// Copies the state at the beginning of the step to YADE's objects, as `scatter` requires. Does
	/// nothing if no step was taken in arrays since the last call.
	void writeBack(Scene&, rcr::ThreadTeam&, SceneHandles&, const rcr::Step&);

	/// Reason for which YADE's engines take the next step; empty: none.
	const std::string& enginesReason() const { return reason_; }
	/// Number of steps taken in arrays so far.
	long               count() const { return count_; }

private:
	struct Motion {
		std::array<double, 2> center, turn;
		std::array<double, 3> velocity;
	};

	static Motion motionOf(const State&);
	std::string   sceneReason(const Scene&, const validation::Engines&, const rcr::Step&);
	std::string   bodiesReason(const Scene&, const rcr::Step&);
	std::string   momentaryReason(const Scene&) const;
	void          begin(rcr::ThreadTeam&, const SceneHandles&, const rcr::Step&);
	void          move(Scene&, const NewtonIntegrator&, rcr::ThreadTeam&, const SceneHandles&,
	                 const std::vector<rcr::PlanarVector>& impulses, rcr::Step&);
	void          runEngines(Scene&, const std::vector<Engine*>&) const;
	void          acceptNewContacts(Scene&, const validation::Engines&);

	long                      count_ = 0, first_ = 0;
	// YADE's objects are out of date since array step first_
	bool                      active_ = false;
	std::string               reason_;
	// engines that exert forces, before and after the InteractionLoop
	std::vector<Engine*>      enginesBefore_, enginesAfter_;
	bool                      movesAfter_ = false; // enginesAfter_ holds a kinematic engine
	std::vector<Body::id_t>   synced_;
	std::vector<char>         isSynced_; // per body
	std::vector<rcr::Inertia> inertia_;  // per body
	std::vector<Motion>       written_;  // per body: as in YADE's objects
	// per body: velocity at the end of the last overdamped step
	std::vector<rcr::PlanarVector>   endVelocity_;
	rcr::Neighbors                   neighbors_;
	rcr::Pairs                       pairs_;
};

} // namespace yade
