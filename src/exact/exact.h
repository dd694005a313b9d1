// For .cpp files only (gmp stays out of other headers): points and directions in rational numbers, and exact
// rays.
#pragma once

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/types.h"

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

enum class RayStatus { counted, grazes, starts_on_surface };

struct RayCount {
  RayStatus status = RayStatus::counted;
  int winding = 0;  // signed crossings: the winding number just ahead of the start
  Index nearest_face = -1;
  std::optional<Rational> nearest;  // parameter of the first crossing, when asked for
};

// Exact signed crossings of rays with a surface, by rational arithmetic behind a floating-point filter.
class Rays {
 public:
  Rays(const VertexMatrix& V, const TriangleMatrix& F, const TriangleBvh& bvh);

  // Directions may have any length, also one that no double can hold.
  //
  // The ray from m along d, tilted by an infinitesimal amount towards `tilt` when that is given. Faces in
  // `skip` (sorted) are not counted: those that contain m. m then may lie on the surface.
  RayCount count(const Point& m, const Point& d, const Point* tilt, const std::vector<Index>& skip,
                 bool want_nearest = false) const;

  // How the line from m along d passes face f: 1 or -1 through its inside, leaving or entering; 0 not at
  // all; kGrazes through its border or in its plane.
  static constexpr int kGrazes = 2;
  int passes(const Point& m, const Point& d, Index f) const;

  // The height of m over face f's plane, times twice f's area: in doubles, wrong by `error` at most
  // (infinity outside the range of the filter); and its sign, exact: 1 in front of the face.
  double height(const Point& m, Index f, double& error) const;
  int side(const Point& m, Index f) const;
  // Where the line through a and b meets face f's plane: 0 at a, 1 at b. pre: a and b differ in height.
  Rational cut(const Point& a, const Point& b, Index f) const;

  // The winding number of m, or none when m lies on the surface.
  std::optional<int> winding(const Point& m) const;

  // All faces that contain m, sorted.
  std::vector<Index> faces_at(const Point& m) const;

  const double* corner(Index f, int k) const { return V_.data() + 3 * std::int64_t{F_(f, k)}; }
  const TriangleMatrix& F() const { return F_; }
  const VertexMatrix& V() const { return V_; }
  Vec normal(Index f) const;                         // (b - a) x (c - a), exact
  Whole whole_normal(Index f) const;                 // times a positive number
  std::array<double, 3> unit_normal(Index f) const;  // in doubles, for choosing directions only

 private:
  struct Line;
  struct Corners;
  int passes(Line& line, Corners& corners, Index f) const;

  const VertexMatrix& V_;
  const TriangleMatrix& F_;
  const TriangleBvh& bvh_;
  double scale_ = 1;  // the largest coordinate
  bool filter_ = true;
};

// A deterministic sequence of numbers in (-1, 1) for directions; k = 0, 1, 2, ...
double scatter(int k);

}  // namespace overtet::exact
