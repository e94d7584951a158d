// Which of the compiled lane widths runs on this processor.
#include "packed_blocks.hpp"

namespace rcr {

// packed_kernels.cpp, compiled once for each
namespace lanes1 { extern const PackedKernels kernels; }
namespace lanes4 { extern const PackedKernels kernels; }
namespace lanes8 { extern const PackedKernels kernels; } // two halves a lane where there is no AVX-512
#ifdef RCR_X86
namespace avx512 { extern const PackedKernels kernels; }
#endif

const PackedKernels& packedKernels(int lanes)
{
#ifdef RCR_X86
	static const bool hasAvx512 = __builtin_cpu_supports("avx512f"), hasAvx2 = __builtin_cpu_supports("avx2");
#else
	constexpr bool hasAvx2 = true; // plain C++ at every width
#endif
	if (lanes == 1 || !hasAvx2) return lanes1::kernels;
#ifdef RCR_X86
	if (hasAvx512 && (lanes == 0 || lanes >= 8)) return avx512::kernels;
#endif
	return lanes == 4 ? lanes4::kernels : lanes8::kernels; // two AVX2 halves are faster than one: more to do at a time
}

} // namespace rcr
