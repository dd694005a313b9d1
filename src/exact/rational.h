// The one exact layer: points and vectors in rational numbers, directions in integers. For .cpp files only:
// gmp stays out of other headers.
//
// Signs of determinants of given doubles are kernels/predicates' work, which is faster. What needs points
// that are no doubles, such as those where surfaces cross, is done here; with one exception: the
// arrangement's faces are cut by CGAL's constrained triangulation, which brings numbers of its own
// (src/arrangement/exact_triangulation.h).
#pragma once

#include <gmpxx.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace overtet::exact {

using Rational = mpq_class;

inline int sign(const Rational& x) { return sgn(x); }

struct Vec {
  std::array<Rational, 3> x;
  const Rational& operator[](int k) const { return x[k]; }
  Rational& operator[](int k) { return x[k]; }
};
inline Vec vec(const double* p) { return {{Rational(p[0]), Rational(p[1]), Rational(p[2])}}; }
inline Vec operator+(const Vec& a, const Vec& b) { return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}}; }
inline Vec operator*(const Rational& s, const Vec& a) { return {{s * a[0], s * a[1], s * a[2]}}; }
inline Rational dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
inline Rational det(const Vec& a, const Vec& b, const Vec& c) { return dot(a, cross(b, c)); }
inline bool is_zero(const Vec& a) { return sign(a[0]) == 0 && sign(a[1]) == 0 && sign(a[2]) == 0; }
// Truncated: within an ulp, or the largest double where x is larger. Never infinite: nothing that goes back
// into rational numbers may be.
inline double approximate(const Rational& x) {
  const double d = x.get_d();
  return std::isfinite(d) ? d : std::copysign(std::numeric_limits<double>::max(), d);
}
inline std::array<double, 3> approximate(const Vec& a) {
  return {approximate(a[0]), approximate(a[1]), approximate(a[2])};
}
// v times a power of two that makes its largest number about 1, as it may be far out of the range of doubles.
// pre: not zero.
Vec near_one(const Vec& v);

// A direction up to a positive factor. Signs do not change when a vector is multiplied by a positive number,
// so they need integers only: no fractions, no common divisors.
using Whole = std::array<mpz_class, 3>;

Whole whole(const Vec& v);      // v times a positive number
Whole primitive(const Vec& v);  // the shortest one along v or against it: its first number not 0 is positive
Whole cross(const Whole& a, const Whole& b);
int dot_sign(const Whole& a, const Whole& b);
int det_sign(const Whole& a, const Whole& b, const Whole& c);
inline bool is_zero(const Whole& a) { return sgn(a[0]) == 0 && sgn(a[1]) == 0 && sgn(a[2]) == 0; }
inline Whole opposite(const Whole& a) { return {mpz_class(-a[0]), mpz_class(-a[1]), mpz_class(-a[2])}; }
// Of length 1, each number wrong by 1e-15 at most; any length of the integers. pre: not zero.
std::array<double, 3> unit(const Whole& a);

// v = numerator / denominator, the denominator positive.
struct Homogeneous {
  Whole numerator;
  mpz_class denominator;
  explicit Homogeneous(const Vec& v);
};

std::string fraction(const Rational& x);  // "-17" or "12345/65536"

// A point or direction with its value in doubles, each within an ulp (of what doubles can hold).
struct Point {
  Vec x;
  std::array<double, 3> near;
  bool in_doubles = false;  // x is near
  Point() = default;
  explicit Point(Vec v) : x(std::move(v)), near(approximate(x)) {
    in_doubles = x[0] == near[0] && x[1] == near[1] && x[2] == near[2];
  }
  explicit Point(const double* p) : x(vec(p)), near{p[0], p[1], p[2]}, in_doubles(true) {}
};

}  // namespace overtet::exact
