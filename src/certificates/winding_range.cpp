#include "src/certificates/winding_range.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "kernels/predicates/predicates.h"
#include "src/exact/wedges.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::RayCount;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;

constexpr int kAttempts = 12;  // other places when a ray grazes an edge

// What one pair says about the winding number.
struct PairFinding {
  bool seen = false;
  bool touches = false;  // no common segment
  int min = 0, max = 0;
  std::optional<Wedge> lowest;
  void add(int low, int high) {
    min = seen ? std::min(min, low) : low;
    max = seen ? std::max(max, high) : high;
    seen = true;
  }
};

// Where a third face crosses a pair's segment.
struct Cut {
  Index face = -1;
  int step = 0;                // how the winding number changes there, on the way along the segment
  double near = 0, error = 0;  // the place on the segment, 0 to 1
  std::optional<Rational> exact;
};

class PairStudy {
 public:
  PairStudy(const Rays& rays, const Partners& partners) : rays_(rays), partners_(partners), wedges_(rays) {}

  PairFinding run(const FacePair& pair) const {
    PairFinding out;
    const Index f = pair.first, g = pair.second;
    const Sides sides_f = sides(f, g), sides_g = sides(g, f);
    if (sides_f == Sides{}) {
      coplanar(f, g, out);
      return out;
    }
    // A face that meets the other one's plane in no more than a corner.
    const auto corner_only = [](const Sides& s) { return std::abs(s[0] + s[1] + s[2]) == 2; };
    if (corner_only(sides_f) || corner_only(sides_g)) {
      out.touches = true;
      return out;
    }
    const Vec nf = rays_.normal(f), ng = rays_.normal(g), u = exact::cross(nf, ng);
    bool regular = true;
    Vec from, to;
    if (!segment(f, g, sides_f, sides_g, nf, ng, u, from, to, regular)) {
      out.touches = true;
      return out;
    }
    pieces(f, g, u, from, to, regular, out);
    return out;
  }

 private:
  Vec corner(Index f, int k) const { return exact::vec(rays_.corner(f, k % 3)); }

  // On which side of face g's plane the corners of face f lie.
  using Sides = std::array<int, 3>;
  Sides sides(Index f, Index g) const {
    Sides out;
    for (int k = 0; k < 3; ++k)
      out[k] = orient3d(rays_.corner(g, 0), rays_.corner(g, 1), rays_.corner(g, 2), rays_.corner(f, k));
    return out;
  }

  // Where the plane (point o, normal n) cuts face f, whose corners lie on these sides of it: the two ends on
  // the common line.
  bool cut(Index f, const Sides& side, const Vec& o, const Vec& n, std::vector<Vec>& ends,
           bool& regular) const {
    for (int k = 0; k < 3; ++k)
      if (side[k] == 0) ends.push_back(corner(f, k));
    if (ends.size() > 1) regular = false;  // an edge of f lies in the plane
    for (int k = 0; k < 3; ++k) {
      const int m = (k + 1) % 3;
      if (side[k] * side[m] >= 0) continue;
      const Vec p = corner(f, k), q = corner(f, m);
      const Rational a = dot(n, p - o), b = dot(n, q - o);
      ends.push_back(p + (a / (a - b)) * (q - p));
    }
    return !ends.empty();
  }

  // The common segment of two faces in different planes; false when it is a point at most.
  bool segment(Index f, Index g, const Sides& sides_f, const Sides& sides_g, const Vec& nf, const Vec& ng,
               const Vec& u, Vec& from, Vec& to, bool& regular) const {
    std::vector<Vec> in_f, in_g;
    if (!cut(f, sides_f, corner(g, 0), ng, in_f, regular) ||
        !cut(g, sides_g, corner(f, 0), nf, in_g, regular))
      return false;
    int axis = 0;
    const auto size = exact::approximate(u);
    for (int k = 1; k < 3; ++k)
      if (std::fabs(size[k]) > std::fabs(size[axis])) axis = k;
    if (exact::sign(u[axis]) == 0)
      for (int k = 0; k < 3; ++k)
        if (exact::sign(u[k]) != 0) axis = k;
    const auto less = [&](const Vec& a, const Vec& b) { return a[axis] < b[axis]; };
    std::sort(in_f.begin(), in_f.end(), less);
    std::sort(in_g.begin(), in_g.end(), less);
    from = std::max(in_f.front(), in_g.front(), less);
    to = std::min(in_f.back(), in_g.back(), less);
    return from[axis] < to[axis];
  }

  // Cuts the segment where third faces' planes cross it and looks at a point of every piece.
  void pieces(Index f, Index g, const Vec& u, const Vec& from, const Vec& to, bool regular,
              PairFinding& out) const {
    const Vec along = to - from;
    const Point start(from), direction(along);
    const Point end(to);
    std::vector<Cut> cuts;
    for (const Index h : partners_.common(f, g)) {
      const int sa = rays_.side(start, h), sb = rays_.side(end, h);
      if (sa * sb > 0 || (sa == 0) != (sb == 0)) continue;
      const int passes = rays_.passes(start, direction, h);
      if (passes == 0) continue;
      if (sa * sb < 0) {
        Cut cut;
        cut.face = h;
        cut.step = -passes;
        double error_a, error_b;
        const double a = rays_.height(start, h, error_a), b = rays_.height(end, h, error_b);
        const double span = std::fabs(a - b) - error_a - error_b;
        cut.near = a / (a - b);
        cut.error = span > 0 ? 3 * (error_a + error_b) / span + 1e-15 : HUGE_VAL;
        cuts.push_back(std::move(cut));
        if (passes == Rays::kGrazes) regular = false;
      } else {
        // The segment runs in the plane of h: cut it at h's edges.
        regular = false;
        const auto [axis, up] = flat_axis(h);
        for (int k = 0; k < 3; ++k) {
          const Crossing c = crossing(start, end, rays_.corner(h, k), rays_.corner(h, (k + 1) % 3), axis, up);
          if (c.from * c.to >= 0) continue;
          Cut cut;
          cut.exact = c.place();
          cut.near = cut.exact->get_d();
          cut.error = 1e-15;
          cuts.push_back(std::move(cut));
        }
      }
    }
    const auto at = [&](Cut& cut) -> const Rational& {
      if (!cut.exact) cut.exact = rays_.cut(start, end, cut.face);
      return *cut.exact;
    };
    // The order of exact arithmetic; the doubles decide wherever they are far enough apart.
    const auto compare = [&](Cut& x, Cut& y) {
      const double gap = x.near - y.near;
      if (std::fabs(gap) > x.error + y.error) return gap < 0 ? -1 : 1;
      return cmp(at(x), at(y));
    };
    std::vector<Cut*> order;
    for (Cut& cut : cuts) order.push_back(&cut);
    std::sort(order.begin(), order.end(), [&](Cut* x, Cut* y) { return compare(*x, *y) < 0; });
    std::vector<Cut*> place;    // where pieces 1, 2, ... begin
    std::vector<int> level{0};  // of each piece, relative to the first
    for (Cut* cut : order) {
      if (!place.empty() && compare(*place.back(), *cut) == 0) {
        level.back() += cut->step;
        continue;
      }
      place.push_back(cut);
      level.push_back(level.back() + cut->step);
    }
    const auto begins = [&](int i) { return i == 0 ? Rational(0) : at(*place[i - 1]); };
    const auto ends = [&](int i) {
      return i == static_cast<int>(place.size()) ? Rational(1) : at(*place[i]);
    };
    const int n = static_cast<int>(level.size());
    if (regular) {
      // One ray, on the lowest piece; the others follow from it.
      const int lowest = static_cast<int>(std::min_element(level.begin(), level.end()) - level.begin());
      if (front_wedge(f, g, u, from, along, begins(lowest), ends(lowest), out)) {
        out.max += *std::max_element(level.begin(), level.end()) - level[lowest];
        return;
      }
    }
    for (int i = 0; i < n; ++i) all_wedges(u, Point(from + ((begins(i) + ends(i)) / 2) * along), out);
  }

  bool front_wedge(Index f, Index g, const Vec& u, const Vec& from, const Vec& along, const Rational& t0,
                   const Rational& t1, PairFinding& out) const {
    const auto wedge = wedges_.in_front(f, g, u, from, along, t0, t1);
    if (!wedge) return false;
    if (!out.lowest || wedge->winding < out.lowest->winding) out.lowest = wedge;
    out.add(wedge->winding, wedge->winding + 2);
    return true;
  }

  void all_wedges(const Vec& u, const Point& m, PairFinding& out) const {
    const PairFinding here = seen_around(u, m);
    if (!here.seen) return;
    if (!out.lowest || here.lowest->winding < out.lowest->winding) out.lowest = here.lowest;
    out.add(here.min, here.max);
  }

  // Where faces coincide many pairs ask about the same place.
  PairFinding seen_around(const Vec& u, const Point& m) const {
    const Place place{m.x, exact::primitive(u)};
    std::vector<std::pair<Place, PairFinding>>* places;
    {
      const std::scoped_lock lock(places_mutex_);
      places = &places_[m.near];
      for (const auto& [known, finding] : *places)
        if (known.m.x == place.m.x && known.u == place.u) return finding;
    }
    PairFinding finding;
    for (const Wedge& wedge : wedges_.around(place.u, m)) {
      if (!finding.lowest || wedge.winding < finding.lowest->winding) finding.lowest = wedge;
      finding.add(wedge.winding, wedge.winding);
    }
    const std::scoped_lock lock(places_mutex_);
    places->emplace_back(place, finding);  // another thread may have done the same: it is the same
    return finding;
  }

  // Coplanar faces: the curve is the outline of their common part. All pieces of the edges of each face
  // inside the other one are looked at from all sides.
  void coplanar(Index f, Index g, PairFinding& out) const {
    bool any = false;
    for (int k = 0; k < 3; ++k) any |= outline(f, k, g, out);
    for (int k = 0; k < 3; ++k) any |= outline(g, k, f, out);
    out.touches = !any;
  }

  // On which side of a face's edge from a to b the two ends of another edge lie in the same plane (1: the
  // face's), and if not on the same, how far from it.
  struct Crossing {
    int from, to;
    Rational from_height, to_height;
    Rational place() const { return from_height / (from_height - to_height); }  // on the edge, 0 to 1
  };
  Crossing crossing(const Point& from, const Point& to, const double* a, const double* b, int axis,
                    int up) const {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    const auto height = [&](const Point& p) -> Rational {
      return (Rational(b[i]) - a[i]) * (p.x[j] - a[j]) - (Rational(b[j]) - a[j]) * (p.x[i] - a[i]);
    };
    const auto side = [&](const Point& p) {
      return up *
             (p.in_doubles ? orient2d(a[i], a[j], b[i], b[j], p.near[i], p.near[j]) : exact::sign(height(p)));
    };
    Crossing out{side(from), side(to), {}, {}};
    if (out.from * out.to >= 0) return out;
    out.from_height = height(from);
    out.to_height = height(to);
    return out;
  }

  // The piece of an edge of face x inside face y, coplanar; false if there is none.
  bool outline(Index x, int k, Index y, PairFinding& out) const {
    const double *from = rays_.corner(x, k), *to = rays_.corner(x, (k + 1) % 3);
    const Point start(from), end(to);
    const auto [axis, up] = flat_axis(y);
    Rational lo = 0, hi = 1;
    for (int j = 0; j < 3; ++j) {
      const Crossing c = crossing(start, end, rays_.corner(y, j), rays_.corner(y, (j + 1) % 3), axis, up);
      if (std::max(c.from, c.to) <= 0 && std::min(c.from, c.to) < 0) return false;
      if (c.from < 0) lo = std::max(lo, c.place());
      if (c.to < 0) hi = std::min(hi, c.place());
    }
    if (!(lo < hi)) return false;
    // Cut where other faces cross, so that every piece has one answer per wedge.
    std::vector<Rational> cuts{lo, hi};
    const auto add = [&](Rational t) {
      if (lo < t && t < hi) cuts.push_back(std::move(t));
    };
    const Vec &p = start.x, e = end.x - p;
    const Point line(e);
    for (const Index h : partners_.common(x, y)) {
      const double* corners[3] = {rays_.corner(h, 0), rays_.corner(h, 1), rays_.corner(h, 2)};
      const int s = orient3d(corners[0], corners[1], corners[2], from);
      const int t = orient3d(corners[0], corners[1], corners[2], to);
      if (s * t < 0) {
        if (rays_.passes(start, line, h) != 0) add(rays_.cut(start, end, h));
      } else if (s == 0 && t == 0) {
        const auto [flat, side] = flat_axis(h);
        for (int j = 0; j < 3; ++j) {
          const double *a = corners[j], *b = corners[(j + 1) % 3];
          const Crossing c = crossing(start, end, a, b, flat, side);
          if (c.from * c.to >= 0) continue;
          // Only the edge cuts, not the line on which it lies.
          const int i1 = (flat + 1) % 3, i2 = (flat + 2) % 3;
          const int sa = orient2d(from[i1], from[i2], to[i1], to[i2], a[i1], a[i2]);
          const int sb = orient2d(from[i1], from[i2], to[i1], to[i2], b[i1], b[i2]);
          if (sa * sb <= 0) add(c.place());
        }
      }
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 1; i < cuts.size(); ++i)
      if (cuts[i - 1] < cuts[i]) all_wedges(e, Point(p + ((cuts[i - 1] + cuts[i]) / 2) * e), out);
    return true;
  }

  // An axis along which a face's plane can be looked at, and the sign of the face's area then.
  std::pair<int, int> flat_axis(Index f) const {
    const double *a = rays_.corner(f, 0), *b = rays_.corner(f, 1), *c = rays_.corner(f, 2);
    const auto n = rays_.unit_normal(f);
    int best = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(n[k]) > std::fabs(n[best])) best = k;
    for (int k = 0;; ++k) {
      const int axis = (best + k) % 3, i = (axis + 1) % 3, j = (axis + 2) % 3;
      if (const int up = orient2d(a[i], a[j], b[i], b[j], c[i], c[j]); up != 0) return {axis, up};
    }
  }

  struct Place {
    Vec m;
    exact::Whole u;  // along the line through it
  };

  const Rays& rays_;
  const Partners& partners_;
  const Wedges wedges_;
  mutable std::mutex places_mutex_;
  mutable std::map<std::array<double, 3>, std::vector<std::pair<Place, PairFinding>>>
      places_;  // by rounded m
};

// The point half-way from the wedge's corner to the next crossing, or a little way when there is none.
std::optional<WindingWitness> make_witness(const Rays& rays, const Wedge& wedge) {
  const Point start(wedge.start), direction(wedge.direction);
  const RayCount ray = rays.count(start, direction, nullptr, wedge.skip, true);
  if (ray.status != RayStatus::counted) return std::nullopt;
  Rational step = ray.nearest ? *ray.nearest / 2 : Rational(1);
  WindingWitness out;
  // Short numbers where the region is wide enough: the nearest doubles, else the exact fraction.
  const Point exact_point(wedge.start + step * wedge.direction);
  out.point = exact_point.near;
  const auto rounded = rays.winding(Point(out.point.data()));
  if (rounded && *rounded < 0) {
    const Vec p = exact::vec(out.point.data());
    for (int k = 0; k < 3; ++k) out.exact[k] = exact::fraction(p[k]);
    out.winding = *rounded;
    out.doubles_suffice = true;
    return out;
  }
  const auto winding = rays.winding(exact_point);
  if (!winding || *winding >= 0) return std::nullopt;
  for (int k = 0; k < 3; ++k) out.exact[k] = exact::fraction(exact_point.x[k]);
  out.winding = *winding;
  return out;
}

}  // namespace

Result<WindingRange> find_winding_range(const Surface& surface, const SurfaceTopology& topology,
                                        const TriangleBvh& bvh, const std::vector<FacePair>& pairs,
                                        const RunContext& context, const WindingRangeOptions& options) {
  const Rays rays(surface.V, surface.F, bvh);
  const Partners partners(pairs);
  const PairStudy study(rays, partners);
  WindingRange out;
  if (auto stop = context.stop()) return *stop;

  // In waves, so that the search can end early at the same place on any number of threads.
  std::vector<Wedge> negative;
  std::vector<FacePair> negative_pair;
  constexpr std::size_t wave = 512;
  for (std::size_t first = 0; first < pairs.size(); first += wave) {
    if (auto stop = context.stop()) return *stop;
    if (options.stop_at_first_negative && !negative.empty()) {
      out.complete = false;
      break;
    }
    const std::size_t last = std::min(first + wave, pairs.size());
    std::vector<PairFinding> findings(last - first);
    parallel_for(static_cast<std::int64_t>(last - first), 8, [&](std::int64_t begin, std::int64_t end) {
      if (context.stop()) return;
      for (std::int64_t i = begin; i < end; ++i) findings[i] = study.run(pairs[first + i]);
    });
    if (auto stop = context.stop()) return *stop;
    for (std::size_t i = 0; i < findings.size(); ++i) {
      const PairFinding& x = findings[i];
      if (!x.seen) {
        ++(x.touches ? out.touching_pairs : out.undecided_pairs);
        continue;
      }
      out.min = std::min(out.min, x.min);
      out.max = std::max(out.max, x.max);
      if (x.min < 0) {
        ++out.negative_pairs;
        negative.push_back(*x.lowest);
        negative_pair.push_back(pairs[first + i]);
      }
    }
  }

  // One look at every component: just in front of a face, at its centre as far as doubles go.
  for (const SurfaceComponent& component : topology.components) {
    const Index f = component.first_face;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Rational wa(3 + attempt), wb(3), wc(3 + attempt % 3);
      const Vec m = (Rational(1) / (wa + wb + wc)) *
                    (wa * exact::vec(rays.corner(f, 0)) + wb * exact::vec(rays.corner(f, 1)) +
                     wc * exact::vec(rays.corner(f, 2)));
      const Vec n = rays.normal(f), back = Rational(-1) * n;
      const Point start(m);
      // Others may lie in the same place.
      const std::vector<Index> skip = rays.faces_at(start);
      const RayCount ahead = rays.count(start, Point(n), nullptr, skip);
      const RayCount behind = rays.count(start, Point(back), nullptr, skip);
      if (ahead.status != RayStatus::counted || behind.status != RayStatus::counted) continue;
      out.min = std::min(out.min, std::min(ahead.winding, behind.winding));
      out.max = std::max(out.max, std::max(ahead.winding, behind.winding));
      if (ahead.winding < 0 || behind.winding < 0) {
        const bool in_front = ahead.winding <= behind.winding;
        negative.push_back(Wedge{m, in_front ? n : back, skip, std::min(ahead.winding, behind.winding)});
        negative_pair.emplace_back(-1, -1);
      }
      break;
    }
  }

  out.negative_at = negative_pair;

  // The certificate with the lowest number, plain doubles preferred; the first of those.
  std::vector<std::size_t> order(negative.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return negative[a].winding < negative[b].winding; });
  for (std::size_t tries = 0; tries < order.size(); ++tries) {
    auto witness = make_witness(rays, negative[order[tries]]);
    if (!witness) continue;
    if (negative_pair[order[tries]].first >= 0) witness->pair = negative_pair[order[tries]];
    if (!out.witness || (witness->doubles_suffice && !out.witness->doubles_suffice)) out.witness = witness;
    if (out.witness->doubles_suffice || tries > 64) break;
  }
  return out;
}

}  // namespace overtet
