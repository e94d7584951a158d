#include "CurvedWays.hpp"

namespace yade {

namespace {

	constexpr double far   = std::numeric_limits<double>::infinity();
	constexpr int    looks = 4;    // times within the step at which a gap is measured before its contact is let pass
	constexpr double clear = 0.02; // share of the slop by which it must stay open: a push, unlike an overlap, is felt at once

	void move(State& moved, const State& from, const rcr::Twist& v, double time)
	{
		moved.pos = from.pos + time * Vector3r(v.x, v.y, 0);
		moved.ori = v.rotation == 0 ? from.ori : Quaternionr(AngleAxisr(time * v.rotation, Vector3r::UnitZ())) * from.ori;
	}

	/// Gap of the point that was number k of `count`; the deepest where their number has changed. Behind a body it is no gap.
	double gapOf(const rcr::Manifold& now, int k, int count, rcr::Vec2 normal)
	{
		if (now.count == 0) return far;
		const int at = now.count == count ? k : now.count == 2 && now.points[1].gap < now.points[0].gap ? 1 : 0;
		return dot(now.points[at].normal, normal) > 0 ? now.points[at].gap : -far;
	}

	/// Has it gone through the other body, so that the overlap is now on the far side?
	bool through(const rcr::Manifold& now, rcr::Vec2 normal)
	{
		return now.count > 0 && dot(now.points[0].normal, normal) <= 0 && now.points[0].gap < 0;
	}

} // namespace

CurvedWays::CurvedWays() : moved1_(boost::make_shared<State>()), moved2_(boost::make_shared<State>()) { }

rcr::Manifold CurvedWays::after(
        double time, const StepBody& one, const StepBody& two, const rcr::Twist& v1, const rcr::Twist& v2, const Body& b1, const Body& b2, IGeomFunctor& functor)
{
	move(*moved1_, *one.state, v1, time);
	move(*moved2_, *two.state, v2, time);
	scratch_ = boost::make_shared<Interaction>(b1.getId(), b2.getId());
	if (!functor.go(b1.shape, b2.shape, *moved1_, *moved2_, Vector3r::Zero(), true, scratch_)) return {};
	return static_cast<const RcrGeom&>(*scratch_->geom).manifold();
}

bool CurvedWays::correct(
        const Scene&                 scene,
        const InteractionLoop&       loop,
        const std::vector<StepBody>& bodies,
        rcr::ContactProblem&         solved,
        Body::id_t                   id1,
        Body::id_t                   id2,
        const RcrGeom&               geom,
        CdPhys&                      phys,
        int                          first,
        bool                         letGo)
{
	const double      dt = double(scene.dt), slop = RcrGeom::slop * double(geom.refR1 + geom.refR2);
	const StepBody &  one = bodies[id1], &two = bodies[id2];
	const rcr::Twist &v1 = solved.velocity[id1], &v2 = solved.velocity[id2];
	Body &      b1 = *(*scene.bodies)[id1], &b2 = *(*scene.bodies)[id2];
	bool        swap = false;
	const auto  functor = loop.geomDispatcher->getFunctor2D(b1.shape, b2.shape, swap);
	if (!functor || swap) return false;
	rcr::Manifold at[looks];
	for (int look = 0; look < looks; ++look)
		at[look] = after(dt * (look + 1) / looks, one, two, v1, v2, b1, b2, *functor);
	const rcr::Manifold begin   = geom.manifold();
	bool                changed = false;
	for (int k = 0; k < begin.count; ++k) {
		rcr::ContactPoint&       c   = solved.points[first + k];
		const double             gap = begin.points[k].gap, way = dt * relativeVelocity(c, v1, v2).n;
		double                   least = far;
		for (const rcr::Manifold& now : at)
			least = std::min(least, gapOf(now, k, begin.count, c.normal));
		int last = looks; // look at which it is still on this side
		while (last > 1 && through(at[last - 1], c.normal))
			--last;
		const double share = double(last) / looks, end = gapOf(at[last - 1], k, begin.count, c.normal);
		const bool   sinks  = (end < std::min(0.0, gap) - slop || last < looks) && std::isfinite(end);
		const bool   passes = letGo && solved.impulse[first + k].n > 0 && least > clear * slop && std::isfinite(least);
		if (phys.restitution > 0 && c.bias < 0) continue; // it bounces at the beginning of the step
		if (!sinks && !passes) continue;
		const double curve = sinks ? (end - gap - share * way) / (share * share) : 2 * least - gap - way; // 2: lets go where another one carries too
		const double bias  = (std::max(gap, 0.0) + curve) / dt;
		if (dt * std::abs(bias - c.bias) < clear * slop) continue; // what the tolerance of the solver leaves would come up again and again
		c.bias = phys.bias[k] = bias;
		changed               = true;
	}
	return changed;
}

} // namespace yade
