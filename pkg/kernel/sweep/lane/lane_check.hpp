// The operations of lane.hpp and lane_records.hpp as the kernels compile them, for tests.
// Each works on sixteen numbers or records, whatever the lane width.
#pragma once

#include "sweep/lane/packed_blocks.hpp"

namespace rcr {

/// Operations on (a, b, c). select: a <= b ? b : c; zero_where: a <= b ? 0 : c.
constexpr const char* laneOperations[] = { "add", "subtract", "multiply", "divide", "add_product",
	"subtract_product", "min", "max", "abs", "copy_sign", "select", "zero_where" };

struct LaneCheck {
	/// out = operation(a, b, c) for arrays of blockWidth numbers at multiples of 64 bytes.
	/// `operation`: index in laneOperations.
	void (*apply)(long operation, const double* a, const double* b, const double* c, double* out);
	/// Copies records, whole or halves, from the offsets `from` to the offsets `to`.
	void (*moveBodies)(double* records, const std::uint32_t* from, const std::uint32_t* to);
	void (*moveCenters)(double* records, const std::uint32_t* from, const std::uint32_t* to);
};

/// The check for the lanes that packedKernels(lanes) chooses.
const LaneCheck& laneCheck(int lanes);

} // namespace rcr
