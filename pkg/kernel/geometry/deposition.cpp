#include "geometry/deposition.hpp"

#include <algorithm>
#include <limits>

namespace rcr {

namespace {

	struct Disc {
		Vec2   center;
		double radius;
	};

	/// Discs that can still support others, ordered by x.
	class Surface {
	public:
		Surface(double width, double largest) : width_(width), largest_(largest) { }

		Vec2 lowestPlace(double r) const
		{
			Vec2       lowest { 0, std::numeric_limits<double>::infinity() };
			const auto offer = [&](Vec2 place) {
				if (place.y < lowest.y && isFree(place, r)) lowest = place;
			};
			offer({ r, r });
			offer({ width_ - r, r });
			for (auto a = discs_.begin(); a != discs_.end(); ++a) {
				const double distance = a->radius + r;
				for (const double x : { r, width_ - r })
					if (std::abs(x - a->center.x) < distance)
						offer({ x, a->center.y + leg(distance, x - a->center.x) });
				if (a->center.y - r < distance)
					for (const double side : { -1, 1 })
						offer({ a->center.x + side * leg(distance, a->center.y - r), r });
				for (auto b = a + 1;
				     b != discs_.end() && b->center.x - a->center.x < distance + r + largest_; ++b)
					offerBetween(*a, *b, r, offer);
			}
			return lowest;
		}

		void add(const Disc& disc)
		{
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
		}

	private:
		static double leg(double hypotenuse, double other)
		{
			return std::sqrt(hypotenuse * hypotenuse - other * other);
		}

		bool isFree(Vec2 place, double r) const
		{
			const double rounding = 1e-9 * r;
			if (place.x < r - rounding || place.x > width_ - r + rounding
			    || place.y < std::max(r, sealed_) - rounding)
				return false;
			const double left = place.x - r - largest_, right = place.x + r + largest_;
			auto disc = std::partition_point(discs_.begin(), discs_.end(), [left](const Disc& d) {
				return d.center.x < left;
			});
			for (; disc != discs_.end() && disc->center.x < right; ++disc)
				if (norm(place - disc->center) < disc->radius + r - rounding) return false;
			return true;
		}

		/// The upper of the two positions that touch both discs; b is to the right of a.
		template <class Offer>
		static void offerBetween(const Disc& a, const Disc& b, double r, Offer offer)
		{
			const Vec2   ab = b.center - a.center;
			const double d = norm(ab), distanceA = a.radius + r, distanceB = b.radius + r;
			if (d >= distanceA + distanceB) return;
			const double along = (d * d + distanceA * distanceA - distanceB * distanceB) / (2 * d);
			const Vec2   unit  = (1 / d) * ab;
			offer(a.center + along * unit + leg(distanceA, along) * perp(unit));
		}

		double            width_, largest_, sealed_ = 0;
		std::vector<Disc> discs_;
	};

} // namespace

std::vector<Vec2> deposit(const std::vector<double>& radii, double width)
{
	std::vector<Vec2> centers;
	if (radii.empty()) return centers;
	const auto [smallest, largest] = std::minmax_element(radii.begin(), radii.end());
	Surface           surface(width, *largest);
	const std::size_t layer
	        = std::max(100.0, width / (2 * *smallest)); // upper bound of the discs side by side
	double level = std::numeric_limits<double>::infinity();
	for (const double radius : radii) {
		centers.push_back(surface.lowestPlace(radius));
		surface.add({ centers.back(), radius });
		level = std::min(level, centers.back().y);
		if (centers.size() % layer == 0) { // pores that no disc of the layer has entered stay empty
			surface.seal(level);
			level = std::numeric_limits<double>::infinity();
		}
	}
	return centers;
}

} // namespace rcr
