#include "problem/settings.hpp"

#include <cmath>

#include "problem/refuse.hpp"

namespace rcr {

const std::vector<std::string>& solverNames()
{
	static const std::vector<std::string> names { "nlgs", "sor", "nesterov", "exact", "auto" };
	return names;
}

void checkSettings(const std::string& solver, const Settings& s)
{
	requireKnown("solver", solver, solverNames());
	if (!(s.tolerance >= 0 && std::isfinite(s.tolerance)))
		refuse("tolerance = ", s.tolerance, ": give a finite residual ≥ 0; 0 runs all iterations");
	if (s.maxIterations < 1) refuse("maxIterations = ", s.maxIterations, ": give at least 1");
	if (s.checkInterval < 1) refuse("checkInterval = ", s.checkInterval, ": give at least 1 sweep");
	if (s.minIterations < 0 || s.minIterations > s.maxIterations)
		refuse("minIterations = ", s.minIterations,
		       ": give at least 0, and at most maxIterations = ", s.maxIterations);
	if (s.stallSweeps < 0)
		refuse("stallSweeps = ", s.stallSweeps, ": give at least 1, or 0 to ignore stalls");
	if (s.threads < 1) refuse("threads = ", s.threads, ": give at least 1");
	if (s.lanes != 0 && s.lanes != 1 && s.lanes != 4 && s.lanes != 8)
		refuse("lanes = ", s.lanes, ": give 1, 4, 8, or 0 for the width of the processor");
	if (!(s.accuracy > 0))
		refuse("accuracy = ", s.accuracy, ": give a fraction > 0; infinity disables the test");
	if (!(s.yielding.compliance >= 0))
		refuse("yieldCompliance = ", s.yielding.compliance,
		       ": give a fraction ≥ 0 of the response of a contact; 0 keeps contacts rigid");
	if (!(s.yielding.yieldImpulse > 0))
		refuse("yieldImpulse = ", s.yielding.yieldImpulse,
		       ": give an impulse > 0; infinity sets no bound");
	if (!(s.meanForceChange >= 0 && std::isfinite(s.meanForceChange)))
		refuse("meanForceChange = ", s.meanForceChange,
		       ": give a finite change ≥ 0; 0 disables the criterion");
}

} // namespace rcr
