// N numbers side by side, doubles or floats: one kernel source for scalars, AVX2 and AVX-512. All intrinsics of the project live here and
// in lane_records.hpp.
//
// Real is double, or float where RCR_SINGLE is defined. Lane<1> is one Real; Lane<4> of doubles or Lane<8> of floats is an AVX2, Lane<8> or
// Lane<16> an AVX-512 register where the compiler may use them; any other width is made of two halves. Every operation is one IEEE
// operation a lane, a product with its sum (FMA) too, so the bits do not depend on the width (given -ffp-contract=off); without
// FMA in hardware the library computes the same bits, slowly.
//
// The same source is compiled once a width and Real with other flags. RCR_LANE_NAMESPACE keeps those copies apart, or the linker
// would keep one of them for all machines. For the same reason this file includes no library code that is inlined.
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <cstdint>

#ifndef RCR_LANE_NAMESPACE
#define RCR_LANE_NAMESPACE lanes
#endif

namespace rcr {
namespace RCR_LANE_NAMESPACE {

#ifdef RCR_SINGLE
	using Real = float;
	using Bits = std::uint32_t;
	inline float fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
	inline float absolute(float a) { return __builtin_fabsf(a); }
	inline float copySign(float a, float b) { return __builtin_copysignf(a, b); }
#else
	using Real = double;
	using Bits = std::uint64_t;
	inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
	inline double absolute(double a) { return __builtin_fabs(a); }
	inline double copySign(double a, double b) { return __builtin_copysign(a, b); }
#endif

	/// True or false in every lane.
	template <int N> struct Mask {
		Mask<N / 2> low, high;
	};

	/// N Reals, as two halves unless specialised below.
	template <int N> struct Lane {
		using Half = Lane<N / 2>;
		Half low, high;

		Lane() = default;
		Lane(Real all) : low(all), high(all) { }
		Lane(Half l, Half h) : low(l), high(h) { }
		static Lane load(const Real* from) { return { Half::load(from), Half::load(from + N / 2) }; }
		template <class Number> void store(Number* to) const // of floats: rounded
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
		/// c + a b and c − a b, rounded once.
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return { addProduct(c.low, a.low, b.low), addProduct(c.high, a.high, b.high) }; }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b)
		{
			return { subtractProduct(c.low, a.low, b.low), subtractProduct(c.high, a.high, b.high) };
		}
		friend Mask<N> operator<=(Lane a, Lane b) { return { a.low <= b.low, a.high <= b.high }; }
		/// a < b ? a : b and a > b ? a : b, also for zeros of either sign.
		friend Lane    min(Lane a, Lane b) { return { min(a.low, b.low), min(a.high, b.high) }; }
		friend Lane    max(Lane a, Lane b) { return { max(a.low, b.low), max(a.high, b.high) }; }
		friend Lane    abs(Lane a) { return { abs(a.low), abs(a.high) }; }
		/// The size of a with the sign of b.
		friend Lane copySign(Lane a, Lane b) { return { copySign(a.low, b.low), copySign(a.high, b.high) }; }
		friend Lane select(Mask<N> m, Lane yes, Lane no) { return { select(m.low, yes.low, no.low), select(m.high, yes.high, no.high) }; }
		/// 0 where m holds, else a.
		friend Lane zeroWhere(Mask<N> m, Lane a) { return { zeroWhere(m.low, a.low), zeroWhere(m.high, a.high) }; }
	};

	template <> struct Mask<1> {
		Bits value; // all bits
	};

	inline Bits bitsOf(Real a)
	{
		Bits bits;
		__builtin_memcpy(&bits, &a, sizeof bits);
		return bits;
	}

	inline Real fromBits(Bits bits)
	{
		Real a;
		__builtin_memcpy(&a, &bits, sizeof a);
		return a;
	}

	/// Choices are made on bits: whether a contact sticks or slides cannot be foreseen, and a branch would cost more.
	template <> struct Lane<1> {
		Real value;

		Lane() = default;
		Lane(Real v) : value(v) { }
		static Lane    load(const Real* from) { return *from; }
		template <class Number> void store(Number* to) const { *to = Number(value); }
		friend Lane    operator+(Lane a, Lane b) { return a.value + b.value; }
		friend Lane    operator-(Lane a, Lane b) { return a.value - b.value; }
		friend Lane    operator*(Lane a, Lane b) { return a.value * b.value; }
		friend Lane    operator/(Lane a, Lane b) { return a.value / b.value; }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return fma(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return fma(-a.value, b.value, c.value); }
		friend Mask<1> operator<=(Lane a, Lane b) { return { a.value <= b.value ? ~Bits(0) : 0 }; }
		friend Lane    min(Lane a, Lane b) { return a.value < b.value ? a.value : b.value; }
		friend Lane    max(Lane a, Lane b) { return a.value > b.value ? a.value : b.value; }
		friend Lane    abs(Lane a) { return absolute(a.value); }
		friend Lane    copySign(Lane a, Lane b) { return RCR_LANE_NAMESPACE::copySign(a.value, b.value); }
		friend Lane    select(Mask<1> m, Lane yes, Lane no) { return fromBits((bitsOf(yes.value) & m.value) | (bitsOf(no.value) & ~m.value)); }
		friend Lane    zeroWhere(Mask<1> m, Lane a) { return fromBits(bitsOf(a.value) & ~m.value); }
	};

#if defined(__AVX2__) && !defined(RCR_SINGLE)
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
		void           store(float* to) const { _mm_store_ps(to, _mm256_cvtpd_ps(value)); }
		friend Lane    operator+(Lane a, Lane b) { return _mm256_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm256_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm256_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm256_div_pd(a.value, b.value); }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return _mm256_fmadd_pd(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return _mm256_fnmadd_pd(a.value, b.value, c.value); }
		friend Mask<4> operator<=(Lane a, Lane b) { return { _mm256_cmp_pd(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    min(Lane a, Lane b) { return _mm256_min_pd(a.value, b.value); }
		friend Lane    max(Lane a, Lane b) { return _mm256_max_pd(a.value, b.value); }
		friend Lane    abs(Lane a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			const __m256d sign = _mm256_set1_pd(-0.0);
			return _mm256_or_pd(_mm256_andnot_pd(sign, a.value), _mm256_and_pd(sign, b.value));
		}
		friend Lane select(Mask<4> m, Lane yes, Lane no) { return _mm256_blendv_pd(no.value, yes.value, m.value); }
		friend Lane zeroWhere(Mask<4> m, Lane a) { return _mm256_andnot_pd(m.value, a.value); }
	};
#endif

#if defined(__AVX512F__) && !defined(RCR_SINGLE)
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
		void           store(float* to) const { _mm256_store_ps(to, _mm512_cvtpd_ps(value)); }
		friend Lane    operator+(Lane a, Lane b) { return _mm512_add_pd(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm512_sub_pd(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm512_mul_pd(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm512_div_pd(a.value, b.value); }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return _mm512_fmadd_pd(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return _mm512_fnmadd_pd(a.value, b.value, c.value); }
		friend Mask<8> operator<=(Lane a, Lane b) { return { _mm512_cmp_pd_mask(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    min(Lane a, Lane b) { return _mm512_min_pd(a.value, b.value); }
		friend Lane    max(Lane a, Lane b) { return _mm512_max_pd(a.value, b.value); }
		friend Lane    abs(Lane a) { return _mm512_abs_pd(a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			// bitwise choice: sign bit from b, the rest from a
			const __m512i sign = _mm512_set1_epi64((long long)0x8000000000000000ull);
			return _mm512_castsi512_pd(_mm512_ternarylogic_epi64(sign, _mm512_castpd_si512(b.value), _mm512_castpd_si512(a.value), 0xca));
		}
		friend Lane select(Mask<8> m, Lane yes, Lane no) { return _mm512_mask_blend_pd(m.value, no.value, yes.value); }
		friend Lane zeroWhere(Mask<8> m, Lane a) { return _mm512_mask_blend_pd(m.value, a.value, _mm512_setzero_pd()); }
	};
#endif

#if defined(__AVX2__) && defined(RCR_SINGLE)
	template <> struct Mask<8> {
		__m256 value;
	};

	template <> struct Lane<8> {
		__m256 value;

		Lane() = default;
		Lane(float all) : value(_mm256_set1_ps(all)) { }
		Lane(__m256 v) : value(v) { }
		static Lane    load(const float* from) { return _mm256_load_ps(from); }
		void           store(float* to) const { _mm256_store_ps(to, value); }
		friend Lane    operator+(Lane a, Lane b) { return _mm256_add_ps(a.value, b.value); }
		friend Lane    operator-(Lane a, Lane b) { return _mm256_sub_ps(a.value, b.value); }
		friend Lane    operator*(Lane a, Lane b) { return _mm256_mul_ps(a.value, b.value); }
		friend Lane    operator/(Lane a, Lane b) { return _mm256_div_ps(a.value, b.value); }
		friend Lane    addProduct(Lane c, Lane a, Lane b) { return _mm256_fmadd_ps(a.value, b.value, c.value); }
		friend Lane    subtractProduct(Lane c, Lane a, Lane b) { return _mm256_fnmadd_ps(a.value, b.value, c.value); }
		friend Mask<8> operator<=(Lane a, Lane b) { return { _mm256_cmp_ps(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane    min(Lane a, Lane b) { return _mm256_min_ps(a.value, b.value); }
		friend Lane    max(Lane a, Lane b) { return _mm256_max_ps(a.value, b.value); }
		friend Lane    abs(Lane a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.value); }
		friend Lane    copySign(Lane a, Lane b)
		{
			const __m256 sign = _mm256_set1_ps(-0.0f);
			return _mm256_or_ps(_mm256_andnot_ps(sign, a.value), _mm256_and_ps(sign, b.value));
		}
		friend Lane select(Mask<8> m, Lane yes, Lane no) { return _mm256_blendv_ps(no.value, yes.value, m.value); }
		friend Lane zeroWhere(Mask<8> m, Lane a) { return _mm256_andnot_ps(m.value, a.value); }
	};
#endif

#if defined(__AVX512F__) && defined(RCR_SINGLE)
	template <> struct Mask<16> {
		__mmask16 value;
	};

	template <> struct Lane<16> {
		__m512 value;

		Lane() = default;
		Lane(float all) : value(_mm512_set1_ps(all)) { }
		Lane(__m512 v) : value(v) { }
		Lane(Lane<8> low, Lane<8> high) : value(_mm512_castpd_ps(_mm512_insertf64x4(_mm512_castps_pd(_mm512_castps256_ps512(low.value)), _mm256_castps_pd(high.value), 1))) { }
		friend Lane<8>  lowHalf(Lane a) { return _mm512_castps512_ps256(a.value); }
		friend Lane<8>  highHalf(Lane a) { return _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(a.value), 1)); }
		static Lane     load(const float* from) { return _mm512_load_ps(from); }
		void            store(float* to) const { _mm512_store_ps(to, value); }
		friend Lane     operator+(Lane a, Lane b) { return _mm512_add_ps(a.value, b.value); }
		friend Lane     operator-(Lane a, Lane b) { return _mm512_sub_ps(a.value, b.value); }
		friend Lane     operator*(Lane a, Lane b) { return _mm512_mul_ps(a.value, b.value); }
		friend Lane     operator/(Lane a, Lane b) { return _mm512_div_ps(a.value, b.value); }
		friend Lane     addProduct(Lane c, Lane a, Lane b) { return _mm512_fmadd_ps(a.value, b.value, c.value); }
		friend Lane     subtractProduct(Lane c, Lane a, Lane b) { return _mm512_fnmadd_ps(a.value, b.value, c.value); }
		friend Mask<16> operator<=(Lane a, Lane b) { return { _mm512_cmp_ps_mask(a.value, b.value, _CMP_LE_OQ) }; }
		friend Lane     min(Lane a, Lane b) { return _mm512_min_ps(a.value, b.value); }
		friend Lane     max(Lane a, Lane b) { return _mm512_max_ps(a.value, b.value); }
		friend Lane     abs(Lane a) { return _mm512_abs_ps(a.value); }
		friend Lane     copySign(Lane a, Lane b)
		{
			const __m512i sign = _mm512_set1_epi32(int(0x80000000u)); // bitwise choice, as of doubles
			return _mm512_castsi512_ps(_mm512_ternarylogic_epi32(sign, _mm512_castps_si512(b.value), _mm512_castps_si512(a.value), 0xca));
		}
		friend Lane select(Mask<16> m, Lane yes, Lane no) { return _mm512_mask_blend_ps(m.value, no.value, yes.value); }
		friend Lane zeroWhere(Mask<16> m, Lane a) { return _mm512_mask_blend_ps(m.value, a.value, _mm512_setzero_ps()); }
	};
#endif

	/// Parts a calculation in two for the compiler, which would mix them and run out of registers.
	inline void keepOrder() { __atomic_signal_fence(__ATOMIC_SEQ_CST); }

} // namespace RCR_LANE_NAMESPACE
} // namespace rcr
