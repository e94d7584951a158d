#include "correction/separation.hpp"

#include "problem/coulomb.hpp"
#include "correction/large_displacements.hpp"

namespace rcr {

namespace {

	constexpr int    mostSweeps = 200;
	constexpr double trigger    = 10;  // least overlap over the slop at which bodies are separated
	constexpr double tolerance  = 1;   // of an overlap, over the slop
	constexpr double kept       = 0.5; // share of an overlap that a large displacement may keep

	class Separation {
	public:
		explicit Separation(Step& step) : step_(step), queued_(step.contacts.size())
		{
		}

		double run(bool displace)
		{
			double deepest = 0;
			for (std::size_t k = 0; k < step_.contacts.size(); ++k) {
				const StepContact& c = step_.contacts[k];
				if (isPrescribed(c)) continue;
				const bool isLarge = hasLargeDisplacement(step_, c);
				if (!isLarge && !closes(c)) continue;
				if (isLarge && c.count > 0
				        && passedThrough(step_, c, step_.problem.points[c.first].normal,
				                solvedPointsAfter(step_, c, step_.dt), step_.dt))
					return 1;
				const double at = excess(c);
				if (at > 0) enqueue(int(k));
				deepest = std::max(deepest, at);
			}
			if (queue_.empty() || !displace) return deepest;
			if (step_.displacement.empty()) step_.displacement.resize(step_.bodies.size());
			indexContacts();
			std::vector<int> sweep;
			for (int count = 0; count < mostSweeps && !queue_.empty(); ++count) {
				sweep.clear();
				sweep.swap(queue_);
				std::sort(sweep.begin(), sweep.end());
				for (int k : sweep)
					queued_[k] = false;
				for (int k : sweep)
					separate(k);
			}
			deepest = 0;
			for (std::size_t k = 0; k < touched_.size(); ++k) {
				const StepContact& c = step_.contacts[k];
				if (isPrescribed(c) || !(touched_[k] || hasLargeDisplacement(step_, c))) continue;
				deepest = std::max(deepest, excess(c));
			}
			return deepest;
		}

	private:
		Step&                         step_;
		std::vector<bool>             queued_, touched_;
		std::vector<int>              queue_;
		std::vector<std::vector<int>> contactsOf_; // per body, or per clump

		void enqueue(int k)
		{
			if (!queued_[k]) queue_.push_back(k);
			queued_[k] = true;
		}

		void indexContacts()
		{
			touched_.resize(step_.contacts.size());
			contactsOf_.resize(step_.bodies.size());
			for (std::size_t k = 0; k < step_.contacts.size(); ++k) {
				const StepContact& c = step_.contacts[k];
				contactsOf_[step_.bodies[c.body1].owner].push_back(int(k));
				contactsOf_[step_.bodies[c.body2].owner].push_back(int(k));
			}
		}

		bool isPrescribed(const StepContact& c) const
		{
			const auto prescribed
			        = [&](int id) { return step_.problem.prescribed(step_.bodies[id].owner); };
			return prescribed(c.body1) && prescribed(c.body2);
		}

		/// Overlap at the end over R₁ + R₂ if it exceeds 10 slops and its bound [-]; else 0.
		double excess(const StepContact& c) const
		{
			const double at = pointsAtEnd(c).deepest();
			return at > std::max(allowed(c), trigger * c.slop()) ? at / c.size : 0;
		}

		/// Returns true if a point of the contact ends with an overlap at its velocity.
		bool closes(const StepContact& c) const
		{
			for (int k = c.first; k < c.first + c.count; ++k) {
				const double u = relativeVelocity(step_.problem, step_.problem.points[k]).n;
				if (step_.gap[k].atStart + step_.dt * u < -trigger * c.slop()) return true;
			}
			return false;
		}

		PlanarVector displacement(int id) const
		{
			return step_.displacement.empty() ? PlanarVector {} : step_.displacement[id];
		}

		Manifold pointsAtEnd(const StepContact& c) const
		{
			return pointsAfter(step_, c, step_.dt, [&](int id) {
				return step_.problem.velocity[id] + displacement(id) / step_.dt;
			});
		}

		/// Overlap that the contact may have at the end of the step [m].
		double allowed(const StepContact& c) const
		{
			double deepest = 0;
			for (int k = 0; k < c.count; ++k)
				deepest = std::max(deepest, -step_.gap[c.first + k].atStart);
			return (hasLargeDisplacement(step_, c) ? kept : 1) * deepest + c.slop();
		}

		void separate(int number)
		{
			const StepContact& c   = step_.contacts[number];
			const Manifold     at  = pointsAtEnd(c);
			const int          id1 = step_.bodies[c.body1].owner, id2 = step_.bodies[c.body2].owner;
			const InverseMass &m1 = step_.problem.inverseMass[id1],
			                  &m2 = step_.problem.inverseMass[id2];
			PlanarVector &     d1 = step_.displacement[id1], &d2 = step_.displacement[id2];
			PlanarVector       moved1, moved2; // by this contact
			touched_[number] = true;
			bool displaced   = false;
			for (int k = 0; k < at.count; ++k) {
				ContactPoint point;
				point.normal = at.points[k].normal;
				const auto center = [&](int id) {
					const PlanarVector &v = step_.problem.velocity[id], &d = step_.displacement[id];
					return step_.bodies[id].center
					        + Vec2 { step_.dt * v.x + d.x, step_.dt * v.y + d.y };
				};
				point.arm1 = at.points[k].position - center(id1);
				point.arm2 = at.points[k].position - (center(id2) + c.shift + step_.dt * c.drift);
				const double gap = at.points[k].gap + relativeVelocity(point, moved1, moved2).n;
				const double surplus = -gap - allowed(c);
				if (surplus <= tolerance * c.slop()) continue;
				const double compliance = delassus(point, m1, m2).nn;
				if (!(compliance > 0)) continue;
				const LocalVector push { surplus / compliance, 0 };
				applyImpulse(point, push, m1, m2, moved1, moved2);
				displaced = true;
			}
			if (!displaced) return;
			d1 = d1 + moved1, d2 = d2 + moved2;
			enqueue(number);
			for (int id : { id1, id2 })
				if (!step_.problem.prescribed(id))
					for (int k : contactsOf_[id])
						enqueue(k);
		}
	};

} // namespace

double separate(Step& step, bool displace) { return Separation(step).run(displace); }

} // namespace rcr
