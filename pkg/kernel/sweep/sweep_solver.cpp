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

static Criteria criteriaOf(
        const Measures& m, double freeVelocity2, int points, const Settings& settings)
{
	if (m.kinematicError2 < points * settings.roundingVelocity * settings.roundingVelocity)
		return {};
	return { residualFromSums(m.error2, m.impulse2, m.stopping2),
		kinematicErrorFromSums(
		        m.kinematicError2, m.velocity2, freeVelocity2, settings.velocityFloor) };
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
	const Criteria criteria = evaluate();
	if (!island_.mixedPrecision()
	        || !(criteria.met(stop_.settings()) || criteria.residual <= minSingleResidual))
		return criteria;
	island_.endMixedPrecision();
	measured_ = false;
	return evaluate();
}

Criteria IslandStop::evaluate()
{
	const Measures m = island_.measure();
	Criteria criteria = criteriaOf(m, island_.freeVelocity2(), island_.points(), stop_.settings());
	// NaN without forces: not met
	if (measured_) criteria.meanForceChange = std::abs(m.normal - normal_) / m.normal;
	normal_   = m.normal;
	measured_ = true;
	return criteria;
}

/// Sums over the points of an island or of the whole problem.
struct Sums {
	Measures measures;
	double   freeVelocity2 = 0, mass = 0, change2 = 0;
	int      points        = 0;

	Sums& operator+=(const Sums& other)
	{
		measures += other.measures;
		freeVelocity2 += other.freeVelocity2, mass += other.mass, change2 += other.change2;
		points += other.points;
		return *this;
	}

	Report report(const Settings& settings) const
	{
		const Criteria criteria = criteriaOf(measures, freeVelocity2, points, settings);
		Report         report;
		report.residual       = criteria.residual;
		report.kinematicError = criteria.kinematicError;
		report.dissipated     = measures.dissipated;
		report.freeSpeed      = points > 0 ? std::sqrt(freeVelocity2 / points) : 0;
		report.mass           = mass;
		// infinite without impulses
		report.impulseGrowth = change2 > 0 ? std::sqrt(change2 / measures.impulse2) : 0;
		return report;
	}
};

Report reportOf(PackedProblem& packed, const Settings& settings, const std::vector<IslandEnd>& ends)
{
	std::vector<Sums> sums(packed.islands());
	packed.forEachIsland([&](PackedIsland&& island) {
		sums[island.number()] = { island.measure(), island.freeVelocity2(), island.mass(), 0,
			island.points() };
	});
	Sums                whole;
	std::vector<Report> islands;
	islands.reserve(sums.size());
	for (std::size_t k = 0; k < sums.size(); ++k) {
		sums[k].change2   = ends[k].change2;
		Settings own      = settings;
		own.velocityFloor = ends[k].velocityFloor;
		islands.push_back(sums[k].report(own));
		Report&        island = islands.back();
		const Criteria criteria { island.residual, island.kinematicError, ends[k].meanForceChange };
		island.converged = criteria.met(settings) || island.meetsTolerances(settings);
		island.iterations = ends[k].sweeps;
		island.work       = double(ends[k].sweeps) * sums[k].points;
		if (island.converged) sums[k].change2 = 0;
		whole += sums[k];
	}
	Report report = whole.report(settings);
	report.combine(std::move(islands));
	return report;
}

} // namespace rcr
