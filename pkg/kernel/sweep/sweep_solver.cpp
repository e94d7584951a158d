#include "sweep/sweep_solver.hpp"

#include "problem/infeasibility.hpp"
#include "problem/residual.hpp"

namespace rcr {

Workspace::Workspace() : packed_(std::make_unique<PackedProblem>()) { }
Workspace::~Workspace() = default;
ThreadTeam&         Workspace::team() { return packed_->team; }
const ModelSummary& Workspace::summary() const { return packed_->summary(); }
double              Workspace::layoutSeconds() const { return packed_->layoutSeconds(); }

constexpr int    sweepsAfterYield  = 50;   // of an island that yielded in an earlier pass
constexpr double minSingleResidual = 1e-6; // least residual in floats, which round to 6e-8

constexpr int    probeSlot        = 2;    // of impulses for tests of divergence

std::vector<LocalVector> impulsesBeforeProbe(Workspace& workspace)
{
	return workspace.packed().savedImpulses(probeSlot);
}

/// Residual of an island; 0 if its errors are rounding errors of velocities.
static double residualOf(const Measures& m, int points, const Settings& settings)
{
	const double rounding = settings.roundingVelocity;
	return m.kinematicError2 < points * rounding * rounding ? 0 : residualFromSums(m);
}

static Settings limited(const PackedIsland& island, Settings settings)
{
	if (settings.tolerance > 0 && settings.mayYield() && island.hasYielded())
		settings.maxIterations = std::min(settings.maxIterations, sweepsAfterYield);
	return settings;
}

IslandStop::IslandStop(PackedIsland& island, const Settings& settings)
        : island_(island), stop_(limited(island, settings))
{
}

bool IslandStop::mustStop()
{
	const bool early = stop_.sweeps() == 1 && island_.points() == 1;
	if (stop_.mustStop(early, [this] { return measure(); })) return true;
	// stop_.sweeps() is 1 before the first sweep
	if (stop_.sweeps() == settings().maxIterations - probeSweeps + 1) {
		island_.saveImpulses(probeSlot);
		probed_ = true;
	}
	return false;
}

Criteria IslandStop::measure()
{
	Criteria   criteria = evaluate(false);
	const bool mayStop  = criteria.met(settings()) || criteria.residual <= minSingleResidual;
	if (island_.mixedPrecision() && mayStop) {
		island_.endMixedPrecision();
		normal_  = std::numeric_limits<double>::quiet_NaN();
		criteria = evaluate(false);
	}
	saveAtCheckpoint(criteria.residual);
	return criteria;
}

/// The estimate needs impulses of half as many sweeps. `atEnd`: takes those saved nearest to them.
Criteria IslandStop::evaluate(bool atEnd)
{
	const Measures m = island_.measure();
	Criteria       criteria;
	criteria.residual = residualOf(m, island_.points(), settings());
	if (criteria.residual > 0) criteria.creep = creepOf(m, island_.points());
	// NaN without forces or an earlier evaluation: not met
	criteria.meanForceChange = std::abs(m.normal - normal_) / m.normal;
	normal_                  = m.normal;
	criteria.errorEstimate   = criteria.residual == 0
	          ? 0
	          : island_.norm().factor * island_.shape().conditionOfSweeps()
	                * relativeRms(m.errorEnergy, m.impulseEnergy);
	if (!atEnd && !settings().areMet(criteria.residual, criteria.creep, 0)) return criteria;
	// a smooth error changes only after impulses have crossed the island
	if (sweeps() < island_.shape().diameter) return criteria;
	const auto distance = [&](int slot) { return std::abs(2 * saved_[slot].sweeps - sweeps()); };
	const int  slot     = distance(1) < distance(0) ? 1 : 0;
	if (saved_[slot].sweeps > 0 && (atEnd || distance(slot) == 0))
		criteria.errorEstimate = std::min(criteria.errorEstimate,
		        estimate(m, criteria.residual, saved_[slot], slot));
	return criteria;
}

double IslandStop::estimate(const Measures& m, double residual, const Saved& saved, int slot)
{
	const PackedIsland::Change change = island_.changeSinceSaved(slot);
	return island_.norm().factor
	        * errorFromChange(
	        { change.energy, m.impulseEnergy, m.errorEnergy, island_.changeEnergy() },
	        saved.residual > 0 ? residual / saved.residual : 1, sweeps(), island_.shape());
}

void IslandStop::saveAtCheckpoint(double residual)
{
	int intervals = sweeps() / settings().checkInterval;
	if (intervals == 0 || sweeps() % settings().checkInterval != 0) return;
	while (intervals % 2 == 0)
		intervals /= 2;
	if (intervals != 1 && intervals != 3) return;
	const int slot = intervals == 1 ? 0 : 1;
	island_.saveImpulses(slot);
	saved_[slot] = { sweeps(), residual };
}

IslandEnd IslandStop::end()
{
	const bool   known   = probed_ && sweeps() == settings().maxIterations;
	const double change2 = known ? island_.changeSinceSaved(probeSlot).square
	                             : std::numeric_limits<double>::infinity();
	const Sums sums { {}, island_.freeVelocity2(), island_.mass(), change2, island_.points() };
	const double meanForceChange = stop_.criteria().meanForceChange;
	Criteria criteria = stop_.criteria().met(settings()) ? stop_.criteria() : evaluate(true);
	criteria.meanForceChange = meanForceChange; // of the last evaluation
	return { sums, sweeps(), criteria, settings(), island_.shape() };
}

static Report reportOf(const Sums& sums, const Settings& settings)
{
	const Measures& m = sums.measures;
	Report          report;
	report.residual   = residualOf(m, sums.points, settings);
	if (report.residual > 0) report.creep = creepOf(m, sums.points);
	report.dissipated = m.dissipated;
	report.freeSpeed  = sums.points > 0 ? std::sqrt(sums.freeVelocity2 / sums.points) : 0;
	report.mass       = sums.mass;
	// infinite without impulses
	report.impulseGrowth = sums.change2 > 0 ? std::sqrt(sums.change2 / m.impulse2) : 0;
	return report;
}

Report reportOf(const std::vector<IslandEnd>& ends, const Settings& settings)
{
	Sums                whole;
	std::vector<Report> islands;
	islands.reserve(ends.size());
	for (const IslandEnd& end : ends) {
		islands.push_back(reportOf(end.sums, settings));
		Report& island       = islands.back();
		island.shape         = end.shape;
		island.errorEstimate = end.criteria.errorEstimate;
		Criteria criteria    = end.criteria;
		criteria.residual    = island.residual;
		criteria.creep       = island.creep;
		island.converged     = criteria.met(end.settings) || island.meets(end.settings);
		island.iterations    = end.sweeps;
		island.work          = double(end.sweeps) * end.sums.points;
		whole.measures += end.sums.measures;
		whole.freeVelocity2 += end.sums.freeVelocity2;
		whole.mass += end.sums.mass;
		whole.change2 += island.converged ? 0 : end.sums.change2;
		whole.points += end.sums.points;
	}
	Report report = reportOf(whole, settings);
	if (islands.size() == 1) report.shape = islands[0].shape;
	report.combine(std::move(islands));
	return report;
}

} // namespace rcr
