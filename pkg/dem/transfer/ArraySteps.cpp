#include "dem/transfer/ArraySteps.hpp"

#include "dem/shapes/planeConversion.hpp"
#include "dem/transfer/newContacts.hpp"

namespace yade {

constexpr long   stepsBetweenUpdates = 100; // a fixed number, so that a run repeats its bits
// change of the edges of a cell between updates, relative. YADE's engines reject cells that become
// too small.
constexpr double mostDeformation = 0.01;

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

/// Returns true if the cell moves bodies along z, or by their height.
static bool leavesPlane(const Scene& scene, const NewtonIntegrator& newton)
{
	const Real z = validation::planeOf(scene);
	for (const Matrix3r& gradient : { plane::nextGradient(*scene.cell), newton.prevVelGrad })
		if (gradient(2, 0) != 0 || gradient(2, 1) != 0 || (z != 0 && gradient.col(2).any()))
			return true;
	return false;
}

ArraySteps::Motion ArraySteps::motionOf(const State& s)
{
	return { { double(s.pos[0]), double(s.pos[1]) }, { double(s.ori.w()), double(s.ori.z()) },
		{ double(s.vel[0]), double(s.vel[1]), double(s.angVel[2]) } };
}

/// Property of the scene that requires YADE's engines; empty: none. Also reads the schedule.
std::string ArraySteps::sceneReason(const Scene& scene, const validation::Engines& engines)
{
	if (scene.forces.getPermForceUsed()) return "permanent forces";
	if (engines.integrator->mask > 0) return "NewtonIntegrator.mask";
	if (scene.isPeriodic && leavesPlane(scene, *engines.integrator))
		return "a motion of the cell along z";
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
	schedule_ = scheduler::scheduleOf(scene);
	return schedule_.foreign.empty() ? "" : "the engine " + schedule_.foreign;
}

/// Selects the synced bodies. Returns the reason for which bodies or contacts require YADE's
/// engines; empty: none.
std::string ArraySteps::bodiesReason(const Scene& scene, const rcr::Step& step)
{
	for (const rcr::StepContact& c : step.contacts)
		if (c.body1 > c.body2 && step.bodies[c.body1].shape.kind == step.bodies[c.body2].shape.kind)
			return "a contact whose bodies are not in their order";
	isSynced_.assign(step.bodies.size(), false);
	for (Body::id_t id : schedule_.bodies)
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
		isSynced_[id] |= !grain && b && !b->isClump();
	}
	for (std::int32_t id : step.members)
		isSynced_[step.bodies[id].owner] |= isSynced_[id];
	for (std::int32_t id : step.members)
		isSynced_[id] = isSynced_[step.bodies[id].owner];
	for (std::size_t id = 0; id < step.bodies.size(); ++id)
		grains += step.bodies[id].shape.grain() && !isSynced_[id];
	synced_.clear();
	for (std::size_t id = 0; id < isSynced_.size(); ++id)
		if (isSynced_[id] && (*scene.bodies)[id]) synced_.push_back(Body::id_t(id));
	return grains < synced_.size() ? "more obstacles and loaded bodies than other grains" : "";
}

/// Present reason for which YADE's engines must take the next step; empty: none.
std::string ArraySteps::momentaryReason(const Scene& scene) const
{
	if (std::string reason = scheduler::reasonToStop(scene); !reason.empty()) return reason;
	if (scene.interactions->dirty || (active_ && scene.bodies->size() != isSynced_.size()))
		return "a change of the bodies or interactions";
	const Matrix3r& edges = scene.cell->hSize;
	if (active_
	        && (count_ - first_ >= stepsBetweenUpdates
	                || (edges - firstEdges_).norm() > mostDeformation * firstEdges_.norm()))
		return "YADE's objects are brought up to date";
	return {};
}

bool ArraySteps::advance(Scene& scene, const validation::Engines& engines, rcr::ThreadTeam& team,
        SceneHandles& handles, const Impulses& impulses, rcr::Neighbors& neighbors,
        rcr::Step& step)
{
	reason_ = active_ ? std::string() : sceneReason(scene, engines);
	if (reason_.empty() && !active_) reason_ = bodiesReason(scene, step);
	if (reason_.empty()) reason_ = momentaryReason(scene);
	if (reason_.empty() && !active_) reason_ = strayForceReason(scene, isSynced_);
	if (!reason_.empty()) return false;
	if (!active_) begin(scene, team, handles, step);
	pairs_.store(step, team, scene.iter);
	++count_;
	const std::vector<rcr::Drive> before = rcr::drivesOf(step);
	move(scene, engines, team, handles, impulses, step);
	const auto regather = [&] {
		regatherBodies(scene, engines, team, synced_, handles, step);
		for (const rcr::Drive& drive : before)
			rcr::setDriveBefore(step, drive);
	};
	scheduler::run(scene, schedule_.before);
	regather();
	rcr::NewContacts host = newContacts(scene, engines);
	host.allows = [&, allows = host.allows](int id1, int id2) {
		const std::string error = validation::materialError(scene, id1, id2);
		if (!error.empty()) errors::refuse(error);
		return allows(id1, id2);
	};
	const rcr::Search search { neighbors, team, host.allows };
	pairs_.detect(search, step, host, scene.iter);
	if (!schedule_.after.empty()) {
		scheduler::run(scene, schedule_.after);
		regather();
		if (schedule_.movesAfter) pairs_.detect(search, step, host, scene.iter, true);
	}
	gatherCellStress(engines, step);
	pairs_.fillStep(step, team);
	return true;
}

/// Reads inertia and motion of the bodies, and the forces of the contacts.
void ArraySteps::begin(const Scene& scene, rcr::ThreadTeam& team, const SceneHandles& handles,
        const rcr::Step& step)
{
	const std::size_t count = step.bodies.size();
	active_ = true, first_ = count_, firstEdges_ = scene.cell->hSize;
	inertia_.resize(count), written_.resize(count), endVelocity_.resize(count);
	team.forEach(count, [&](std::size_t id) {
		const State* s = handles.state[id];
		inertia_[id]   = s ? plane::inertiaOf(*s) : rcr::Inertia {};
		if (s) written_[id] = motionOf(*s), endVelocity_[id] = plane::velocityOf(*s);
	});
	clumps_.clear();
	for (std::size_t id = 0; id < count; ++id) {
		const Body* b = (*scene.bodies)[id].get();
		if (step.members.empty() || isSynced_[id] || !b || !b->isClump()) continue;
		clumps_.push_back({ Body::id_t(id), {} });
		for (const auto& [member, at] : static_cast<const Clump&>(*b->shape).members)
			clumps_.back().members.push_back({ member, plane::toPlane(at.position),
			        { double(at.orientation.w()), double(at.orientation.z()) } });
	}
	pairs_.all.clear(), pairs_.listed = false;
	for (const rcr::StepContact& contact : step.contacts) {
		if (contact.handleIndex < 0) continue;
		rcr::Pair pair;
		pair.body1 = contact.body1, pair.body2 = contact.body2;
		pair.handleIndex = contact.handleIndex;
		pair.shift       = contact.shift;
		pairs_.all.push_back(pair);
	}
	pairs_.manifold.resize(pairs_.all.size());
	team.forEach(pairs_.all.size(), [&](std::size_t k) {
		rcr::Pair&    pair = pairs_.all[k];
		const CdPhys& phys = *handles.sorted[pair.handleIndex].phys;
		pair.pointCount    = phys.points;
		pair.law           = phys.law();
		for (int point = 0; point < 2; ++point)
			pair.along[point] = double(phys.along[point]);
	});
}

} // namespace yade
