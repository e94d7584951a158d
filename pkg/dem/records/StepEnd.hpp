// Time step, places and velocities at the end of the last step.
//
// They give the positions at which the forces of this step acted: pos − O.dt vel. A later change by
// a script makes these positions wrong.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/step/step.hpp"

namespace yade {

/// Names the first change of O.dt or of a velocity since the last step. Empty: none. Velocities may
/// differ by as much as a position correction moves bodies.
std::string changeSince(const Scene&, double dt, const std::vector<rcr::PlanarVector>& velocity);

/// The end of a run or step, or the moment after O.load, under any law.
class StepEnd {
public:
	/// Ignores a second record of the same step.
	void record(const Scene&);
	/// Returns changeSince, or names the first body that a script has moved or turned since. Empty
	/// if the scene has made steps since the record.
	std::string change(const Scene&) const;

	/// Call it before a run. YADE moves the cell by O.dt at the beginning of a step; after a change
	/// of O.dt, this lets it move by the step by which its bodies have moved.
	void adaptCell(Scene&) const;

private:
	/// Returns true if the record is that of the last step of this scene.
	bool isOf(const Scene&) const;

	boost::weak_ptr<const Factorable> scene_;
	long                              iter_ = 0; // no forces before the first step
	double                            dt_   = 0;
	std::vector<rcr::PlanarVector>    velocity_; // by body
	std::vector<std::pair<Vector3r, Quaternionr>> place_; // by body
};

} // namespace yade
