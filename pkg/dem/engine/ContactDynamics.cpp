// The stages of a step; ContactDynamics.hpp lists them, pkg/README.md explains their terms.
#include "dem/engine/ContactDynamics.hpp"

#include "dem/engine/CellStress.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/ArraySteps.hpp"
#include "dem/transfer/newContacts.hpp"
#include "dem/transfer/scatter.hpp"
#include "dem/validation/deferredError.hpp"
#include "kernel/correction/large_displacements.hpp"
#include "kernel/correction/position_correction.hpp"
#include "kernel/correction/separation.hpp"
#include "kernel/step/adapt_biases.hpp"
#include "kernel/step/mean_stretch.hpp"
#include "kernel/step/restitution.hpp"

namespace yade {

CREATE_LOGGER(ContactDynamics);

constexpr int mostPasses = 10; // most steps need one to three

void ContactDynamics::action()
{
	try {
		const std::string invalid = attributeError();
		if (!invalid.empty()) validation::refuse(invalid);
		const validation::Engines engines = validator_.validate(*scene);
		if (scene->isPeriodic) suppressHomoDeform(*scene, overdamped);
		if (!arraySteps_) arraySteps_ = std::make_shared<ArraySteps>();
		scene->forces.sync();
		stepThread_ = std::this_thread::get_id();
		workspace_.team().run(solverThreads(), [&] { runSteps(engines); });
		validator_.recordNextStep(*scene);
	} catch (const std::exception& error) {
		rememberError(error.what());
		throw;
	}
}

/// Solves this step, and up to 100 following steps in arrays until one requires YADE's objects.
void ContactDynamics::runSteps(const validation::Engines& engines)
{
	if (validator_.hasNewScene(*scene)) {
		energy = {};
		set<&ContactDynamics::monitor>(StepMonitor {});
		meanStretchRate = stretchChange = Vector2r::Zero();
		observer_.restart();
	}
	rcr::ThreadTeam& team  = workspace_.team();
	step_.overdamped = overdamped;
	if (!tracksStretch()) meanStretchRate = stretchChange = Vector2r::Zero();
	setStartFlow(); // gather replaces it in a periodic cell
	timed("gather", [&] {
		gather(*scene, engines, team, handles_, step_);
		addUnlistedContacts(*scene, engines, *this, handles_, step_);
	});
	try {
		std::vector<rcr::PlanarVector> impulses;
		bool                           advanced = false;
		do {
			solveStep(engines);
			impulses = contactImpulses(step_);
			observer_.record(stepOutcome(), get<&ContactDynamics::observe>(), observeEvery,
			        impulses, step_, handles_);
			advanced = timed("arrays", [&] {
				return arrays
				        && arraySteps_->advance(*scene, engines, team, handles_, impulses, step_);
			});
			set<&ContactDynamics::model_>(StepModel { workspace_.summary(), work_, meanStretchRate,
			        arraySteps_->count(),
			        arrays ? arraySteps_->enginesReason() : "ContactDynamics.arrays = False" });
		} while (advanced);
		// YADE's objects get the state at the beginning of the last step; scatter adds the contact
		// forces of that step
		timed("writeBack", [&] { arraySteps_->writeBack(*scene, team, handles_, step_); });
		timed("scatter", [&] {
			const UnbalancedForce unbalanced = unbalancedForceOf(step_);
			unbalancedForce = unbalanced.mean, largestUnbalancedForce = unbalanced.largest;
			if (scene->trackEnergy)
				energy.enterPrevious(*scene->energy, step_, impulses,
				        plane::toPlane(engines.integrator->gravity));
			else
				energy = {};
			scatter(*scene, team, impulses, handles_, step_);
		});
	} catch (...) {
		arraySteps_->writeBack(*scene, team, handles_, step_);
		throw;
	}
	// interactions near in space lie near in memory; results do not depend on their order
	timed("sort", [&] { sortInteractions(*scene, handles_); });
}

/// Solves the contact problem of the step in at most `mostPasses` passes. A further pass follows if
/// bodies meet whose contact was not part of the solve (a late contact). It also follows if a bias
/// is wrong: after a large displacement, or if restitution adds energy. The last pass is not
/// reviewed: if it leaves out a late contact, the step has not converged. Settings of each pass
/// derive from `base`.
void ContactDynamics::solveStep(const validation::Engines& engines)
{
	iterations          = 0;
	work_               = 0;
	largeDisplacements_ = false;
	if (tracksStretch())
		timed("meanStretch", [&] {
			rcr::removeDragImpulses(step_, { double(stretchChange[0]), double(stretchChange[1]) });
		});
	// speed of the drive, compliance of yielding contacts, impulse beyond which contacts yield
	rcr::YieldBounds bounds = rcr::yieldBoundsOf(step_, workspace_.team());
	rcr::Settings    base = settingsOfFirstPass(bounds), passSettings = base;
	for (int pass = 1;; ++pass) {
		passSettings.solutionExists = rcr::restIsAdmissible(step_, bounds.driveSpeed);
		solvePass(passSettings);
		if (pass == mostPasses) {
			if (timed("lateContacts", [&] {
				    return rcr::findLateContacts(step_, contactFilter(*scene, engines));
			    }))
				converged = false;
			if (!overdamped) largeDisplacements_ |= rcr::anyLargeDisplacement(step_);
			break;
		}
		const PassOutcome outcome = reviewPass(engines, pass);
		if (outcome == PassOutcome::consistent) break;
		// The drive is measured at contact points. The added contact may be the first one of a
		// driven body.
		if (outcome == PassOutcome::contactsAdded && bounds.driveSpeed == 0) {
			bounds = rcr::yieldBoundsOf(step_, workspace_.team());
			if (bounds.driveSpeed > 0) base = settingsOfFirstPass(bounds);
		}
		passSettings = settingsOfNextPass(base, outcome);
	}
	if (rcr::spansHalfCell(step_)) converged = false;
	checkFinite(step_, scene->iter);
	checkCellStress(step_, scene->iter);
	timed("correct", [&] {
		rcr::computeCorrection(step_, double(correction), workspace_);
		if (!largeDisplacements_) return;
		const double overlap = rcr::separate(step_, correction > 0, contactFilter(*scene, engines));
		if (overlap > rcr::JamDetector::jamOverlap) converged = false;
		if (!converged) checkEnergy(step_, scene->iter);
	});
	monitorStep();
	if (tracksStretch()) timed("meanStretch", [&] { updateMeanStretch(); });
}

void ContactDynamics::solvePass(const rcr::Settings& passSettings)
{
	const double    layoutBefore  = workspace_.layoutSeconds();
	const rcr::Vec2 stretchBefore = step_.problem.stretchRate;
	warmStart_                    = step_.problem.impulse;
	// biases by which yielding contacts remove their overlaps
	rcr::setRecoveryBias(step_, double(correction), workspace_.team());
	const std::string name   = get<&ContactDynamics::solver>();
	const rcr::Report report = timed(
	        "solve", [&] { return rcr::solve(step_.problem, name, passSettings, workspace_); });
	const double layout = workspace_.layoutSeconds() - layoutBefore;
	// the solve contains the layout, which has a time of its own
	times_.add("layout", layout), times_.add("solve", -layout);
	iterations = iterations + report.iterations;
	work_ += report.work;
	residual       = report.residual;
	errorEstimate  = report.errorEstimate;
	converged      = report.converged;
	yielded        = report.yielded;
	contactPoints  = int(step_.problem.points.size());
	timed("forces", [&] {
		step_.setMemberVelocities();
		step_.updateGradient(stretchBefore);
		step_.computePointForces(workspace_.team());
	});
}

ContactDynamics::PassOutcome ContactDynamics::reviewPass(
        const validation::Engines& engines, int pass)
{
	const bool nextIsLast = pass == mostPasses - 1;
	if (timed("lateContacts", [&] { return addLateContacts(*scene, engines, step_); })) {
		// The last pass is not reviewed, so biases that separate bodies could add energy.
		// Overdamped steps need such biases to remove overlaps.
		if (nextIsLast && !overdamped) rcr::removeNegativeBiases(step_);
		return PassOutcome::contactsAdded;
	}
	if (overdamped) return PassOutcome::consistent;
	return timed("biasUpdate", [&] {
		// else passes could release and load a contact in turn
		const bool mayRelease = pass <= mostPasses / 2;
		bool changed = rcr::adaptBiases(step_, mayRelease, nextIsLast, double(tolerance),
		        largeDisplacements_, workspace_.team());
		if (yielded) changed |= rcr::lowerRestitutionOfYielded(step_, nextIsLast);
		return changed ? PassOutcome::biasChanged : PassOutcome::consistent;
	});
}

} // namespace yade
