#include "sweep/lane/lane_check.hpp"

#include "sweep/lane/lane_records.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

namespace {

	using L = Lane<RCR_LANES>;

	L result(LaneOperation operation, L a, L b, L c)
	{
		switch (operation) {
			case LaneOperation::add: return a + b;
			case LaneOperation::subtract: return a - b;
			case LaneOperation::multiply: return a * b;
			case LaneOperation::divide: return a / b;
			case LaneOperation::addProduct: return addProduct(a, b, c);
			case LaneOperation::subtractProduct: return subtractProduct(a, b, c);
			case LaneOperation::min: return min(a, b);
			case LaneOperation::max: return max(a, b);
			case LaneOperation::abs: return abs(a);
			case LaneOperation::copySign: return copySign(a, b);
			case LaneOperation::select: return select(a <= b, b, c);
			case LaneOperation::zeroWhere: return zeroWhere(a <= b, c);
		}
		return a;
	}

	void apply(LaneOperation operation, const double* a, const double* b, const double* c,
	        double* out)
	{
		for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
			result(operation, L::load(a + lane), L::load(b + lane), L::load(c + lane))
			        .store(out + lane);
	}

	void moveBodies(double* records, const std::uint32_t* from, const std::uint32_t* to)
	{
		for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
			storeBodies<RCR_LANES>(
			        loadBodies<RCR_LANES>({ records, from + lane }), { records, to + lane });
	}

	void moveCenters(double* records, const std::uint32_t* from, const std::uint32_t* to)
	{
		for (int lane = 0; lane < blockWidth; lane += RCR_LANES)
			storeCenters<RCR_LANES>(
			        loadCenters<RCR_LANES>({ records, from + lane }), { records, to + lane });
	}

} // namespace

extern const LaneCheck check;
const LaneCheck        check { apply, moveBodies, moveCenters };

} // namespace rcr::RCR_LANE_NAMESPACE
