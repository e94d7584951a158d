// Solves problems of W and q by nonlinear block Gauss–Seidel, one contact point after the other:
//
//   p_k ← solution of the law for u_k = W_kk p_k + g_k,   g_k = q_k + Σ_{j≠k} W_kj p_j
//
// | solver                | method                                                           |
// |-----------------------|------------------------------------------------------------------|
// | nlgs                  | plain sweeps                                                     |
// | sor                   | over-relaxed sweeps: p ← P_K(p + 1.3 (solution − p))             |
// | nesterov, exact, auto | sweeps with momentum and restart (sweep/momentum.hpp)            |
//
// Stiff problems may stall above the tolerance; `converged` of the report is then false.
// Source: Jean 1999; Nesterov 1983.

#include "delassus/delassus_problem.hpp"
#include "problem/infeasibility.hpp"
#include "problem/refuse.hpp"
#include "problem/residual.hpp"
#include "sweep/momentum.hpp"
#include "sweep/stop_test.hpp"

namespace rcr {

static void checkSizes(const DelassusProblem& problem)
{
	const std::size_t count = problem.freeVelocity.size(), blocks = problem.column.size();
	const std::size_t rows = problem.rowStart.size();
	if (problem.friction.size() != count || problem.impulse.size() != count || rows != count + 1)
		refuse("q has ", count, " contacts, µ ", problem.friction.size(), ", impulse ",
		        problem.impulse.size(), ", W ", std::ptrdiff_t(rows) - 1,
		        "; expected one number");
	const auto& start = problem.rowStart;
	if (problem.block.size() != blocks || start.front() != 0
	        || std::size_t(start.back()) != blocks
	        || !std::is_sorted(start.begin(), start.end()))
		refuse("the rows of W do not fit its ", blocks, " blocks");
}

/// Checks the order of the columns, the diagonal and the numbers of row k.
static void checkRow(const DelassusProblem& problem, std::int32_t k)
{
	bool diagonal = false;
	for (std::int32_t e = problem.rowStart[k], last = -1; e < problem.rowStart[k + 1]; ++e) {
		const std::int32_t   j = problem.column[e];
		const DelassusBlock& w = problem.block[e];
		if (j <= last || j >= std::int32_t(problem.freeVelocity.size()))
			refuse("row ", k, " of W: columns are out of range or order");
		if (!finite(w.nn, w.nt, w.tn, w.tt)) refuse("block (", k, ", ", j, ") of W is not finite");
		if (j == k && (w.nn < 0 || w.tt < 0))
			refuse("W has a negative diagonal at contact ", k,
			        "; expected a positive semi-definite matrix");
		last     = j;
		diagonal = diagonal || j == k;
	}
	if (!diagonal) refuse("row ", k, " of W has no diagonal block");
	const LocalVector q = problem.freeVelocity[k], p = problem.impulse[k];
	const double      friction = problem.friction[k];
	if (!finite(q.n, q.t, p.n, p.t)) refuse("contact ", k, ": q or the impulse is not finite");
	if (!(friction >= 0 && std::isfinite(friction)))
		refuse("contact ", k, ": µ = ", friction, "; expected µ ≥ 0");
	if (friction > maxFriction)
		refuse("contact ", k, ": µ = ", friction,
		        " is too large to measure errors; expected µ ≤ ", maxFriction);
}

/// The pattern of W is symmetric. Requires rows that checkRow accepts.
static void checkSymmetry(const DelassusProblem& problem)
{
	const auto columns = problem.column.begin();
	for (std::int32_t k = 0; k < std::int32_t(problem.freeVelocity.size()); ++k)
		for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
			const std::int32_t j = problem.column[e];
			if (!std::binary_search(
			            columns + problem.rowStart[j], columns + problem.rowStart[j + 1], k))
				refuse("block (", k, ", ", j, ") of W has no mirror image");
		}
}

namespace {

	class Sweeps {
	public:
		explicit Sweeps(DelassusProblem& problem)
		        : problem_(problem)
		        , diagonal_(problem.freeVelocity.size())
		{
			for (std::size_t k = 0; k < diagonal_.size(); ++k) {
				const auto row = problem.column.begin() + problem.rowStart[k];
				const auto end = problem.column.begin() + problem.rowStart[k + 1];
				diagonal_[k] = std::int32_t(std::lower_bound(row, end, k) - problem.column.begin());
				if (block(k).nn <= 0)
					problem.impulse[k] = {}; // two prescribed bodies: no impulse moves them
			}
		}

		/// next(p, solution, µ) returns the new impulse of a point.
		template <class Next> void sweep(Next next)
		{
			for (std::size_t k = 0; k < diagonal_.size(); ++k) {
				const DelassusBlock& w = block(k);
				if (w.nn <= 0) continue;
				LocalVector& p        = problem_.impulse[k];
				const double friction = problem_.friction[k];
				LocalVector  g        = velocityWithoutOwn(k);
				g.t += (w.tn - w.nt) * p.n; // rounding of files: solveCoulomb takes w_tn = w_nt
				p = next(p, solveCoulomb({ w.nn, w.nt, w.tt }, g.n, g.t, friction), friction);
			}
		}

		/// A sweep from y = p + β (p − p_old). Returns ‖p − y‖².
		double accelerated(double momentum)
		{
			std::vector<LocalVector>& impulse = problem_.impulse;
			old_.resize(impulse.size());
			for (std::size_t k = 0; k < impulse.size(); ++k) {
				const LocalVector p = impulse[k];
				impulse[k]          = p + momentum * (p - old_[k]);
				old_[k]             = p;
			}
			double change2 = 0;
			sweep([&](LocalVector y, LocalVector solved, double) {
				change2 += square(solved - y);
				return solved;
			});
			return change2;
		}

		/// Writes u = W p + q to the problem. Returns the residual of problem/residual.hpp.
		double measure()
		{
			double error2 = 0, impulse2 = 0, stopping2 = 0;
			problem_.velocity.resize(diagonal_.size());
			for (std::size_t k = 0; k < diagonal_.size(); ++k) {
				const LocalVector p = problem_.impulse[k], u = velocityWithoutOwn(k) + block(k) * p;
				const double      w = block(k).nn, friction = problem_.friction[k];
				problem_.velocity[k] = u;
				if (w <= 0) continue;
				const LocalVector shifted { u.n + friction * std::abs(u.t), u.t };
				error2 += square(p - projectCone(p - (1 / w) * shifted, friction));
				impulse2 += square(p);
				stopping2 += u.n / w * (u.n / w);
			}
			return residualFromSums(error2, impulse2, stopping2);
		}

		/// exceedsEnergyBound (problem/infeasibility.hpp) with the masses 1/W_nn and biases in q.
		bool exceedsEnergyBound() const
		{
			double energy = 0, mass = 0, speed = 0, largest = 0;
			for (const LocalVector& p : problem_.impulse)
				largest = std::max(largest, p.n);
			for (std::size_t k = 0; k < diagonal_.size(); ++k) {
				const LocalVector p = problem_.impulse[k], u = problem_.velocity[k];
				energy -= dot(p, u);
				if (p.n <= noiseShare * largest) continue;
				mass += 1 / block(k).nn;
				speed = std::max(speed,
				        std::max(1.0, problem_.friction[k])
				                * std::sqrt(square(problem_.freeVelocity[k])));
			}
			return rcr::exceedsEnergyBound(energy, std::sqrt(mass) * speed);
		}

		/// Returns true if a point closes that no impulse can open. The residual omits it.
		bool closesBlockedPoint() const
		{
			double largest = 0, closing = 0;
			for (std::size_t k = 0; k < diagonal_.size(); ++k) {
				largest = std::max(largest, std::sqrt(square(problem_.freeVelocity[k])));
				if (block(k).nn <= 0) closing = std::max(closing, -problem_.velocity[k].n);
			}
			return closing > roundingShare * largest;
		}

	private:
		const DelassusBlock& block(std::size_t k) const { return problem_.block[diagonal_[k]]; }

		/// g_k of the comment at the top.
		LocalVector velocityWithoutOwn(std::size_t k) const
		{
			LocalVector g   = problem_.freeVelocity[k];
			const auto  add = [&](std::int32_t begin, std::int32_t end) {
				for (std::int32_t e = begin; e < end; ++e)
					g = g + problem_.block[e] * problem_.impulse[problem_.column[e]];
			};
			add(problem_.rowStart[k], diagonal_[k]);
			add(diagonal_[k] + 1, problem_.rowStart[k + 1]);
			return g;
		}

		DelassusProblem&          problem_;
		std::vector<std::int32_t> diagonal_; // of each row: its diagonal block
		std::vector<LocalVector>  old_;      // one sweep before, for momentum
	};

} // namespace

Report solve(DelassusProblem& problem, const std::string& solver, const Settings& settings)
{
	checkSettings(solver, settings);
	checkSizes(problem);
	for (std::int32_t k = 0; k < std::int32_t(problem.freeVelocity.size()); ++k)
		checkRow(problem, k);
	checkSymmetry(problem);
	Sweeps   sweeps(problem);
	Momentum momentum; // β = 0 in the first sweep
	StopTest stop(settings);
	while (!stop.mustStop(false, [&] { return Criteria { { sweeps.measure() } }; })) {
		if (solver == "nlgs")
			sweeps.sweep([](LocalVector, LocalVector solved, double) { return solved; });
		else if (solver == "sor")
			sweeps.sweep([](LocalVector p, LocalVector solved, double friction) {
				return projectCone(p + sorRelaxation * (solved - p), friction);
			});
		else
			momentum.advance(sweeps.accelerated(momentum.beta()));
	}
	Report report;
	report.iterations = stop.sweeps();
	report.residual   = sweeps.measure();
	report.converged  = report.residual <= settings.tolerance
	        && !sweeps.closesBlockedPoint() && !sweeps.exceedsEnergyBound();
	return report;
}

} // namespace rcr
