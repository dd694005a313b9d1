#include "src/exact/rays.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/assertions.h"
#include "kernels/predicates/predicates.h"

namespace overtet::exact {

namespace {

using Near = std::array<double, 3>;

double det(const Near& a, const Near& b, const Near& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}
double largest(const Near& a) {
  return std::max(std::max(std::fabs(a[0]), std::fabs(a[1])), std::fabs(a[2]));
}

// The corners of a triangle: whole numbers times 2^low, low <= 0.
struct Scaled {
  long mantissa[9];
  int exponent[9], low = 0;
  explicit Scaled(const double* const* corner) {
    for (int i = 0; i < 9; ++i) {
      const double x = corner[i / 3][i % 3];
      mantissa[i] = static_cast<long>(std::ldexp(std::frexp(x, &exponent[i]), 53));
      exponent[i] -= 53;
      if (mantissa[i] == 0) {
        exponent[i] = 0;
        continue;
      }
      const int zeros = __builtin_ctzl(static_cast<unsigned long>(mantissa[i]));
      mantissa[i] >>= zeros;
      exponent[i] += zeros;
      low = std::min(low, exponent[i]);
    }
  }
  // x = factor * (the number at i) * 2^-low
  void times(int i, const mpz_class& factor, mpz_class& x) const {
    mpz_mul_si(x.get_mpz_t(), factor.get_mpz_t(), mantissa[i]);
    mpz_mul_2exp(x.get_mpz_t(), x.get_mpz_t(), exponent[i] - low);
  }
};

// The corners of a triangle as seen from m, times one positive number.
void seen_from(const Homogeneous& m, const double* const* corner, Whole* out) {
  const Scaled q(corner);
  thread_local mpz_class shifted;
  for (int k = 0; k < 3; ++k) {
    mpz_mul_2exp(shifted.get_mpz_t(), m.numerator[k].get_mpz_t(), -q.low);
    for (int c = 0; c < 3; ++c) {
      q.times(3 * c + k, m.denominator, out[c][k]);
      out[c][k] -= shifted;
    }
  }
}

// The plane of a triangle. Heights are linear in the point: much shorter numbers than determinants of corners
// seen from there.
class Plane {
 public:
  explicit Plane(const double* const* corner) {
    const Scaled q(corner);
    static const mpz_class one = 1;
    thread_local Whole p[3];
    for (int i = 0; i < 9; ++i) q.times(i, one, p[i / 3][i % 3]);
    for (int k = 0; k < 3; ++k)
      for (int c : {1, 2}) p[c][k] -= p[0][k];
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      normal_[k] = p[1][i] * p[2][j];
      normal_[k] -= p[1][j] * p[2][i];
      offset_ += normal_[k] * p[0][k];
    }
    shift_ = -q.low;
  }
  const Whole& normal() const { return normal_; }
  // Above the plane; times m's denominator and a positive number that belongs to the plane.
  void height(const Homogeneous& m, mpz_class& out) const {
    out = 0;
    for (int k = 0; k < 3; ++k) out += normal_[k] * m.numerator[k];
    mpz_mul_2exp(out.get_mpz_t(), out.get_mpz_t(), shift_);
    out -= offset_ * m.denominator;
  }

 private:
  Whole normal_;
  mpz_class offset_;
  mp_bitcnt_t shift_ = 0;
};

// A direction whose doubles have all their digits, products of them with two coordinates included: d itself
// nearly always, else `other`.
const Point& with_digits(const Point& d, std::optional<Point>& other) {
  const double size = largest(d.near);
  if ((size > 1e-100 && size < 1e100) || is_zero(d.x)) return d;
  return other.emplace(near_one(d.x));
}

void make_exact(std::optional<Homogeneous>& start, std::optional<Homogeneous>& line, const Point& m,
                const Point& d) {
  if (start) return;
  start.emplace(m.x);
  line.emplace(d.x);
}

}  // namespace

double scatter(int k) {
  // Fractional parts of multiples of the golden ratio.
  const double x = (k + 1) * 0.6180339887498949;
  return 2 * (x - std::floor(x)) - 1;
}

Rays::Rays(const VertexMatrix& V, const TriangleMatrix& F, const TriangleBvh& bvh) : V_(V), F_(F), bvh_(bvh) {
  scale_ = bvh.reach();
  // Outside these limits products of three coordinates leave the range of doubles: everything is then
  // decided in rational numbers.
  filter_ = scale_ < 1e90 && scale_ > 1e-60;
}

Vec Rays::normal(Index f) const {
  const Vec a = vec(corner(f, 0));
  return cross(vec(corner(f, 1)) - a, vec(corner(f, 2)) - a);
}

Whole Rays::whole_normal(Index f) const {
  const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
  return Plane(corners).normal();
}

std::array<double, 3> Rays::unit_normal(Index f) const {
  const double *a = corner(f, 0), *b = corner(f, 1), *c = corner(f, 2);
  double u[3], w[3], big = 0;
  for (int k = 0; k < 3; ++k) {
    u[k] = b[k] - a[k];
    w[k] = c[k] - a[k];
    big = std::max(big, std::max(std::fabs(u[k]), std::fabs(w[k])));
  }
  Near n{u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 1e-10 * big * big) || !std::isfinite(length) || length < 1e-100) {
    // A needle or an extreme scale: from the exact normal, scaled into range.
    const Vec exact_normal = normal(f);
    Rational top = 0;
    for (int k = 0; k < 3; ++k) top = std::max(top, Rational(abs(exact_normal[k])));
    if (sign(top) == 0) return {0, 0, 0};
    for (int k = 0; k < 3; ++k) n[k] = Rational(exact_normal[k] / top).get_d();
    const double l = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return {n[0] / l, n[1] / l, n[2] / l};
  }
  return {n[0] / length, n[1] / length, n[2] / length};
}

struct Rays::Line {
  const Point& m;
  const Point& d;
  const Point* tilt;
  double size_d, S;
  std::optional<Homogeneous> start, line, lean;  // made when the filter first fails
};

// A face as seen from the start of a line, in doubles and, when asked for, in integers.
struct Rays::Corners {
  Near p[3];
  double M = 0;
  Whole exact_p[3];
  bool exact_made = false;
};

// kGrazes stands for a line that meets the border of the face or lies in its plane; kGrazes + 1 and - 1
// for the border with the sign of the passage known.
int Rays::passes(Line& line, Corners& c, Index f) const {
  for (int k = 0; k < 3; ++k) {
    const double* q = corner(f, k);
    for (int i = 0; i < 3; ++i) c.p[k][i] = q[i] - line.m.near[i];
    c.M = std::max(c.M, largest(c.p[k]));
  }
  // Signs of det(d, a, b), det(d, b, c), det(d, c, a). The bound: six products, each with the rounding of
  // its factors (an ulp of the coordinates, not of the differences) and its own.
  const double bound = line.size_d * c.M * (1e-14 * c.M + 6e-15 * line.S) + 1e-290;
  int s[3];
  bool grazes = false;
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    const double value = filter_ ? det(line.d.near, c.p[k], c.p[n]) : 0;
    if (filter_ && std::fabs(value) > bound) {
      s[k] = value > 0 ? 1 : -1;
    } else {
      make_exact(line.start, line.line, line.m, line.d);
      if (!c.exact_made) {
        const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
        seen_from(*line.start, corners, c.exact_p);
        c.exact_made = true;
      }
      s[k] = det_sign(line.line->numerator, c.exact_p[k], c.exact_p[n]);
      if (s[k] == 0 && line.tilt) {
        if (!line.lean) line.lean.emplace(line.tilt->x);
        s[k] = det_sign(line.lean->numerator, c.exact_p[k], c.exact_p[n]);
      }
      if (s[k] == 0) grazes = true;
    }
    if (k > 0 && s[k] * s[k - 1] < 0) return 0;
  }
  if (s[0] * s[2] < 0) return 0;
  const int sum = s[0] + s[1] + s[2];
  if (!grazes) return sum > 0 ? 1 : -1;
  return sum > 0 ? kGrazes + 1 : sum < 0 ? -kGrazes - 1 : kGrazes;
}

int Rays::passes(const Point& m, const Point& towards, Index f) const {
  std::optional<Point> other;
  const Point& d = with_digits(towards, other);
  Line line{m, d, nullptr, largest(d.near), std::max(scale_, largest(m.near)), {}, {}, {}};
  Corners corners;
  const int s = passes(line, corners, f);
  return std::abs(s) >= kGrazes ? kGrazes : s;
}

double Rays::height(const Point& m, Index f, double& error) const {
  const double *a = corner(f, 0), *b = corner(f, 1), *c = corner(f, 2);
  Near u, v, w;
  for (int k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k], w[k] = m.near[k] - a[k];
  const double S = std::max(scale_, largest(m.near)),
               M = std::max(std::max(largest(u), largest(v)), largest(w));
  error = filter_ ? M * M * (1e-14 * M + 1e-14 * S) + 1e-290 : HUGE_VAL;
  return det(u, v, w);
}

int Rays::side(const Point& m, Index f) const {
  double error;
  const double value = height(m, f, error);
  if (std::fabs(value) > error) return value > 0 ? 1 : -1;
  const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
  if (m.in_doubles) return orient3d(corners[0], corners[1], corners[2], m.near.data());
  thread_local mpz_class height;
  Plane(corners).height(Homogeneous(m.x), height);
  return sgn(height);
}

Rational Rays::cut(const Point& a, const Point& b, Index f) const {
  const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
  const Plane plane(corners);
  const Homogeneous from(a.x), to(b.x);
  mpz_class x, y;
  plane.height(from, x);
  plane.height(to, y);
  x *= to.denominator;
  y *= from.denominator;
  OVERTET_EXPECTS(x != y);
  Rational t(x, x - y);
  t.canonicalize();
  return t;
}

RayCount Rays::count(const Point& m, const Point& towards, const Point* tilt, const std::vector<Index>& skip,
                     RayQuestion question) const {
  RayCount out;
  std::optional<Point> other;
  const Point& d = with_digits(towards, other);
  const double S = std::max(scale_, largest(m.near));
  // The start and the direction are known to an ulp each: over the length of the surface that is far
  // less than this slack, which costs nothing.
  const double slack = 1e-12 * S;
  Line line{m, d, tilt, largest(d.near), S, {}, {}, {}};
  bvh_.query_ray(m.near.data(), d.near.data(), slack, [&](Index f) {
    if (out.status != RayStatus::counted) return;
    if (!skip.empty() && std::binary_search(skip.begin(), skip.end(), f)) return;
    Corners c;
    const int s = passes(line, c, f);
    if (s == 0) return;
    if (s == kGrazes) {
      out.status = RayStatus::grazes;
      return;
    }
    // Which side of the face the start is on: det(a, b, c).
    int side;
    const double value = filter_ ? det(c.p[0], c.p[1], c.p[2]) : 0;
    if (filter_ && std::fabs(value) > c.M * c.M * (1e-14 * c.M + 1e-14 * S) + 1e-290) {
      side = value > 0 ? 1 : -1;
    } else {
      make_exact(line.start, line.line, m, d);
      if (!c.exact_made) {
        const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
        seen_from(*line.start, corners, c.exact_p);
      }
      side = det_sign(c.exact_p[0], c.exact_p[1], c.exact_p[2]);
    }
    if (side != 0 && (side > 0) != (s > 0)) return;  // behind the start
    if (std::abs(s) > kGrazes) {
      out.status = RayStatus::grazes;
      return;
    }
    if (side == 0) {
      out.status = RayStatus::starts_on_surface;
      return;
    }
    out.winding += s;
    if (question == RayQuestion::winding_and_nearest) {
      const Vec n = normal(f);
      const Rational t = dot(n, vec(corner(f, 0)) - m.x) / dot(n, towards.x);
      if (!out.nearest || t < *out.nearest) out.nearest = t;
    }
  });
  return out;
}

std::vector<Index> Rays::faces_at(const Point& m) const {
  double lo[3], hi[3];
  const double slack = 1e-12 * std::max(scale_, largest(m.near));
  for (int k = 0; k < 3; ++k) lo[k] = m.near[k] - slack, hi[k] = m.near[k] + slack;
  std::vector<Index> out;
  const Homogeneous start(m.x);
  bvh_.query_box(lo, hi, [&](Index f) {
    const double* corners[3] = {corner(f, 0), corner(f, 1), corner(f, 2)};
    Whole p[3];
    seen_from(start, corners, p);
    const Whole ab = cross(p[0], p[1]);
    if (dot_sign(ab, p[2]) != 0) return;
    const Whole bc = cross(p[1], p[2]), ca = cross(p[2], p[0]);
    const Whole n{mpz_class(ab[0] + bc[0] + ca[0]), mpz_class(ab[1] + bc[1] + ca[1]),
                  mpz_class(ab[2] + bc[2] + ca[2])};
    if (dot_sign(n, ab) >= 0 && dot_sign(n, bc) >= 0 && dot_sign(n, ca) >= 0) out.push_back(f);
  });
  std::sort(out.begin(), out.end());
  return out;
}

std::optional<int> Rays::winding(const Point& m) const {
  for (int attempt = 0;; ++attempt) {
    // Almost along an axis, so that few faces are looked at; two tilts make grazing rare.
    const double d[3] = {1, 0x1p-8 * scatter(2 * attempt), 0x1p-8 * scatter(2 * attempt + 1)};
    const double t[3] = {0, 0.5 + 0.4 * scatter(attempt + 7), 1};
    const Point direction(d), tilt(t);
    const RayCount got = count(m, direction, &tilt, {});
    if (got.status == RayStatus::counted) return got.winding;
    if (got.status == RayStatus::starts_on_surface) return std::nullopt;
    if (attempt % 8 == 7 && !faces_at(m).empty()) return std::nullopt;
  }
}

}  // namespace overtet::exact
