// Solvers of problems that are given by W and q: Gauss–Seidel over rows of blocks, plain, over-relaxed or with momentum,
// and a proximal point iteration with Newton steps on the pieces of the contact law.
//
// The proximal step about p_ref is that of proximal_problem.hpp with the impulses themselves as unknowns, d = p − p_ref:
//   π = p_ref − k (u_ref + W d),   k = ρ/w_nn;   on given pieces p = S π, so (1 + S k W) d = S (p_ref − k u_ref) − p_ref
// with S = 0 apart, 1 where it sticks, (n, t) → (n, sµ n) where it slides. Newton goes from the pieces of one π to those of
// the next and has arrived when they are the same. Where it does not arrive, ρ falls and sweeps bring other pieces.
#include <algorithm>
#include <cmath>
#include <limits>

#include "block_lu.hpp"
#include "coulomb.hpp"
#include "delassus_problem.hpp"
#include "momentum.hpp"
#include "residual.hpp"

namespace rcr {

namespace {

	constexpr double relaxation = 1.3;  // as for problems with bodies
	constexpr double handover   = 1e-6; // residual at which sweeps hand over to the proximal point iteration
	constexpr int    maxSweeps  = 3000; // … or their number
	constexpr int    stall      = 300;  // … or sweeps without a new low
	constexpr int    between    = 200;  // sweeps where Newton has not arrived: they cost less than one of its steps
	constexpr int    maxNewton  = 6;    // steps; beyond, it cycles

	Impulse operator+(Impulse a, Impulse b) { return { a.n + b.n, a.t + b.t }; }
	Impulse operator-(Impulse a, Impulse b) { return { a.n - b.n, a.t - b.t }; }
	Impulse operator*(double s, Impulse a) { return { s * a.n, s * a.t }; }
	Impulse operator*(const DelassusBlock& w, Impulse a) { return { w.nn * a.n + w.nt * a.t, w.tn * a.n + w.tt * a.t }; }
	double  square(Impulse a) { return a.n * a.n + a.t * a.t; }

	using Impulses = std::vector<Impulse>;

	/// The problem with what every solver needs at hand.
	class Points {
	public:
		explicit Points(DelassusProblem& given) : problem(given), diagonal_(given.free.size())
		{
			for (std::size_t k = 0; k < size(); ++k) {
				const auto           first = problem.column.begin() + problem.rowStart[k];
				const auto           entry = std::lower_bound(first, problem.column.begin() + problem.rowStart[k + 1], std::int32_t(k));
				const DelassusBlock& w     = problem.block[entry - problem.column.begin()];
				diagonal_[k]               = { w.nn, 0.5 * (w.nt + w.tn), w.tt };
				if (!carries(k)) problem.impulse[k] = {};
			}
		}

		std::size_t     size() const { return problem.free.size(); }
		const Delassus& diagonal(std::size_t k) const { return diagonal_[k]; }
		bool            carries(std::size_t k) const { return diagonal_[k].nn > 0; } // not between two prescribed bodies

		/// (W x)_k
		Impulse product(std::size_t k, const Impulses& x) const
		{
			Impulse sum;
			for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e)
				sum = sum + problem.block[e] * x[problem.column[e]];
			return sum;
		}

		/// Velocities for the present impulses, and their residual.
		double measure()
		{
			double error2 = 0, impulse2 = 0, stopping2 = 0;
			problem.velocity.resize(size());
			for (std::size_t k = 0; k < size(); ++k) {
				const Impulse u = problem.velocity[k] = problem.free[k] + product(k, problem.impulse);
				if (!carries(k)) continue;
				const Impulse p = problem.impulse[k];
				const double  w = diagonal_[k].nn, friction = problem.friction[k];
				const Impulse q = projectCone({ p.n - (u.n + friction * std::abs(u.t)) / w, p.t - u.t / w }, friction);
				error2 += square(p - q);
				impulse2 += square(p);
				stopping2 += u.n * u.n / (w * w);
			}
			return relativeError(error2, impulse2, stopping2);
		}

		/// Solves every point once; change(k, solution) is what becomes of its impulse.
		template <class Change> void sweep(Change change)
		{
			for (std::size_t k = 0; k < size(); ++k) {
				if (!carries(k)) continue;
				const Delassus& w = diagonal_[k];
				const Impulse   p = problem.impulse[k], u = problem.free[k] + product(k, problem.impulse);
				problem.impulse[k] = change(k, solveCoulomb(w, u.n - w.nn * p.n - w.nt * p.t, u.t - w.nt * p.n - w.tt * p.t, problem.friction[k]));
			}
		}

		DelassusProblem& problem;

	private:
		std::vector<Delassus> diagonal_;
	};

	/// Calls iterate() until the settings stop it.
	template <class Iterate> Report sweeps(Points& points, const Settings& settings, Iterate iterate)
	{
		Report report;
		double lowest   = std::numeric_limits<double>::infinity();
		int    lowestAt = 0;
		for (;; ++report.iterations) {
			const bool last = report.iterations >= settings.maxIterations;
			if (last || (report.iterations >= settings.minIterations && report.iterations % settings.checkInterval == 0)) {
				report.residual  = points.measure();
				report.converged = report.reached(settings) || report.residual == 0;
				if (report.residual < lowest) {
					lowest   = report.residual;
					lowestAt = report.iterations;
				}
				if (last || report.reached(settings) || (settings.stallSweeps > 0 && report.iterations - lowestAt >= settings.stallSweeps)) return report;
			}
			iterate();
		}
	}

	Report plain(Points& points, const Settings& settings)
	{
		return sweeps(points, settings, [&] { points.sweep([](std::size_t, Impulse solution) { return solution; }); });
	}

	Report relaxed(Points& points, const Settings& settings)
	{
		const DelassusProblem& problem = points.problem;
		return sweeps(points, settings, [&] {
			points.sweep([&](std::size_t k, Impulse solution) {
				return projectCone(problem.impulse[k] + relaxation * (solution - problem.impulse[k]), problem.friction[k]);
			});
		});
	}

	Report accelerated(Points& points, const Settings& settings)
	{
		Impulses& impulse = points.problem.impulse;
		Impulses  old     = impulse;
		Momentum  momentum;
		return sweeps(points, settings, [&] {
			const double beta = momentum.beta();
			for (std::size_t k = 0; k < points.size(); ++k) {
				const Impulse p = impulse[k];
				impulse[k]      = p + beta * (p - old[k]);
				old[k]          = p;
			}
			double error = 0;
			points.sweep([&](std::size_t k, Impulse solution) {
				error += square(solution - impulse[k]);
				return solution;
			});
			momentum.advance(error);
		});
	}

	/// S of one point, in the symbols above.
	struct Piece {
		double n = 0, t = 0, side = 0; // p_n = n π_n,  p_t = t π_t + side π_n

		bool operator==(const Piece& o) const { return n == o.n && t == o.t && side == o.side; }
		Impulse operator*(Impulse p) const { return { n * p.n, t * p.t + side * p.n }; }
	};

	Piece pieceAt(Impulse predictor, double friction)
	{
		if (predictor.n <= 0) return {};
		if (std::abs(predictor.t) <= friction * predictor.n) return { 1, 1, 0 };
		return { 1, 0, std::copysign(friction, predictor.t) };
	}

	class ProximalSteps {
	public:
		explicit ProximalSteps(Points& points)
		        : points_(points), matrix_(std::int32_t(points.size()), findPairs(points.problem, pairOf_)), pieces_(points.size()), change_(points.size())
		{
		}

		/// From p_ref = the impulses of the problem to the solution of the step; counts Newton's steps. False: not arrived.
		bool step(double rho, int& iterations, int maxIterations)
		{
			DelassusProblem& problem = points_.problem;
			const Impulses   reference = problem.impulse;
			std::fill(change_.begin(), change_.end(), Impulse {});
			updatePieces(rho, reference);
			for (int i = 0; i < maxNewton && iterations < maxIterations; ++i) {
				++iterations;
				if (!solvePieces(rho, reference)) return false;
				if (!updatePieces(rho, reference)) {
					for (std::size_t k = 0; k < points_.size(); ++k)
						problem.impulse[k] = pieces_[k] * predictor(k, rho, reference);
					return true;
				}
			}
			return false;
		}

	private:
		/// Pairs of points with a block of W, each once, and the pair of every block off the diagonal.
		static std::vector<BlockLu::Pair> findPairs(const DelassusProblem& problem, std::vector<std::int32_t>& pairOf)
		{
			std::vector<BlockLu::Pair> pairs;
			std::vector<std::int32_t>  next(problem.free.size()); // a row above: its next pair
			pairOf.resize(problem.column.size());
			for (std::int32_t k = 0; k < std::int32_t(problem.free.size()); ++k) {
				next[k] = std::int32_t(pairs.size());
				for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
					const std::int32_t j = problem.column[e];
					if (j < k) pairOf[e] = next[j]++;
					if (j <= k) continue;
					pairOf[e] = std::int32_t(pairs.size());
					pairs.emplace_back(k, j);
				}
			}
			return pairs;
		}

		double stiffness(std::size_t k, double rho) const { return points_.carries(k) ? rho / points_.diagonal(k).nn : 0; }

		Impulse predictor(std::size_t k, double rho, const Impulses& reference) const
		{
			return reference[k] - stiffness(k, rho) * (points_.problem.velocity[k] + points_.product(k, change_));
		}

		/// True if a piece is another than before.
		bool updatePieces(double rho, const Impulses& reference)
		{
			bool changed = false;
			for (std::size_t k = 0; k < points_.size(); ++k) {
				const Piece piece = points_.carries(k) ? pieceAt(predictor(k, rho, reference), points_.problem.friction[k]) : Piece {};
				changed |= !(piece == pieces_[k]);
				pieces_[k] = piece;
			}
			return changed;
		}

		/// d on the present pieces.
		bool solvePieces(double rho, const Impulses& reference)
		{
			const DelassusProblem&   problem = points_.problem;
			std::vector<BlockVector> right(points_.size());
			matrix_.setIdentity();
			for (std::size_t k = 0; k < points_.size(); ++k) {
				const Piece& piece = pieces_[k];
				const double stiff = stiffness(k, rho);
				for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
					const std::size_t    j     = problem.column[e];
					Block&               place = j == k ? matrix_.diagonal(std::int32_t(k)) : matrix_.pairBlock(pairOf_[e], j < k);
					const DelassusBlock& w     = problem.block[e];
					const Impulse        n = piece * Impulse { stiff * w.nn, stiff * w.tn }, t = piece * Impulse { stiff * w.nt, stiff * w.tt };
					place.entry[0][0] += n.n;
					place.entry[0][1] += n.t;
					place.entry[1][0] += t.n;
					place.entry[1][1] += t.t;
				}
				const Impulse b   = piece * (reference[k] - stiff * problem.velocity[k]) - reference[k];
				right[k].entry[0] = b.n;
				right[k].entry[1] = b.t;
			}
			if (!matrix_.factor()) return false;
			matrix_.solve(right);
			for (std::size_t k = 0; k < points_.size(); ++k)
				change_[k] = { right[k].entry[0], right[k].entry[1] };
			return true;
		}

		Points&                   points_;
		std::vector<std::int32_t> pairOf_; // a block of W
		BlockLu                   matrix_; // 1 + S k W; the third row of each block is idle
		std::vector<Piece>        pieces_;
		Impulses                  change_; // d
	};

	/// ρ over the steps: stiffer while Newton arrives, much softer where it does not.
	class Stiffness {
	public:
		double rho() const { return rho_; }
		void   arrived() { rho_ = std::min(1e5, 4 * rho_); } // beyond 1e5 rounding is seen
		void   failed() { rho_ = std::max(1e-3, rho_ / 16); }

	private:
		double rho_ = 100;
	};

	/// Accelerated sweeps, then proximal steps; the best iterate stays.
	Report exact(Points& points, const Settings& settings)
	{
		const auto sweep = [&](double tolerance, int count) {
			Settings few      = settings;
			few.tolerance     = std::max(settings.tolerance, tolerance);
			few.maxIterations = std::min(settings.maxIterations, count);
			few.stallSweeps   = stall;
			return accelerated(points, few);
		};
		Report        report = sweep(handover, maxSweeps);
		ProximalSteps proximal(points);
		Stiffness     stiffness;
		Impulses      best = points.problem.impulse;
		while (report.residual > settings.tolerance && report.iterations < settings.maxIterations) {
			if (proximal.step(stiffness.rho(), report.iterations, settings.maxIterations)) stiffness.arrived();
			else {
				stiffness.failed();
				report.iterations += sweep(0, std::min(between, settings.maxIterations - report.iterations)).iterations;
			}
			const double residual = points.measure();
			if (!(residual < report.residual)) continue;
			report.residual = residual;
			best            = points.problem.impulse;
		}
		points.problem.impulse = best;
		report.residual        = points.measure();
		report.converged       = report.reached(settings) || report.residual == 0;
		return report;
	}

} // namespace

Report solve(DelassusProblem& problem, const std::string& solver, const Settings& settings)
{
	checkSettings(solver, settings);
	checkProblem(problem);
	Points points(problem);
	if (solver == "nlgs") return plain(points, settings);
	if (solver == "sor") return relaxed(points, settings);
	if (solver == "nesterov" || (solver == "auto" && settings.tolerance == 0)) return accelerated(points, settings);
	return exact(points, settings); // auto too: it begins with sweeps
}

} // namespace rcr
