#include "detection/neighbors.hpp"

#include "detection/late_contacts.hpp"
#include "problem/list_by_key.hpp"

namespace rcr {

constexpr double stepsAhead = 12;             // steps that a margin lasts
constexpr double least = 0.05, most = 0.6;    // margin over the mean inscribed radius
// the list is repaired if at most 1/50 of the bodies moved
constexpr int    repairFraction = 50;
constexpr int    bodiesPerPart = 256;
constexpr int    mostCellsPerGrain = 4;

/// Returns true if the shape has not changed. A core of two vertices may move, turn and stretch in
/// the frame of its body; `displacement` contains this motion.
static bool isSame(const PlanarShape& one, const PlanarShape& two)
{
	return one.kind == two.kind && one.axis == two.axis && one.sense == two.sense
	        && one.rounding == two.rounding
	        && (one.core == two.core || (one.core && two.core && *one.core == *two.core));
}

/// Largest displacement of a point of the surface of a body [m].
double Neighbors::displacement(const Reference& at, const StepBody& body)
{
	const PlanarShape &before = at.shape, &now = body.shape;
	const Pose&        from   = at.pose;
	const Pose         to     = body.pose();
	if (now.kind == PlanarShape::wall)
		return now.axis == 0 ? std::abs(to.center.x - from.center.x)
		                     : std::abs(to.center.y - from.center.y);
	const double arm = now.radius() - now.rounding;
	return norm(to.center - from.center) + arm * norm(to.axis - from.axis)
	        + norm(now.offset - before.offset)
	        + now.halfLength * norm(now.direction - before.direction)
	        + std::abs(now.halfLength - before.halfLength);
}

/// The value with `count` smaller or equal ones; 0 without values.
static double ranked(std::vector<double>& values, std::size_t count)
{
	if (values.empty()) return 0;
	std::nth_element(values.begin(), values.begin() + count, values.end());
	return values[count];
}

/// The value with `count` larger or equal ones; 0 without values.
static double rankedFromTop(std::vector<double>& values, std::size_t count)
{
	return ranked(values, values.size() - 1 - count);
}

/// Interval of all but 1 % of the values, so that a few distant grains do not enlarge the grid.
static std::pair<double, double> bulk(std::vector<double>& x)
{
	const std::size_t few = x.size() / 200;
	return { ranked(x, few), rankedFromTop(x, few) };
}

/// ℓ of a body.
double Neighbors::reach(const Step& step, const StepBody& body)
{
	const double toImages
	        = step.cell.periodic ? imageReach(body.shape, step.cell.imageSpeed, step.dt) : 0;
	return body.alertDistance + toImages;
}

void Neighbors::setReference(std::size_t id, const Step& step)
{
	const StepBody& body = step.bodies[id];
	reference_[id] = { body.shape, { toReference(body.center), body.pose().axis }, reach(step, body),
		body.owner };
}

/// Computes F, F⁻¹ and ε.
void Neighbors::deform(const PeriodicCell& now)
{
	double square = 0;
	for (int i = 0; i < 2; ++i)
		for (int j = 0; j < 2; ++j) {
			forward_[i][j]  = now.h[i][0] * cell_.inverse[0][j] + now.h[i][1] * cell_.inverse[1][j];
			backward_[i][j] = cell_.h[i][0] * now.inverse[0][j] + cell_.h[i][1] * now.inverse[1][j];
			const double change = backward_[i][j] - (i == j);
			square += change * change;
		}
	strain_ = std::sqrt(square);
}

/// Left-hand side of the condition [m].
double Neighbors::movedDistance(const Reference& at, const Step& step, const StepBody& body) const
{
	if (!cell_.periodic) return displacement(at, body) + body.alertDistance - at.alertDistance;
	Reference carried   = at;
	carried.pose.center = product(forward_, at.pose.center);
	const double now    = reach(step, body);
	return (1 + strain_) * displacement(carried, body) + now - at.alertDistance
	        + strain_ * (body.shape.radius() + now);
}

/// Lists the bodies that violate the condition; returns false if the shape of a body changed.
bool Neighbors::findMovedBodies(const Step& step, ThreadTeam& team)
{
	moved_.clear();
	if (reference_.size() != step.bodies.size() || cell_.periodic != step.cell.periodic)
		return false;
	if (cell_.periodic) deform(step.cell);
	std::atomic<bool> same { true };
	isSearched_.assign(reference_.size(), false);
	team.forEach(reference_.size(), [&](std::size_t id) {
		const StepBody& body = step.bodies[id];
		const Reference& at   = reference_[id];
		if (body.shape.kind == PlanarShape::none && at.shape.kind == PlanarShape::none) return;
		if (!isSame(at.shape, body.shape) || at.owner != body.owner)
			same.store(false, std::memory_order_relaxed);
		else
			isSearched_[id] = movedDistance(at, step, body) > margin_;
	});
	if (!same) return false;
	for (std::size_t id = 0; id < isSearched_.size(); ++id)
		if (isSearched_[id]) moved_.push_back(std::int32_t(id));
	return true;
}

bool Neighbors::update(const Step& step, ThreadTeam& team)
{
	const bool same = findMovedBodies(step, team);
	current_        = true;
	if (same && moved_.empty()) return false;
	const std::size_t few   = reference_.size() / repairFraction,
	                  leave = std::count_if(moved_.begin(), moved_.end(),
	                          [&](std::int32_t id) { return !isWide_[id]; });
	if (same && moved_.size() <= few && wide_.size() + leave <= wideAtFirst_ + few)
		repair(step, team);
	else
		findAll(step, team);
	return true;
}

void Neighbors::chooseMargin()
{
	std::vector<double> paths;
	double              radii = 0;
	int                 grains = 0;
	paths.reserve(reference_.size());
	for (const Reference& body : reference_) {
		if (body.shape.kind == PlanarShape::none) continue;
		paths.push_back(0.5 * body.alertDistance); // the alert distance is twice the path of a step
		if (!body.shape.grain()) continue;
		radii += body.shape.inscribedRadius();
		++grains;
	}
	const double radius = grains > 0 ? radii / grains : 0;
	// exceeded by at most 0.2 % of the bodies, a tenth of those that a repair may move
	const double path = rankedFromTop(paths, paths.size() / (10 * repairFraction));
	margin_           = std::clamp(stepsAhead * path, least * radius, most * radius);
}

/// Sorts grains into cells, except for the widest, which search their surroundings.
void Neighbors::sortIntoCells()
{
	std::vector<double>       extents, x, y;
	std::vector<std::int32_t> grains;
	isWide_.assign(reference_.size(), true);
	wide_.clear();
	for (std::size_t id = 0; id < reference_.size(); ++id) {
		if (reference_[id].shape.kind == PlanarShape::none) continue;
		if (!reference_[id].shape.grain()) {
			wide_.push_back(std::int32_t(id));
			continue;
		}
		x.push_back(reference_[id].pose.center.x), y.push_back(reference_[id].pose.center.y);
		grains.push_back(std::int32_t(id));
		extents.push_back(extent(reference_[id]));
	}
	std::vector<double> ordered = extents;
	const std::size_t   exempt
	        = std::min(extents.size() - 1, std::size_t(std::sqrt(double(extents.size()))));
	const double widest      = rankedFromTop(ordered, exempt);
	const auto [left, right] = bulk(x);
	const auto [low, high]   = bulk(y);
	Vec2 size { right - left, high - low };
	if (cell_.periodic) // heights of the cell
		size = { cell_.area() / std::hypot(cell_.h[0][1], cell_.h[1][1]),
			cell_.area() / std::hypot(cell_.h[0][0], cell_.h[1][0]) };
	width_ = std::max({ 2 * widest,
	        std::sqrt(size.x * size.y / (mostCellsPerGrain * double(grains.size() + 1))),
	        std::max(size.x, size.y) / 10000 });
	if (!(width_ > 0)) width_ = 1;
	origin_  = { left, low };
	columns_ = std::max(1, int(size.x / width_) + !cell_.periodic);
	rows_    = std::max(1, int(size.y / width_) + !cell_.periodic);
	mostEdges_ = { 0.5 + 3 * margin_ / size.x, 0.5 + 3 * margin_ / size.y };
	std::vector<std::int32_t> cell(grains.size());
	for (std::size_t k = 0; k < grains.size(); ++k) {
		if (extents[k] > widest) {
			wide_.push_back(grains[k]);
			cell[k] = -1;
			continue;
		}
		isWide_[grains[k]] = false;
		const Vec2 at = place(reference_[grains[k]].pose.center);
		cell[k] = range(at.y, at.y, rows_).first * columns_ + range(at.x, at.x, columns_).first;
	}
	listByKey(std::size_t(columns_) * rows_, firstIn_, inCells_, [&](auto add) {
		for (std::size_t k = 0; k < grains.size(); ++k)
			if (cell[k] >= 0) add(cell[k], grains[k]);
	});
}

Vec2 Neighbors::place(Vec2 x0) const
{
	if (!cell_.periodic) return { (x0.x - origin_.x) / width_, (x0.y - origin_.y) / width_ };
	const Vec2 edges = product(cell_.inverse, x0);
	return { edges.x * columns_, edges.y * rows_ };
}

Neighbors::Range Neighbors::range(double low, double high, int count) const
{
	if (!cell_.periodic) {
		// 0 for NaN: places that overflow end in an error of the solved velocities
		const auto clipped = [&](double at) {
			return at > 0 ? int(std::min(at, count - 1.0)) : 0;
		};
		return { clipped(low), clipped(high) - clipped(low) + 1 };
	}
	const double first = std::floor(low), number = std::floor(high) - first + 1;
	return { int(first - count * std::floor(first / count)), int(std::min<double>(number, count)) };
}

bool Neighbors::nearImage(const Reference& one, const Reference& two, Vec2 shift) const
{
	const double maxGap = one.alertDistance + two.alertDistance + 2 * margin_;
	const double limit  = maxGap * (1 + 1e-9);
	const Pose   image  = shifted(two.pose, shift);
	if (!mayTouch(one.shape, one.pose, two.shape, image, limit)) return false;
	const bool bounded = one.shape.grain() && !one.shape.core && !two.shape.core;
	return bounded || contactPoints(one.shape, one.pose, two.shape, image, limit).count > 0;
}

bool Neighbors::near(std::int32_t body1, std::int32_t body2) const
{
	const Reference &one = reference_[body1], &two = reference_[body2];
	if (one.owner == two.owner) return false;
	if (!cell_.periodic) return nearImage(one, two, {});
	// images that may be the nearest one before the list expires
	const Vec2 between = one.pose.center - two.pose.center + one.shape.offset - two.shape.offset,
	           edges   = product(cell_.inverse, between);
	for (double i = std::ceil(edges.x - mostEdges_.x); i <= edges.x + mostEdges_.x; ++i)
		for (double j = std::ceil(edges.y - mostEdges_.y); j <= edges.y + mostEdges_.y; ++j)
			if (nearImage(one, two, product(cell_.h, { i, j }))) return true;
	return false;
}

void Neighbors::searchNarrow(ThreadTeam& team)
{
	const int parts = int((reference_.size() + bodiesPerPart - 1) / bodiesPerPart);
	found_.resize(parts);
	team.parallelFor(0, parts, [&](int part) {
		List& found = found_[part];
		found.clear();
		for (std::size_t id = std::size_t(part) * bodiesPerPart;
		        id < std::min(reference_.size(), std::size_t(part + 1) * bodiesPerPart); ++id) {
			if (isWide_[id]) continue;
			const std::size_t begin  = found.size();
			const double      around = extent(reference_[id]) + 0.5 * width_;
			forEachGrain({ reference_[id].pose.center, { around, around } }, [&](std::int32_t other) {
				if (comesFirst(reference_[id].shape, int(id), reference_[other].shape, other)
				        && near(std::int32_t(id), other))
					found.push_back({ std::int32_t(id), other });
			});
			std::sort(found.begin() + begin, found.end());
		}
	});
	list_.clear();
	for (const List& found : found_)
		list_.insert(list_.end(), found.begin(), found.end());
}

/// Adds the pairs of some wide bodies, each pair once.
void Neighbors::searchAround(const std::vector<std::int32_t>& bodies, ThreadTeam& team)
{
	found_.resize(bodies.size());
	team.parallelFor(0, int(bodies.size()), [&](int k) {
		const std::int32_t id = bodies[k];
		found_[k].clear();
		const auto take = [&](std::int32_t other) {
			const bool ordered
			        = comesFirst(reference_[id].shape, id, reference_[other].shape, other);
			const auto pair    = ordered ? std::make_pair(id, other) : std::make_pair(other, id);
			if (canTouch(reference_[pair.first].shape.kind, reference_[pair.second].shape.kind)
			        && near(pair.first, pair.second))
				found_[k].push_back(pair);
		};
		const auto [center, half] = boundsOf(reference_[id].shape, reference_[id].pose);
		const double around       = reference_[id].alertDistance + margin_ + 0.5 * width_;
		forEachGrain({ center, half + Vec2 { around, around } }, take);
		for (std::int32_t other : wide_)
			if (other > id || (other < id && !isSearched_[other])) take(other);
	});
	const std::size_t before = list_.size();
	for (const List& found : found_)
		list_.insert(list_.end(), found.begin(), found.end());
	std::sort(list_.begin() + before, list_.end());
	std::inplace_merge(list_.begin(), list_.begin() + before, list_.end());
}

void Neighbors::findAll(const Step& step, ThreadTeam& team)
{
	reference_.resize(step.bodies.size());
	cell_ = step.cell;
	if (cell_.periodic) deform(cell_);
	team.forEach(reference_.size(), [&](std::size_t id) { setReference(id, step); });
	chooseMargin();
	sortIntoCells();
	searchNarrow(team);
	wideAtFirst_ = wide_.size();
	isSearched_ = isWide_; // each pair of two wide bodies is found once
	searchAround(wide_, team);
}

/// Removes moved bodies from their cells and searches their pairs again.
void Neighbors::repair(const Step& step, ThreadTeam& team)
{
	for (std::int32_t id : moved_) {
		setReference(id, step);
		if (!isWide_[id]) wide_.push_back(id);
		isWide_[id] = true;
	}
	const auto moved = [&](const auto& pair) {
		return isSearched_[pair.first] || isSearched_[pair.second];
	};
	list_.erase(std::remove_if(list_.begin(), list_.end(), moved), list_.end());
	searchAround(moved_, team);
}

} // namespace rcr
