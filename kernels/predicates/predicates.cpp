#include "kernels/predicates/predicates.h"

#include <gmpxx.h>

#include <bit>
#include <cstdint>
#include <initializer_list>

#include "kernels/parallel/counts.h"

namespace overtet {

namespace {

using Rational = mpq_class;

// A sum of doubles that do not overlap, smallest first, zeros left out (Shewchuk 1997).
template <int Capacity>
struct Expansion {
  double term[Capacity];
  int size = 0;
  void push(double x) {
    if (x != 0) term[size++] = x;
  }
  int sign() const { return size == 0 ? 0 : term[size - 1] > 0 ? 1 : -1; }
};

inline void two_sum(double a, double b, double& sum, double& error) {
  sum = a + b;
  const double bv = sum - a, av = sum - bv;
  error = (a - av) + (b - bv);
}

inline void fast_two_sum(double a, double b, double& sum, double& error) {  // |a| >= |b|
  sum = a + b;
  error = b - (sum - a);
}

inline void two_product(double a, double b, double& product, double& error) {
  product = a * b;
  constexpr double splitter = 134217729.0;  // 2^27 + 1
  const double ca = splitter * a, ah = ca - (ca - a), al = a - ah;
  const double cb = splitter * b, bh = cb - (cb - b), bl = b - bh;
  error = al * bl - (((product - ah * bh) - al * bh) - ah * bl);
}

using Difference = Expansion<2>;

inline Difference difference(double a, double b) {
  double hi, lo;
  two_sum(a, -b, hi, lo);
  Difference e;
  e.push(lo);
  e.push(hi);
  return e;
}

// e + s f for s = 1 or -1.
template <int N, int M>
Expansion<N + M> add(const Expansion<N>& e, const Expansion<M>& f, double s = 1) {
  Expansion<N + M> h;
  int i = 0, j = 0;
  const auto next = [&] {
    if (j >= f.size || (i < e.size && std::fabs(e.term[i]) < std::fabs(f.term[j]))) return e.term[i++];
    return s * f.term[j++];
  };
  const int total = e.size + f.size;
  if (total == 0) return h;
  double q = next();
  for (int k = 1; k < total; ++k) {
    double sum, error;
    two_sum(q, next(), sum, error);
    h.push(error);
    q = sum;
  }
  h.push(q);
  return h;
}

template <int N>
Expansion<2 * N> scale(const Expansion<N>& e, double b) {
  Expansion<2 * N> h;
  if (e.size == 0 || b == 0) return h;
  double q, error;
  two_product(e.term[0], b, q, error);
  h.push(error);
  for (int k = 1; k < e.size; ++k) {
    double hi, lo, sum;
    two_product(e.term[k], b, hi, lo);
    two_sum(q, lo, sum, error);
    h.push(error);
    fast_two_sum(hi, sum, q, error);
    h.push(error);
  }
  h.push(q);
  return h;
}

template <int N>
Expansion<4 * N> multiply(const Expansion<N>& e, const Difference& d) {
  if (d.size == 0) return {};
  Expansion<2 * N> low = scale(e, d.term[0]);
  if (d.size == 1) {
    Expansion<4 * N> h;
    for (int k = 0; k < low.size; ++k) h.push(low.term[k]);
    return h;
  }
  return add(low, scale(e, d.term[1]));
}

// Within these limits no product of three components leaves the range of doubles: the lowest bit of a
// component is above 2^-353, of a product of three above 2^-1060.
bool safe(const Difference& d) {
  for (int k = 0; k < d.size; ++k)
    if (!(std::fabs(d.term[k]) >= 0x1p-300 && std::fabs(d.term[k]) <= 0x1p300)) return false;
  return true;
}

// Rational numbers of what is not finite end the program.
bool finite(std::initializer_list<double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

int orient3d_rational(const double* a, const double* b, const double* c, const double* d) {
  for (const double* p : {a, b, c, d})
    if (!finite({p[0], p[1], p[2]})) return 0;
  Rational m[3][3];
  const double* row[3] = {b, c, d};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) m[i][k] = Rational(row[i][k]) - Rational(a[k]);
  return sgn(Rational(m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                      m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                      m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])));
}

// The coordinates of some points along one axis as whole numbers below 2^60, scaled by a power of two. False
// when their bits span more than that.
using Wide = __int128;
template <int N>
bool whole(const double (&x)[N], std::int64_t (&out)[N]) {
  double most = 0;
  for (const double v : x) most = std::max(most, std::fabs(v));
  const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(most) >> 52);  // 1023: 1 <= most < 2
  if (exponent < 100 || exponent > 1900) return false;
  const double scale = std::bit_cast<double>(static_cast<std::uint64_t>(2 * 1023 + 59 - exponent) << 52);
  bool exact = true;
  for (int i = 0; i < N; ++i) {
    const double v = x[i] * scale;  // a power of two: nothing is lost, or v is far from whole
    out[i] = static_cast<std::int64_t>(v);
    exact &= static_cast<double>(out[i]) == v;
  }
  return exact;
}

// The sign of the sum of minor times factor, minors below 2^123, factors below 2^61 in absolute value: 192
// bits.
int sign_of_sum(const Wide (&minor)[3], const std::int64_t (&factor)[3]) {
  Wide high = 0, low = 0;
  for (int i = 0; i < 3; ++i) {
    high += static_cast<Wide>(static_cast<std::int64_t>(minor[i] >> 64)) * factor[i];
    low += static_cast<Wide>(static_cast<std::uint64_t>(minor[i])) * factor[i];
  }
  high += low >> 64;
  if (high != 0) return high > 0 ? 1 : -1;
  return static_cast<std::uint64_t>(low) != 0 ? 1 : 0;
}

// The closed interval test on a line: p, q, r collinear in the plane, r within the box of pq.
bool within(double px, double py, double qx, double qy, double rx, double ry) {
  return std::min(px, qx) <= rx && rx <= std::max(px, qx) && std::min(py, qy) <= ry && ry <= std::max(py, qy);
}

// A view of 3D points in the plane of coordinates (i, j).
struct Plane {
  int i, j;
  int orient(const double* a, const double* b, const double* c) const {
    return orient2d(a[i], a[j], b[i], b[j], c[i], c[j]);
  }
  bool within_box(const double* p, const double* q, const double* r) const {
    return within(p[i], p[j], q[i], q[j], r[i], r[j]);
  }
  // Closed segments; points allowed.
  bool segments(const double* p, const double* q, const double* r, const double* s) const {
    const int r_side = orient(p, q, r), s_side = orient(p, q, s);
    if (r_side * s_side > 0) return false;
    const int p_side = orient(r, s, p), q_side = orient(r, s, q);
    if (p_side * q_side > 0) return false;
    if (r_side * s_side < 0 && p_side * q_side < 0) return true;
    return (r_side == 0 && within_box(p, q, r)) || (s_side == 0 && within_box(p, q, s)) ||
           (p_side == 0 && within_box(r, s, p)) || (q_side == 0 && within_box(r, s, q));
  }
  // The closed triangle; it must not be flat in this view.
  bool inside(const double* p, const double* a, const double* b, const double* c) const {
    const int x = orient(a, b, p), y = orient(b, c, p), z = orient(c, a, p);
    return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
  }
};
constexpr Plane planes[3] = {{0, 1}, {1, 2}, {2, 0}};

// A view in which the triangle keeps its area, or null when it has none.
const Plane* view_of(const double* a, const double* b, const double* c) {
  for (const Plane& v : planes)
    if (v.orient(a, b, c) != 0) return &v;
  return nullptr;
}

// Closed segments in space. Coplanar ones meet exactly when they meet in all three views: in one of
// them their plane (or line) keeps all distances between different points.
bool segments_intersect(const double* p, const double* q, const double* r, const double* s) {
  if (orient3d(p, q, r, s) != 0) return false;
  for (const Plane& v : planes)
    if (!v.segments(p, q, r, s)) return false;
  return true;
}

bool coplanar_segment_triangle(const Plane& v, const double* p, const double* q, const double* a,
                               const double* b, const double* c) {
  return v.inside(p, a, b, c) || v.segments(p, q, a, b) || v.segments(p, q, b, c) || v.segments(p, q, c, a);
}

// The sides of several points of one plane: its normal is computed once. Answers are orient3d's; the bound
// is the same, over the coordinates of all points.
template <int N>
void sides(const double* a, const double* b, const double* c, const double* const* d, int* out) {
  using predicates_detail::max3;
  const double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
  const double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
  const double nz = bx * cy - by * cx, nx = by * cz - bz * cy, ny = bz * cx - bx * cz;
  double mx = std::max(std::fabs(bx), std::fabs(cx)), my = std::max(std::fabs(by), std::fabs(cy)),
         mz = std::max(std::fabs(bz), std::fabs(cz));
  double det[N];
  for (int i = 0; i < N; ++i) {
    const double dx = d[i][0] - a[0], dy = d[i][1] - a[1], dz = d[i][2] - a[2];
    det[i] = nz * dz + nx * dx + ny * dy;
    mx = std::max(mx, std::fabs(dx));
    my = std::max(my, std::fabs(dy));
    mz = std::max(mz, std::fabs(dz));
  }
  const bool in_range = std::min(std::min(mx, my), mz) >= 1e-97 && max3(mx, my, mz) <= 1e102;
  const double bound = 5.12e-15 * mx * my * mz;
  for (int i = 0; i < N; ++i)
    out[i] = in_range && det[i] > bound ? 1 : in_range && det[i] < -bound ? -1 : orient3d(a, b, c, d[i]);
}

// p and q on different sides (or one of them on the plane) of a triangle with area.
bool piercing(const double* p, const double* q, const double* a, const double* b, const double* c) {
  const int x = orient3d(p, q, a, b), y = orient3d(p, q, b, c);
  if (x * y < 0) return false;
  const int z = orient3d(p, q, c, a);
  return x * z >= 0 && y * z >= 0;
}

// The same with the sides of p and q known; abc has an area unless all sides are 0.
bool segment_triangle(const double* p, const double* q, int p_side, int q_side, const double* a,
                      const double* b, const double* c) {
  if (p_side * q_side > 0) return false;
  if (p_side != 0 || q_side != 0) return piercing(p, q, a, b, c);
  if (const Plane* v = view_of(a, b, c)) return coplanar_segment_triangle(*v, p, q, a, b, c);
  return segments_intersect(p, q, a, b) || segments_intersect(p, q, b, c) || segments_intersect(p, q, c, a);
}

}  // namespace

namespace predicates_detail {

int orient3d_slow(const double* a, const double* b, const double* c, const double* d) {
  {
    const double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
    const double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
    const double dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
    const double bc = bx * cy, cb = by * cx, bc1 = by * cz, cb1 = bz * cy, bc2 = bz * cx, cb2 = bx * cz;
    const double det = (bc - cb) * dz + (bc1 - cb1) * dx + (bc2 - cb2) * dy;
    const double permanent = (std::fabs(bc) + std::fabs(cb)) * std::fabs(dz) +
                             (std::fabs(bc1) + std::fabs(cb1)) * std::fabs(dx) +
                             (std::fabs(bc2) + std::fabs(cb2)) * std::fabs(dy);
    const double high = max3(max3(std::fabs(bx), std::fabs(by), std::fabs(bz)),
                             max3(std::fabs(cx), std::fabs(cy), std::fabs(cz)),
                             max3(std::fabs(dx), std::fabs(dy), std::fabs(dz)));
    // Shewchuk's bound (7 + 56 eps) eps. A product that underflows is wrong by 1e-323 at most, which
    // times 1e30 stays far below the second term.
    if (high <= 1e30) {
      const double bound = 8e-16 * permanent + 1e-280;
      if (det > bound) return 1;
      if (det < -bound) return -1;
    }
  }
  count(Count::exact_evaluations);
  // Whole numbers, where the coordinates along each axis are of similar size: several times as fast as
  // expansions.
  std::int64_t at[3][4];
  bool similar = true;
  for (int k = 0; k < 3 && similar; ++k) similar = whole({a[k], b[k], c[k], d[k]}, at[k]);
  if (similar) {
    const auto from_a = [&](int axis, int point) { return at[axis][point] - at[axis][0]; };
    const auto minor = [&](int i, int j) {
      return static_cast<Wide>(from_a(i, 1)) * from_a(j, 2) - static_cast<Wide>(from_a(j, 1)) * from_a(i, 2);
    };
    return sign_of_sum({minor(0, 1), minor(1, 2), minor(2, 0)}, {from_a(2, 3), from_a(0, 3), from_a(1, 3)});
  }
  Difference B[3], C[3], D[3];
  bool in_range = true;
  for (int k = 0; k < 3; ++k) {
    // Differences of huge numbers may overflow; the test below then sends them to the rationals.
    B[k] = difference(b[k], a[k]);
    C[k] = difference(c[k], a[k]);
    D[k] = difference(d[k], a[k]);
    in_range = in_range && safe(B[k]) && safe(C[k]) && safe(D[k]);
  }
  if (!in_range) return orient3d_rational(a, b, c, d);
  const auto minor = [&](int i, int j) { return add(multiply(B[i], C[j]), multiply(B[j], C[i]), -1); };
  const auto z = multiply(minor(0, 1), D[2]);
  const auto x = multiply(minor(1, 2), D[0]);
  const auto y = multiply(minor(2, 0), D[1]);
  return add(add(z, x), y).sign();
}

int orient2d_slow(double ax, double ay, double bx, double by, double cx, double cy) {
  count(Count::exact_evaluations);
  std::int64_t x[3], y[3];
  if (whole({ax, bx, cx}, x) && whole({ay, by, cy}, y)) {
    const Wide det =
        static_cast<Wide>(x[1] - x[0]) * (y[2] - y[0]) - static_cast<Wide>(y[1] - y[0]) * (x[2] - x[0]);
    return det > 0 ? 1 : det < 0 ? -1 : 0;
  }
  const Difference px = difference(bx, ax), py = difference(by, ay);
  const Difference qx = difference(cx, ax), qy = difference(cy, ay);
  if (safe(px) && safe(py) && safe(qx) && safe(qy)) return add(multiply(px, qy), multiply(py, qx), -1).sign();
  if (!finite({ax, ay, bx, by, cx, cy})) return 0;
  return sgn(Rational((Rational(bx) - Rational(ax)) * (Rational(cy) - Rational(ay)) -
                      (Rational(by) - Rational(ay)) * (Rational(cx) - Rational(ax))));
}

}  // namespace predicates_detail

bool collinear(const double* a, const double* b, const double* c) { return view_of(a, b, c) == nullptr; }

bool segment_triangle_intersect(const double* p, const double* q, const double* a, const double* b,
                                const double* c) {
  return segment_triangle(p, q, orient3d(a, b, c, p), orient3d(a, b, c, q), a, b, c);
}

bool triangles_intersect(const double* a0, const double* a1, const double* a2, const double* b0,
                         const double* b1, const double* b2) {
  const double* a[3] = {a0, a1, a2};
  const double* b[3] = {b0, b1, b2};
  int side_b[3], side_a[3];
  sides<3>(a0, a1, a2, b, side_b);
  if (side_b[0] != 0 && side_b[0] == side_b[1] && side_b[0] == side_b[2]) return false;
  sides<3>(b0, b1, b2, a, side_a);
  if (side_a[0] != 0 && side_a[0] == side_a[1] && side_a[0] == side_a[2]) return false;
  // Two triangles that meet do so on an edge of one of them, coplanar or flat ones too.
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    if (segment_triangle(b[k], b[n], side_b[k], side_b[n], a0, a1, a2)) return true;
    if (segment_triangle(a[k], a[n], side_a[k], side_a[n], b0, b1, b2)) return true;
  }
  return false;
}

bool triangles_intersect_beyond_vertex(const double* v, const double* a, const double* b, const double* c,
                                       const double* d) {
  const double *cd[2] = {c, d}, *ab[2] = {a, b};
  int cd_side[2], ab_side[2];
  sides<2>(v, a, b, cd, cd_side);
  if (cd_side[0] * cd_side[1] > 0) return false;
  sides<2>(v, c, d, ab, ab_side);
  if (ab_side[0] * ab_side[1] > 0) return false;
  // Follow the ray from v through a common point to the first far edge: that edge meets the other one.
  return segment_triangle(a, b, ab_side[0], ab_side[1], v, c, d) ||
         segment_triangle(c, d, cd_side[0], cd_side[1], v, a, b);
}

bool triangles_overlap_at_edge(const double* a, const double* b, const double* c, const double* d) {
  if (orient3d(a, b, c, d) != 0) return false;
  for (const Plane& view : planes)
    if (view.orient(a, b, c) * view.orient(a, b, d) > 0) return true;
  return false;
}

bool faces_intersect(const double* V, const Index* f, const Index* g) {
  // Bit 3 i + j: corner i of f is corner j of g. Without branches: this runs for every pair of boxes.
  unsigned same = 0;
  same |= unsigned{f[0] == g[0]} | unsigned{f[0] == g[1]} << 1 | unsigned{f[0] == g[2]} << 2;
  same |= unsigned{f[1] == g[0]} << 3 | unsigned{f[1] == g[1]} << 4 | unsigned{f[1] == g[2]} << 5;
  same |= unsigned{f[2] == g[0]} << 6 | unsigned{f[2] == g[1]} << 7 | unsigned{f[2] == g[2]} << 8;
  const auto p = [&](const Index* face, int k) { return V + 3 * static_cast<std::ptrdiff_t>(face[k]); };
  if (same == 0) return triangles_intersect(p(f, 0), p(f, 1), p(f, 2), p(g, 0), p(g, 1), p(g, 2));
  constexpr int next[3] = {1, 2, 0}, after[3] = {2, 0, 1};
  const int first = __builtin_ctz(same), i = first / 3, j = first % 3;
  const unsigned rest = same & (same - 1);
  if (rest == 0)
    return triangles_intersect_beyond_vertex(p(f, i), p(f, next[i]), p(f, after[i]), p(g, next[j]),
                                             p(g, after[j]));
  if ((rest & (rest - 1)) != 0) return true;
  const int second = __builtin_ctz(rest), i2 = second / 3, j2 = second % 3;
  return triangles_overlap_at_edge(p(f, i), p(f, i2), p(f, 3 - i - i2), p(g, 3 - j - j2));
}

}  // namespace overtet
