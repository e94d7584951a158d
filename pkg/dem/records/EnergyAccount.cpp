#include "dem/records/EnergyAccount.hpp"

namespace yade {

void EnergyAccount::enter(EnergyTracker& energy, const rcr::Step& step,
        const std::vector<rcr::Twist>& impulses, rcr::Vec2 gravity)
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

} // namespace yade
