// Chooses the compiled lane width that runs on this processor.
#include "sweep/lane/packed_blocks.hpp"

namespace rcr {

// packed_kernels.cpp, compiled once per width, for doubles and for floats
#define RCR_COMPILED(doubles, floats)                                                              \
	namespace doubles { extern const PackedKernels kernels; }                                      \
	namespace floats { extern const SweepKernels<float> kernels; }
RCR_COMPILED(lanes1, single1)
RCR_COMPILED(lanes4, single8)
#ifdef RCR_X86
RCR_COMPILED(fma1, single_fma1) // one lane with FMA in hardware
RCR_COMPILED(avx512, single_avx512)
#endif

namespace {

	struct Kernels {
		const PackedKernels&          packed;
		const SweepKernels<float>& single;
	};

	Kernels chosen(int lanes)
	{
#ifdef RCR_X86
		static const bool hasFma    = __builtin_cpu_supports("fma");
		static const bool hasAvx2   = hasFma && __builtin_cpu_supports("avx2");
		static const bool hasAvx512 = hasAvx2 && __builtin_cpu_supports("avx512f")
		        && __builtin_cpu_supports("avx512vl");
		if (!hasFma) return { lanes1::kernels, single1::kernels };
		if (lanes == 1 || !hasAvx2) return { fma1::kernels, single_fma1::kernels };
		if (hasAvx512 && (lanes == 0 || lanes >= 8))
			return { avx512::kernels, single_avx512::kernels };
#else
		if (lanes == 1) return { lanes1::kernels, single1::kernels };
#endif
		return { lanes4::kernels, single8::kernels };
	}

} // namespace

const PackedKernels&          packedKernels(int lanes) { return chosen(lanes).packed; }
const SweepKernels<float>& singleKernels(int lanes) { return chosen(lanes).single; }

} // namespace rcr
