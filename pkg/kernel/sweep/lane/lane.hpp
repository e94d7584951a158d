// N numbers side by side, doubles or floats: one kernel source for scalars, AVX2 and AVX-512.
// All SIMD intrinsics of the project are here and in lane_records.hpp.
//
// Real is double, or float if RCR_SINGLE is defined. Lane<1> is one Real. AVX2 registers are
// Lane<4> of doubles and Lane<8> of floats; AVX-512 registers are Lane<8> and Lane<16>, if the
// compiler may use them. Any other width consists of two halves. Each operation is one IEEE
// operation per lane; a fused product and sum (FMA) is one operation. So the bits do not depend on
// the width, given -ffp-contract=off. Without FMA in hardware, the C library computes the same bits
// slowly.
//
// CMake compiles this source once per width and Real, each with its own flags. RCR_LANE_NAMESPACE
// separates these copies; otherwise the linker would keep one of them for all processors. For the
// same reason this file includes no inline library code.
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <cstdint>

namespace rcr::RCR_LANE_NAMESPACE {

#ifdef RCR_SINGLE
using Real = float;
using Bits = std::uint32_t;
inline float fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
inline float absolute(float a) { return __builtin_fabsf(a); }
inline float root(float a) { return __builtin_sqrtf(a); }
inline float copySign(float a, float b) { return __builtin_copysignf(a, b); }
#else
using Real = double;
using Bits = std::uint64_t;
inline double fma(double a, double b, double c) { return __builtin_fma(a, b, c); }
inline double absolute(double a) { return __builtin_fabs(a); }
inline double root(double a) { return __builtin_sqrt(a); }
inline double copySign(double a, double b) { return __builtin_copysign(a, b); }
#endif

/// N Reals, as two halves unless specialised below.
template <int N> struct Lane {
	using Half = Lane<N / 2>;
	struct Mask { // true or false in every lane
		typename Half::Mask low, high;
	};
	Half low, high;

	Lane() = default;
	Lane(Real all) : low(all), high(all) { }
	Lane(Half l, Half h) : low(l), high(h) { }
	static Lane load(const Real* from)
	{
		return { Half::load(from), Half::load(from + N / 2) };
	}
	template <class Number> void store(Number* to) const // rounds to floats
	{
		low.store(to);
		high.store(to + N / 2);
	}
	friend Half lowHalf(Lane a) { return a.low; }
	friend Half highHalf(Lane a) { return a.high; }
	friend Lane operator+(Lane a, Lane b) { return { a.low + b.low, a.high + b.high }; }
	friend Lane operator-(Lane a, Lane b) { return { a.low - b.low, a.high - b.high }; }
	friend Lane operator*(Lane a, Lane b) { return { a.low * b.low, a.high * b.high }; }
	friend Lane operator/(Lane a, Lane b) { return { a.low / b.low, a.high / b.high }; }
	/// c + a b and c − a b, rounded once.
	friend Lane addProduct(Lane c, Lane a, Lane b)
	{
		return { addProduct(c.low, a.low, b.low), addProduct(c.high, a.high, b.high) };
	}
	friend Lane subtractProduct(Lane c, Lane a, Lane b)
	{
		return { subtractProduct(c.low, a.low, b.low), subtractProduct(c.high, a.high, b.high) };
	}
	friend Mask operator<=(Lane a, Lane b) { return { a.low <= b.low, a.high <= b.high }; }
	/// a < b ? a : b and a > b ? a : b, also for zeros of either sign.
	friend Lane min(Lane a, Lane b) { return { min(a.low, b.low), min(a.high, b.high) }; }
	friend Lane max(Lane a, Lane b) { return { max(a.low, b.low), max(a.high, b.high) }; }
	friend Lane abs(Lane a) { return { abs(a.low), abs(a.high) }; }
	friend Lane sqrt(Lane a) { return { sqrt(a.low), sqrt(a.high) }; }
	/// |a| with the sign of b.
	friend Lane copySign(Lane a, Lane b)
	{
		return { copySign(a.low, b.low), copySign(a.high, b.high) };
	}
	friend Lane select(Mask m, Lane yes, Lane no)
	{
		return { select(m.low, yes.low, no.low), select(m.high, yes.high, no.high) };
	}
	/// 0 where m holds, else a.
	friend Lane zeroWhere(Mask m, Lane a)
	{
		return { zeroWhere(m.low, a.low), zeroWhere(m.high, a.high) };
	}
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

/// Selects by bits: the processor cannot predict which contacts slide, so a branch costs more.
template <> struct Lane<1> {
	struct Mask {
		Bits value; // all bits
	};
	Real value;

	Lane() = default;
	Lane(Real v) : value(v) { }
	static Lane                  load(const Real* from) { return *from; }
	template <class Number> void store(Number* to) const { *to = Number(value); }
	friend Lane                  operator+(Lane a, Lane b) { return a.value + b.value; }
	friend Lane                  operator-(Lane a, Lane b) { return a.value - b.value; }
	friend Lane                  operator*(Lane a, Lane b) { return a.value * b.value; }
	friend Lane                  operator/(Lane a, Lane b) { return a.value / b.value; }
	friend Lane addProduct(Lane c, Lane a, Lane b) { return fma(a.value, b.value, c.value); }
	friend Lane subtractProduct(Lane c, Lane a, Lane b)
	{
		return fma(-a.value, b.value, c.value);
	}
	friend Mask operator<=(Lane a, Lane b) { return { a.value <= b.value ? ~Bits(0) : 0 }; }
	friend Lane    min(Lane a, Lane b) { return a.value < b.value ? a.value : b.value; }
	friend Lane    max(Lane a, Lane b) { return a.value > b.value ? a.value : b.value; }
	friend Lane    abs(Lane a) { return absolute(a.value); }
	friend Lane    sqrt(Lane a) { return root(a.value); }
	friend Lane    copySign(Lane a, Lane b)
	{
		return RCR_LANE_NAMESPACE::copySign(a.value, b.value);
	}
	friend Lane select(Mask m, Lane yes, Lane no)
	{
		return fromBits((bitsOf(yes.value) & m.value) | (bitsOf(no.value) & ~m.value));
	}
	friend Lane zeroWhere(Mask m, Lane a) { return fromBits(bitsOf(a.value) & ~m.value); }
};

#if defined(__AVX2__)
// The operations that AVX2 and AVX-512 name alike.
#define RCR_LANE_ARITHMETIC(Register, mm, type)                                                    \
	Register value;                                                                                \
	Lane() = default;                                                                              \
	Lane(Real all) : value(mm##_set1_##type(all)) { }                                              \
	Lane(Register v) : value(v) { }                                                                \
	static Lane load(const Real* from) { return mm##_load_##type(from); }                          \
	void        store(Real* to) const { mm##_store_##type(to, value); }                            \
	friend Lane operator+(Lane a, Lane b) { return mm##_add_##type(a.value, b.value); }            \
	friend Lane operator-(Lane a, Lane b) { return mm##_sub_##type(a.value, b.value); }            \
	friend Lane operator*(Lane a, Lane b) { return mm##_mul_##type(a.value, b.value); }            \
	friend Lane operator/(Lane a, Lane b) { return mm##_div_##type(a.value, b.value); }            \
	friend Lane addProduct(Lane c, Lane a, Lane b)                                                 \
	{                                                                                              \
		return mm##_fmadd_##type(a.value, b.value, c.value);                                       \
	}                                                                                              \
	friend Lane subtractProduct(Lane c, Lane a, Lane b)                                            \
	{                                                                                              \
		return mm##_fnmadd_##type(a.value, b.value, c.value);                                      \
	}                                                                                              \
	friend Lane min(Lane a, Lane b) { return mm##_min_##type(a.value, b.value); }                  \
	friend Lane max(Lane a, Lane b) { return mm##_max_##type(a.value, b.value); }                  \
friend Lane sqrt(Lane a) { return mm##_sqrt_##type(a.value); }

// AVX2: a mask is a register. −0 has the sign bit alone.
#define RCR_LANE_AVX2(Register, type)                                                              \
	struct Mask {                                                                                  \
		Register value;                                                                            \
	};                                                                                             \
	friend Lane abs(Lane a) { return _mm256_andnot_##type(Lane(Real(-0.0)).value, a.value); }      \
	friend Lane copySign(Lane a, Lane b)                                                           \
	{                                                                                              \
		const auto sign = Lane(Real(-0.0)).value;                                                  \
		return _mm256_or_##type(                                                                   \
		        _mm256_andnot_##type(sign, a.value), _mm256_and_##type(sign, b.value));            \
	}                                                                                              \
	friend Mask operator<=(Lane a, Lane b)                                                         \
	{                                                                                              \
		return { _mm256_cmp_##type(a.value, b.value, _CMP_LE_OQ) };                                \
	}                                                                                              \
	friend Lane select(Mask m, Lane yes, Lane no)                                                  \
	{                                                                                              \
		return _mm256_blendv_##type(no.value, yes.value, m.value);                                 \
	}                                                                                              \
friend Lane zeroWhere(Mask m, Lane a) { return _mm256_andnot_##type(m.value, a.value); }
#endif

#if defined(__AVX512F__)
// AVX-512: a mask is a number. 0xca chooses bits: the sign of b, the rest of a.
#define RCR_LANE_AVX512(lanes, type, bits)                                                         \
	struct Mask {                                                                                  \
		__mmask##lanes value;                                                                      \
	};                                                                                             \
	friend Lane abs(Lane a) { return _mm512_abs_##type(a.value); }                                 \
	friend Lane copySign(Lane a, Lane b)                                                           \
	{                                                                                              \
		const __m512i sign = _mm512_cast##type##_si512(Lane(Real(-0.0)).value);                    \
		return _mm512_castsi512_##type(_mm512_ternarylogic_##bits(sign,                            \
		        _mm512_cast##type##_si512(b.value), _mm512_cast##type##_si512(a.value), 0xca));    \
	}                                                                                              \
	friend Mask operator<=(Lane a, Lane b)                                                         \
	{                                                                                              \
		return { _mm512_cmp_##type##_mask(a.value, b.value, _CMP_LE_OQ) };                         \
	}                                                                                              \
	friend Lane select(Mask m, Lane yes, Lane no)                                                  \
	{                                                                                              \
		return _mm512_mask_blend_##type(m.value, no.value, yes.value);                             \
	}                                                                                              \
	friend Lane zeroWhere(Mask m, Lane a)                                                          \
	{                                                                                              \
		return _mm512_mask_blend_##type(m.value, a.value, _mm512_setzero_##type());                \
}
#endif

#if defined(__AVX2__) && !defined(RCR_SINGLE)
template <> struct Lane<4> {
	RCR_LANE_ARITHMETIC(__m256d, _mm256, pd)
	RCR_LANE_AVX2(__m256d, pd)
	void store(float* to) const { _mm_store_ps(to, _mm256_cvtpd_ps(value)); }
};
#endif

#if defined(__AVX512F__) && !defined(RCR_SINGLE)
template <> struct Lane<8> {
	RCR_LANE_ARITHMETIC(__m512d, _mm512, pd)
	RCR_LANE_AVX512(8, pd, epi64)
	Lane(Lane<4> low, Lane<4> high)
	        : value(_mm512_insertf64x4(_mm512_castpd256_pd512(low.value), high.value, 1))
	{
	}
	friend Lane<4> lowHalf(Lane a) { return _mm512_castpd512_pd256(a.value); }
	friend Lane<4> highHalf(Lane a) { return _mm512_extractf64x4_pd(a.value, 1); }
	void           store(float* to) const { _mm256_store_ps(to, _mm512_cvtpd_ps(value)); }
};
#endif

#if defined(__AVX2__) && defined(RCR_SINGLE)
template <> struct Lane<8> {
	RCR_LANE_ARITHMETIC(__m256, _mm256, ps)
	RCR_LANE_AVX2(__m256, ps)
};
#endif

#if defined(__AVX512F__) && defined(RCR_SINGLE)
template <> struct Lane<16> {
	RCR_LANE_ARITHMETIC(__m512, _mm512, ps)
	RCR_LANE_AVX512(16, ps, epi32)
	Lane(Lane<8> low, Lane<8> high) : value(joined(low.value, high.value)) { }
	friend Lane<8> lowHalf(Lane a) { return _mm512_castps512_ps256(a.value); }
	friend Lane<8> highHalf(Lane a)
	{
		return _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(a.value), 1));
	}

private:
	static __m512 joined(__m256 low, __m256 high)
	{
		const __m512d whole = _mm512_castps_pd(_mm512_castps256_ps512(low));
		return _mm512_castpd_ps(_mm512_insertf64x4(whole, _mm256_castps_pd(high), 1));
	}
};
#endif

/// Prevents the compiler from interleaving two calculations, which would exhaust the registers.
inline void scheduleBarrier() { __atomic_signal_fence(__ATOMIC_SEQ_CST); }

} // namespace rcr::RCR_LANE_NAMESPACE
