// The stages of a step; ContactDynamics.hpp lists them, pkg/README.md explains their terms.
#include "dem/engine/ContactDynamics.hpp"

#include "dem/loads/CellStress.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/ArraySteps.hpp"
#include "dem/transfer/newContacts.hpp"
#include "dem/transfer/scatter.hpp"
#include "dem/errors/deferredError.hpp"
#include "kernel/step/mean_stretch.hpp"

namespace yade {

CREATE_LOGGER(ContactDynamics);

void ContactDynamics::action()
{
	try {
		const std::string invalid = attributeError();
		if (!invalid.empty()) errors::refuse(invalid);
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
		drivenBodies.clear(), drivenVelocities.clear();
		observer_.restart();
	}
	rcr::ThreadTeam& team  = workspace_.team();
	step_.overdamped = overdamped;
	if (!tracksStretch()) meanStretchRate = stretchChange = Vector2r::Zero();
	setStartFlow(); // gather replaces it in a periodic cell
	timed("gather", [&] {
		gather(*scene, engines, team, { drivenBodies, drivenVelocities }, handles_, step_);
		neighbors_.expire();
		addUnlistedContacts(*scene, engines, *this, team, handles_, neighbors_, step_);
	});
	try {
		std::vector<rcr::PlanarVector> impulses;
		bool                           advanced = false;
		do {
			solveStep(engines);
			impulses = contactImpulses(step_);
			observer_.record(stepOutcome(), get<&ContactDynamics::observe>(), observeEvery,
			        impulses, step_, handles_);
			if (scene->trackEnergy)
				energy.enterPrevious(*scene->energy, step_, impulses,
				        plane::toPlane(engines.integrator->gravity));
			else
				energy = {};
			advanced = timed("arrays", [&] {
				return arrays
				        && arraySteps_->advance(*scene, engines, team, handles_, impulses,
				                neighbors_, step_);
			});
			set<&ContactDynamics::model_>(StepModel { workspace_.summary(), result_.work, meanStretchRate,
			        arraySteps_->count(),
			        arrays ? arraySteps_->enginesReason() : "ContactDynamics.arrays = False" });
		} while (advanced);
		storeDrives();
		// YADE's objects get the state at the beginning of the last step; scatter adds the contact
		// forces of that step
		timed("writeBack", [&] { arraySteps_->writeBack(*scene, team, handles_, step_); });
		timed("scatter", [&] {
			const UnbalancedForce unbalanced = unbalancedForceOf(step_);
			unbalancedForce = unbalanced.mean, largestUnbalancedForce = unbalanced.largest;
			scatter(*scene, team, impulses, handles_, step_);
		});
	} catch (...) {
		arraySteps_->writeBack(*scene, team, handles_, step_);
		throw;
	}
}

void ContactDynamics::storeDrives()
{
	drivenBodies.clear(), drivenVelocities.clear();
	for (const auto& [body, v] : rcr::drivesOf(step_)) {
		drivenBodies.push_back(body);
		drivenVelocities.push_back({ v.x, v.y, v.rotation });
	}
}

void ContactDynamics::solveStep(const validation::Engines& engines)
{
	if (tracksStretch())
		timed("meanStretch", [&] {
			rcr::removeDragImpulses(step_, { double(stretchChange[0]), double(stretchChange[1]) });
		});
	rcr::StepSettings settings = stepSettings();
	settings.squeezed          = monitor.jam.active();
	result_ = rcr::solveStep(step_, settings, stepHost(engines), neighbors_, workspace_);
	iterations    = result_.iterations;
	residual      = result_.residual;
	errorEstimate = result_.errorEstimate;
	converged     = result_.converged;
	yielded       = result_.yielded;
	if (result_.largeDisplacements && !result_.converged) checkEnergy(step_, scene->iter);
	monitorStep();
	if (tracksStretch()) timed("meanStretch", [&] { updateMeanStretch(); });
}

rcr::StepHost ContactDynamics::stepHost(const validation::Engines& engines)
{
	rcr::StepHost host { newContacts(*scene, engines) };
	host.check = [this] {
		contactPoints = int(step_.problem.points.size()); // also of a step that fails
		checkFinite(step_, scene->iter);
		checkCellStress(step_, scene->iter);
	};
	host.clock = [this](const char* stage, double seconds) { times_.add(stage, seconds); };
	return host;
}

} // namespace yade
