// Steps in flat arrays: what YADE's engines do between two solves, without YADE's objects.
//
// Bodies, shapes, states and interactions each have an allocation of their own in YADE, and a walk through them costs more than a solve. In the midst
// of a run nobody has to look at them: from a solved step, `goOn` moves the bodies as NewtonIntegrator does, lets the loads of the
// scene act, finds the contacts as the collider and InteractionLoop do and hands back the next step, gathered. `publish` writes to YADE's objects
// what the last of these steps began with, for `scatter` and the engines that follow. All of it gives the bits of the engines' own way.
//
// A step is YADE's
//
//   * where a run ends, or 100 steps are over, for whoever watches it;
//   * where an engine that may look at anything is due: a PyRunner, a recorder, any engine that is not named below;
//   * in scenes with what is not kept in arrays: clumps, a periodic cell, energy tracking, permanent forces.
//
// Loads on named bodies (kinematic engines, ForceEngine and its like, WallStress) and obstacles stay with YADE: these few bodies are written and read every step.
#pragma once

#include <array>

#include "../kernel/step/leapfrog.hpp"
#include "../kernel/step/pairs.hpp"
#include "gather.hpp"

namespace yade {

class FlatSteps {
public:
	/// From a solved step, whose impulses load its bodies by `loads`, to the next one, gathered. False, with the step and the scene as they
	/// were, where the next one is YADE's: `why` tells.
	bool goOn(Scene&, const gate::Engines&, rcr::ThreadTeam&, StepSources&, const std::vector<rcr::Twist>& loads, rcr::Step&);

	/// YADE's objects as the step began, so that it can be scattered. Does nothing where `goOn` has not gone on since the last time.
	void publish(Scene&, rcr::ThreadTeam&, StepSources&, const rcr::Step&);

	const std::string& why() const { return why_; }   // empty: the last step was meanStretchRate by one of these
	long               count() const { return count_; } // steps so far

private:
	struct Motion {
		std::array<double, 2> center, turn;
		std::array<double, 3> velocity;
	};

	static Motion        motionOf(const State&);
	std::string          reason(const Scene&, const gate::Engines&, const rcr::Step&);
	std::string          reasonNow(const Scene&) const;
	std::string          watch(const Scene&, const rcr::Step&);
	void                 begin(rcr::ThreadTeam&, const StepSources&, const rcr::Step&);
	void                 move(Scene&, const NewtonIntegrator&, rcr::ThreadTeam&, const StepSources&, const std::vector<rcr::Twist>& loads, rcr::Step&);
	void                 load(Scene&, const std::vector<Engine*>&) const;
	void                 setPhysics(Scene&, const gate::Engines&);
	StepSources::Contact write(int number, Interaction&, const rcr::Step&) const;

	long                      count_ = 0, first_ = 0;
	bool                      going_ = false; // YADE's objects are behind, since step first_
	std::string               why_;
	std::vector<Engine*>      early_, late_; // loads before and after the InteractionLoop
	std::vector<Body::id_t>   watched_;      // bodies that stay with YADE
	std::vector<char>         watches_;      // a body
	std::vector<rcr::Inertia> inertia_;      // a body
	std::vector<Motion>       begun_;        // a body: as YADE has it
	std::vector<rcr::Twist>   arrived_;      // a body: its velocity at the end of the last overdamped step
	rcr::Neighbours           neighbours_;
	rcr::Pairs                pairs_;
};

} // namespace yade
