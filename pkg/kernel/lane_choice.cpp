// Which of the compiled lane widths runs on this processor.
#include "packed_blocks.hpp"

namespace rcr {

// packed_kernels.cpp, compiled once for each
namespace lanes1 { extern const PackedKernels kernels; }
namespace lanes4 { extern const PackedKernels kernels; }
namespace lanes8 { extern const PackedKernels kernels; } // two halves a lane where there is no AVX-512
#ifdef RCR_X86
namespace fma1   { extern const PackedKernels kernels; } // one lane with FMA in hardware
namespace avx512 { extern const PackedKernels kernels; }
#endif

const PackedKernels& packedKernels(int lanes)
{
#ifdef RCR_X86
	static const bool hasFma = __builtin_cpu_supports("fma"), hasAvx2 = hasFma && __builtin_cpu_supports("avx2");
	static const bool hasAvx512 = hasAvx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
	if (!hasFma) return lanes1::kernels;
	if (lanes == 1 || !hasAvx2) return fma1::kernels;
	if (hasAvx512 && (lanes == 0 || lanes >= 8)) return avx512::kernels;
#else
	if (lanes == 1) return lanes1::kernels; // plain C++ at every width
#endif
	return lanes == 4 ? lanes4::kernels : lanes8::kernels; // two AVX2 halves are faster than one: more to do at a time
}

} // namespace rcr
