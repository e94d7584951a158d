#include "dem/validation/SceneQuery.hpp"

#include "dem/errors/deferredError.hpp"
#include "dem/loads/CellStress.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "dem/validation/PairExclusions.hpp"

namespace yade::validation {

namespace {

	// ---- engines

	template <class Kind>
	std::string missing(const SceneQuery& v, const char* name, const char* why)
	{
		if (v.indexOf<Kind>() >= 0) return {};
		return std::string("O.engines holds no ") + name
		        + (v.dead<Kind>() ? " that is not dead, " : ", ") + why;
	}

	template <class Kind> std::string twice(const SceneQuery& v, const char* name)
	{
		const auto count = std::count_if(v.engines.begin(), v.engines.end(), isLive<Kind>);
		if (count < 2) return {};
		return "O.engines holds " + std::to_string(count) + " of " + name
		        + "; expected one: remove the others.";
	}

	template <class Before, class After> std::string order(const SceneQuery& v, const char* text)
	{
		const int before = v.indexOf<Before>(), after = v.indexOf<After>();
		return before >= 0 && after >= 0 && before > after ? text : std::string();
	}

	// ---- functors

	std::string mixedLaws(const SceneQuery& v)
	{
		if (v.law != mixed) return {};
		const char* with = v.indexOf<RigidSolver>() >= 0 ? "the engine ContactDynamics"
		        : has<Law2_RcrGeom_CdPhys_SignoriniCoulomb>(v.loop->lawDispatcher->functors)
		        ? "Law2_RcrGeom_CdPhys_SignoriniCoulomb"
		        : "Ip2_FrictMat_FrictMat_CdPhys";
		return std::string("O.engines mix Law2_RcrGeom_FrictPhys_CundallStrack (springs) with ")
		        + with + ". Springs need Ip2_FrictMat_FrictMat_FrictPhys, this law and no "
		          "ContactDynamics; rigid contacts "
		          "Ip2_FrictMat_FrictMat_CdPhys, Law2_RcrGeom_CdPhys_SignoriniCoulomb and "
		          "ContactDynamics before the NewtonIntegrator.";
	}

	std::string noLaw(const SceneQuery& v)
	{
		if (!v.loop) return {};
		if (!v.hasNoSphere() && !has<Ig2_Planar_RcrGeom>(v.loop->geomDispatcher->functors)) return {};
		return "the InteractionLoop has no law for contacts of rcr; put "
		       "Law2_RcrGeom_CdPhys_SignoriniCoulomb (with ContactDynamics) or "
		       "Law2_RcrGeom_FrictPhys_CundallStrack into its third list.";
	}

	std::string rigidFunctors(const SceneQuery& v)
	{
		if (!v.loop) return {};
		bool                 swap;
		shared_ptr<Material> material = boost::make_shared<FrictMat>();
		if (!dynamic_cast<Ip2_FrictMat_FrictMat_CdPhys*>(
		            v.loop->physDispatcher->getFunctor2D(material, material, swap).get()))
			return "the InteractionLoop has no Ip2_FrictMat_FrictMat_CdPhys for two FrictMats; "
			       "put it into its second list.";
		shared_ptr<IGeom> geom = boost::make_shared<RcrGeom>();
		shared_ptr<IPhys> phys = boost::make_shared<CdPhys>();
		if (!dynamic_cast<Law2_RcrGeom_CdPhys_SignoriniCoulomb*>(
		            v.loop->lawDispatcher->getFunctor2D(geom, phys, swap).get()))
			return "the InteractionLoop has no Law2_RcrGeom_CdPhys_SignoriniCoulomb; put it "
			       "into its third list.";
		return {};
	}

	std::string springFunctors(const SceneQuery& v)
	{
		bool                 swap;
		shared_ptr<Material> material = boost::make_shared<FrictMat>();
		if (v.loop && !v.loop->physDispatcher->getFunctor2D(material, material, swap))
			return "the InteractionLoop has no Ip2_FrictMat_FrictMat_FrictPhys; put it into "
			       "its second list.";
		return {};
	}

	/// Ig2 functors whose contacts the laws of rcr cannot solve.
	std::string foreignGeometry(const SceneQuery& v)
	{
		if (!v.loop) return {};
		for (const auto& functor : v.loop->geomDispatcher->functors) {
			if (dynamic_cast<const Ig2_Planar_RcrGeom*>(functor.get())) continue;
			const std::string name = functor->getClassName(),
			                  pair = name.substr(0, name.rfind('_'));
			return name + " makes contacts that "
			        + (v.law == rigid ? "ContactDynamics" : "Law2_RcrGeom_FrictPhys_CundallStrack")
			        + " does not solve; take "
			        + (pair.rfind("Ig2_", 0) == 0 ? pair + "_RcrGeom" : "an Ig2_…_RcrGeom")
			        + " instead.";
		}
		return {};
	}

	/// A row of the table: a rule for scenes with one of these laws.
	struct Rule {
		int laws;
		std::string (*message)(const SceneQuery&);
	};

	// clang-format off
	const Rule rules[] = {
		{ neither, noLaw },
		{ mixed,   mixedLaws },
		{ any,     parallelEngines },
		{ any,     [](const SceneQuery& v) { return missing<NewtonIntegrator>(v, "NewtonIntegrator", "so nothing would move; append NewtonIntegrator(damping=0)."); } },
		{ any,     [](const SceneQuery& v) { return missing<InteractionLoop>(v, "InteractionLoop", "so there are no contacts; put one after the collider."); } },
		{ any,     [](const SceneQuery& v) { return missing<Collider>(v, "collider", "so no bodies would meet; put InsertionSortCollider([Bo1_Rcr_Aabb(), …]) before the InteractionLoop."); } },
		{ any,     [](const SceneQuery& v) { return missing<ForceResetter>(v, "ForceResetter", "so forces would add up from step to step; put ForceResetter() first."); } },
		{ rigid,   [](const SceneQuery& v) { return missingSolver(v.scene); } },
		{ any,     [](const SceneQuery& v) { return twice<NewtonIntegrator>(v, "NewtonIntegrator"); } },
		{ any,     [](const SceneQuery& v) { return twice<InteractionLoop>(v, "InteractionLoop"); } },
		{ any,     [](const SceneQuery& v) { return twice<RigidSolver>(v, "ContactDynamics"); } },
		{ any,     [](const SceneQuery& v) { return twice<Collider>(v, "the collider"); } },
		{ any,     [](const SceneQuery& v) { return twice<CellStress>(v, "CellStress"); } },
		{ any,     [](const SceneQuery& v) { return order<ForceResetter, InteractionLoop>(v, "the ForceResetter stands after the InteractionLoop, so it would take its forces away; put it first."); } },
		{ any,     [](const SceneQuery& v) { return order<Collider, InteractionLoop>(v, "the collider stands after the InteractionLoop; put it before."); } },
		{ rigid,   [](const SceneQuery& v) { return order<InteractionLoop, RigidSolver>(v, "ContactDynamics stands before the InteractionLoop, so it would solve the contacts of the step before; put it after."); } },
		{ rigid,   [](const SceneQuery& v) { return order<RigidSolver, NewtonIntegrator>(v, "ContactDynamics stands after the NewtonIntegrator, so its forces would come too late; put it before."); } },
		{ springs, [](const SceneQuery& v) { return order<InteractionLoop, NewtonIntegrator>(v, "the InteractionLoop stands after the NewtonIntegrator, so its forces would come too late; put it before."); } },
		{ any,     cellStress },
		{ rigid,   readsTooEarly },
		{ rigid,   recordersOfMembers },
		{ rigid,   loadAfterSolver },
		{ any,     loadWithoutEffect },
		{ any,     timeStep },
		{ any,     attributeErrors },
		{ rigid,   [](const SceneQuery& v) { return order<CellStress, RigidSolver>(v, "CellStress stands after ContactDynamics, which would not see its load; put it before."); } },
		{ any,     finiteMotion },
		{ any,     contactsWithoutBodies },
		{ rigid,   integrator },
		{ rigid,   timeStepper },
		{ springs, firstTimeStep },
		{ any,     wallsInCell },
		{ any,     bounds },
		{ rigid,   rigidFunctors },
		{ springs, springFunctors },
		{ any,     foreignGeometry },
		{ any,     materials },
		{ any,     velocityGradient },
		{ any,     smallCell },
		{ any,     invalidBodies },
		{ any,     unsupportedPairs },
		{ any,     verletDistance },
	};
	// clang-format on

	/// Objects on which the rules depend and that seldom change.
	Signature signature(const Scene& scene)
	{
		Signature  now { scene.bodies->size(), scene.isPeriodic, {} };
		const auto add    = [&](const auto& object) { now.objects.emplace_back(object); };
		const auto addAll = [&](const auto& functors) {
			for (const auto& f : functors)
				add(f);
		};
		now.objects.emplace_back(scene.weak_from_this());
		for (const auto& e : scene.engines) {
			add(e->dead ? shared_ptr<Engine>() : e);
			if (const auto* loop = dynamic_cast<const InteractionLoop*>(e.get()))
				addAll(loop->geomDispatcher->functors), addAll(loop->physDispatcher->functors),
				        addAll(loop->lawDispatcher->functors);
			if (const auto* collider = dynamic_cast<const Collider*>(e.get()))
				addAll(collider->boundDispatcher->functors);
			if (const auto* stepper = dynamic_cast<const TimeStepper*>(e.get()))
				add(stepper->active ? e : shared_ptr<Engine>());
		}
		return now;
	}

} // namespace

bool Signature::operator==(const Signature& other) const
{
	const auto same = [](const Object& a, const Object& b) {
		return !a.owner_before(b) && !b.owner_before(a);
	};
	const auto &a = objects, &b = other.objects;
	return bodies == other.bodies && periodic == other.periodic
	        && std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

std::string sceneError(const Scene& scene)
{
	const SceneQuery view(scene);
	for (const Rule& rule : rules) {
		const std::string message = rule.laws & view.law ? rule.message(view) : std::string();
		if (!message.empty()) return message;
	}
	return {};
}

std::string missingSolver(const Scene& scene)
{
	return missing<RigidSolver>(SceneQuery(scene), "ContactDynamics",
	        "so rigid contacts would carry nothing; put ContactDynamics() between the "
	        "InteractionLoop and the NewtonIntegrator.");
}

/// Returns false if the material has the number of a place in O.materials that it does not have.
static bool isListed(const Scene& scene, const Material& material)
{
	const auto& listed = scene.materials;
	return material.id < 0
	        || (material.id < int(listed.size()) && listed[material.id].get() == &material);
}

std::string prepareRun(Scene& scene)
{
	static PairExclusions last; // of the last run
	const SceneQuery      view(scene);
	const std::string     error = sceneError(scene);
	if (!error.empty()) return error;
	replaceSphereBounds(scene);
	static Signature seen;
	const Signature  now = signature(scene);
	if (view.law != neither && !(now == seen)) { // contacts and pairs of other functors
		if (const std::string foreign = foreignContacts(view); !foreign.empty()) return foreign;
		forgetFunctors(scene);
	}
	seen = now;
	if (scene.isPeriodic && !view.first<RigidSolver>()) suppressHomoDeform(scene, false);
	if (view.law != neither) last.restartIfChanged(scene, *view.first<Collider>());
	for (const auto& b : *scene.bodies) {
		if (!b) continue;
		// from texts of few digits; YADE does so after the step
		if (math::abs(b->state->ori.norm() - 1) > 1e-9) b->state->ori.normalize();
		// of an earlier scene: YADE could not load what it saves
		if (b->material && !isListed(scene, *b->material)) b->material->id = -1;
	}
	// lets a collider that YADE has cleared list all bodies, also after an erasure
	scene.bodies->checkedByCollider = false;
	return {};
}

/// Rejects a change of the time step or of the cell's motion between ContactDynamics and
/// NewtonIntegrator. The former divides impulses by the time step, the latter multiplies forces by
/// it. YADE advances the time by O.dt at the end of the step.
void Validator::checkLastStep(const SceneQuery& v)
{
	const bool recorded = isNextStep(v.scene);
	const Real change   = recorded ? math::abs(v.scene.time - nextTime_) : 0;
	nextStep_           = -1; // the next attempt is accepted
	if (recorded && v.scene.isPeriodic && v.scene.cell->prevVelGrad != gradient_)
		refuse("O.cell.velGrad changed after ContactDynamics in the last step, so images moved "
		       "otherwise than solved; change it by an engine before ContactDynamics or after "
		       "NewtonIntegrator.");
	if (change <= 1e-6 * v.scene.dt + 1e-12 * v.scene.time) return;
	const int  integrator = v.indexOf<NewtonIntegrator>();
	const bool cellMoves  = v.scene.isPeriodic && gradient_ != Matrix3r::Zero();
	// an engine after the integrator may change the time step, unless YADE then moves the cell by it
	if (cellMoves
	        || (integrator > v.indexOf<RigidSolver>() + 1
	                && integrator == int(v.scene.engines.size()) - 1))
		refuse("O.dt changed after ContactDynamics in the last step, so NewtonIntegrator applied "
		       "wrong forces, or the cell moved by another step than its grains; change O.dt by an "
		       "engine before ContactDynamics.");
}

bool Validator::hasNewScene(const Scene& scene)
{
	const bool other = hasScene_ && scene_.lock().get() != &scene;
	scene_ = scene.weak_from_this(), hasScene_ = true;
	return other;
}

void Validator::recordNextStep(const Scene& scene)
{
	nextStep_ = scene.iter + 1, nextTime_ = scene.time + scene.dt;
	if (scene.isPeriodic) gradient_ = plane::nextGradient(*scene.cell);
}

Engines Validator::validate(const Scene& scene)
{
	const SceneQuery view(scene);
	checkLastStep(view);
	if (const std::string error = takeSceneError(scene); !error.empty()) refuse(error);
	// may change without a change of objects
	for (const auto rule : { timeStep, finiteMotion, integrator, velocityGradient, smallCell })
		if (const std::string error = rule(view); !error.empty()) refuse(error);
	const Signature now = signature(scene);
	if (now == seen_) return engines_;
	std::string message = sceneError(scene);
	if (message.empty()) message = foreignContacts(view);
	if (!message.empty()) refuse(message);
	replaceSphereBounds(scene);
	forgetFunctors(scene);
	engines_ = { view.first<NewtonIntegrator>(), view.first<InteractionLoop>(),
		view.first<Collider>(), view.first<CellStress>() };
	seen_    = signature(scene);
	return engines_;
}

bool mayCollide(const Scene& scene, Collider& collider, Body::id_t id1, Body::id_t id2)
{
	const Body *one = (*scene.bodies)[id1].get(), *two = (*scene.bodies)[id2].get();
	if (!one->isBounded() || !two->isBounded()) return false;
#ifdef YADE_MPI
	return collider.mayCollide(one, two, scene.subdomain);
#else
	return collider.mayCollide(one, two);
#endif
}

bool acceptContact(const Interaction& i, const Scene& scene)
{
	const SceneQuery view(scene);
	const auto       reject = [&](const std::string& error) { // in a parallel loop
		if (view.indexOf<RigidSolver>() < 0) deferError(error);
		else
			leaveSceneError(scene, error);
		return false;
	};
	std::string error = materialError(scene, i.getId1(), i.getId2());
	if (!error.empty()) return reject(error);
	// YADE checks masks only when boxes begin to overlap; here a rigid contact forms
	Collider* collider = view.law == rigid ? view.first<Collider>() : nullptr;
	if (collider && !mayCollide(scene, *collider, i.getId1(), i.getId2())) return false;
	thread_local Signature passed; // of the last valid scene
	const Signature        now = signature(scene);
	if (now == passed) return true;
	error = sceneError(scene);
	if (!error.empty()) return reject(error);
	passed = now;
	return true;
}

} // namespace yade::validation
