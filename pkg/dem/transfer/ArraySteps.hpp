// Takes steps in flat arrays, without YADE's objects.
//
// YADE allocates bodies, shapes, states and interactions one by one, and a loop over them takes
// longer than a solve. While no engine reads these objects, `advance` takes the next step in
// arrays. It moves bodies like NewtonIntegrator and applies the loads. It detects contacts like the
// collider and InteractionLoop. `writeBack` then copies the state at the beginning of the last step
// to YADE's objects. Results have the same bits as steps by YADE's engines.
//
// YADE's engines complete the last step of a run. They take a step after 100 steps in arrays, which
// updates YADE's objects, and steps in which an engine is due that may read any object
// (scheduler.hpp). They take all steps of scenes that the arrays do not support (`sceneReason`,
// `bodiesReason`).
//
// Obstacles and bodies that engines load or drive (kinematic engines, force engines, WallStress)
// are synced: each step reads and writes YADE's objects of them. A clump is synced with its
// members.
#pragma once

#include <array>

#include "kernel/step/leapfrog.hpp"
#include "kernel/detection/pairs.hpp"
#include "dem/transfer/gather.hpp"
#include "dem/transfer/scheduler.hpp"

namespace yade {

class ArraySteps {
public:
	/// Advances from a solved step to the next one and gathers it. `impulses`: sum of the contact
	/// impulses on each body. If YADE's engines must take the next step, returns false and changes
	/// neither bodies nor step; enginesReason() is then the reason.
	bool advance(Scene&, const validation::Engines&, rcr::ThreadTeam&, SceneHandles&,
	        const std::vector<rcr::PlanarVector>& impulses, rcr::Neighbors&, rcr::Step&);

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
	struct MovedClump {
		Body::id_t                    id;
		std::vector<rcr::ClumpMember> members;
	};
	using Impulses = std::vector<rcr::PlanarVector>;

	static Motion motionOf(const State&);
	std::string   sceneReason(const Scene&, const validation::Engines&);
	std::string   bodiesReason(const Scene&, const rcr::Step&);
	std::string   momentaryReason(const Scene&) const;
	void          begin(const Scene&, rcr::ThreadTeam&, const SceneHandles&, const rcr::Step&);
	// as NewtonIntegrator (moveBodies.cpp)
	void          move(Scene&, const validation::Engines&, rcr::ThreadTeam&, const SceneHandles&,
	                 const Impulses&, rcr::Step&);
	void          displaceSynced(const SceneHandles&, const rcr::Step&) const;
	void          moveSynced(Scene&, const NewtonIntegrator&, const SceneHandles&, const Impulses&,
	                 const rcr::Step&) const;
	void          enterEnergies(Scene&, NewtonIntegrator&, const SceneHandles&, const rcr::Step&) const;

	long                      count_ = 0, first_ = 0;
	// YADE's objects are out of date since array step first_
	bool                      active_ = false;
	std::string               reason_;
	scheduler::Schedule       schedule_;
	Matrix3r                  firstEdges_; // of the cell, at array step first_
	std::vector<Body::id_t>   synced_;
	std::vector<char>         isSynced_; // per body
	std::vector<rcr::Inertia> inertia_;  // per body
	std::vector<Motion>       written_;  // per body: as in YADE's objects
	// per body: velocity at the end of the last step. The next one may begin with another velocity.
	std::vector<rcr::PlanarVector> endVelocity_;
	std::vector<MovedClump>        clumps_; // that are not synced
	rcr::Pairs                     pairs_;
};

} // namespace yade
