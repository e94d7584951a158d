// The operations of lane.hpp and lane_records.hpp as the kernels compile them, for tests.
// Each works on sixteen numbers or records, whatever the lane width.
#pragma once

#include "sweep/lane/packed_blocks.hpp"

namespace rcr {

enum class LaneOperation {
	add, subtract, multiply, divide, addProduct, subtractProduct, min, max, abs, copySign, select,
	zeroWhere
};

struct LaneCheck {
	/// out = operation(a, b, c) for arrays of blockWidth numbers at multiples of 64 bytes.
	/// select: a <= b ? b : c; zeroWhere: a <= b ? 0 : c.
	void (*apply)(LaneOperation, const double* a, const double* b, const double* c, double* out);
	/// Copies records, whole or halves, from the offsets `from` to the offsets `to`.
	void (*moveBodies)(double* records, const std::uint32_t* from, const std::uint32_t* to);
	void (*moveCenters)(double* records, const std::uint32_t* from, const std::uint32_t* to);
};

/// The check for the lanes that packedKernels(lanes) chooses.
const LaneCheck& laneCheck(int lanes);

} // namespace rcr
