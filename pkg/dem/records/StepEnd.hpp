// Time step and velocities at the end of the last step.
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
	/// Returns changeSince; empty if the scene has made steps since the record.
	std::string change(const Scene&) const;

private:
	/// Returns true if the record is that of the last step of this scene.
	bool isOf(const Scene&) const;

	boost::weak_ptr<const Factorable> scene_;
	long                              iter_ = 0; // no forces before the first step
	double                            dt_   = 0;
	std::vector<rcr::PlanarVector>    velocity_; // by body
};

} // namespace yade
