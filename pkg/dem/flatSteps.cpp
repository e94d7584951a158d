#include "flatSteps.hpp"

#include <algorithm>
#include <set>

#include <core/Omega.hpp>
#include <core/PartialEngine.hpp>
#include <pkg/common/Collider.hpp>
#include <pkg/common/ForceResetter.hpp>
#include <pkg/common/KinematicEngines.hpp>
#include <pkg/common/PeriodicEngines.hpp>

#include "ContactDynamics.hpp"
#include "WallStress.hpp"
#include "plane.hpp"
#include "prefetch.hpp"
#include "scatter.hpp"

namespace yade {

namespace {

	constexpr long mostSteps = 100; // between two updates of YADE's objects; no clock, so that a run repeats its bits

	/// Whether a PeriodicEngine will act when it is asked at this iteration and time; asking it would count.
	bool due(const PeriodicEngine& engine, long iter, Real time)
	{
		if (engine.nDone == 0) return engine.firstIterRun <= 0 || engine.firstIterRun == iter; // it counts from the first time that it is asked
		if (iter < engine.iterLast) return true;
		if (engine.nDo >= 0 && engine.nDone >= engine.nDo) return false;
		return (engine.virtPeriod > 0 && time - engine.virtLast >= engine.virtPeriod)
		        || (engine.realPeriod > 0 && PeriodicEngine::getClock() - engine.realLast >= engine.realPeriod)
		        || (engine.iterPeriod > 0 && iter - engine.iterLast >= engine.iterPeriod);
	}

	/// The bodies that an engine loads or drives; false where it may look at others.
	bool loaded(const Engine& engine, std::vector<Body::id_t>& ids)
	{
		if (const auto* stress = dynamic_cast<const WallStress*>(&engine)) {
			ids.insert(ids.end(), { stress->wall, stress->start, stress->end });
			return true;
		}
		static const std::set<std::string> forces { "ForceEngine", "InterpolatingDirectedForceEngine", "RadialForceEngine", "TorqueEngine", "DragEngine", "LinearDragEngine" };
		if (!dynamic_cast<const KinematicEngine*>(&engine) && !forces.count(engine.getClassName())) return false;
		const auto& loads = static_cast<const PartialEngine&>(engine).ids;
		ids.insert(ids.end(), loads.begin(), loads.end());
		return true;
	}

	bool core(const Engine& engine)
	{
		return dynamic_cast<const ForceResetter*>(&engine) || dynamic_cast<const Collider*>(&engine) || dynamic_cast<const InteractionLoop*>(&engine)
		        || dynamic_cast<const ContactDynamics*>(&engine) || dynamic_cast<const NewtonIntegrator*>(&engine);
	}

	/// A force of this step alone on a body that does not stay with YADE, as a PyRunner adds one: arrays know contacts and gravity.
	template <class Watches> std::string strayForce(Scene& scene, const Watches& watches)
	{
		for (std::size_t id = 0; id < watches.size(); ++id)
			if (!watches[id] && (*scene.bodies)[id] && (scene.forces.getForce(Body::id_t(id)) != Vector3r::Zero() || scene.forces.getTorque(Body::id_t(id)) != Vector3r::Zero()))
				return "a force on body #" + std::to_string(id);
		return {};
	}

	/// The interaction of two bodies without one that is real.
	Interaction* interactionOf(Scene& scene, const rcr::Pair& pair)
	{
		shared_ptr<Interaction> i = scene.interactions->find(pair.body1, pair.body2);
		if (!i) {
			i = boost::make_shared<Interaction>(pair.body1, pair.body2);
			scene.interactions->insert(i);
		}
		if (i->getId1() != pair.body1) i->swapOrder();
		return i.get();
	}

} // namespace

FlatSteps::Motion FlatSteps::motionOf(const State& s)
{
	return { { double(s.pos[0]), double(s.pos[1]) }, { double(s.ori.w()), double(s.ori.z()) }, { double(s.vel[0]), double(s.vel[1]), double(s.angVel[2]) } };
}

/// What of the scene keeps its steps from being taken in arrays; also finds the loads.
std::string FlatSteps::reason(const Scene& scene, const gate::Engines& engines, const rcr::Step& step)
{
	if (scene.isPeriodic) return "a periodic cell";
	if (!step.members.empty()) return "clumps";
	if (scene.trackEnergy) return "O.trackEnergy";
	if (scene.forces.getPermForceUsed()) return "permanent forces";
	const NewtonIntegrator& newton = *engines.integrator;
	if (newton.mask > 0) return "NewtonIntegrator.mask";
	if (!engines.loop->callbacks.empty()) return "callbacks of the InteractionLoop";
	for (const auto& functor : engines.loop->geomDispatcher->functors)
		if (functor->getBaseClassName() != "Ig2_Planar_RcrGeom") return "the functor " + functor->getClassName();
	for (const auto& functor : engines.loop->physDispatcher->functors)
		if (functor->getClassName() != "Ip2_FrictMat_FrictMat_CdPhys") return "the functor " + functor->getClassName();
	for (const auto& functor : engines.loop->lawDispatcher->functors)
		if (functor->getClassName() != "Law2_RcrGeom_CdPhys_SignoriniCoulomb") return "the functor " + functor->getClassName();
	early_.clear(), late_.clear(), watched_.clear();
	bool looped = false, solved = false;
	for (const auto& engine : scene.engines) {
		if (engine->dead || dynamic_cast<const PeriodicEngine*>(engine.get())) continue; // looked at in each step
		looped |= engine.get() == engines.loop;
		solved |= bool(dynamic_cast<const ContactDynamics*>(engine.get()));
		if (core(*engine)) continue;
		if (solved || !loaded(*engine, watched_)) return "the engine " + engine->getClassName();
		(looped ? late_ : early_).push_back(engine.get());
	}
	return {};
}

/// The bodies that stay with YADE, and what of the contacts keeps their steps from being taken in arrays.
std::string FlatSteps::watch(const Scene& scene, const rcr::Step& step)
{
	for (const rcr::StepContact& c : step.contacts)
		if (c.body1 > c.body2 && step.bodies[c.body1].shape.kind == step.bodies[c.body2].shape.kind) return "a contact whose bodies are not in their order";
	watches_.assign(step.bodies.size(), false);
	for (Body::id_t id : watched_)
		if (id >= 0 && std::size_t(id) < watches_.size()) watches_[id] = true;
	std::size_t grains = 0;
	for (std::size_t id = 0; id < step.bodies.size(); ++id) {
		const bool grain = step.bodies[id].shape.grain();
		watches_[id] |= !grain && (*scene.bodies)[id];
		grains += grain && !watches_[id];
	}
	watched_.clear();
	for (std::size_t id = 0; id < watches_.size(); ++id)
		if (watches_[id] && (*scene.bodies)[id]) watched_.push_back(Body::id_t(id));
	return grains < watched_.size() ? "more obstacles and driven bodies than others" : "";
}

/// What keeps the next step, at this moment, from being taken in arrays.
std::string FlatSteps::reasonNow(const Scene& scene) const
{
	if (!Omega::instance().isRunning() || scene.subStepping) return "a single step";
	const long iter = scene.iter + 1;
	const Real time = scene.time + scene.dt;
	if ((scene.stopAtIter > 0 && iter >= scene.stopAtIter) || (scene.stopAtTime > 0 && time >= scene.stopAtTime)) return "the end of the run";
	if (scene.interactions->dirty || (going_ && scene.bodies->size() != watches_.size())) return "a change of the bodies or interactions";
	if (!scene._nextEngines.empty()) return "a change of O.engines";
	if (going_ && count_ - first_ >= mostSteps) return "YADE's objects are brought up to date";
	bool solved = false;
	for (const auto& engine : scene.engines) {
		solved |= bool(dynamic_cast<const ContactDynamics*>(engine.get()));
		const auto* periodic = engine->dead ? nullptr : dynamic_cast<const PeriodicEngine*>(engine.get());
		if (periodic && (solved ? due(*periodic, scene.iter, scene.time) : due(*periodic, iter, time))) return "the engine " + engine->getClassName();
	}
	return {};
}

bool FlatSteps::goOn(Scene& scene, const gate::Engines& engines, rcr::ThreadTeam& team, StepSources& sources, const std::vector<rcr::Twist>& loads, rcr::Step& step)
{
	why_ = going_ ? std::string() : reason(scene, engines, step);
	if (why_.empty()) why_ = reasonNow(scene);
	if (why_.empty() && !going_) why_ = watch(scene, step);
	if (why_.empty() && !going_) why_ = strayForce(scene, watches_);
	if (!why_.empty()) return false;
	const bool first = !going_;
	if (first) begin(team, sources, step);
	pairs_.takeIn(step, scene.iter);
	if (first || !step.taken.empty()) pairs_.number(step);
	pairs_.keepForces(step, team);
	move(scene, *engines.integrator, team, sources, loads, step);
	++scene.iter;
	scene.time += scene.dt;
	++count_;
	scene.forces.reset(scene.iter);
	load(scene, early_);
	gatherAgain(scene, engines, team, watched_, sources, step);
	const bool changed = neighbours_.update(step, team);
	if (first || changed) pairs_.become(neighbours_.list());
	pairs_.detect(step, team);
	setPhysics(scene, engines);
	if (!late_.empty()) {
		load(scene, late_);
		gatherAgain(scene, engines, team, watched_, sources, step);
	}
	pairs_.contacts(step, team);
	return true;
}

/// Of the bodies: what moves them, and where YADE has them; of the contacts: what YADE has carried so far.
void FlatSteps::begin(rcr::ThreadTeam& team, const StepSources& sources, const rcr::Step& step)
{
	going_                  = true;
	first_                  = count_;
	const std::size_t count = step.bodies.size();
	inertia_.resize(count), begun_.resize(count), arrived_.resize(count);
	team.forEach(count, [&](std::size_t id) {
		prefetch<State>(sources.state[std::min(id + prefetchAhead, count - 1)]);
		inertia_[id]         = {};
		const State* const s = sources.state[id];
		if (!s) return;
		const auto free = [&](unsigned dof) { return !(s->blockedDOFs & dof); };
		inertia_[id]    = { double(s->mass), double(s->inertia[2]), free(State::DOF_X), free(State::DOF_Y), free(State::DOF_RZ) };
		begun_[id]      = motionOf(*s);
	});
	pairs_.all.clear();
	for (const rcr::StepContact& contact : step.contacts) {
		if (contact.source < 0) continue;
		rcr::Pair pair;
		pair.body1 = contact.body1, pair.body2 = contact.body2, pair.source = contact.source;
		pairs_.all.push_back(pair);
	}
	pairs_.manifold.resize(pairs_.all.size());
	team.forEach(pairs_.all.size(), [&](std::size_t k) {
		rcr::Pair& pair = pairs_.all[k];
		prefetch<CdPhys>(sources.sorted[pairs_.all[std::min(k + prefetchAhead, pairs_.all.size() - 1)].source].phys);
		const CdPhys& phys = *sources.sorted[pair.source].phys;
		pair.points        = phys.points;
		pair.friction = double(phys.tangensOfFrictionAngle), pair.restitution = double(phys.restitution);
		for (int point = 0; point < 2; ++point)
			pair.along[point] = double(phys.along[point]);
	});
}

/// As NewtonIntegrator does it; bodies that stay with YADE need not lie in the plane.
void FlatSteps::move(
        Scene& scene, const NewtonIntegrator& newton, rcr::ThreadTeam& team, const StepSources& sources, const std::vector<rcr::Twist>& loads, rcr::Step& step)
{
	for (Body::id_t id : watched_) {
		State&         s = *sources.state[id];
		const Vector3r force = scene.forces.getForce(id) + 1 / step.dt * Vector3r(loads[id].x, loads[id].y, 0);
		const Vector3r torque = scene.forces.getTorque(id) + 1 / step.dt * Vector3r(0, 0, loads[id].rotation);
		if (step.overdamped) stop(s, step.bodies[id].velocity);
		if (!step.displacement.empty() && step.bodies[id].free) displace(s, step.displacement[id]);
		for (int axis = 0; axis < 3; ++axis) {
			if (!(s.blockedDOFs & State::axisDOF(axis))) s.vel[axis] += scene.dt * (force[axis] / s.mass + newton.gravity[axis]);
			if (!(s.blockedDOFs & State::axisDOF(axis, true))) s.angVel[axis] += scene.dt * (torque[axis] / s.inertia[axis]);
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
		if (watches_[id]) return;
		rcr::StepBody& body = step.bodies[id];
		if (!step.displacement.empty() && body.free) {
			const rcr::Twist& by = step.displacement[id];
			body.center          = { body.center.x + by.x, body.center.y + by.y };
			if (by.rotation != 0) body.turn = rcr::scaled(rcr::turned(body.turn, by.rotation));
		}
		const rcr::Twist& p = loads[id];
		body.velocity = rcr::accelerated(body.velocity, inertia_[id], { inverseDt * p.x, inverseDt * p.y, inverseDt * p.rotation }, gravity, before);
		body.center   = { body.center.x + body.velocity.x * before, body.center.y + body.velocity.y * before };
		body.turn     = rcr::leapt(body.turn, body.velocity.rotation, before);
		body.alertDistance = rcr::alertDistance(body.shape, body.velocity, step.dt);
		if (body.free) body.expected = body.alertDistance;
		if (step.overdamped) {
			arrived_[id]  = body.velocity;
			body.velocity = atRest(body.velocity, inertia_[id], step.rest.at(body.center));
		}
		step.problem.freeVelocity[id] = rcr::accelerated(body.velocity, inertia_[id], {}, gravity, step.dt);
	});
}

void FlatSteps::load(Scene& scene, const std::vector<Engine*>& engines) const
{
	for (Engine* engine : engines) {
		engine->scene = &scene;
		if (!engine->dead && engine->isActivated()) engine->action();
	}
	scene.forces.sync();
}

void FlatSteps::setPhysics(Scene& scene, const gate::Engines& engines)
{
	for (rcr::Pair& pair : pairs_.all) {
		if (!pair.fresh) continue;
		if (!gate::frictional(scene, pair.body1, pair.body2) || !mayMeet(scene, engines, pair.body1, pair.body2)) {
			pair.points = 0;
			continue;
		}
		const ContactLaw law = contactLaw(scene, *engines.loop, pair.body1, pair.body2);
		pair.friction = law.friction, pair.restitution = law.restitution;
		pair.since    = scene.iter;
	}
}

void FlatSteps::publish(Scene& scene, rcr::ThreadTeam& team, StepSources& sources, const rcr::Step& step)
{
	if (!going_) return;
	going_       = false;
	scene.doSort = true; // the collider has not looked for long
	team.forEach(step.bodies.size(), [&](std::size_t id) {
		prefetch<State>(sources.state[std::min(id + prefetchAhead, step.bodies.size() - 1)]);
		State* s = sources.state[id];
		if (!s || watches_[id]) return;
		const rcr::StepBody& body = step.bodies[id];
		const rcr::Twist&    v      = step.overdamped ? arrived_[id] : body.velocity;
		const Motion         before = begun_[id], now = motionOf(*s); // what somebody has written to a body meanwhile stays
		if (now.center == before.center) s->pos[0] = body.center.x, s->pos[1] = body.center.y;
		if (now.turn == before.turn) s->ori.w() = body.turn.w, s->ori.z() = body.turn.z;
		if (now.velocity == before.velocity) s->vel[0] = v.x, s->vel[1] = v.y, s->angVel[2] = v.rotation;
	});

	std::vector<Interaction*> interaction(pairs_.all.size());
	std::vector<char>         lasts(sources.sorted.size());
	const auto made = [](const rcr::Pair& pair) { return pair.points > 0 && (pair.source >= 0 || pair.since >= 0); }; // not where an error came in between
	for (std::size_t k = 0; k < interaction.size(); ++k) {
		const int source = pairs_.all[k].source;
		if (!made(pairs_.all[k]) || source < 0) continue;
		lasts[source]  = true;
		interaction[k] = sources.sorted[source].interaction;
	}
	for (std::size_t k = 0; k < lasts.size(); ++k)
		if (!lasts[k] && sources.sorted[k].interaction) sources.sorted[k].interaction->reset();
	for (std::size_t k = 0; k < interaction.size(); ++k)
		if (made(pairs_.all[k]) && !interaction[k]) interaction[k] = interactionOf(scene, pairs_.all[k]);
	std::vector<StepSources::Contact> contacts(interaction.size());
	team.forEach(interaction.size(), [&](std::size_t k) {
		if (const Interaction* later = interaction[std::min(k + prefetchAhead, interaction.size() - 1)]) {
			prefetch<RcrGeom>(later->geom.get());
			prefetch<CdPhys>(later->phys.get());
		}
		if (interaction[k]) contacts[k] = write(int(k), *interaction[k], step);
	});
	sources.sorted.swap(contacts);
}

/// YADE's contact of a pair as the pair has it.
StepSources::Contact FlatSteps::write(int number, Interaction& i, const rcr::Step& step) const
{
	const rcr::Pair& pair = pairs_.all[number];
	if (!i.geom) i.geom = boost::make_shared<RcrGeom>();
	if (pair.since >= 0) {
		auto phys                    = boost::make_shared<CdPhys>();
		phys->tangensOfFrictionAngle = pair.friction;
		phys->restitution            = pair.restitution;
		i.phys                       = phys;
		i.iterMadeReal               = pair.since;
	}
	RcrGeom&             geom = static_cast<RcrGeom&>(*i.geom);
	CdPhys&              phys = static_cast<CdPhys&>(*i.phys);
	const rcr::StepBody &one = step.bodies[pair.body1], &two = step.bodies[pair.body2];
	geom.set(pairs_.manifold[number], one.shape, one.pose(), two.shape, two.pose());
	phys.points = geom.points;
	phys.along  = geom.along;
	phys.force1 = Vector2r(pair.force[0].n, pair.force[0].t);
	phys.force2 = Vector2r(pair.force[1].n, pair.force[1].t);
	return { &geom, &phys, &i, pair.body1, pair.body2, geom.points };
}

} // namespace yade
