#include "delassus/delassus_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace rcr {

namespace {

	template <class... Parts> [[noreturn]] void refuse(const Parts&... parts)
	{
		std::ostringstream text;
		(text << ... << parts);
		throw std::invalid_argument(text.str());
	}

	[[noreturn]] void refuseMirror(std::int32_t row, std::int32_t column) { refuse("block (", row, ", ", column, ") of W has no mirror image"); }

	constexpr double infinity = std::numeric_limits<double>::infinity();

	bool finite(double a) { return std::abs(a) < infinity; }
	bool finite(Impulse p) { return finite(p.n) & finite(p.t); }
	bool finite(const DelassusBlock& w) { return finite(w.nn) & finite(w.nt) & finite(w.tn) & finite(w.tt); }

	void checkSizes(const DelassusProblem& problem)
	{
		const std::size_t count = problem.free.size(), entries = problem.column.size();
		if (problem.friction.size() != count || problem.impulse.size() != count || problem.rowStart.size() != count + 1)
			refuse("q, µ, impulse and rows of W stand for ", count, ", ", problem.friction.size(), ", ", problem.impulse.size(), " and ",
			       std::ptrdiff_t(problem.rowStart.size()) - 1, " contacts; wanted one number");
		if (problem.block.size() != entries || problem.rowStart.front() != 0 || std::size_t(problem.rowStart.back()) != entries
		    || !std::is_sorted(problem.rowStart.begin(), problem.rowStart.end()))
			refuse("the rows of W do not fit its ", entries, " blocks");
	}

	/// Blocks of a row above the diagonal meet their mirror images in the order of the rows below.
	void checkPattern(const DelassusProblem& problem)
	{
		const std::int32_t        count = std::int32_t(problem.free.size());
		std::vector<std::int32_t> next(count); // of a row: the block above the diagonal whose mirror image comes next
		for (std::int32_t k = 0; k < count; ++k) {
			bool diagonal = false;
			for (std::int32_t e = problem.rowStart[k], last = -1; e < problem.rowStart[k + 1]; ++e) {
				const std::int32_t j = problem.column[e];
				if (j <= last || j >= count) refuse("row ", k, " of W: columns are out of range or order");
				last = j;
				if (j == k) {
					diagonal = true;
					next[k]  = e + 1;
					if (problem.block[e].nn < 0 || problem.block[e].tt < 0)
						refuse("W has a negative diagonal at contact ", k, "; wanted a positive semi-definite matrix");
				}
				if (j >= k) continue;
				const std::int32_t mirror = next[j] < problem.rowStart[j + 1] ? problem.column[next[j]] : count;
				if (mirror != k) mirror < k ? refuseMirror(j, mirror) : refuseMirror(k, j);
				++next[j];
			}
			if (!diagonal) refuse("row ", k, " of W has no diagonal block");
		}
		for (std::int32_t k = 0; k < count; ++k)
			if (next[k] < problem.rowStart[k + 1]) refuseMirror(k, problem.column[next[k]]);
	}

	/// All numbers at once: rows are looked at only to say which one it is.
	void checkNumbers(const DelassusProblem& problem)
	{
		std::int64_t wrong = 0;
		for (const DelassusBlock& w : problem.block)
			wrong += !finite(w);
		for (const Impulse& q : problem.free)
			wrong += !finite(q);
		for (const Impulse& p : problem.impulse)
			wrong += !finite(p);
		for (const double friction : problem.friction)
			wrong += !(friction >= 0 && friction < infinity);
		if (!wrong) return;
		for (std::size_t k = 0; k < problem.free.size(); ++k) {
			for (std::int32_t e = problem.rowStart[k]; e < problem.rowStart[k + 1]; ++e)
				if (!finite(problem.block[e])) refuse("block (", k, ", ", problem.column[e], ") of W holds a number that is not finite");
			if (!finite(problem.free[k]) || !finite(problem.impulse[k])) refuse("contact ", k, ": q or the impulse is not finite");
			if (!(problem.friction[k] >= 0 && problem.friction[k] < infinity)) refuse("contact ", k, ": µ = ", problem.friction[k], "; wanted µ ≥ 0");
		}
	}

} // namespace

void checkProblem(const DelassusProblem& problem)
{
	checkSizes(problem);
	checkPattern(problem);
	checkNumbers(problem);
}

DelassusProblem partOf(const DelassusProblem& problem, const std::vector<std::int32_t>& rows)
{
	DelassusProblem           part;
	std::vector<std::int32_t> place(problem.free.size());
	for (std::size_t i = 0; i < rows.size(); ++i)
		place[rows[i]] = std::int32_t(i);
	part.rowStart.push_back(0);
	for (const std::int32_t row : rows) {
		for (std::int32_t e = problem.rowStart[row]; e < problem.rowStart[row + 1]; ++e) {
			part.column.push_back(place[problem.column[e]]);
			part.block.push_back(problem.block[e]);
		}
		part.rowStart.push_back(std::int32_t(part.column.size()));
		part.free.push_back(problem.free[row]);
		part.friction.push_back(problem.friction[row]);
		part.impulse.push_back(problem.impulse[row]);
	}
	part.velocity.resize(rows.size());
	return part;
}

} // namespace rcr
