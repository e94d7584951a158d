#include "correction/separation.hpp"

#include "problem/coulomb.hpp"
#include "detection/large_displacements.hpp"

namespace rcr {

namespace {

	constexpr int    mostSweeps = 200;
	constexpr double trigger    = 10;  // least overlap over the slop at which bodies are separated
	constexpr double tolerance  = 1;   // of an overlap, over the slop
	constexpr double kept       = 0.5; // share of an overlap that a large displacement may keep

	class Separation {
	public:
		Separation(Step& step, const Search& search)
		        : step_(step), search_(search), queued_(step.contacts.size())
		{
		}

		double run(bool displace)
		{
			double deepest = 0;
			for (std::size_t k = 0; k < step_.contacts.size(); ++k) {
				const StepContact& c = step_.contacts[k];
				if (isPrescribed(c)) continue;
				const bool isLarge = hasLargeDisplacement(step_, c);
				if (!isLarge && !endsInside(c)) continue;
				if (isLarge && c.count > 0
				        && passedThrough(step_, c, step_.problem.points[c.first].normal,
				                solvedPointsAfter(step_, c, step_.dt), step_.dt)) {
					step_.intruding = { c.body1, c.body2 };
					return 1;
				}
				if (isLarge && step_.intruding.none() && intrudesOnPath(step_, c))
					step_.intruding = { c.body1, c.body2 };
				const double at = violation(c);
				if (at > 0) enqueue(int(k));
				deepest = std::max(deepest, at);
			}
			if (!queue_.empty() && displace) deepest = displaceBodies();
			return step_.intruding.none() ? deepest : 1;
		}

	private:
		/// Returns the deepest violation that is left [-].
		double displaceBodies()
		{
			if (step_.displacement.empty()) step_.displacement.resize(step_.bodies.size());
			for (int sweeps = mostSweeps; sweeps > 0 && !queue_.empty(); addReached()) {
				indexContacts();
				for (; sweeps > 0 && !queue_.empty(); --sweeps)
					sweep();
			}
			return deepestViolation();
		}

		Step&                         step_;
		const Search&                 search_;
		std::vector<StepContact>      reached_; // contacts that the step lacks
		std::vector<bool>             queued_, touched_;
		std::vector<int>              queue_;
		std::vector<std::vector<int>> contactsOf_; // per body, or per clump

		/// Number of the contacts of the step and of reached ones, which follow.
		std::size_t count() const { return step_.contacts.size() + reached_.size(); }

		const StepContact& contact(std::size_t k) const
		{
			const std::size_t listed = step_.contacts.size();
			return k < listed ? step_.contacts[k] : reached_[k - listed];
		}

		/// Adds the contacts that displaced bodies reach, and enqueues those with an overlap.
		void addReached()
		{
			reached_ = contactsOfDisplaced(step_, search_);
			queued_.resize(count());
			for (std::size_t k = step_.contacts.size(); k < count(); ++k)
				if (!isPrescribed(contact(k)) && violation(contact(k)) > 0) enqueue(int(k));
		}

		void sweep()
		{
			std::vector<int> contacts;
			contacts.swap(queue_);
			std::sort(contacts.begin(), contacts.end());
			for (int k : contacts)
				queued_[k] = false;
			for (int k : contacts)
				separate(k);
		}

		/// Deepest violation that is left [-].
		double deepestViolation() const
		{
			double deepest = 0;
			for (std::size_t k = 0; k < count(); ++k) {
				const StepContact& c      = contact(k);
				const bool         listed = k < step_.contacts.size();
				if (isPrescribed(c)) continue;
				if (listed && !touched_[k] && !hasLargeDisplacement(step_, c)) continue;
				deepest = std::max(deepest, violation(c));
			}
			return deepest;
		}

		void enqueue(int k)
		{
			if (!queued_[k]) queue_.push_back(k);
			queued_[k] = true;
		}

		void indexContacts()
		{
			touched_.resize(count());
			contactsOf_.assign(step_.bodies.size(), {});
			for (std::size_t k = 0; k < count(); ++k) {
				const StepContact& c = contact(k);
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
		double violation(const StepContact& c) const
		{
			const double at = pointsAtEnd(c).deepest();
			return at > std::max(allowed(c), trigger * c.slop()) ? at / c.size : 0;
		}

		/// Returns true if a point of the contact ends above 10 slops of overlap at its velocity.
		bool endsInside(const StepContact& c) const
		{
			for (int k = c.first; k < c.first + c.count; ++k) {
				const double u = relativeVelocity(step_.problem, step_.problem.points[k]).n;
				if (step_.gap[k].atStart + step_.dt * u < -trigger * c.slop()) return true;
			}
			return false;
		}

		/// The contact with the image at which the strain of the cell has placed body 2.
		StepContact strained(StepContact c) const
		{
			c.shift = c.shift + componentwise(step_.strain, c.shift);
			return c;
		}

		/// Contact points at the end. If displacements have pushed one body through the other, the
		/// normals are reversed, and the overlaps lead back to the side before.
		Manifold pointsAtEnd(const StepContact& c) const
		{
			Manifold at = pointsAfter(step_, strained(c), step_.dt,
			        [&](int id) { return step_.velocityToEnd(id); });
			if (at.count == 0 || step_.displacement.empty()) return at;
			const Manifold before = solvedPointsAfter(step_, c, step_.dt);
			if (before.count == 0 || dot(before.points[0].normal, at.points[0].normal) >= 0)
				return at;
			const double radii = inscribedRadii(step_, c);
			for (ManifoldPoint& point : at.points) {
				point.normal = -point.normal;
				point.gap    = -radii - std::abs(point.gap + radii);
			}
			return at;
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
			const StepContact& c   = contact(number);
			const Manifold     at  = pointsAtEnd(c);
			const int          id1 = step_.bodies[c.body1].owner, id2 = step_.bodies[c.body2].owner;
			const InverseMass  m1 = inverseMass(id1), m2 = inverseMass(id2);
			PlanarVector &     d1 = step_.displacement[id1], &d2 = step_.displacement[id2];
			PlanarVector       moved1, moved2; // by this contact
			touched_[number] = true;
			bool displaced   = false;
			for (int k = 0; k < at.count; ++k) {
				ContactPoint point;
				point.normal = at.points[k].normal;
				const auto center = [&](int id) {
					const PlanarVector v = step_.velocityToEnd(id);
					return step_.bodies[id].center + step_.dt * Vec2 { v.x, v.y };
				};
				point.arm1 = at.points[k].position - center(id1);
				point.arm2 = at.points[k].position
				        - (center(id2) + strained(c).shift + step_.dt * c.drift);
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
				if (!inverseMass(id).prescribed())
					for (int k : contactsOf_[id])
						enqueue(k);
		}

		/// Bodies whose contacts yield are not displaced.
		InverseMass inverseMass(int id) const
		{
			return step_.problem.hasYielded(id) ? InverseMass {} : step_.problem.inverseMass[id];
		}
	};

} // namespace

double separate(Step& step, bool displace, const Search& search)
{
	return Separation(step, search).run(displace);
}

} // namespace rcr
