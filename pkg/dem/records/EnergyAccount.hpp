// Enters the energies of each step into O.energy, one step later. YADE computes the kinetic energy
// at the beginning of a step.
#pragma once

#include "dem/yadeHeaders.hpp"
#include "kernel/step/energy.hpp"

namespace yade {

class EnergyAccount {
public:
	/// Enters the energies of the last step and computes the energies of this step. `impulses`: sum
	/// of the contact impulses on each body [N s, N m s].
	void enterPrevious(EnergyTracker& energy, const rcr::Step& step,
	        const std::vector<rcr::PlanarVector>& impulses, rcr::Vec2 gravity)
	{
		const auto add = [&](const char* name, double work) {
			int unknown = -1; // O.energy may have been cleared, or be that of another scene
			energy.add(work, name, unknown, false);
		};
		add("plastDissip", pending_.friction);
		add("impactDissip", pending_.impact);
		add("driveWork", pending_.driven);
		add("correctionWork", -pending_.lifted);
		add("gravWork", pending_.lifted);
		pending_ = rcr::stepEnergy(step, impulses, gravity);
	}

	template <class Archive> void serialize(Archive& archive, unsigned)
	{
		using boost::serialization::make_nvp;
		archive & make_nvp("friction", pending_.friction) & make_nvp("impact", pending_.impact);
		archive & make_nvp("driven", pending_.driven) & make_nvp("lifted", pending_.lifted);
	}

private:
	rcr::StepEnergy pending_;
};

} // namespace yade
