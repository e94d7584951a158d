#include "sweep/sweep_solver.hpp"

#include "problem/residual.hpp"

namespace rcr {

Workspace::Workspace() : packed_(std::make_unique<PackedProblem>()) { }
Workspace::~Workspace() = default;
ThreadTeam&         Workspace::team() { return packed_->team; }
const ModelSummary& Workspace::summary() const { return packed_->summary(); }
double              Workspace::layoutSeconds() const { return packed_->layoutSeconds(); }

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

Report reportOf(PackedProblem& packed, const Settings& settings, const std::vector<IslandEnd>& ends)
{
	struct Part {
		Measures measures;
		double   freeVelocity2;
		int      points;
	};
	std::vector<Part> parts(packed.islands());
	packed.forEachIsland([&](PackedIsland&& island) {
		parts[island.number()] = { island.measure(), island.freeVelocity2(), island.points() };
	});
	Report report;
	Part   whole {};
	double change2 = 0;
	int    points  = 0;
	for (std::size_t k = 0; k < parts.size(); ++k) {
		Criteria criteria = criteriaOf(
		        parts[k].measures, parts[k].freeVelocity2, parts[k].points, settings);
		criteria.meanForceChange = ends[k].meanForceChange;
		const bool met           = criteria.met(settings)
		        || (settings.tolerance == 0 && criteria.residual == 0);
		report.converged = report.converged && met;
		if (!met) change2 += ends[k].change2;
		report.iterations = std::max(report.iterations, ends[k].sweeps);
		report.work += double(ends[k].sweeps) * parts[k].points;
		points += parts[k].points;
		whole.measures += parts[k].measures;
		whole.freeVelocity2 += parts[k].freeVelocity2;
	}
	const Criteria criteria = criteriaOf(whole.measures, whole.freeVelocity2, points, settings);
	report.residual         = criteria.residual;
	report.kinematicError   = criteria.kinematicError;
	// infinite without impulses
	report.impulseGrowth = change2 > 0 ? std::sqrt(change2 / whole.measures.impulse2) : 0;
	report.dissipated    = whole.measures.dissipated;
	report.freeSpeed     = points > 0 ? std::sqrt(whole.freeVelocity2 / points) : 0;
	return report;
}

} // namespace rcr
