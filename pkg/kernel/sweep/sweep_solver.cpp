#include "sweep/sweep_solver.hpp"

#include "problem/residual.hpp"

namespace rcr {

Workspace::Workspace() : packed_(std::make_unique<PackedProblem>()) { }
Workspace::~Workspace() = default;
ThreadTeam&         Workspace::team() { return packed_->team; }
const ModelSummary& Workspace::summary() const { return packed_->summary(); }
double              Workspace::layoutSeconds() const { return packed_->layoutSeconds(); }

constexpr int    sweepsAfterYield  = 50;   // of an island that yielded in an earlier pass
constexpr double minSingleResidual = 1e-6; // least residual in floats, which round to 6e-8

static Errors errorsOf(
        const Measures& m, double freeVelocity2, int points, const Settings& settings)
{
	if (m.kinematicError2 < points * settings.roundingVelocity * settings.roundingVelocity)
		return {};
	return errorsFromSums(m, freeVelocity2, settings.velocityFloor);
}

Settings IslandStop::settingsFor(const PackedIsland& island, const Settings& settings)
{
	Settings own = settings.ofIsland ? settings.ofIsland(settings, island.points()) : settings;
	if (settings.tolerance > 0 && settings.mayYield() && island.hasYielded())
		own.maxIterations = std::min(own.maxIterations, sweepsAfterYield);
	return own;
}

Criteria IslandStop::measure()
{
	const Measures m = island_.measure();
	Criteria criteria { errorsOf(m, island_.freeVelocity2(), island_.points(), settings()) };
	// NaN without forces or an earlier evaluation: not met
	criteria.meanForceChange = std::abs(m.normal - normal_) / m.normal;
	normal_                  = m.normal;
	const bool mayStop = criteria.met(settings()) || criteria.residual <= minSingleResidual;
	if (!island_.mixedPrecision() || !mayStop) return criteria;
	island_.endMixedPrecision();
	normal_ = std::numeric_limits<double>::quiet_NaN();
	return measure();
}

IslandEnd IslandStop::end()
{
	const bool known = island_.hasSavedImpulses() && sweeps() == settings().maxIterations;
	const double change2 = known ? island_.changeSinceSaved()
	                             : std::numeric_limits<double>::infinity();
	const Sums sums { {}, island_.freeVelocity2(), island_.mass(), change2, island_.points() };
	return { sums, sweeps(), stop_.criteria().meanForceChange, settings().velocityFloor };
}

static Report reportOf(const Sums& sums, const Settings& settings)
{
	const Measures& m = sums.measures;
	Report          report;
	static_cast<Errors&>(report) = errorsOf(m, sums.freeVelocity2, sums.points, settings);
	report.dissipated            = m.dissipated;
	report.freeSpeed = sums.points > 0 ? std::sqrt(sums.freeVelocity2 / sums.points) : 0;
	report.mass      = sums.mass;
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
		Settings own      = settings;
		own.velocityFloor = end.velocityFloor;
		islands.push_back(reportOf(end.sums, own));
		Report& island = islands.back();
		island.converged = Criteria { island, end.meanForceChange }.met(settings)
		        || island.meetsTolerances(settings);
		island.iterations = end.sweeps;
		island.work       = double(end.sweeps) * end.sums.points;
		whole.measures += end.sums.measures;
		whole.freeVelocity2 += end.sums.freeVelocity2;
		whole.mass += end.sums.mass;
		whole.change2 += island.converged ? 0 : end.sums.change2;
		whole.points += end.sums.points;
	}
	Report report = reportOf(whole, settings);
	report.combine(std::move(islands));
	return report;
}

} // namespace rcr
