#include "dem/transfer/ArraySteps.hpp"

#include <set>

#include "dem/contacts/prefetch.hpp"
#include "dem/loads/WallStress.hpp"
#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/newContacts.hpp"
#include "dem/transfer/scatter.hpp"

namespace yade {

constexpr long stepsBetweenUpdates = 100; // a fixed number, so that a run repeats its bits

/// Returns true if a PeriodicEngine will act at this iteration and time. Its own isActivated()
/// would count the call.
static bool isDue(const PeriodicEngine& engine, long iter, Real time)
{
	// the first call starts the counts of the engine
	if (engine.nDone == 0) return engine.firstIterRun <= 0 || engine.firstIterRun == iter;
	if (iter < engine.iterLast) return true;
	if (engine.nDo >= 0 && engine.nDone >= engine.nDo) return false;
	return (engine.virtPeriod > 0 && time - engine.virtLast >= engine.virtPeriod)
	        || (engine.realPeriod > 0
	                && PeriodicEngine::getClock() - engine.realLast >= engine.realPeriod)
	        || (engine.iterPeriod > 0 && iter - engine.iterLast >= engine.iterPeriod);
}

/// Adds the bodies that an engine loads or drives; returns false if it may read other bodies.
static bool addLoadedBodies(const Engine& engine, std::vector<Body::id_t>& ids)
{
	if (const auto* stress = dynamic_cast<const WallStress*>(&engine)) {
		ids.insert(ids.end(), { stress->wall, stress->start, stress->end });
		return true;
	}
	static const std::set<std::string> forces { "ForceEngine",
		"InterpolatingDirectedForceEngine", "RadialForceEngine", "TorqueEngine", "DragEngine",
		"LinearDragEngine" };
	if (!validation::isKinematic(engine) && !forces.count(engine.getClassName()))
		return false;
	const auto& more = static_cast<const PartialEngine&>(engine).ids;
	ids.insert(ids.end(), more.begin(), more.end());
	return true;
}

static bool isCoreEngine(const Engine& engine)
{
	return dynamic_cast<const ForceResetter*>(&engine) || dynamic_cast<const Collider*>(&engine)
	        || dynamic_cast<const InteractionLoop*>(&engine)
	        || dynamic_cast<const RigidSolver*>(&engine)
	        || dynamic_cast<const NewtonIntegrator*>(&engine);
}

/// Finds a force on a body of the arrays, for example from a PyRunner. Arrays apply contact
/// forces and gravity only.
static std::string strayForceReason(Scene& scene, const std::vector<char>& isSynced)
{
	for (std::size_t id = 0; id < isSynced.size(); ++id)
		if (!isSynced[id] && (*scene.bodies)[id]
		        && (scene.forces.getForce(Body::id_t(id)) != Vector3r::Zero()
		                || scene.forces.getTorque(Body::id_t(id)) != Vector3r::Zero()))
			return "a force on body #" + std::to_string(id);
	return {};
}

/// Advances iteration and time, and updates O.speed and the counts of O.timingEnabled, as
/// Scene::moveToNextTimeStep does.
static void advanceTime(Scene& scene)
{
	const auto now      = boost::posix_time::microsec_clock::local_time();
	const long duration = (now - scene.prevTime).total_microseconds();
	scene.prevTime      = now;
	scene.SpeedElements(scene.iter % Scene::nSpeedIter, 0) = 1e6 / std::max(duration, 1L);
	scene.speed                                            = scene.SpeedElements.mean();
	if (TimingInfo::enabled)
		for (const auto& engine : scene.engines)
			engine->timingInfo.nExec
			        += !engine->dead && !dynamic_cast<const PeriodicEngine*>(engine.get());
	++scene.iter;
	scene.time += scene.dt;
}

ArraySteps::Motion ArraySteps::motionOf(const State& s)
{
	return { { double(s.pos[0]), double(s.pos[1]) }, { double(s.ori.w()), double(s.ori.z()) },
		{ double(s.vel[0]), double(s.vel[1]), double(s.angVel[2]) } };
}

/// Property of the scene that requires YADE's engines; empty: none. Also collects the engines that
/// exert forces.
std::string ArraySteps::sceneReason(
        const Scene& scene, const validation::Engines& engines, const rcr::Step& step)
{
	if (scene.isPeriodic) return "a periodic cell";
	if (!step.members.empty()) return "clumps";
	if (scene.trackEnergy) return "O.trackEnergy";
	if (scene.forces.getPermForceUsed()) return "permanent forces";
	const NewtonIntegrator& newton = *engines.integrator;
	if (newton.mask > 0) return "NewtonIntegrator.mask";
	if (!engines.loop->callbacks.empty()) return "callbacks of the InteractionLoop";
	for (const auto& functor : engines.loop->geomDispatcher->functors)
		if (functor->getBaseClassName() != "Ig2_Planar_RcrGeom")
			return "the functor " + functor->getClassName();
	for (const auto& functor : engines.loop->physDispatcher->functors)
		if (functor->getClassName() != "Ip2_FrictMat_FrictMat_CdPhys")
			return "the functor " + functor->getClassName();
	for (const auto& functor : engines.loop->lawDispatcher->functors)
		if (functor->getClassName() != "Law2_RcrGeom_CdPhys_SignoriniCoulomb")
			return "the functor " + functor->getClassName();
	enginesBefore_.clear(), enginesAfter_.clear(), synced_.clear();
	movesAfter_ = false;
	bool looped = false, solved = false;
	for (const auto& engine : scene.engines) {
		// checked in each step
		if (engine->dead || dynamic_cast<const PeriodicEngine*>(engine.get())) continue;
		looped |= engine.get() == engines.loop;
		solved |= bool(dynamic_cast<const RigidSolver*>(engine.get()));
		if (isCoreEngine(*engine)) continue;
		if (solved || !addLoadedBodies(*engine, synced_))
			return "the engine " + engine->getClassName();
		(looped ? enginesAfter_ : enginesBefore_).push_back(engine.get());
		movesAfter_ |= looped && validation::isKinematic(*engine);
	}
	return {};
}

/// Selects the synced bodies. Returns the reason for which bodies or contacts require YADE's
/// engines; empty: none.
std::string ArraySteps::bodiesReason(const Scene& scene, const rcr::Step& step)
{
	for (const rcr::StepContact& c : step.contacts)
		if (c.body1 > c.body2 && step.bodies[c.body1].shape.kind == step.bodies[c.body2].shape.kind)
			return "a contact whose bodies are not in their order";
	isSynced_.assign(step.bodies.size(), false);
	for (Body::id_t id : synced_)
		if (id >= 0 && std::size_t(id) < isSynced_.size()) isSynced_[id] = true;
	std::size_t grains = 0;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const rcr::StepBody& body  = step.bodies[id];
		const bool           grain = body.shape.grain();
		// gather rejects obstacles that a free Box or Facet would pass through
		if (body.free && body.shape.kind == rcr::PlanarShape::box) return "a Box that can move";
		if (body.free && body.shape.kind == rcr::PlanarShape::segment)
			return "a Facet that can move";
		const Body* b = (*scene.bodies)[id].get();
		if (b && body.shape.kind == rcr::PlanarShape::none && b->shape && b->isBounded()
		        && !dynamic_cast<const Wall*>(b->shape.get())) // parallel to the plane
			return "the shape " + b->shape->getClassName() + " of body #" + std::to_string(id);
		isSynced_[id] |= !grain && b;
		grains += grain && !isSynced_[id];
	}
	synced_.clear();
	for (std::size_t id = 0; id < isSynced_.size(); ++id)
		if (isSynced_[id] && (*scene.bodies)[id]) synced_.push_back(Body::id_t(id));
	return grains < synced_.size() ? "more obstacles and loaded bodies than other grains" : "";
}

/// Present reason for which YADE's engines must take the next step; empty: none.
std::string ArraySteps::momentaryReason(const Scene& scene) const
{
	if (!Omega::instance().isRunning() || scene.subStepping) return "a single step";
	const long iter = scene.iter + 1;
	const Real time = scene.time + scene.dt;
	if ((scene.stopAtIter > 0 && iter >= scene.stopAtIter)
	        || (scene.stopAtTime > 0 && time >= scene.stopAtTime))
		return "the end of the run";
	if (scene.interactions->dirty || (active_ && scene.bodies->size() != isSynced_.size()))
		return "a change of the bodies or interactions";
	if (!scene._nextEngines.empty()) return "a change of O.engines";
	if (active_ && count_ - first_ >= stepsBetweenUpdates)
		return "YADE's objects are brought up to date";
	bool solved = false;
	for (const auto& engine : scene.engines) {
		if (engine->dead) continue;
		solved |= bool(dynamic_cast<const RigidSolver*>(engine.get()));
		const auto* periodic = dynamic_cast<const PeriodicEngine*>(engine.get());
		if (periodic && isDue(*periodic, solved ? scene.iter : iter, solved ? scene.time : time))
			return "the engine " + engine->getClassName();
	}
	return {};
}

bool ArraySteps::advance(Scene& scene, const validation::Engines& engines, rcr::ThreadTeam& team,
        SceneHandles& handles, const std::vector<rcr::PlanarVector>& impulses, rcr::Step& step)
{
	reason_ = active_ ? std::string() : sceneReason(scene, engines, step);
	if (reason_.empty() && !active_) reason_ = bodiesReason(scene, step);
	if (reason_.empty()) reason_ = momentaryReason(scene);
	if (reason_.empty() && !active_) reason_ = strayForceReason(scene, isSynced_);
	if (!reason_.empty()) return false;
	const bool first = !active_;
	if (first) begin(team, handles, step);
	pairs_.addFoundContacts(step, scene.iter);
	if (first || !step.added.empty()) pairs_.numberContacts(step);
	pairs_.storeForces(step, team);
	move(scene, *engines.integrator, team, handles, impulses, step);
	advanceTime(scene);
	++count_;
	scene.forces.reset(scene.iter);
	runEngines(scene, enginesBefore_);
	regatherBodies(scene, engines, team, synced_, handles, step);
	const auto detect = [&](bool listAll, bool keepContacts) {
		const bool changed = neighbors_.update(step, team);
		if (listAll || changed) pairs_.assign(neighbors_.list(), keepContacts);
		pairs_.detect(step, team, keepContacts);
		acceptNewContacts(scene, engines);
	};
	detect(first, false);
	if (!enginesAfter_.empty()) {
		runEngines(scene, enginesAfter_);
		regatherBodies(scene, engines, team, synced_, handles, step);
		if (movesAfter_) detect(false, true);
	}
	pairs_.fillStep(step, team);
	return true;
}

/// Reads inertia and motion of the bodies, and the forces of the contacts.
void ArraySteps::begin(rcr::ThreadTeam& team, const SceneHandles& handles, const rcr::Step& step)
{
	const std::size_t count = step.bodies.size();
	active_ = true, first_ = count_;
	inertia_.resize(count), written_.resize(count), endVelocity_.resize(count);
	team.forEach(count, [&](std::size_t id) {
		prefetch<State>(handles.state[indexAhead(id, count)]);
		const State* s = handles.state[id];
		inertia_[id]   = s ? plane::inertiaOf(*s) : rcr::Inertia {};
		if (s) written_[id] = motionOf(*s);
	});
	pairs_.all.clear();
	for (const rcr::StepContact& contact : step.contacts) {
		if (contact.handleIndex < 0) continue;
		rcr::Pair pair;
		pair.body1 = contact.body1, pair.body2 = contact.body2;
		pair.handleIndex = contact.handleIndex;
		pairs_.all.push_back(pair);
	}
	pairs_.manifold.resize(pairs_.all.size());
	team.forEach(pairs_.all.size(), [&](std::size_t k) {
		rcr::Pair&       pair  = pairs_.all[k];
		const rcr::Pair& later = pairs_.all[indexAhead(k, pairs_.all.size())];
		prefetch<CdPhys>(handles.sorted[later.handleIndex].phys);
		const CdPhys& phys = *handles.sorted[pair.handleIndex].phys;
		pair.pointCount    = phys.points;
		pair.law           = phys.law();
		for (int point = 0; point < 2; ++point)
			pair.along[point] = double(phys.along[point]);
	});
}

/// Moves the bodies like NewtonIntegrator. Obstacles need not lie in the plane.
void ArraySteps::move(Scene& scene, const NewtonIntegrator& newton, rcr::ThreadTeam& team,
        const SceneHandles& handles, const std::vector<rcr::PlanarVector>& impulses,
        rcr::Step& step)
{
	for (Body::id_t id : synced_) {
		State&                   s = *handles.state[id];
		const rcr::PlanarVector& p = impulses[id];
		const Vector3r force = scene.forces.getForce(id) + 1 / step.dt * Vector3r(p.x, p.y, 0);
		const Vector3r    torque
		        = scene.forces.getTorque(id) + 1 / step.dt * Vector3r(0, 0, p.rotation);
		if (step.overdamped) setUnblockedVelocity(s, step.bodies[id].velocity);
		if (!step.displacement.empty() && step.bodies[id].free)
			displace(s, step.displacement[id]);
		for (int axis = 0; axis < 3; ++axis) {
			if (!(s.blockedDOFs & State::axisDOF(axis)))
				s.vel[axis] += scene.dt * (force[axis] / s.mass + newton.gravity[axis]);
			if (!(s.blockedDOFs & State::axisDOF(axis, true)))
				s.angVel[axis] += scene.dt * (torque[axis] / s.inertia[axis]);
		}
		s.pos += s.vel * scene.dt;
		const Real rate = s.angVel.norm();
		if (rate != 0) s.ori = Quaternionr(AngleAxisr(rate * scene.dt, s.angVel / rate)) * s.ori;
		s.ori.normalize();
	}
	const double    before = step.dt, inverseDt = 1 / before;
	const rcr::Vec2 gravity = plane::toPlane(newton.gravity);
	step.dt                 = double(scene.dt);
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		if (isSynced_[id]) return;
		rcr::StepBody& body = step.bodies[id];
		if (!step.displacement.empty() && body.free) rcr::displace(body, step.displacement[id]);
		rcr::PlanarVector& v = body.velocity;
		v             = rcr::accelerated(v, inertia_[id], inverseDt * impulses[id], gravity, before);
		rcr::move(body, before);
		body.alertDistance = rcr::alertDistance(body.shape, v, step.dt);
		if (body.free) body.coveredPath = body.alertDistance;
		if (step.overdamped) {
			endVelocity_[id] = v;
			v                = startVelocity(v, inertia_[id], step.startFlow.at(body.center));
		}
		step.problem.freeVelocity[id] = rcr::accelerated(v, inertia_[id], {}, gravity, step.dt);
	});
}

void ArraySteps::runEngines(Scene& scene, const std::vector<Engine*>& engines) const
{
	for (Engine* engine : engines) {
		engine->scene = &scene;
		if (!engine->dead && engine->isActivated()) engine->action();
	}
	scene.forces.sync();
}

/// Sets the coefficients of new contacts. Removes contacts that the scene does not allow.
void ArraySteps::acceptNewContacts(Scene& scene, const validation::Engines& engines)
{
	const rcr::StepHost host = newContacts(scene, engines);
	for (rcr::Pair& pair : pairs_.all) {
		if (!pair.isNew) continue;
		const std::string error = validation::materialError(scene, pair.body1, pair.body2);
		if (!error.empty()) errors::refuse(error);
		if (!host.allows(pair.body1, pair.body2)) {
			pair.pointCount = 0;
			continue;
		}
		pair.law      = host.law(pair.body1, pair.body2);
		pair.formedAt = scene.iter;
	}
}

} // namespace yade
