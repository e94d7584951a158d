// What ContactDynamics tells of a step: balance, missed steps, energy, and what Python asks for.
#include <array>
#include <optional>
#include <sstream>

#include <core/Omega.hpp>
#include <core/Scene.hpp>
#include <lib/pyutil/gil.hpp>

#include "ContactDynamics.hpp"
#include "flatSteps.hpp"
#include "plane.hpp"

namespace yade {

namespace {

	constexpr double mostStretch = 0.02; // of a cell in a step: the way of bodies side by side past each other, over R₁ + R₂, from which on they count as crushed

	/// "body #1", "bodies #1 and #2"; empty without ids.
	std::string bodies(const std::vector<int>& ids)
	{
		if (ids.empty()) return {};
		std::string text = ids.size() == 1 ? "body" : "bodies";
		for (std::size_t k = 0; k < ids.size(); ++k)
			text += (k == 0 ? " #" : k + 1 < ids.size() ? ", #" : " and #") + std::to_string(ids[k]);
		return text;
	}

} // namespace

/// A step whose solution is not finite ends the run before anything moves, and leaves its problem in a file.
void ContactDynamics::refuseUnlessFinite() const
{
	for (std::size_t id = 0; id < step_.bodies.size(); ++id) {
		const rcr::Twist& v = step_.problem.velocity[id];
		if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.rotation)) continue;
		const gilLock     lock;
		const std::string saved = boost::python::extract<std::string>(boost::python::import("rcr.scene").attr("save_not_finite")());
		throw std::runtime_error(
		        "ContactDynamics: step " + std::to_string(scene->iter) + " would give body #" + std::to_string(id) + " the velocity (" + gate::text(v.x) + ", "
		        + gate::text(v.y) + ") and the angular velocity " + gate::text(v.rotation) + ". Nothing has moved. " + saved);
	}
}

/// Images that a stretch of the cell brings near are not looked for, as bodies are that go far.
void ContactDynamics::refuseFarStretch() const
{
	const double inverse[2] = { step_.cell.inverseMass.x, step_.cell.inverseMass.y };
	for (int axis = 0; axis < 2; ++axis) {
		const double strain = inverse[axis] > 0 ? std::abs(step_.cell.gradient[axis][axis]) * step_.dt : 0;
		if (strain > mostStretch)
			throw std::runtime_error(
			        "ContactDynamics: CellStress would stretch the cell by " + gate::text(100 * strain) + " % along " + "xy"[axis] + " in step "
			        + std::to_string(scene->iter) + ", past contacts that nothing foresees; wanted at most " + gate::text(100 * mostStretch)
			        + " %. Nothing has moved. Take a smaller O.dt or a larger CellStress.mass, or bring the bodies of a loose cell together by O.cell.velGrad first.");
	}
}

void ContactDynamics::measureUnbalance()
{
	double contact = 0, net = 0, largest = 0; // impulses
	int    closed = 0, free = 0;
	for (const rcr::Impulse& p : step_.problem.impulse) {
		contact += p.n;
		closed += p.n > 0;
	}
	for (std::size_t id = 0; id < step_.bodies.size(); ++id) {
		const rcr::StepBody& body = step_.bodies[id];
		if (!body.free || !(body.shape.grain() || body.shape.kind == rcr::PlanarShape::none)) continue;
		const rcr::InverseMass& inverse = step_.problem.inverseMass[id];
		const rcr::Twist &      v = step_.problem.velocity[id], &before = body.velocity;
		const rcr::Vec2         change { inverse.x > 0 ? (v.x - before.x) / inverse.x : 0, inverse.y > 0 ? (v.y - before.y) / inverse.y : 0 };
		largest = std::max(largest, norm(change));
		net += norm(change);
		++free;
	}
	constexpr double none = std::numeric_limits<double>::infinity();
	unbalancedForce        = closed > 0 && free > 0 ? (net / free) / (contact / closed) : none;
	largestUnbalancedForce = closed > 0 ? largest / (contact / closed) : none;
}

/// The end of the last entry is where the next step begins.
template <class Place> void ContactDynamics::place(Place placeOf)
{
	if (observations_.empty() || std::exchange(observations_.back().placed, true)) return;
	for (int id : observations_.back().of.ids)
		if (const std::optional<rcr::Vec2> at = placeOf(id)) observations_.back().position[id] = *at;
}

void ContactDynamics::checkObserved() const
{
	for (int id : observe) {
		const std::string holds = "ContactDynamics.observe holds " + std::to_string(id);
		if (id < 0 || std::size_t(id) >= step_.bodies.size()) gate::refuse(holds + "; wanted ids of bodies, 0 to " + std::to_string(step_.bodies.size() - 1) + ".");
		if (!sources_.state[id]) gate::refuse(holds + ", a body that has been erased; take it out.");
		const int owner = step_.bodies[id].owner;
		if (owner != id) gate::refuse(holds + ", a member of the clump " + std::to_string(owner) + ", on which its contacts act; give that.");
	}
}

void ContactDynamics::observeStep(const std::vector<rcr::Twist>& loads)
{
	const std::lock_guard<std::mutex> lock(reading_);
	checkObserved();
	summary_ = workspace_.summary();
	place([&](int id) -> std::optional<rcr::Vec2> {
		if (std::size_t(id) >= step_.bodies.size() || !sources_.state[id]) return {};
		return step_.bodies[id].center;
	});
	if (observed_.ids != observe) observed_ = {}; // means are of steps that have observed the same
	observed_.ids = observe;
	++observed_.steps;
	observed_.iterations += iterations;
	observed_.yielded += yielded;
	observed_.residual = std::max(observed_.residual, double(residual));
	if (tolerance > 0 && !converged) {
		const double by = double(std::max(residual / tolerance, kinematicError / kinematicTolerance));
		++observed_.missed;
		observed_.missedSum += by;
		observed_.missedLargest = std::max(observed_.missedLargest, by);
	}
	for (int id : observe) {
		rcr::Twist& sum = observed_.force[id];
		sum = { sum.x + loads[id].x / step_.dt, sum.y + loads[id].y / step_.dt, sum.rotation + loads[id].rotation / step_.dt };
	}
	if (observeEvery == 0 || observed_.steps < observeEvery) return;
	observations_.push_back({ std::exchange(observed_, {}), scene->iter + 1, double(scene->time + scene->dt), double(residual), contactPoints, iterations, {}, false });
}

boost::python::list ContactDynamics::observationsList()
{
	namespace py = boost::python;
	const std::lock_guard<std::mutex> lock(reading_);
	const bool running = Omega::instance().isRunning(); // the end of the last entry is then not known yet
	if (!running)
		place([&](int id) -> std::optional<rcr::Vec2> {
			if (!scene->bodies->exists(id)) return {};
			return plane::toPlane((*scene->bodies)[id]->state->pos);
		});
	const bool open = !observations_.empty() && !observations_.back().placed;
	py::list   all;
	for (auto entryOf = observations_.begin(); entryOf != observations_.end() - open; ++entryOf) {
		const Observation& one = *entryOf;
		py::dict entry = dictOf(one.of), positions;
		for (const auto& [id, at] : one.position)
			positions[id] = py::make_tuple(at.x, at.y);
		entry["step"] = one.step, entry["time"] = one.time;
		entry["points"] = one.points, entry["last_iterations"] = one.iterations, entry["last_residual"] = one.residual;
		entry["positions"] = positions;
		all.append(entry);
	}
	observations_.erase(observations_.begin(), observations_.end() - open);
	return all;
}

boost::python::dict ContactDynamics::observedDict()
{
	const std::lock_guard<std::mutex> lock(reading_);
	return dictOf(std::exchange(observed_, {}));
}

boost::python::dict ContactDynamics::dictOf(const Observed& now) const
{
	namespace py = boost::python;
	py::dict observed, forces;
	for (int id : now.steps > 0 ? now.ids : observe) {
		const auto       sum  = now.force.find(id);
		const rcr::Twist mean = sum == now.force.end() ? rcr::Twist {} : sum->second;
		const double     over = double(std::max(1L, now.steps));
		forces[id]            = py::make_tuple(mean.x / over, mean.y / over, mean.rotation / over);
	}
	observed["steps"]          = now.steps;
	observed["iterations"]     = now.iterations;
	observed["residual"]       = now.residual;
	observed["missed"]         = now.missed;
	observed["yielded"]        = now.yielded;
	observed["missed_sum"]     = now.missedSum;
	observed["missed_largest"] = now.missedLargest;
	observed["forces"]         = forces;
	return observed;
}

/// Overlap of a point at the beginning of the step, over R₁ + R₂. Obstacles may overlap each other.
double ContactDynamics::overlapOf(std::size_t k) const
{
	const double share = rcr::contactSlop * step_.gap[k].now / step_.gap[k].allowed;
	if (share <= 0) return 0;
	const rcr::ContactPoint& c = step_.problem.points[k];
	return step_.problem.prescribed(c.body1) && step_.problem.prescribed(c.body2) ? 0 : share;
}

double ContactDynamics::overlapAtStart()
{
	return workspace_.team().maximum(step_.gap.size(), [&](std::size_t k) { return overlapOf(k); });
}

rcr::Squeeze ContactDynamics::squeeze() const { return { int(watched[4]), int(watched[1]), double(watched[5]) }; }

/// Counts steps that have not converged, and ends a run whose overlaps only grow.
void ContactDynamics::watch()
{
	const double overlap = overlapAtStart();
	const auto   deepestPair = [&] {
		std::size_t k = 0;
		while (overlapOf(k) != overlap)
			++k;
		return bodies({ step_.problem.points[k].body1, step_.problem.points[k].body2 });
	};
	rcr::MissedSteps count { long(watched[0]), missedSteps, yieldedSteps, double(deepestOverlap), long(watched[2]), double(watched[3]) };
	if (count.count(!converged && tolerance > 0, yielded, overlap, overdamped))
		LOG_WARN("step " << scene->iter << ": " << count.message() << (overlap > count.harmless ? " Deepest in this step: " + deepestPair() + "." : ""));
	missedSteps = int(count.missed), yieldedSteps = int(count.yielded), deepestOverlap = count.deepest;
	rcr::Squeeze squeeze = this->squeeze();
	const auto   verdict = squeeze.update(overlap, yielded);
	watched = { Real(count.steps), Real(squeeze.certified), Real(count.toldYielded), count.toldDeepest, Real(squeeze.grown), squeeze.deepest };
	if (verdict == rcr::Squeeze::Verdict::none) return;
	std::string culprits = bodies(rcr::drivenBodies(step_.problem));
	if (step_.cell.driven()) culprits += std::string(culprits.empty() ? "" : " and ") + "the velocity gradient of the cell";
	if (culprits.empty()) return;
	std::ostringstream text;
	text.precision(2);
	text << "ContactDynamics: " << (verdict == rcr::Squeeze::Verdict::jam ? "jam: " : "not converged: ") << deepestPair() << " overlap by " << overlap
	     << " of R₁ + R₂, and the overlap grows from step to step. ";
	if (verdict == rcr::Squeeze::Verdict::jam)
		text << "Rigid grains do not give way, so the steps have no solution; the motion prescribed to " << culprits
		     << " asks for it. Stop or reverse that motion (b.state.vel, O.cell.velGrad), or press by a force (WallStress, CellStress).";
	else
		text << "No step was found to be without a solution, but the solver has not reached one in " << iterations << " sweeps, so positions and forces "
		     << "are wrong. Set more ContactDynamics.maxIterations or a smaller O.dt.";
	throw std::runtime_error(text.str());
}

/// YADE's kinetic energy is that of the beginning of a step, so what the contacts of a step take is added in the next one.
void ContactDynamics::bookEnergy(const std::vector<rcr::Twist>& loads, const Vector3r& gravity)
{
	EnergyTracker& energy = *scene->energy;
	energy.add(pendingEnergy[0], "plastDissip", frictionIx, false);
	energy.add(pendingEnergy[1], "impactDissip", impactIx, false);
	energy.add(pendingEnergy[2], "driveWork", driveIx, false);
	energy.add(-pendingEnergy[3], "correctionWork", correctionIx, false);
	energy.add(pendingEnergy[3], "gravWork", gravityIx, false);
	const rcr::StepEnergy now = rcr::stepEnergy(step_, loads, plane::toPlane(gravity));
	pendingEnergy             = { now.friction, now.impact, now.driven, now.lifted };
}

std::string ContactDynamics::solverName() const
{
	const std::lock_guard<std::mutex> lock(reading_);
	return solver;
}

void ContactDynamics::setSolver(const std::string& name)
{
	const std::lock_guard<std::mutex> lock(reading_);
	solver = name;
}

std::vector<int> ContactDynamics::observedIds() const
{
	const std::lock_guard<std::mutex> lock(reading_);
	return observe;
}

void ContactDynamics::setObserve(const std::vector<int>& ids)
{
	const std::lock_guard<std::mutex> lock(reading_);
	observe = ids;
}

boost::python::dict ContactDynamics::secondsDict() const
{
	const std::lock_guard<std::mutex> lock(reading_);
	boost::python::dict               seconds;
	for (const auto& [what, total] : seconds_)
		seconds[what] = total;
	return seconds;
}

boost::python::dict ContactDynamics::missedDict() const
{
	boost::python::dict missed;
	missed["steps"]           = long(watched[0]);
	missed["missed"]          = missedSteps;
	missed["share"]           = watched[0] > 0 ? double(missedSteps / watched[0]) : 0.0;
	missed["yielded"]         = yieldedSteps;
	missed["deepest_overlap"] = double(deepestOverlap);
	return missed;
}

boost::python::dict ContactDynamics::problemDict() const
{
	namespace py = boost::python;
	if (Omega::instance().isRunning() && stepThread_.load() != std::this_thread::get_id())
		throw std::runtime_error("ContactDynamics: the problem changes while O.run goes on; call O.pause() first.");
	py::dict   columns;
	const auto add = [&](const char* name, const auto& rows) {
		const char* bytes = reinterpret_cast<const char*>(rows.data());
		columns[name]     = py::object(py::handle<>(PyBytes_FromStringAndSize(bytes, Py_ssize_t(rows.size() * sizeof(rows[0])))));
	};
	std::vector<std::array<double, 8>> points; // normal, arm1, arm2, bias, friction
	std::vector<std::array<int, 2>>    bodies;
	for (const rcr::ContactPoint& c : step_.problem.points) {
		points.push_back({ c.normal.x, c.normal.y, c.arm1.x, c.arm1.y, c.arm2.x, c.arm2.y, c.bias, c.friction });
		bodies.push_back({ c.body1, c.body2 });
	}
	add("points", points), add("bodies", bodies), add("impulse", warmStart_);
	add("inverse_mass", step_.problem.inverseMass), add("free_velocity", step_.problem.freeVelocity);
	return columns;
}

boost::python::dict ContactDynamics::modelDict() const
{
	const std::lock_guard<std::mutex> lock(reading_);
	const rcr::ModelSummary&          m = summary_;
	boost::python::dict               model;
	model["bodies"]       = m.bodies;
	model["rotations"]    = m.rotating;
	model["fixed"]        = m.fixed;
	model["pairs"]        = m.pairs;
	model["points"]       = m.points;
	model["unknowns"]     = m.unknowns();
	model["frictionless"] = m.frictionalPoints == 0;
	model["islands"]      = m.islands;
	model["layouts"]      = m.layouts;
	model["work"]         = work_;
	model["arrays"]       = fastSteps_;
	model["engines"]      = !arrays ? "ContactDynamics.arrays = False" : enginesReason_;
	return model;
}

} // namespace yade
