#include "dem/records/EnergyAccount.hpp"

namespace yade {

void EnergyAccount::enter(EnergyTracker& energy, const rcr::Step& step,
        const std::vector<rcr::Twist>& impulses, rcr::Vec2 gravity)
{
	energy.add(pending_.friction, "plastDissip", index_.friction, false);
	energy.add(pending_.impact, "impactDissip", index_.impact, false);
	energy.add(pending_.driven, "driveWork", index_.drive, false);
	energy.add(-pending_.lifted, "correctionWork", index_.correction, false);
	energy.add(pending_.lifted, "gravWork", index_.gravity, false);
	pending_ = rcr::stepEnergy(step, impulses, gravity);
}

} // namespace yade
