// Rules of validation on engines: order of loads, attributes, time step, bounds of the collider.
#include "dem/validation/SceneQuery.hpp"
#include "dem/loads/WallStress.hpp"

namespace yade::validation {

// YADE's strideActive is private. An explicit template instantiation may name private members.
bool isStriding(const InsertionSortCollider&);
template <bool InsertionSortCollider::*member> struct Striding {
	friend bool isStriding(const InsertionSortCollider& collider) { return collider.*member; }
};
template struct Striding<&InsertionSortCollider::strideActive>;

bool isKinematic(const Engine& engine)
{
	return dynamic_cast<const KinematicEngine*>(&engine)
	        || dynamic_cast<const CombinedKinematicEngine*>(&engine);
}

/// Returns true if the engine sets positions or velocities.
static bool moves(const Engine& engine)
{
	return isKinematic(engine) || dynamic_cast<const StepDisplacer*>(&engine);
}

/// Returns true if the engine adds forces, which last until the ForceResetter.
static bool pushes(const Engine& engine)
{
	// NewtonIntegrator derives from FieldApplier, and a TimeAverager reads forces
	if (moves(engine) || dynamic_cast<const NewtonIntegrator*>(&engine)
	        || engine.getClassName() == "TimeAverager")
		return false;
	return dynamic_cast<const PartialEngine*>(&engine) || dynamic_cast<const FieldApplier*>(&engine)
	        || dynamic_cast<const WallStress*>(&engine)
	        || engine.getClassName() == "VESupportEngine"; // a BoundaryController in YADE
}

std::string loadAfterSolver(const SceneQuery& v)
{
	const int solver = v.indexOf<RigidSolver>(), integrator = v.indexOf<NewtonIntegrator>();
	for (int k = solver + 1; solver >= 0 && k < integrator; ++k)
		if (!v.engines[k]->dead && (pushes(*v.engines[k]) || moves(*v.engines[k])))
			return "the " + v.engines[k]->getClassName()
			        + " stands after ContactDynamics, which would not see its load; put it before.";
	return {};
}

/// Rejects load engines after the integrator or before the ForceResetter, whose forces would
/// have no effect.
std::string loadWithoutEffect(const SceneQuery& v)
{
	const int resetter = v.indexOf<ForceResetter>(), integrator = v.indexOf<NewtonIntegrator>();
	for (int k = 0; k < int(v.engines.size()); ++k) {
		if (v.engines[k]->dead || !pushes(*v.engines[k]) || (resetter < k && k < integrator))
			continue;
		return "the " + v.engines[k]->getClassName() + " stands "
		        + (k < resetter ? "before the ForceResetter" : "after the NewtonIntegrator")
		        + ", so its forces would be taken away before they move anything; put it "
		          "between the two.";
	}
	return {};
}

std::vector<const Engine*> livePartsOf(const Engine& engine)
{
	if (engine.dead) return {};
	std::vector<const Engine*> parts { &engine };
	if (const auto* all = dynamic_cast<const CombinedKinematicEngine*>(&engine))
		for (const auto& one : all->comb)
			if (!one->dead) parts.push_back(one.get());
	return parts;
}

/// Controllers and recorders read forces that are complete after ContactDynamics. A controller also
/// moves bodies, which ContactDynamics must know, so it must stand after the integrator.
std::string readsTooEarly(const SceneQuery& v)
{
	const int solver = v.indexOf<RigidSolver>(), integrator = v.indexOf<NewtonIntegrator>();
	for (int k = 0; k < integrator; ++k) {
		const std::string name  = v.engines[k]->getClassName();
		const auto        error = [&](const char* before, const char* does) {
			return "the " + name + " stands before " + before + ", so it would " + does
			        + " forces without those of contacts; put it after the NewtonIntegrator.";
		};
		if (v.engines[k]->dead) continue;
		for (const Engine* part : livePartsOf(*v.engines[k]))
			if ((dynamic_cast<const BoundaryController*>(part) && !pushes(*part))
			        || part->getClassName() == "ServoPIDController")
				return error("the NewtonIntegrator", "read");
		static const std::set<std::string> recorders { "ForceRecorder", "TorqueRecorder",
			"TimeAverager", "VTKRecorder" };
		if (k < solver && recorders.count(name)) return error("ContactDynamics", "record");
	}
	return {};
}

/// Contact forces act on the clumps of members.
std::string recordersOfMembers(const SceneQuery& v)
{
	for (const auto& engine : v.engines) {
		const auto* force  = dynamic_cast<const ForceRecorder*>(engine.get());
		const auto* torque = dynamic_cast<const TorqueRecorder*>(engine.get());
		if (engine->dead || !(force || torque)) continue;
		const std::vector<int>& ids = force ? force->ids : torque->ids;
		for (Body::id_t id : ids)
			if (v.scene.bodies->exists(id) && (*v.scene.bodies)[id]->isClumpMember()
			        && !std::count(ids.begin(), ids.end(), (*v.scene.bodies)[id]->clumpId))
				return "the " + engine->getClassName() + " records " + bodyNames({ id })
				        + ", a clump member without forces of its own: contact forces act on its "
				          "clump. Record "
				        + bodyNames({ (*v.scene.bodies)[id]->clumpId }) + '.';
	}
	return {};
}

std::string parallelEngines(const SceneQuery& v)
{
	for (const auto& engine : v.engines)
		if (!engine->dead && engine->getClassName() == "ParallelEngine")
			return "O.engines holds a ParallelEngine, whose engines cannot be checked; put them into "
			       "O.engines one by one.";
	return {};
}

std::string attributeErrors(const SceneQuery& v)
{
	for (const auto& engine : v.engines) {
		if (engine->dead) continue;
		std::string message;
		if (const auto* stress = dynamic_cast<const WallStress*>(engine.get()))
			message = stress->attributeError(v.scene);
		if (const auto* solver = dynamic_cast<const RigidSolver*>(engine.get()))
			message = solver->attributeError();
		if (!message.empty()) return message;
	}
	return {};
}

std::string timeStep(const SceneQuery& v)
{
	const Real dt = v.scene.dt;
	if (dt > 0 && math::isfinite(dt)) return {};
	return "O.dt = " + text(dt) + "; expected a finite time step > 0.";
}

std::string finiteMotion(const SceneQuery& v)
{
	const NewtonIntegrator* newton = v.first<NewtonIntegrator>();
	if (!newton) return {};
	if (!math::isfinite(newton->gravity.sum()))
		return "NewtonIntegrator.gravity = " + coordinates(newton->gravity)
		        + "; expected finite accelerations, as gravity=(0, -9.81, 0).";
	if (math::isfinite(newton->damping)) return {};
	return "NewtonIntegrator.damping = " + text(newton->damping)
	        + "; expected a finite share, 0 for none.";
}

/// O.bodies.clear() leaves the contacts, which new bodies then do not know.
std::string contactsWithoutBodies(const SceneQuery& v)
{
	const BodyContainer& bodies = *v.scene.bodies;
	std::size_t          known  = 0; // by both bodies
	for (const auto& b : *v.scene.bodies)
		if (b) known += b->intrs.size();
	if (known == 2 * v.scene.interactions->size()) return {};
	const auto isKnown = [&](Body::id_t id, Body::id_t other) {
		return bodies.exists(id) && bodies[id]->intrs.count(other);
	};
	for (const auto& i : *v.scene.interactions)
		if (!isKnown(i->getId1(), i->getId2()) || !isKnown(i->getId2(), i->getId1()))
			return "the contact of bodies #" + std::to_string(i->getId1()) + " and #"
			        + std::to_string(i->getId2())
			        + " is left from removed bodies; call O.interactions.clear() after "
			          "O.bodies.clear().";
	return {};
}

std::string integrator(const SceneQuery& v)
{
	const NewtonIntegrator* newton = v.first<NewtonIntegrator>();
	if (!newton) return {};
	if (newton->damping != 0)
		return "NewtonIntegrator.damping = " + text(newton->damping)
		        + " would damp the contact forces; set damping=0 (a restitution below 1 "
		          "dissipates energy).";
	if (newton->densityScaling)
		return "NewtonIntegrator.densityScaling is on; switch it off, the time step is not "
		       "bound by a stiffness.";
	if (newton->gravity[2] == 0) return {};
	return "NewtonIntegrator.gravity = " + coordinates(newton->gravity)
	        + " pulls out of the plane of the grains, which is x and y; set gravity=(0, -9.81, 0).";
}

std::string timeStepper(const SceneQuery& v)
{
	const TimeStepper* stepper = v.first<TimeStepper>();
	if (!stepper || !stepper->active) return {};
	return "the " + stepper->getClassName()
	        + " would set O.dt from stiffnesses, which rigid contacts do not have; remove it "
	          "and set O.dt by the accuracy you need.";
}

/// Without contacts, YADE's stepper uses the wave speed of spheres, and 1 s without spheres.
std::string firstTimeStep(const SceneQuery& v)
{
	const auto* stepper = v.first<GlobalStiffnessTimeStepper>();
	if (!stepper || !stepper->active || stepper->defaultDt > 0 || !v.hasNoSphere()) return {};
	return "GlobalStiffnessTimeStepper.defaultDt = " + text(stepper->defaultDt)
	        + " would set O.dt = 1 s while no grains touch; set defaultDt = 0.5 * "
	          "rcr.critical_time_step().";
}

std::string bounds(const SceneQuery& v)
{
	const Collider* collider = v.first<Collider>();
	if (!collider) return {};
	for (const auto& b : *v.scene.bodies) {
		if (!b || !b->shape || b->isClump() || !b->isBounded()
		        || collider->boundDispatcher->getFunctor1D(b->shape))
			continue;
		const std::string shape = b->shape->getClassName();
		return "the collider has no Bo1_" + shape + "_Aabb, so " + bodyNames({ b->getId() })
		        + " would meet nothing; put Bo1_" + shape + "_Aabb() into its list.";
	}
	return {};
}

std::string verletDistance(const SceneQuery& v)
{
	const auto* collider = v.first<InsertionSortCollider>();
	if (!collider || !isStriding(*collider) || collider->verletDist != 0) return {};
	return "the InsertionSortCollider has verletDist = 0 after steps with another one, for which "
	       "YADE ends the process; put a new InsertionSortCollider into O.engines.";
}

void replaceSphereBounds(const Scene& scene)
{
	if (SceneQuery(scene).law != rigid) return;
	for (const auto& e : scene.engines) {
		Collider* collider = dynamic_cast<Collider*>(e.get());
		if (!collider) continue;
		auto       functors = collider->boundDispatcher->functors;
		const auto sphere   = std::find_if(functors.begin(), functors.end(),
                    [](const auto& f) { return f->getClassName() == "Bo1_Sphere_Aabb"; });
		if (sphere == functors.end()) continue;
		auto disc = boost::make_shared<Bo1_Disc_Aabb>();
		disc->aabbEnlargeFactor = static_cast<const Bo1_Sphere_Aabb&>(**sphere).aabbEnlargeFactor;
		*sphere = disc;
		collider->boundDispatcher->functors_set(functors);
		for (const auto& b : *scene.bodies)
			if (b && b->shape && dynamic_cast<const Sphere*>(b->shape.get()))
				b->shape->boundFunctor = nullptr; // a cache
		return;
	}
}

} // namespace yade::validation
