// N doubles side by side: one kernel source for scalars, AVX2 and AVX-512. All intrinsics of the project live here.
//
// Lane<1> is a double, Lane<4> an AVX2 and Lane<8> an AVX-512 register where the compiler may use them; any other width
// is made of two halves. Every operation is one IEEE operation a lane, so the bits do not depend on the width (given
// -ffp-contract=off).
//
// The same source is compiled once a width with other flags. RCR_LANE_NAMESPACE keeps those copies apart, or the linker
// would keep one of them for all machines. For the same reason this file includes no library code that is inlined.
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "packed_blocks.hpp"

#ifndef RCR_LANE_NAMESPACE
#define RCR_LANE_NAMESPACE lanes
#endif

namespace rcr {
namespace RCR_LANE_NAMESPACE {

	/// True or false in every lane.
	template <int N> struct Mask {
		Mask<N / 2> low, high;
	};

	/// N doubles, as two halves unless specialised below.
	template <int N> struct Lane {
		using Half = Lane<N / 2>;
		Half low, high;

		Lane() = default;
		Lane(double all) : low(all), high(all) { }
		Lane(Half l, Half h) : low(l), high(h) { }
		static Lane load(const double* from) { return { Half::load(from), Half::load(from + N / 2) }; }
		void        store(double* to) const
		{
			low.store(to);
			high.store(to + N / 2);
		}
		friend Half    lowHalf(Lane a) { return a.low; }
		friend Half    highHalf(Lane a) { return a.high; }
		friend Lane    operator+(Lane a, Lane b) { return { a.low + b.low, a.high + b.high }; }
		friend Lane    operator-(Lane a, Lane b) { return { a.low - b.low, a.high - b.high }; }
		friend Lane    operator*(Lane a, Lane b) { return { a.low * b.low, a.high * b.high }; }
		friend Lane    operator/(Lane a, Lane b) { return { a.low / b.low, a.high / b.high }; }
		friend Mask<N> operator<=(Lane a, Lane b) { return { a.low <= b.low, a.high <= b.high }; }
		friend Lane    abs(Lane a) { return { abs(a.low), abs(a.high) }; }
		/// The size of a with the sign of b.
		friend Lane copySign(Lane a, Lane b) { return { copySign(a.low, b.low), copySign(a.high, b.high) }; }
		friend Lane select(Mask<N> m, Lane yes, Lane no) { return { select(m.low, yes.low, no.low), select(m.high, yes.high, no.high) }; }
		/// 0 where m holds, else a.
		friend Lane zeroWhere(Mask<N> m, Lane a) { return { zeroWhere(m.low, a.low), zeroWhere(m.high, a.high) }; }
		/// `below` where the sign bit of a is set, else `above`.
		friend Lane bySign(Lane a, Lane above, Lane below)
		{
			return { bySign(a.low, above.low, below.low), bySign(a.high, above.high, below.high) };
		}
	};

	template <> struct Mask<1> {
		std::uint64_t value; // all bits
	};

	inline std::uint64_t bitsOf(double a)
	{
		std::uint64_t bits;
		__builtin_memcpy(&bits, &a, sizeof bits);
		return bits;
	}

	inline double fromBits(std::uint64_t bits)
	{
		double a;
		__builtin_memcpy(&a, &bits, sizeof a);
		return a;
	}

	/// Choices are made on bits: whether a contact sticks or slides cannot be foreseen, and a branch would cost more.
	template <> struct Lane<1> {
		double value;

		Lane() = default;
		Lane(double v) : value(v) { }
		static Lane    load(const double* from) { return *from; }
		void           store(double* to) const { *to = value; }
		friend Lane    operator+(Lane a, Lane b) { return a.value + b.value; }
		friend Lane    operator-(Lane a, Lane b) { return a.value - b.value; }
		friend Lane    operator*(Lane a, Lane b) { return a.value * b.value; }
		friend Lane    operator/(Lane a, Lane b) { return a.value / b.value; }
		friend Mask<1> operator<=(Lane a, Lane b) { return { a.value <= b.value ? ~std::uint64_t(0) : 0 }; }
		friend Lane    abs(Lane a) { return __builtin_fabs(a.value); }
		friend Lane    copySign(Lane a, Lane b) { return __builtin_copysign(a.value, b.value); }
		friend Lane    select(Mask<1> m, Lane yes, Lane no) { return fromBits((bitsOf(yes.value) & m.value) | (bitsOf(no.value) & ~m.value)); }
		friend Lane    zeroWhere(Mask<1> m, Lane a) { return fromBits(bitsOf(a.value) & ~m.value); }
		friend Lane    bySign(Lane a, Lane above, Lane below) { return select({ std::uint64_t(0) - (bitsOf(a.value) >> 63) }, below, above); }
	};

#if defined(__AVX2__)
	template <> struct Mask<4> {
		__m256d value;
	};

	template <> struct Lane<4> {
		__m256d value;

		Lane() = default;
		Lane(double all) : value(_mm256_set1_pd(all)) { }
		Lane(__m256d v) : value(v) { }
		static Lane    load(const double* from) { return _mm256_load_pd(from); }
		void           store(double* to) const { _mm256_store_pd(to, value); }
		friend Lane    operator+(Lane a, Lane b) { return _mm256_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm256_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm256_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm256_div_pd(a.value, b.value); }
		friend Mask<4> operator<=(Lane a, Lane b) { return { _mm256_cmp_pd(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    abs(Lane a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			const __m256d sign = _mm256_set1_pd(-0.0);
			return _mm256_or_pd(_mm256_andnot_pd(sign, a.value), _mm256_and_pd(sign, b.value));
		}
		friend Lane select(Mask<4> m, Lane yes, Lane no) { return _mm256_blendv_pd(no.value, yes.value, m.value); }
		friend Lane zeroWhere(Mask<4> m, Lane a) { return _mm256_andnot_pd(m.value, a.value); }
		friend Lane bySign(Lane a, Lane above, Lane below) { return _mm256_blendv_pd(above.value, below.value, a.value); }
	};
#endif

#if defined(__AVX512F__)
	template <> struct Mask<8> {
		__mmask8 value;
	};

	template <> struct Lane<8> {
		__m512d value;

		Lane() = default;
		Lane(double all) : value(_mm512_set1_pd(all)) { }
		Lane(__m512d v) : value(v) { }
		Lane(Lane<4> low, Lane<4> high) : value(_mm512_insertf64x4(_mm512_castpd256_pd512(low.value), high.value, 1)) { }
		friend Lane<4> lowHalf(Lane a) { return _mm512_castpd512_pd256(a.value); }
		friend Lane<4> highHalf(Lane a) { return _mm512_extractf64x4_pd(a.value, 1); }
		static Lane    load(const double* from) { return _mm512_load_pd(from); }
		void           store(double* to) const { _mm512_store_pd(to, value); }
		friend Lane    operator+(Lane a, Lane b) { return _mm512_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm512_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm512_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm512_div_pd(a.value, b.value); }
		friend Mask<8> operator<=(Lane a, Lane b) { return { _mm512_cmp_pd_mask(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    abs(Lane a) { return _mm512_abs_pd(a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			// bitwise choice: sign bit from b, the rest from a
			const __m512i sign = _mm512_set1_epi64((long long)0x8000000000000000ull);
			return _mm512_castsi512_pd(_mm512_ternarylogic_epi64(sign, _mm512_castpd_si512(b.value), _mm512_castpd_si512(a.value), 0xca));
		}
		friend Lane select(Mask<8> m, Lane yes, Lane no) { return _mm512_mask_blend_pd(m.value, no.value, yes.value); }
		friend Lane zeroWhere(Mask<8> m, Lane a) { return _mm512_mask_blend_pd(m.value, a.value, _mm512_setzero_pd()); }
		friend Lane bySign(Lane a, Lane above, Lane below)
		{
			return _mm512_mask_blend_pd(_mm512_cmpgt_epi64_mask(_mm512_setzero_si512(), _mm512_castpd_si512(a.value)), above.value, below.value);
		}
	};
#endif

	// ---- body records: N records of four doubles to and from four lanes. Plain loads and a transpose in registers are
	// more than twice as fast as hardware gathers and scatters.

	template <int N> struct Bodies {
		Lane<N> x, y, spin, inverseMass;
	};

	/// Where the records of N bodies are.
	template <int N> struct Places {
		BodyRecord* at[N];

		Places(BodyRecord* body, const std::int32_t* index)
		{
			for (int i = 0; i < N; ++i)
				at[i] = body + index[i];
		}
	};

	template <int N> inline Bodies<N> loadBodies(BodyRecord* const* at)
	{
		if constexpr (N == 1) return { (*at)->x, (*at)->y, (*at)->spin, (*at)->inverseMass };
		else {
			const Bodies<N / 2> low = loadBodies<N / 2>(at), high = loadBodies<N / 2>(at + N / 2);
			return { { low.x, high.x }, { low.y, high.y }, { low.spin, high.spin }, { low.inverseMass, high.inverseMass } };
		}
	}

	/// Back to where they were; the bodies must be distinct.
	template <int N> inline void storeBodies(const Bodies<N>& v, BodyRecord* const* at)
	{
		if constexpr (N == 1) **at = { v.x.value, v.y.value, v.spin.value, v.inverseMass.value };
		else {
			storeBodies<N / 2>({ lowHalf(v.x), lowHalf(v.y), lowHalf(v.spin), lowHalf(v.inverseMass) }, at);
			storeBodies<N / 2>({ highHalf(v.x), highHalf(v.y), highHalf(v.spin), highHalf(v.inverseMass) }, at + N / 2);
		}
	}

#if defined(__AVX2__)
	template <> inline Bodies<4> loadBodies<4>(BodyRecord* const* at)
	{
		// (x, y) of records 0 | 2 and 1 | 3, then unpack; the same for (spin, 1/m)
		const auto halves = [&](int i, int part) __attribute__((always_inline)) {
			return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(&at[i]->x + part)), _mm_load_pd(&at[i + 2]->x + part), 1);
		};
		const __m256d v02 = halves(0, 0), v13 = halves(1, 0), w02 = halves(0, 2), w13 = halves(1, 2);
		return { _mm256_unpacklo_pd(v02, v13), _mm256_unpackhi_pd(v02, v13), _mm256_unpacklo_pd(w02, w13), _mm256_unpackhi_pd(w02, w13) };
	}

	template <> inline void storeBodies<4>(const Bodies<4>& v, BodyRecord* const* at)
	{
		const auto put = [&](__m256d pair, int i, int part) __attribute__((always_inline)) {
			_mm_store_pd(&at[i]->x + part, _mm256_castpd256_pd128(pair));
			_mm_store_pd(&at[i + 2]->x + part, _mm256_extractf128_pd(pair, 1));
		};
		put(_mm256_unpacklo_pd(v.x.value, v.y.value), 0, 0);
		put(_mm256_unpackhi_pd(v.x.value, v.y.value), 1, 0);
		put(_mm256_unpacklo_pd(v.spin.value, v.inverseMass.value), 0, 2);
		put(_mm256_unpackhi_pd(v.spin.value, v.inverseMass.value), 1, 2);
	}
#endif

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
