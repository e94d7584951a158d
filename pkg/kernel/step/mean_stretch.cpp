#include "step/mean_stretch.hpp"

namespace rcr {

namespace {

	constexpr int    sliceCount = 64;
	// largest change of the impulses through a slice, as a fraction
	constexpr double mostShare  = 0.5;

	struct Axis {
		double Vec2::*of;
		double PlanarVector::*speed;
		double InverseMass::*inverse;
	};
	constexpr Axis xAxis { &Vec2::x, &PlanarVector::x, &InverseMass::x },
	        yAxis { &Vec2::y, &PlanarVector::y, &InverseMass::y };

	/// Calls visit(body, position along the axis, mass) for all bodies that are free along it.
	template <class Visit> void forEachFree(const Step& step, const Axis& axis, Visit visit)
	{
		for (std::size_t id = 0; id < step.bodies.size(); ++id)
			if (const double w = step.problem.inverseMass[id].*axis.inverse; w > 0)
				visit(id, step.bodies[id].center.*axis.of, 1 / w);
	}

	double meanStretchRate(const Step& step, const Axis& axis)
	{
		double moment = 0, inertia = 0;
		forEachFree(step, axis, [&](std::size_t id, double r, double mass) {
			const PlanarVector change = step.problem.velocity[id] - step.bodies[id].velocity;
			moment += mass * r * change.*axis.speed;
			inertia += mass * r * r;
		});
		return inertia > 0 ? moment / inertia : 0;
	}

	/// One value per slice of equal width along an axis.
	class Slices {
	public:
		Slices(double low, double high)
		        : low_(low)
		        , width_((high - low) / sliceCount)
		        , value_(sliceCount)
		{
		}

		double& at(double r) { return value_[number(r)]; }
		/// Adds to each slice f times its fraction between two positions, or −f if the second lies
		/// below the first.
		void addBetween(double from, double to, double f)
		{
			const double low  = (std::min(from, to) - low_) / width_,
			             high = (std::max(from, to) - low_) / width_;
			for (int k = std::max(0, int(low)); k <= std::min(sliceCount - 1, int(high)); ++k)
				value_[k] += (to < from ? -f : f)
				        * std::max(0.0, std::min(high, k + 1.0) - std::max(low, double(k)));
		}
		/// Sums the slices from the outside towards the origin, with a negative sign below it.
		void sumTowardsOrigin()
		{
			const int first = number(0);
			for (int k = sliceCount - 2; k >= first; --k)
				value_[k] += value_[k + 1];
			for (int k = 0; k < first; ++k)
				value_[k] = (k > 0 ? value_[k - 1] : 0) - value_[k];
		}

	private:
		int number(double r) const
		{
			return int(std::clamp((r - low_) / width_, 0.0, sliceCount - 1.0));
		}

		double              low_, width_;
		std::vector<double> value_;
	};

	void removeDragImpulses(Step& step, const Axis& axis, double stretchRate)
	{
		double low = std::numeric_limits<double>::infinity(), high = -low;
		forEachFree(step, axis, [&](std::size_t, double r, double) {
			low = std::min(low, r), high = std::max(high, r);
		});
		if (stretchRate == 0 || !(high > low)) return;
		Slices beyond(low, high), through(low, high);
		forEachFree(step, axis,
		        [&](std::size_t, double r, double mass) { beyond.at(r) += mass * stretchRate * r; });
		beyond.sumTowardsOrigin();
		ContactProblem& problem = step.problem;
		const auto      place   = [&](const ContactPoint& c) {
            return (step.bodies[c.body1].center + c.arm1).*axis.of;
		};
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const ContactPoint& c   = problem.points[k];
			const Vec2          f   = toCartesian(c.normal, problem.impulse[k]);
			const auto end = [&](int id) {
				return problem.inverseMass[id].*axis.inverse > 0 ? step.bodies[id].center.*axis.of
				                                                 : place(c);
			};
			through.addBetween(end(c.body1), end(c.body2), f.*axis.of);
		}
		for (std::size_t k = 0; k < problem.points.size(); ++k) {
			const double at = place(problem.points[k]), all = through.at(at);
			if (all > 0)
				problem.impulse[k] = (1 - std::clamp(beyond.at(at) / all, -mostShare, mostShare))
				        * problem.impulse[k];
		}
	}

} // namespace

Vec2 meanStretchRate(const Step& step)
{
	return { meanStretchRate(step, xAxis), meanStretchRate(step, yAxis) };
}

void removeDragImpulses(Step& step, Vec2 stretchRate)
{
	removeDragImpulses(step, xAxis, stretchRate.x);
	removeDragImpulses(step, yAxis, stretchRate.y);
}

} // namespace rcr
