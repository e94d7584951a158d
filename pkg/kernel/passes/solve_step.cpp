#include "passes/solve_step.hpp"

#include "correction/position_correction.hpp"
#include "correction/separation.hpp"
#include "detection/large_displacements.hpp"
#include "parallel/timed.hpp"
#include "passes/adapt_biases.hpp"
#include "solve/solve.hpp"
#include "step/restitution.hpp"
#include "watch/jam_detector.hpp"

namespace rcr {

constexpr int    mostPasses       = 10;   // most steps need one to three
constexpr int    sweepsOfNextPass = 10;   // least number of sweeps of a further pass
// maxIterations over this, from 10 to 100, are those that a further pass may take in any case
constexpr int    shareAllowed     = 10;
constexpr int    mostAllowed      = 100;
constexpr double fineTolerance    = 1e-6; // below it, a further pass may use all iterations
constexpr int    squeezedEffort   = 10;   // factor of maxIterations while grains are squeezed

namespace {

	/// Outcome of a pass. All but `consistent` require a further pass.
	enum class Outcome { consistent, contactsAdded, biasChanged };

	/// Arguments of solveStep, and its result.
	struct Call {
		Step&               step;
		const StepSettings& settings;
		const StepHost&     host;
		Search              search;
		Workspace&          workspace;
		StepResult          result = {};

		/// Runs `work` and reports its wall time.
		template <class Work> auto timed(const char* stage, Work work) const
		{
			return rcr::timed([&](double seconds) { host.clock(stage, seconds); }, work);
		}
	};

} // namespace

void addFoundContacts(Step& step, const NewContacts& host)
{
	for (FoundContact& c : step.found)
		if (!c.known) c.law = host.law(c.body1, c.body2);
	addFoundContacts(step);
}

Settings passSettings(const StepSettings& settings, const YieldBounds& bounds)
{
	Settings s = settings.pass;
	s.yielding = bounds.yielding;
	s.undriven = YieldBounds().yielding;
	s.yielding.compliance *= settings.yieldCompliance;
	s.undriven.compliance *= settings.yieldCompliance;
	s.yielding.yieldImpulse /= settings.yieldCompliance; // infinite for 0
	return s;
}

static Settings firstPass(const Call& call, const YieldBounds& bounds)
{
	Settings s         = passSettings(call.settings, bounds);
	s.roundingVelocity = call.step.roundingVelocity(call.workspace.team());
	// overdamped steps leave no overlap
	if (!call.step.overdamped) s.creepTolerance = creepTolerance(call.step);
	if (call.settings.squeezed) s.maxIterations *= squeezedEffort;
	return s;
}

/// A further pass corrects a few contacts. The residual over all contacts would not show them, so
/// the pass runs at least ten sweeps. All passes share the iterations of the step, except for fine
/// tolerances.
static Settings nextPass(const Call& call, Settings s)
{
	if (s.tolerance >= fineTolerance)
		s.maxIterations = std::max(s.maxIterations - call.result.iterations,
		        std::clamp(s.maxIterations / shareAllowed, sweepsOfNextPass, mostAllowed));
	s.minIterations = std::min(sweepsOfNextPass, s.maxIterations);
	return s;
}

static void solvePass(Call& call, const Settings& settings)
{
	auto& [step, given, host, search, workspace, result] = call;
	const double layoutBefore                            = workspace.layoutSeconds();
	const Vec2   stretchBefore                           = step.problem.stretchRate;
	step.warmStart                                       = step.problem.impulse;
	step.warmRolling                                     = step.problem.rollingImpulse;
	// biases by which yielding contacts remove their overlaps
	setRecoveryBias(step, given.correction, workspace.team());
	const Report report = call.timed("solve", [&] {
		return rcr::solve(step.problem, given.solver, settings, workspace);
	});
	const double layout = workspace.layoutSeconds() - layoutBefore;
	// the solve contains the layout, which has a time of its own
	host.clock("layout", layout), host.clock("solve", -layout);
	result.iterations += report.iterations;
	result.work += report.work;
	result.residual      = report.residual;
	result.errorEstimate = report.errorEstimate;
	result.converged     = report.converged;
	result.yielded       = report.yielded;
	call.timed("forces", [&] {
		step.setMemberVelocities();
		step.updateGradient(stretchBefore);
		step.computePointForces(workspace.team());
	});
}

static Outcome review(Call& call, int pass)
{
	auto& [step, settings, host, search, workspace, result] = call;
	const bool nextIsLast                                   = pass == mostPasses - 1;
	const bool late                                         = call.timed("lateContacts", [&] {
                if (!findLateContacts(step, search)) return false;
                addFoundContacts(step, host);
                return true;
        });
	if (late) {
		// The last pass is not reviewed, so biases that separate bodies could add energy.
		// Overdamped steps need such biases to remove overlaps.
		if (nextIsLast && !step.overdamped) removeNegativeBiases(step);
		return Outcome::contactsAdded;
	}
	if (step.overdamped) return Outcome::consistent;
	return call.timed("biasUpdate", [&] {
		// else passes could release and load a contact in turn
		const bool mayRelease = pass <= mostPasses / 2;
		bool       changed    = adaptBiases(
		                 step, mayRelease, nextIsLast, settings.pass.tolerance,
		                 result.largeDisplacements, workspace.team());
		if (result.yielded) changed |= lowerRestitutionOfYielded(step, nextIsLast);
		return changed ? Outcome::biasChanged : Outcome::consistent;
	});
}

static void displace(Call& call)
{
	auto& [step, settings, host, search, workspace, result] = call;
	computeCorrection(step, settings.correction, workspace);
	if (!result.largeDisplacements) return;
	const double overlap = separate(step, settings.correction > 0, search);
	if (overlap > JamDetector::jamOverlap) result.converged = false;
}

StepResult solveStep(Step& step, const StepSettings& settings, const StepHost& host,
        Neighbors& neighbors, Workspace& workspace)
{
	Call call { step, settings, host, { neighbors, workspace.team(), host.allows }, workspace };
	// speed of the drive, compliance of yielding contacts, impulse beyond which contacts yield
	YieldBounds bounds = yieldBoundsOf(step, workspace.team());
	Settings    base = firstPass(call, bounds), now = base;
	for (int pass = 1;; ++pass) {
		now.solutionExists = restIsAdmissible(step, bounds.driveSpeed);
		solvePass(call, now);
		if (pass == mostPasses) {
			if (call.timed("lateContacts", [&] {
				    return findLateContacts(step, call.search);
			    }))
				call.result.converged = false;
			if (!step.overdamped)
				call.result.largeDisplacements |= anyLargeDisplacement(step);
			break;
		}
		const Outcome outcome = review(call, pass);
		if (outcome == Outcome::consistent) break;
		// The drive is measured at contact points. The added contact may be the first one of a
		// driven body.
		if (outcome == Outcome::contactsAdded && bounds.driveSpeed == 0) {
			bounds = yieldBoundsOf(step, workspace.team());
			if (bounds.driveSpeed > 0) base = firstPass(call, bounds);
		}
		now = nextPass(call, base);
	}
	if (spansHalfCell(step)) call.result.converged = false;
	host.check();
	call.timed("correct", [&] { displace(call); });
	return std::move(call.result);
}

} // namespace rcr
