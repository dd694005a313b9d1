#include "src/exact/wedges.h"

#include <algorithm>
#include <cmath>

#include "src/exact/tuning.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::RayCount;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;
using exact::Whole;

// Of length about 1. pre: not zero.
Vec shortened(const Vec& x) {
  const auto a = exact::approximate(x);
  const double big = std::max(std::max(std::fabs(a[0]), std::fabs(a[1])), std::fabs(a[2]));
  return big > 1e-290 && big < 1e290 ? Rational(1 / big) * x : exact::near_one(x);
}

using Near = std::array<double, 3>;

Near cross(const Near& a, const Near& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Near& a, const Near& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The half-planes around a line along u in which the faces through one of its points show, as directions
// across u, in order of their angles. A face is seen as one or two of them, or (with the point on its edge
// across u) as less: all n x u and -(n x u) are taken, as too many do no harm. Signs are exact, decided in
// doubles where those are sure.
class Borders {
 public:
  Borders(const Rays& rays, const Whole& u, const std::vector<Index>& faces) : u_{u, exact::unit(u)} {
    std::vector<Whole> normals;
    for (const Index f : faces) {
      Whole normal = rays.whole_normal(f);
      const Whole back = exact::opposite(normal);
      // Of faces that lie on each other one is enough.
      if (std::any_of(normals.begin(), normals.end(),
                      [&](const Whole& known) { return known == normal || known == back; }))
        continue;
      const Whole b = exact::cross(normal, u);
      normals.push_back(std::move(normal));
      if (exact::is_zero(b)) continue;
      for (const Whole& exact : {b, exact::opposite(b)}) list_.push_back({exact, exact::unit(exact)});
    }
    if (list_.empty()) return;
    first_ = list_[0];
    const Whole second = exact::cross(u, first_.exact);
    second_ = {second, exact::unit(second)};
    for (Direction& x : list_) x.half = half(x);
    std::sort(list_.begin(), list_.end(), [&](const Direction& x, const Direction& y) {
      return x.half != y.half ? x.half < y.half : turn(x, y) > 0;
    });
  }

  int size() const { return static_cast<int>(list_.size()); }
  int turn(int i, int j) const { return turn(list_[i], list_[j]); }
  bool alike(int i, int j) const { return sign_of_dot(list_[i], list_[j]) > 0; }

  // A direction between two neighbours, another one at each attempt.
  Vec between(int i, int j, int turn, int attempt) const {
    const Direction &x = list_[i], &y = list_[j];
    const double weight = 1 + 0.4 * exact::scatter(attempt);
    const double lean = attempt > 0 ? 0.3 * exact::scatter(attempt + 5) : 0;
    const Near side = turn == 0 ? cross(u_.near, x.near) : x.near;
    const Near& other = turn == 0 ? x.near : y.near;
    const double part = turn == 0 ? weight - 1 : weight;
    Direction d;
    for (int k = 0; k < 3; ++k) d.near[k] = side[k] + part * other[k] + lean * u_.near[k];
    // Doubles where the wedge is wide enough for them: short numbers are fast.
    Vec rounded = exact::vec(d.near.data());
    d.exact = exact::whole(rounded);
    if (this->turn(x, d) > 0 && (turn == 0 || this->turn(d, y) > 0)) return rounded;
    const Vec axis = shortened(u_.exact), a = shortened(x.exact);
    return (turn == 0 ? exact::cross(axis, a) + Rational(weight - 1) * a
                      : a + Rational(weight) * shortened(y.exact)) +
           Rational(lean) * axis;
  }

 private:
  struct Direction {
    Whole exact;
    Near near;  // its length is 1, or about that
    int half = 0;
  };

  // Of length about 1.
  static Vec shortened(const Whole& a) {
    std::size_t bits = 0;
    for (const mpz_class& x : a) bits = std::max(bits, mpz_sizeinbase(x.get_mpz_t(), 2));
    Vec out;
    for (int k = 0; k < 3; ++k) {
      out[k] = Rational(a[k]);
      mpq_div_2exp(out[k].get_mpq_t(), out[k].get_mpq_t(), bits);
    }
    return out;
  }

  int turn(const Direction& x, const Direction& y) const {
    const double value = dot(u_.near, cross(x.near, y.near));
    if (std::fabs(value) > kSure) return value > 0 ? 1 : -1;
    return exact::det_sign(u_.exact, x.exact, y.exact);
  }
  static int sign_of_dot(const Direction& x, const Direction& y) {
    const double value = dot(x.near, y.near);
    if (std::fabs(value) > kSure) return value > 0 ? 1 : -1;
    return exact::dot_sign(x.exact, y.exact);
  }
  int half(const Direction& v) const {
    const int side = sign_of_dot(second_, v);
    return side > 0 || (side == 0 && sign_of_dot(first_, v) > 0) ? 0 : 1;
  }

  Direction u_, first_, second_;
  std::vector<Direction> list_;
};

}  // namespace

std::optional<Wedge> Wedges::in_front(Index f, Index g, const Vec& u, const Vec& from, const Vec& along,
                                      const Rational& t0, const Rational& t1) const {
  const std::vector<Index> skip{std::min(f, g), std::max(f, g)};
  const Vec nf = rays_.normal(f), ng = rays_.normal(g);
  const auto a = rays_.unit_normal(f), b = rays_.unit_normal(g);
  for (int attempt = 0; attempt < kRayAttempts; ++attempt) {
    const Rational part(1 + attempt % 5);
    const Point m(from + ((part * t0 + t1) / (part + 1)) * along);
    const double weight = 1 + 0.4 * exact::scatter(attempt);
    const double sum[3] = {a[0] + weight * b[0], a[1] + weight * b[1], a[2] + weight * b[2]};
    Point d(sum);
    if (exact::sign(dot(nf, d.x)) <= 0 || exact::sign(dot(ng, d.x)) <= 0) {
      // A wedge too thin for doubles: u x nf and ng x u span it.
      const Vec p = exact::cross(u, nf), q = exact::cross(ng, u);
      d = Point(Rational(weight) * shortened(p) + shortened(q));
    }
    const RayCount ray = rays_.count(m, d, nullptr, skip);
    if (ray.status == RayStatus::starts_on_surface) return std::nullopt;
    if (ray.status != RayStatus::counted) continue;
    return Wedge{m.x, d.x, skip, ray.winding};
  }
  return std::nullopt;
}

std::vector<Wedge> Wedges::around(const Whole& u, const Point& m) const {
  std::vector<Wedge> out;
  const std::vector<Index> at = rays_.faces_at(m);
  if (at.empty()) return out;
  const Borders borders(rays_, u, at);
  const int n = borders.size();
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    // Every border comes with its opposite, so a wedge is half a turn at most.
    const int turn = borders.turn(i, j);
    if (turn < 0 || (turn == 0 && borders.alike(i, j))) continue;
    for (int attempt = 0; attempt < kRayAttempts; ++attempt) {
      const Vec d = borders.between(i, j, turn, attempt);
      const RayCount ray = rays_.count(m, Point(d), nullptr, at);
      if (ray.status != RayStatus::counted) continue;
      out.push_back({m.x, d, at, ray.winding});
      break;
    }
  }
  return out;
}

}  // namespace overtet
