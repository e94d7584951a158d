#include "delassus/delassus_problem.hpp"

#include "problem/refuse.hpp"
#include "problem/residual.hpp"

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

/// Columns ascend and stay in range; each row has its diagonal; the pattern is symmetric.
static void checkPattern(const DelassusProblem& problem)
{
	const std::int32_t count = std::int32_t(problem.freeVelocity.size());
	for (std::int32_t k = 0; k < count; ++k) {
		bool diagonal = false;
		for (std::int32_t e = problem.rowStart[k], last = -1; e < problem.rowStart[k + 1];
		        ++e) {
			const std::int32_t j = problem.column[e];
			if (j <= last || j >= count)
				refuse("row ", k, " of W: columns are out of range or order");
			last     = j;
			diagonal = diagonal || j == k;
		}
		if (!diagonal) refuse("row ", k, " of W has no diagonal block");
	}
	const auto columns = problem.column.begin();
	for (std::int32_t k = 0; k < count; ++k)
		for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
			const std::int32_t j = problem.column[e];
			if (!std::binary_search(
			            columns + problem.rowStart[j], columns + problem.rowStart[j + 1], k))
				refuse("block (", k, ", ", j, ") of W has no mirror image");
		}
}

static void checkNumbers(const DelassusProblem& problem)
{
	for (std::size_t k = 0; k < problem.freeVelocity.size(); ++k) {
		for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e) {
			const std::int32_t   j = problem.column[e];
			const DelassusBlock& w = problem.block[e];
			if (!finite(w.nn, w.nt, w.tn, w.tt))
				refuse("block (", k, ", ", j, ") of W is not finite");
			if (j == std::int32_t(k) && (w.nn < 0 || w.tt < 0))
				refuse("W has a negative diagonal at contact ", k,
				        "; expected a positive semi-definite matrix");
		}
		const Impulse q = problem.freeVelocity[k], p = problem.impulse[k];
		if (!finite(q.n, q.t, p.n, p.t))
			refuse("contact ", k, ": q or the impulse is not finite");
		if (!(problem.friction[k] >= 0 && std::isfinite(problem.friction[k])))
			refuse("contact ", k, ": µ = ", problem.friction[k], "; expected µ ≥ 0");
		if (problem.friction[k] > maxFriction)
			refuse("contact ", k, ": µ = ", problem.friction[k],
			        " is too large to measure errors; expected µ ≤ ", maxFriction);
	}
}

void checkProblem(const DelassusProblem& problem)
{
	checkSizes(problem);
	checkPattern(problem);
	checkNumbers(problem);
}

} // namespace rcr
