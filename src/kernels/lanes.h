// SPDX-License-Identifier: GPL-3.0-or-later
// Short vectors of 4 and 8 numbers for the kernels, on the compiler's vector extensions (GCC, Clang).
//
// A kernel's source is compiled once for each instruction set. All its code is in an unnamed namespace, and
// it calls no inline function of other headers: otherwise the linker could keep the one compiled for the
// largest instruction set and use it everywhere. Every operation is rounded by itself (no contraction into
// fused multiply-adds), so all instruction sets give the same bits. Highway's vectors are no longer than the
// registers of an instruction set; these have the same length with each.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace {

template <class Number, int n>
struct Lanes;
template <>
struct Lanes<float, 4> {
  typedef float Real __attribute__((vector_size(16)));
  typedef std::int32_t Integer __attribute__((vector_size(16)));
};
template <>
struct Lanes<float, 8> {
  typedef float Real __attribute__((vector_size(32)));
  typedef std::int32_t Integer __attribute__((vector_size(32)));
};
template <>
struct Lanes<double, 4> {
  typedef double Real __attribute__((vector_size(32)));
  typedef std::int64_t Integer __attribute__((vector_size(32)));
};
template <>
struct Lanes<double, 8> {
  typedef double Real __attribute__((vector_size(64)));
  typedef std::int64_t Integer __attribute__((vector_size(64)));
};

using Float4 = Lanes<float, 4>::Real;
using Float8 = Lanes<float, 8>::Real;
using Double4 = Lanes<double, 4>::Real;
using Double8 = Lanes<double, 8>::Real;
using Int4 = Lanes<float, 4>::Integer;
using Int8 = Lanes<float, 8>::Integer;
using Long4 = Lanes<double, 4>::Integer;
using Long8 = Lanes<double, 8>::Integer;

inline Float4 to_real(Int4 v) {
  return __builtin_convertvector(v, Float4);
}
inline Float8 to_real(Int8 v) {
  return __builtin_convertvector(v, Float8);
}

/// To the nearest integer, ties to even. Raises the processor's invalid flag if the integer does not fit.
inline Int4 rounded(Float4 v) {
#if defined(__SSE2__)
  return (Int4)_mm_cvtps_epi32((__m128)v);
#else
  return Int4{(std::int32_t)__builtin_lrintf(v[0]), (std::int32_t)__builtin_lrintf(v[1]),
              (std::int32_t)__builtin_lrintf(v[2]), (std::int32_t)__builtin_lrintf(v[3])};
#endif
}
inline Int8 rounded(Float8 v) {
#if defined(__AVX2__)
  return (Int8)_mm256_cvtps_epi32((__m256)v);
#else
  const Int4 low = rounded(__builtin_shufflevector(v, v, 0, 1, 2, 3));
  const Int4 high = rounded(__builtin_shufflevector(v, v, 4, 5, 6, 7));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

// Integers below 2^51 in magnitude are the low bits of a double near 1.5 * 2^52.
constexpr double shift = 6755399441055744.0;
constexpr std::int64_t shift_bits = 0x4338000000000000;
inline Double4 to_real(Long4 v) {
  return (Double4)(v + shift_bits) - shift;
}
inline Double8 to_real(Long8 v) {
  return (Double8)(v + shift_bits) - shift;
}
inline Long4 rounded(Double4 v) {
  return (Long4)(v + shift) - shift_bits;
}
inline Long8 rounded(Double8 v) {
  return (Long8)(v + shift) - shift_bits;
}

#if defined(__SSE2__)
inline Float4 square_root(Float4 v) {
  return (Float4)_mm_sqrt_ps((__m128)v);
}
inline Double4 square_root(Double4 v) {
#if defined(__AVX__)
  return (Double4)_mm256_sqrt_pd((__m256d)v);
#else
  typedef double Double2 __attribute__((vector_size(16)));
  const Double2 low = (Double2)_mm_sqrt_pd((__m128d)__builtin_shufflevector(v, v, 0, 1));
  const Double2 high = (Double2)_mm_sqrt_pd((__m128d)__builtin_shufflevector(v, v, 2, 3));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3);
#endif
}
#else
inline Float4 square_root(Float4 v) {
  return Float4{__builtin_sqrtf(v[0]), __builtin_sqrtf(v[1]), __builtin_sqrtf(v[2]), __builtin_sqrtf(v[3])};
}
inline Double4 square_root(Double4 v) {
  return Double4{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]), __builtin_sqrt(v[3])};
}
#endif
template <class Vector8>
inline Vector8 square_root(Vector8 v) {
  const auto low = square_root(__builtin_shufflevector(v, v, 0, 1, 2, 3));
  const auto high = square_root(__builtin_shufflevector(v, v, 4, 5, 6, 7));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// The minimum of all lanes, none of which may be NaN.
template <class Vector>
inline auto smallest(Vector v) {
  if constexpr (sizeof v / sizeof v[0] == 8) {
    const Vector halves = __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3);
    v = v < halves ? v : halves;
    const Vector quarters = __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
    v = v < quarters ? v : quarters;
  } else {
    const Vector halves = __builtin_shufflevector(v, v, 2, 3, 0, 1);
    v = v < halves ? v : halves;
  }
  return v[0] < v[1] ? v[0] : v[1];
}

/// Maximum per lane; neither number may be NaN.
template <class Vector>
inline Vector larger(Vector a, Vector b) {
  return a > b ? a : b;
}
#if defined(__SSE2__)
inline Float4 larger(Float4 a, Float4 b) {
  return (Float4)_mm_max_ps((__m128)a, (__m128)b);
}
#endif
#if defined(__AVX2__)
inline Float8 larger(Float8 a, Float8 b) {
  return (Float8)_mm256_max_ps((__m256)a, (__m256)b);
}
inline Double4 larger(Double4 a, Double4 b) {
  return (Double4)_mm256_max_pd((__m256d)a, (__m256d)b);
}
#endif
#if defined(__AVX512F__)
inline Double8 larger(Double8 a, Double8 b) {
  return (Double8)_mm512_max_pd((__m512d)a, (__m512d)b);
}
#endif

inline Float4 absolute(Float4 v) {
  return (Float4)((Int4)v & 0x7fffffff);
}
inline Float8 absolute(Float8 v) {
  return (Float8)((Int8)v & 0x7fffffff);
}
inline Double4 absolute(Double4 v) {
  return (Double4)((Long4)v & 0x7fffffffffffffff);
}
inline Double8 absolute(Double8 v) {
  return (Double8)((Long8)v & 0x7fffffffffffffff);
}

/// The first three columns of each 4 x 4 block of rows: 4 rows of x, y, z, - become 4 x, 4 y and 4 z.
template <class V>
requires(sizeof(V) / sizeof(V{}[0]) == 8) inline void to_columns(const V r[4], V& x, V& y, V& z) {
  const V a = __builtin_shufflevector(r[0], r[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const V b = __builtin_shufflevector(r[2], r[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const V c = __builtin_shufflevector(r[0], r[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const V d = __builtin_shufflevector(r[2], r[3], 2, 10, 3, 11, 6, 14, 7, 15);
  x = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
  y = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  z = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
}
template <class V>
requires(sizeof(V) / sizeof(V{}[0]) == 4) inline void to_columns(const V r[4], V& x, V& y, V& z) {
  const V a = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
  const V b = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
  const V c = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7);
  const V d = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
  x = __builtin_shufflevector(a, b, 0, 1, 4, 5);
  y = __builtin_shufflevector(a, b, 2, 3, 6, 7);
  z = __builtin_shufflevector(c, d, 0, 1, 4, 5);
}

/// The inverse of to_columns; the fourth column is 0.
template <class V>
requires(sizeof(V) / sizeof(V{}[0]) == 8) inline void to_rows(V x, V y, V z, V r[4]) {
  const V zero{};
  const V a = __builtin_shufflevector(x, y, 0, 8, 1, 9, 4, 12, 5, 13);
  const V b = __builtin_shufflevector(x, y, 2, 10, 3, 11, 6, 14, 7, 15);
  const V c = __builtin_shufflevector(z, zero, 0, 8, 1, 9, 4, 12, 5, 13);
  const V d = __builtin_shufflevector(z, zero, 2, 10, 3, 11, 6, 14, 7, 15);
  r[0] = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13);
  r[1] = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15);
  r[2] = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13);
  r[3] = __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15);
}
template <class V>
requires(sizeof(V) / sizeof(V{}[0]) == 4) inline void to_rows(V x, V y, V z, V r[4]) {
  const V zero{};
  const V a = __builtin_shufflevector(x, y, 0, 4, 1, 5);
  const V b = __builtin_shufflevector(x, y, 2, 6, 3, 7);
  const V c = __builtin_shufflevector(z, zero, 0, 4, 1, 5);
  const V d = __builtin_shufflevector(z, zero, 2, 6, 3, 7);
  r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  r[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  r[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

}  // namespace
