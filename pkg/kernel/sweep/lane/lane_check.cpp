#include "sweep/lane/lane_check.hpp"

#include "sweep/lane/lane_records.hpp"

namespace rcr::RCR_LANE_NAMESPACE {

namespace {

	using L = Lane<RCR_LANES>;

	void apply(long operation, const double* x, const double* y, const double* z, double* out)
	{
		for (int lane = 0; lane < blockWidth; lane += RCR_LANES) {
			const L a = L::load(x + lane), b = L::load(y + lane), c = L::load(z + lane);
			const L results[] = { a + b, a - b, a * b, a / b, addProduct(a, b, c),
				subtractProduct(a, b, c), min(a, b), max(a, b), abs(a), copySign(a, b),
				select(a <= b, b, c), zeroWhere(a <= b, c) }; // in the order of laneOperations
			results[operation].store(out + lane);
		}
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
