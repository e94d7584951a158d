// The operations of lane.hpp and lane_records.hpp as the kernels compile them, for tests: each on sixteen numbers or records, whatever
// the width.
#pragma once

#include "sweep/lane/packed_blocks.hpp"

namespace rcr {

enum class LaneOperation { add, subtract, multiply, divide, addProduct, subtractProduct, min, max, abs, copySign, select, zeroWhere };

struct LaneCheck {
	int width;
	/// out = operation(a, b, c); select and zeroWhere choose by a <= b: between b and c, or c and 0. Arrays of blockWidth, aligned.
	void (*apply)(LaneOperation, const double* a, const double* b, const double* c, double* out);
	/// Records from the offsets `from` to the offsets `to`, whole or the first halves.
	void (*moveBodies)(HalfRecord*, const std::uint32_t* from, const std::uint32_t* to);
	void (*moveCentres)(HalfRecord*, const std::uint32_t* from, const std::uint32_t* to);
};

/// For the same choice of lanes as packedKernels.
const LaneCheck& laneCheck(int lanes);

} // namespace rcr
