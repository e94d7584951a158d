// Estimate of the true error: the distance of an iterate to the solution that it approaches.
//
// The residual is blind to errors that vary slowly from contact to contact. A smooth force error e
// in a row of N bodies leaves a residual of about 5 e/N². Two estimates see such errors. Each is a
// relative error of velocities and forces [-], and the smaller one counts.
//
//   bound    4 D² ‖d‖_w/‖p‖_w in slim islands, with the diameter D of the contact graph; 100 D² if
//            their pairs have two points, since such a row bends, and in other islands
//   change   from the change Δp of the impulses since half as many sweeps, from D sweeps on:
//            impulses must have crossed the island
//
// The change in packings with friction, after k sweeps of n points, is a fit to measured errors:
//
//   e = 0.5 (n/k · ‖Δp‖_w/‖p‖_w)^0.4
//
// Elsewhere, the residual r of the iterate and of the earlier one gives the rate s of convergence:
//
//   s = √(r/r_half),  p* − p ≈ Δp s/(1 − s),  e = √(‖d‖_w ‖p* − p‖_w)/‖v − v_free‖_M
//
// e follows from the bound of Cauchy and Schwarz, (p − p*)ᵀ W (p − p*) ≤ Σ w_nn d · (p − p*). In
// slim islands e is at least ‖p* − p‖_w/‖p‖_w. While s > 0.9, the change tells nothing.
//
// Norms: ‖p‖_w² = Σ w_nn |p|², ‖v‖_M² = Σ m |v|² + I ω². d is the error of a point in the contact
// laws (residual.hpp). ‖v − v_free‖_M counts as at least a hundredth of ‖p‖_w, since bodies at rest
// between walls have no scale of their own.
//
// Heavy bodies hide the errors of light ones in these norms, and slow the solvers. Let M be the
// largest mass of a body times the mean w_nn. Both estimates of a slim island are multiplied by M.
// In other islands, bodies and contacts whose mass is over 30 times the mean do not enter the norms.
// Without friction, the estimates are multiplied by √(M/30), at least 1, where walls do not count.
//
// Neither velocities of other bodies nor contacts without a force are scales, so a common motion
// or an idle neighbour changes nothing. docs/measurements/index.md compares the estimate with true
// errors.
#pragma once

#include "problem/contact_problem.hpp"
#include "problem/measures.hpp"

namespace rcr {

constexpr double unknownError = std::numeric_limits<double>::infinity();

/// Goal of dense packings with friction over `accuracy`: solutions differ by 10 to 30 % [-].
constexpr double solutionSpread = 30;

/// The contact graph of an island: its free bodies, joined by pairs.
struct IslandShape {
	int  points = 0, bodies = 0;
	int  pairs      = 0;     // of two free bodies
	int  diameter   = 0;     // longest of the shortest paths from a far body, in pairs
	bool frictional = false; // µ > 0 or µ_r > 0 at a point
	bool rolls      = false; // a point has rolling resistance
	bool bends      = false; // a pair of free bodies has two points

	/// Rows, columns and trees: a factorisation has hardly any fill-in, and exact iterations cost
	/// less than sweeps, whose number grows with the diameter.
	bool slim() const
	{
		constexpr int tiny = 16, bodiesPerLoop = 20;
		// bodies that touch in the plane form at most three pairs a body: of more, many lie apart
		const int widest = pairs > 3 * bodies ? 6 : 4;
		return bodies <= tiny || bodies <= widest * diameter
		        || bodiesPerLoop * (pairs + 1 - bodies) <= bodies;
	}
	/// Estimated error at which the island counts as solved [-].
	double goal(double accuracy) const { return slim() ? accuracy : spreadGoal(accuracy); }
	/// The same for any island.
	double spreadGoal(double accuracy) const
	{
		return frictional ? solutionSpread * accuracy : accuracy;
	}
	/// Error over residual of the smoothest error, at most [-].
	double condition() const
	{
		const double perPair2 = !slim() ? 10 : bends ? 100 : 4;
		return perPair2 * diameter * diameter;
	}
	/// The same for sweeps: in packings, friction can hide errors ten times as large.
	double conditionOfSweeps() const { return (slim() ? 1 : 10) * condition(); }
};

/// Change of an iterate, and the sums at the iterate, in the norms above.
struct IterateChange {
	double impulseChange = 0; // ‖Δp‖_w² [J/m]
	double impulse       = 0; // ‖p‖_w² [J/m]
	double error         = 0; // ‖d‖_w² [J/m]
	double velocity      = 0; // ‖v − v_free‖_M² [J/m]
};

/// Largest mass of the free bodies, and of those that are no walls [kg].
struct LargestMass {
	double any = 0, noWall = 0;

	void include(const InverseMass& m)
	{
		any = std::max(any, m.mass());
		if (m.translatesFreely()) noWall = std::max(noWall, m.mass());
	}
};

/// Which contacts count in the norms, and how much their errors may be hidden.
struct NormWeights {
	double leastResponse = 0; // of contacts in the norms [1/kg]
	double factor        = 1; // of the estimates [-]

	NormWeights() = default;
	/// From the mean w_nn of the points [1/kg] and the free bodies.
	NormWeights(const IslandShape&, double meanResponse, const LargestMass&);
};

/// The estimate from the change. `residualRatio`: r/r_half.
double errorFromChange(
        const IterateChange&, double residualRatio, int sweeps, const IslandShape&);

/// Condition of the island: `shape.condition()` times the factor of its norm weights [-].
double conditionOf(const ContactProblem&, const IslandShape&);

/// Distance of the impulses of the problem from `before`, in forces and velocities [-]: the larger
/// of ‖Δp‖_w/‖p‖_w and ‖Δv‖_M/‖v − v_free‖_M.
double distanceFrom(const ContactProblem&, const Impulses& before, const IslandShape&);

} // namespace rcr
