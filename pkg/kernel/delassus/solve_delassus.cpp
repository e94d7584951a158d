// Solvers of problems that are given by W and q: Gauss–Seidel over packed rows of blocks (row_batch.hpp), plain, over-relaxed or with
// momentum, and a proximal point iteration (piece_steps.hpp) where sweeps lead no further.
#include <algorithm>
#include <limits>
#include <numeric>

#include "delassus/delassus_problem.hpp"
#include "delassus/piece_steps.hpp"
#include "delassus/row_batch.hpp"
#include "exact/stiffness.hpp"
#include "problem/residual.hpp"
#include "sweep/momentum.hpp"
#include "sweep/stop_test.hpp"

namespace rcr {

namespace {

	constexpr double relaxation = 1.3;   // as for problems with bodies
	constexpr int    stall      = 1000;  // sweeps without a new low of the residual, before a proximal step is tried
	constexpr int    maxSweeps  = 20000; // … or so many; a proximal step costs as much as some hundred
	constexpr int    between    = 1000;  // sweeps where Newton has not arrived: they cost less than its steps

	constexpr double infinity = std::numeric_limits<double>::infinity();

	/// How a batch was left.
	struct End {
		int     sweeps = 0;
		RowSums sums;

		double residual() const { return relativeError(sums.error2, sums.impulse2, sums.stopping2); }
		bool   reached(const Settings& settings) const { return settings.tolerance > 0 && residual() <= settings.tolerance; }
	};

	/// Calls sweep() until the settings stop it. A measurement costs as much as a sweep, so it is also made early, where the last
	/// change, at the ratio of residual to change that was measured last, lets the tolerance be met. A batch that starts cold has
	/// points that approach, or it would be at rest: its first sweep needs no measurement.
	template <class Sweep> End sweepUntil(RowBatch& batch, const Settings& settings, Sweep sweep)
	{
		StopTest stop(settings, batch.cold() ? 1 : 0);
		End      end;
		double   changed = infinity, ratio = 1; // last change of the impulses, relative; residual over change
		const auto measure = [&] {
			end.sums              = batch.measure();
			const double residual = end.residual();
			if (changed > 0 && changed < infinity) ratio = residual / changed;
			return Criteria { residual };
		};
		while (!stop.reached(settings.tolerance > 0 && ratio * changed <= settings.tolerance, measure)) {
			const RowChange change = sweep();
			changed                = relativeError(change.change2, change.impulse2, 0);
		}
		if (!stop.measured()) end.sums = batch.measure();
		end.sweeps = stop.sweeps();
		return end;
	}

	End plain(RowBatch& batch, const Settings& settings)
	{
		return sweepUntil(batch, settings, [&] { return batch.sweep(); });
	}

	End relaxed(RowBatch& batch, const Settings& settings)
	{
		return sweepUntil(batch, settings, [&] { return batch.sweepRelaxed(relaxation); });
	}

	End accelerated(RowBatch& batch, const Settings& settings)
	{
		Momentum momentum;
		return sweepUntil(batch, settings, [&] {
			batch.extrapolate(momentum.beta());
			const RowChange change = batch.sweep();
			momentum.advance(change.change2);
			return change;
		});
	}

	/// Stiffer while Newton arrives, much softer where it does not. Beyond 1e5 rounding is seen.
	constexpr Stiffness::Limits stiffnessLimits { 100, 1e-3, 1e5, 4, 16, 1 };

	/// Proximal steps, and sweeps where Newton does not arrive; the best iterate stays. Returns sweeps and Newton's steps.
	int proximal(DelassusProblem& problem, const Settings& settings, int iterations)
	{
		const Batches batches(problem);
		RowBatch      batch(problem, batches, settings.lanes);
		RowIds        all(problem.free.size());
		std::iota(all.begin(), all.end(), 0);
		batch.load(all.data(), all.data() + all.size());
		const auto measure = [&] {
			batch.loadImpulses();
			const End end { 0, batch.measure() };
			batch.store();
			return end.residual();
		};
		PieceSteps           steps(problem);
		Stiffness            stiffness(stiffnessLimits);
		double               lowest = measure();
		std::vector<Impulse> best   = problem.impulse;
		while (lowest > settings.tolerance && iterations < settings.maxIterations) {
			if (steps.step(stiffness.rho(), iterations, settings.maxIterations)) stiffness.arrived();
			else {
				stiffness.failed();
				Settings few      = settings;
				few.tolerance     = 0;
				few.maxIterations = std::min(between, settings.maxIterations - iterations);
				iterations += accelerated(batch, few).sweeps;
				batch.store();
			}
			const double residual = measure();
			if (!(residual < lowest)) continue;
			lowest = residual;
			best   = problem.impulse;
		}
		problem.impulse = best;
		return iterations;
	}

	/// Accelerated sweeps, then proximal steps.
	End exact(RowBatch& batch, DelassusProblem& problem, const Settings& settings)
	{
		Settings sweeps      = settings;
		sweeps.maxIterations = std::min(settings.maxIterations, maxSweeps);
		sweeps.stallSweeps   = stall;
		End end              = accelerated(batch, sweeps);
		if (end.residual() <= settings.tolerance || end.sweeps >= settings.maxIterations) return end;
		batch.store();
		RowIds rows = batch.rows();
		std::sort(rows.begin(), rows.end());
		DelassusProblem part = partOf(problem, rows);
		end.sweeps           = proximal(part, settings, end.sweeps);
		for (std::size_t i = 0; i < rows.size(); ++i)
			problem.impulse[rows[i]] = part.impulse[i];
		batch.loadImpulses();
		end.sums = batch.measure();
		return end;
	}

} // namespace

Report solve(DelassusProblem& problem, const std::string& solver, const Settings& settings)
{
	checkSettings(solver, settings);
	checkProblem(problem);
	problem.velocity = problem.free; // that of what is at rest, which has no error either
	const Batches batches(problem);
	RowBatch      batch(problem, batches, settings.lanes);
	Report        report;
	End           whole;
	for (int b = 0; b < batches.count(); ++b) {
		batch.load(batches.begin(b), batches.end(b));
		const auto run = [&] {
			if (solver == "nlgs") return plain(batch, settings);
			if (solver == "sor") return relaxed(batch, settings);
			if (solver == "nesterov" || (solver == "auto" && settings.tolerance == 0)) return accelerated(batch, settings);
			return exact(batch, problem, settings); // auto too: it begins with sweeps
		};
		const End end = run();
		batch.store();
		report.converged  = report.converged && (end.reached(settings) || end.residual() == 0);
		report.iterations = std::max(report.iterations, end.sweeps);
		report.work += double(end.sweeps) * double(batch.rows().size());
		whole.sums += end.sums;
	}
	report.residual = whole.residual();
	return report;
}

} // namespace rcr
