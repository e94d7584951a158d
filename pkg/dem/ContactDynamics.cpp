#include "ContactDynamics.hpp"

#include <chrono>

#include <core/Omega.hpp>
#include <core/Scene.hpp>

#include "../kernel/step/adapt_biases.hpp"
#include "../kernel/step/follow_stretch.hpp"
#include "../kernel/step/missed_contacts.hpp"
#include "../kernel/step/position_correction.hpp"
#include "../kernel/step/restitution.hpp"
#include "../kernel/sweep/sweep_solver.hpp"
#include "flatSteps.hpp"
#include "plane.hpp"
#include "refuseLater.hpp"
#include "scatter.hpp"

namespace yade {

YADE_PLUGIN((ContactDynamics));
CREATE_LOGGER(ContactDynamics);

namespace {
	constexpr int mostPasses     = 10; // missed contacts and large displacements settle in two or three
	constexpr int squeezedEffort = 10; // sweeps, over maxIterations, while grains are squeezed: a jam must not be a lack of sweeps
}

void ContactDynamics::action()
{
	try {
		act();
	} catch (const std::exception& error) {
		rememberError(error.what());
		throw;
	}
}

void ContactDynamics::act()
{
	const std::string told = wrong();
	if (!told.empty()) gate::refuse(told);
	const gate::Engines engines = gate_.pass(*scene);
	if (overdamped && scene->isPeriodic) scene->cell->homoDeform = 0; // rest is the cell's own motion, see gather
	if (!flat_) flat_ = std::make_shared<FlatSteps>();
	scene->forces.sync();
	stepThread_ = std::this_thread::get_id();
	workspace_.team().run(solverThreads(), [&] { step(engines); });
}

void ContactDynamics::step(const gate::Engines& engines)
{
	rcr::ThreadTeam& team  = workspace_.team();
	step_.overdamped = overdamped;
	if (!follows()) meanStretchRate = stretchChange = Vector2r::Zero();
	setRest();
	timed("gather", [&] { gather(*scene, engines, team, sources_, step_); });
	try {
		std::vector<rcr::Twist> loads;
		bool                    goesOn = false;
		do {
			solveAll(engines);
			timed("arrays", [&] {
				loads = loadsOf(step_);
				observeStep(loads);
				goesOn = arrays && flat_->goOn(*scene, engines, team, sources_, loads, step_);
				const std::lock_guard<std::mutex> lock(reading_);
				enginesReason_ = flat_->why(), fastSteps_ = flat_->count();
			});
		} while (goesOn);
		timed("publish", [&] { flat_->publish(*scene, team, sources_, step_); });
		timed("scatter", [&] {
			measureUnbalance();
			if (scene->trackEnergy) bookEnergy(loads, engines.integrator->gravity);
			scatter(*scene, team, loads, sources_, step_);
		});
	} catch (...) {
		flat_->publish(*scene, team, sources_, step_);
		throw;
	}
	timed("gather", [&] { keepInteractionsTogether(*scene, sources_); });
}

/// Solves the contacts of the step, once more for each pass that shows the solved problem to be incomplete.
void ContactDynamics::solveAll(const gate::Engines& engines)
{
	iterations = 0;
	work_      = 0;
	overlap_   = 0;
	if (follows()) timed("biasUpdate", [&] { rcr::relieve(step_, { double(stretchChange[0]), double(stretchChange[1]) }); });
	const rcr::Drive    drive = rcr::driveOf(step_, workspace_.team());
	std::vector<double> detected; // biases before the first pass that changes them; empty where they must not be restored
	rcr::Settings       how = settings(drive);
	how.roundingVelocity            = step_.rounding(workspace_.team());
	if (squeeze().active()) how.maxIterations *= squeezedEffort;
	if (overlapAtStart() > rcr::MissedSteps::harmless) how.yieldImpulse = std::numeric_limits<double>::infinity(); // yields by proof alone
	const double yieldCompliance = how.yieldCompliance;
	bool         last       = false;
	for (int pass = 1;; ++pass) {
		how.yieldCompliance = rcr::restIsAllowed(step_, drive) ? 0 : yieldCompliance;
		solve(how);
		last |= pass == mostPasses;
		const PassOutcome outcome = last ? reviewLastPass(engines) : reviewPass(engines, pass, drive, detected);
		if (outcome == PassOutcome::accepted) break;
		how           = settingsOfFurtherPass(how);
		how.sameProblem = outcome != PassOutcome::missedContact;
		how.yieldedBefore   = yielded && (outcome == PassOutcome::missedContact || outcome == PassOutcome::biasChanged);
		last          = outcome == PassOutcome::biasesRestored;
	}
	if (follows()) timed("biasUpdate", [&] { followStretch(); });
	refuseUnlessFinite();
	refuseFarStretch();
	if (overlap_ > rcr::MissedSteps::deep) converged = false;
	watch();
	timed("correct", [&] { correctPositions(step_, double(correction), workspace_); });
}

ContactDynamics::PassOutcome ContactDynamics::reviewPass(
        const gate::Engines& engines, int pass, const rcr::Drive& drive, std::vector<double>& detected)
{
	bool missed = false;
	timed("missedContacts", [&] { missed = takeInMissedContacts(engines); });
	if (missed) {
		detected.clear();
		return PassOutcome::missedContact;
	}
	if (overdamped) return PassOutcome::accepted;
	PassOutcome outcome = PassOutcome::accepted;
	timed("biasUpdate", [&] {
		const bool nextIsLast = pass == mostPasses - 1;
		if (yielded && rcr::lowerBounces(step_, nextIsLast)) {
			outcome = PassOutcome::bounceLowered;
			return;
		}
		if (yielded && rcr::goBack(step_, detected)) { // only changed biases can ask for the impossible
			outcome = PassOutcome::biasesRestored;
			return;
		}
		if (pass == 1 && drive.speed == 0) detected = rcr::biases(step_.problem);
		if (adaptBiases(pass)) outcome = PassOutcome::biasChanged;
	});
	return outcome;
}

/// No pass follows: a contact that is still missed makes the step a missed one.
ContactDynamics::PassOutcome ContactDynamics::reviewLastPass(const gate::Engines& engines)
{
	timed("missedContacts", [&] {
		if (findMissedContacts(engines)) converged = false;
	});
	return PassOutcome::accepted;
}

void ContactDynamics::setRest()
{
	step_.rest = plane::flowOf(flow);
	step_.rest.gradient[0][0] += double(meanStretchRate[0]);
	step_.rest.gradient[1][1] += double(meanStretchRate[1]);
}

/// What the bodies have stretched by belongs to the flow that they start the next step from.
void ContactDynamics::followStretch()
{
	const rcr::Vec2 change = rcr::commonStretch(step_);
	stretchChange          = Vector2r(change.x, change.y);
	meanStretchRate += stretchChange;
	setRest();
}

template <class Work> void ContactDynamics::timed(const char* what, Work work)
{
	const auto start = std::chrono::steady_clock::now();
	work();
	const double                      seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	const std::lock_guard<std::mutex> lock(reading_);
	seconds_[what] += seconds;
}

/// Colours and order have a key of their own among the times.
void ContactDynamics::solve(const rcr::Settings& how)
{
	const double layout = workspace_.layoutSeconds();
	warmStart_          = step_.problem.impulse;
	const rcr::Vec2 stretch = step_.problem.stretch;
	rcr::prepareRecovery(step_, double(correction), workspace_.team());
	timed("solve", [&] { report(rcr::solve(step_.problem, solverName(), how, workspace_)); });
	const double laidOut = workspace_.layoutSeconds() - layout;
	{
		const std::lock_guard<std::mutex> lock(reading_);
		seconds_["layout"] += laidOut;
		seconds_["solve"] -= laidOut;
	}
	timed("scatter", [&] {
		step_.moveMembers();
		step_.stretchCell(stretch);
		step_.keepForces(workspace_.team());
	});
}

void ContactDynamics::report(const rcr::Report& report)
{
	iterations += report.iterations;
	work_ += report.work;
	residual      = report.residual;
	kinematicError     = report.kinematicError;
	converged     = report.converged;
	yielded       = report.yielded;
	contactPoints = int(step_.problem.points.size());
}

int ContactDynamics::solverThreads() const { return threads > 0 ? threads : omp_get_max_threads(); }

bool ContactDynamics::findMissedContacts(const gate::Engines& engines)
{
	return rcr::findMissedContacts(step_, [&](int id1, int id2) { return mayMeet(*scene, engines, id1, id2); });
}

bool ContactDynamics::takeInMissedContacts(const gate::Engines& engines)
{
	if (!findMissedContacts(engines)) return false;
	for (rcr::GrownContact& grown : step_.grown) {
		if (grown.known) continue;
		const ContactLaw law = contactLaw(*scene, *engines.loop, grown.body1, grown.body2);
		grown.friction = law.friction, grown.restitution = law.restitution;
	}
	rcr::takeInGrownContacts(step_);
	return true;
}

bool ContactDynamics::adaptBiases(int pass) { return rcr::adaptBiases(step_, pass <= mostPasses / 2, pass == mostPasses - 1, overlap_, workspace_.team()); }

} // namespace yade
