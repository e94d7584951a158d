// Which of the compiled lane widths runs on this processor.
#include "sweep/packed_blocks.hpp"
#include "delassus/packed_rows.hpp"

namespace rcr {

// packed_kernels.cpp and row_kernels.cpp, compiled once for each
#define RCR_COMPILED(lanes) \
	namespace lanes { \
		extern const PackedKernels kernels; \
		extern const RowKernels    rowKernels; \
	}
RCR_COMPILED(lanes1)
RCR_COMPILED(lanes4)
RCR_COMPILED(lanes8) // two halves a lane where there is no AVX-512
#ifdef RCR_X86
RCR_COMPILED(fma1) // one lane with FMA in hardware
RCR_COMPILED(avx512)
#endif

namespace {

	struct Kernels {
		const PackedKernels& packed;
		const RowKernels&    rows;
	};

	Kernels chosen(int lanes)
	{
#ifdef RCR_X86
		static const bool hasFma = __builtin_cpu_supports("fma"), hasAvx2 = hasFma && __builtin_cpu_supports("avx2");
		static const bool hasAvx512 = hasAvx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
		if (!hasFma) return { lanes1::kernels, lanes1::rowKernels };
		if (lanes == 1 || !hasAvx2) return { fma1::kernels, fma1::rowKernels };
		if (hasAvx512 && (lanes == 0 || lanes >= 8)) return { avx512::kernels, avx512::rowKernels };
#else
		if (lanes == 1) return { lanes1::kernels, lanes1::rowKernels }; // plain C++ at every width
#endif
		if (lanes == 4) return { lanes4::kernels, lanes4::rowKernels };
		return { lanes8::kernels, lanes8::rowKernels }; // two AVX2 halves are faster than one: more to do at a time
	}

} // namespace

const PackedKernels& packedKernels(int lanes) { return chosen(lanes).packed; }
const RowKernels&    rowKernels(int lanes) { return chosen(lanes).rows; }

} // namespace rcr
