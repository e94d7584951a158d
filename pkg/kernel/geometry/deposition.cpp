#include "geometry/deposition.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace rcr {

namespace {

	constexpr double infinity = std::numeric_limits<double>::infinity();
	constexpr double rounding = 1e-9; // overlap that counts as none, over a radius
	constexpr int    classes  = 8;    // intervals of radii

	struct Disc {
		Vec2   center;
		double radius;
	};

	double leg(double hypotenuse, double other)
	{
		return std::sqrt(hypotenuse * hypotenuse - other * other);
	}

	/// Two discs that may support a third one from below.
	struct Pair {
		Disc     left, right;
		double   distance;      // of the centres
		Vec2     unit;          // from left to right
		unsigned open = 0;      // bit k: a disc of class k may have a free place
		double   lowest = infinity; // bound of these places

		Pair(const Disc& a, const Disc& b)
		        : left(a.center.x <= b.center.x ? a : b)
		        , right(a.center.x <= b.center.x ? b : a)
		        , distance(norm(right.center - left.center))
		        , unit((1 / distance) * (right.center - left.center))
		{
		}

		/// Returns true if a disc of radius r touches both.
		bool supports(double r) const { return distance < left.radius + right.radius + 2 * r; }

		/// The upper one of its two places.
		Vec2 place(double r) const
		{
			const double a = left.radius + r, b = right.radius + r;
			const double along = (distance * distance + a * a - b * b) / (2 * distance);
			return left.center + along * unit + leg(a, along) * perp(unit);
		}

		/// Length of the path of the place over the change of r, at most, from this radius on:
		/// 1/cos(φ/2) with the angle φ between the contacts of the third disc.
		double slope(double r) const
		{
			const double difference = left.radius - right.radius;
			const double cosine     = 1
			        - (distance * distance - difference * difference)
			                / (2 * (left.radius + r) * (right.radius + r));
			return std::sqrt(2 / (1 + cosine));
		}
	};

	/// Places on a pair of all discs of a class of radii, from the smallest disc on.
	struct Path {
		Vec2   first;
		double radius, change, slope; // change: of the radius

		Path(const Pair& pair, double r, double end)
		        : first(pair.place(r)), radius(r), change(end - r), slope(pair.slope(r))
		{
		}

		/// Returns true if the disc overlaps all of them. The gap grows by at most slope − 1 per
		/// radius.
		bool isClosedBy(const Disc& disc) const
		{
			const double gap = norm(first - disc.center) - disc.radius - radius;
			return gap + change * (slope - 1) < -2 * rounding * (radius + change);
		}
	};

	/// Discs that can still support others, ordered by x, and the pairs with open places.
	class Surface {
	public:
		Surface(double width, double smallest, double largest)
		        : width_(width), smallest_(smallest), largest_(largest)
		{
		}

		Vec2 lowestPlace(double r) const
		{
			// of equal heights, the place whose supports lie to the left
			std::tuple<double, double, double> least { infinity, infinity, infinity };
			Vec2       lowest { 0, infinity };
			const auto offer = [&](Vec2 place, double left, double right) {
				const std::tuple<double, double, double> key { place.y, left, right };
				if (key < least && isFree(place, r)) lowest = place, least = key;
			};
			offer({ r, r }, -infinity, 0);
			offer({ width_ - r, r }, -infinity, 1);
			const auto offerWall = [&](const Disc& d, double x) {
				const double distance = d.radius + r;
				if (std::abs(x - d.center.x) < distance)
					offer({ x, d.center.y + leg(distance, x - d.center.x) }, d.center.x, -infinity);
			};
			for (auto d = discs_.begin(); d != discs_.end() && d->center.x < 2 * r + largest_; ++d)
				offerWall(*d, r);
			for (auto d = discs_.rbegin();
			     d != discs_.rend() && d->center.x > width_ - 2 * r - largest_; ++d)
				offerWall(*d, width_ - r);
			if (sealed_ <= r)
				for (const Disc& d : discs_)
					if (const double distance = d.radius + r; d.center.y - r < distance)
						for (const double side : { -1, 1 })
							offer({ d.center.x + side * leg(distance, d.center.y - r), r },
							        d.center.x, -infinity);
			const unsigned bit = 1u << classOf(r);
			for (const Pair& pair : pairs_)
				if ((pair.open & bit) && pair.lowest <= lowest.y && pair.supports(r))
					offer(pair.place(r), pair.left.center.x, pair.right.center.x);
			return lowest;
		}

		void add(const Disc& disc)
		{
			bool closes = false;
			for (Pair& pair : pairs_) {
				// from the left disc to the place, and on to the new disc
				if (std::abs(pair.left.center.x - disc.center.x) > 4 * largest_) continue;
				for (int k = 0; k < classes; ++k)
					if ((pair.open >> k & 1) && pair.supports(edge(k))
					        && pathOf(pair, k).isClosedBy(disc))
						pair.open &= ~(1u << k);
				closes = closes || pair.open == 0;
			}
			if (closes) removeClosedPairs();
			forEachNear(disc.center.x, disc.radius + 3 * largest_, [&](const Disc& other) {
				Pair pair(disc, other);
				if (!pair.supports(largest_)) return;
				findOpenClasses(pair);
				if (pair.open != 0) pairs_.push_back(pair);
			});
			const auto leftOf
			        = [](const Disc& a, const Disc& b) { return a.center.x < b.center.x; };
			discs_.insert(std::upper_bound(discs_.begin(), discs_.end(), disc, leftOf), disc);
		}

		/// Excludes positions below `level`, and removes the discs that support none above.
		void seal(double level)
		{
			sealed_ = level;
			const auto buried
			        = [&](const Disc& d) { return d.center.y + d.radius + largest_ < level; };
			discs_.erase(std::remove_if(discs_.begin(), discs_.end(), buried), discs_.end());
			removePairs([&](const Pair& pair) { return buried(pair.left) || buried(pair.right); });
			for (Pair& pair : pairs_)
				findOpenClasses(pair);
			removeClosedPairs();
		}

	private:
		double edge(int k) const { return smallest_ + (largest_ - smallest_) * k / classes; }
		int    classOf(double r) const
		{
			int k = 0;
			while (k < classes - 1 && r > edge(k + 1))
				++k;
			return k;
		}

		Path pathOf(const Pair& pair, int k) const { return { pair, edge(k), edge(k + 1) }; }

		template <class Remove> void removePairs(Remove remove)
		{
			pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(), remove), pairs_.end());
		}
		void removeClosedPairs()
		{
			removePairs([](const Pair& pair) { return pair.open == 0; });
		}

		/// Calls visit(disc) for the discs whose centres are less than `reach` from x.
		template <class Visit> void forEachNear(double x, double reach, Visit visit) const
		{
			auto disc = std::partition_point(discs_.begin(), discs_.end(),
			        [&](const Disc& d) { return d.center.x < x - reach; });
			for (; disc != discs_.end() && disc->center.x < x + reach; ++disc)
				visit(*disc);
		}

		bool isFree(Vec2 place, double r) const
		{
			const double least = rounding * r;
			if (place.x < r - least || place.x > width_ - r + least
			    || place.y < std::max(r, sealed_) - least)
				return false;
			bool free = true;
			forEachNear(place.x, r + largest_, [&](const Disc& d) {
				free = free && !(norm(place - d.center) < d.radius + r - least);
			});
			return free;
		}

		/// Sets `open` and `lowest`. A class stays open unless all its places are closed.
		void findOpenClasses(Pair& pair) const
		{
			pair.open = 0, pair.lowest = infinity;
			for (int k = 0; k < classes; ++k) {
				const double r = edge(k), end = edge(k + 1);
				if (!pair.supports(end)) continue;
				double lowest = -infinity;
				if (pair.supports(r)) {
					const Path   path = pathOf(pair, k);
					const Vec2   at   = path.first;
					const double way  = path.change * path.slope + 2 * rounding * end;
					if (at.y + way < std::max(r, sealed_) || at.x + way < r
					        || at.x - way > width_ - r)
						continue;
					bool closed = false;
					forEachNear(at.x, largest_ + r,
					        [&](const Disc& d) { closed = closed || path.isClosedBy(d); });
					if (closed) continue;
					lowest = at.y - way;
				}
				pair.open |= 1u << k;
				pair.lowest = std::min(pair.lowest, lowest);
			}
		}

		double            width_, smallest_, largest_, sealed_ = 0;
		std::vector<Disc> discs_;
		std::vector<Pair> pairs_;
	};

} // namespace

std::vector<Vec2> deposit(const std::vector<double>& radii, double width)
{
	std::vector<Vec2> centers;
	if (radii.empty()) return centers;
	const auto [smallest, largest] = std::minmax_element(radii.begin(), radii.end());
	Surface           surface(width, *smallest, *largest);
	const std::size_t layer
	        = std::max(100.0, width / (2 * *smallest)); // upper bound of the discs side by side
	double level = infinity;
	for (const double radius : radii) {
		centers.push_back(surface.lowestPlace(radius));
		surface.add({ centers.back(), radius });
		level = std::min(level, centers.back().y);
		if (centers.size() % layer == 0) { // pores that no disc of the layer has entered stay empty
			surface.seal(level);
			level = infinity;
		}
	}
	return centers;
}

} // namespace rcr
