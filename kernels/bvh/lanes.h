// Four floats side by side: the little that the box tree needs, with SSE or without. Results are the same.
#pragma once

#include <cmath>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace overtet::bvh_detail {

#if defined(__SSE2__)

struct Lanes {
  __m128 v;
  static Lanes load(const float* p) { return {_mm_loadu_ps(p)}; }
  static Lanes all(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_storeu_ps(p, v); }
  friend Lanes operator+(Lanes a, Lanes b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Lanes operator-(Lanes a, Lanes b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Lanes operator*(Lanes a, Lanes b) { return {_mm_mul_ps(a.v, b.v)}; }
};
// Where a is not a number: b.
inline Lanes min(Lanes a, Lanes b) { return {_mm_min_ps(a.v, b.v)}; }
inline Lanes max(Lanes a, Lanes b) { return {_mm_max_ps(a.v, b.v)}; }

// Bit k: true in lane k.
struct Truth {
  __m128 v;
  friend Truth operator&(Truth a, Truth b) { return {_mm_and_ps(a.v, b.v)}; }
  unsigned bits() const { return static_cast<unsigned>(_mm_movemask_ps(v)); }
};
inline Truth operator<=(Lanes a, Lanes b) { return {_mm_cmple_ps(a.v, b.v)}; }

#else

struct Lanes {
  float v[4];
  static Lanes load(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
  static Lanes all(float x) { return {{x, x, x, x}}; }
  void store(float* p) const {
    for (int k = 0; k < 4; ++k) p[k] = v[k];
  }
  template <class Op>
  static Lanes each(Lanes a, Lanes b, Op op) {
    return {{op(a.v[0], b.v[0]), op(a.v[1], b.v[1]), op(a.v[2], b.v[2]), op(a.v[3], b.v[3])}};
  }
  friend Lanes operator+(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x + y; });
  }
  friend Lanes operator-(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x - y; });
  }
  friend Lanes operator*(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x * y; });
  }
};
inline Lanes min(Lanes a, Lanes b) {
  return Lanes::each(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Lanes max(Lanes a, Lanes b) {
  return Lanes::each(a, b, [](float x, float y) { return x > y ? x : y; });
}

struct Truth {
  unsigned b;
  friend Truth operator&(Truth x, Truth y) { return {x.b & y.b}; }
  unsigned bits() const { return b; }
};
inline Truth operator<=(Lanes a, Lanes b) {
  unsigned bits = 0;
  for (int k = 0; k < 4; ++k) bits |= unsigned{a.v[k] <= b.v[k]} << k;
  return {bits};
}

#endif

}  // namespace overtet::bvh_detail
