#include "src/certificates/winding_range.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "kernels/core/assertions.h"
#include "kernels/predicates/predicates.h"
#include "src/arrangement/intersection_graph.h"
#include "src/exact/in_plane.h"
#include "src/exact/tuning.h"
#include "src/exact/wedges.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::RayCount;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;

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

class PairStudy {
 public:
  PairStudy(const Rays& rays, const IntersectionGraph& graph) : rays_(rays), graph_(graph), wedges_(rays) {}

  // pre: the graph is prepared for the pair's segment.
  PairFinding run(std::size_t pair) const {
    PairFinding out;
    const auto [f, g] = graph_.pairs()[pair];
    switch (graph_.kind(pair)) {
      case IntersectionGraph::Kind::segment:
        pieces(graph_.segment_of(pair), out);
        break;
      case IntersectionGraph::Kind::coplanar:
        coplanar(f, g, out);
        break;
      default:
        out.touches = true;
    }
    return out;
  }

 private:
  // Looks at a point of every piece of a segment, on the way along its longest extent.
  void pieces(Index number, PairFinding& out) const {
    const IntersectionGraph::Segment& s = graph_.segments()[number];
    const IntersectionGraph::Cuts& cuts = graph_.cuts(number);
    const auto [f, g] = s.faces;
    const Vec u = exact::cross(rays_.normal(f), rays_.normal(g));
    const Vec &a = graph_.position(s.node[0]).x, &b = graph_.position(s.node[1]).x;
    const bool ahead = goes_up(u, a, b);
    const Vec &from = ahead ? a : b, along = ahead ? b - a : a - b;
    const int n = static_cast<int>(cuts.places.size());
    bool regular = s.plain() && !cuts.in_plane;
    std::vector<int> level{0};  // of each piece, relative to the first
    for (int i = 0; i < n; ++i) {
      const IntersectionGraph::Cut& cut = cuts.places[ahead ? i : n - 1 - i];
      regular = regular && cut.plain;
      level.push_back(level.back() + (ahead ? cut.step : -cut.step));
    }
    const auto place = [&](int i) -> Rational {  // where piece i begins, and piece i - 1 ends
      if (i == 0 || i == n + 1) return i == 0 ? 0 : 1;
      const Rational at = graph_.place(rays_, number, cuts.places[ahead ? i - 1 : n - i]);
      return ahead ? at : Rational(1 - at);
    };
    if (regular) {
      // One ray, on the lowest piece; the others follow from it.
      const int lowest = static_cast<int>(std::min_element(level.begin(), level.end()) - level.begin());
      if (front_wedge(f, g, u, from, along, place(lowest), place(lowest + 1), out)) {
        out.max += *std::max_element(level.begin(), level.end()) - level[lowest];
        return;
      }
    }
    Rational begin = 0;
    for (int i = 0; i <= n; ++i) {
      Rational end = place(i + 1);
      all_wedges(u, Point(from + ((begin + end) / 2) * along), out);
      begin = std::move(end);
    }
  }

  // Whether the largest coordinate of a direction grows from a to b.
  static bool goes_up(const Vec& u, const Vec& a, const Vec& b) {
    int axis = 0;
    const auto size = exact::approximate(u);
    for (int k = 1; k < 3; ++k)
      if (std::fabs(size[k]) > std::fabs(size[axis])) axis = k;
    if (exact::sign(u[axis]) == 0)
      for (int k = 0; k < 3; ++k)
        if (exact::sign(u[k]) != 0) axis = k;
    return a[axis] < b[axis];
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

  // The piece of an edge of face x inside face y, coplanar; false if there is none.
  bool outline(Index x, int k, Index y, PairFinding& out) const {
    const double *from = rays_.corner(x, k), *to = rays_.corner(x, (k + 1) % 3);
    const Point start(from), end(to);
    const exact::PlaneView view(rays_, y);
    Rational lo = 0, hi = 1;
    for (int j = 0; j < 3; ++j) {
      const auto c = view.crossing(start, end, rays_.corner(y, j), rays_.corner(y, (j + 1) % 3));
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
    for (const Index h : graph_.common_partners(x, y)) {
      const double* corners[3] = {rays_.corner(h, 0), rays_.corner(h, 1), rays_.corner(h, 2)};
      const int s = orient3d(corners[0], corners[1], corners[2], from);
      const int t = orient3d(corners[0], corners[1], corners[2], to);
      if (s * t < 0) {
        if (rays_.passes(start, line, h) != 0) add(rays_.cut(start, end, h));
      } else if (s == 0 && t == 0) {
        const exact::PlaneView flat(rays_, h);
        for (int j = 0; j < 3; ++j) {
          const double *a = corners[j], *b = corners[(j + 1) % 3];
          const auto c = flat.crossing(start, end, a, b);
          // Only the edge cuts, not the line on which it lies.
          if (c.crosses() && flat.side(from, to, a) * flat.side(from, to, b) <= 0) add(c.place());
        }
      }
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 1; i < cuts.size(); ++i)
      if (cuts[i - 1] < cuts[i]) all_wedges(e, Point(p + ((cuts[i - 1] + cuts[i]) / 2) * e), out);
    return true;
  }

  struct Place {
    Vec m;
    exact::Whole u;  // along the line through it
  };

  const Rays& rays_;
  const IntersectionGraph& graph_;
  const Wedges wedges_;
  mutable std::mutex places_mutex_;
  mutable std::map<std::array<double, 3>, std::vector<std::pair<Place, PairFinding>>>
      places_;  // by rounded m
};

// The point half-way from the wedge's corner to the next crossing, or a little way when there is none.
std::optional<WindingCertificate> make_witness(const Rays& rays, const Wedge& wedge) {
  const Point start(wedge.start), direction(wedge.direction);
  const RayCount ray =
      rays.count(start, direction, nullptr, wedge.skip, exact::RayQuestion::winding_and_nearest);
  if (ray.status != RayStatus::counted) return std::nullopt;
  Rational step = ray.nearest ? *ray.nearest / 2 : Rational(1);
  WindingCertificate out;
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

// Where the winding number is negative: wedges, each with the pair that shows it; (-1, -1): a component.
struct Negatives {
  std::vector<Wedge> wedges;
  std::vector<FacePair> at;
};

// All pairs, in waves, so that the search can end early at the same place on any number of threads.
Status look_at_pairs(const Rays& rays, IntersectionGraph& graph, const RunContext& context,
                     const WindingRangeOptions& options, WindingRange& out, Negatives& negatives) {
  const std::vector<FacePair>& pairs = graph.pairs();
  const PairStudy study(rays, graph);
  constexpr std::size_t wave = 512;
  for (std::size_t first = 0; first < pairs.size(); first += wave) {
    if (auto stop = context.stop()) return *stop;
    if (options.stop_at_first_negative && !negatives.wedges.empty()) {
      out.complete = false;
      break;
    }
    const std::size_t last = std::min(first + wave, pairs.size());
    const Index segments = static_cast<Index>(graph.segments().size());
    const Status ready = graph.prepare(rays, graph.segment_of(first),
                                       last < pairs.size() ? graph.segment_of(last) : segments, context);
    if (!ready) return ready.error();
    std::vector<PairFinding> findings(last - first);
    parallel_for(static_cast<std::int64_t>(last - first), 8, [&](std::int64_t begin, std::int64_t end) {
      if (context.stop()) return;
      for (std::int64_t i = begin; i < end; ++i) findings[i] = study.run(first + i);
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
        negatives.wedges.push_back(*x.lowest);
        negatives.at.push_back(pairs[first + i]);
      }
    }
  }
  return success();
}

// One look, at a face: just in front of it and behind it, at its centre as far as rays from there count.
void look_at_face(const Rays& rays, Index f, WindingRange& out, Negatives& negatives) {
  for (int attempt = 0; attempt < kRayAttempts; ++attempt) {
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
      negatives.wedges.push_back(
          Wedge{m, in_front ? n : back, skip, std::min(ahead.winding, behind.winding)});
      negatives.at.emplace_back(-1, -1);
    }
    return;
  }
}

// The certificate with the lowest number, plain doubles preferred; the first of those.
std::optional<WindingCertificate> best_witness(const Rays& rays, const std::vector<Wedge>& negative) {
  std::vector<std::size_t> order(negative.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return negative[a].winding < negative[b].winding; });
  std::optional<WindingCertificate> best;
  for (std::size_t tries = 0; tries < order.size(); ++tries) {
    auto witness = make_witness(rays, negative[order[tries]]);
    if (!witness) continue;
    if (!best || (witness->doubles_suffice && !best->doubles_suffice)) best = witness;
    if (best->doubles_suffice || tries > 64) break;
  }
  return best;
}

}  // namespace

Result<WindingRange> find_winding_range(const Surface& surface, const SurfaceTopology& topology,
                                        const TriangleBvh& bvh, IntersectionGraph& graph,
                                        const RunContext& context, const WindingRangeOptions& options) {
  OVERTET_EXPECTS(degenerate_faces(surface).empty());
  const Rays rays(surface.V, surface.F, bvh);
  WindingRange out;
  if (auto stop = context.stop()) return *stop;
  Negatives negatives;
  if (const Status looked = look_at_pairs(rays, graph, context, options, out, negatives); !looked)
    return looked.error();
  for (const SurfaceComponent& component : topology.components)
    look_at_face(rays, component.first_face, out, negatives);
  out.witness = best_witness(rays, negatives.wedges);
  out.negative_at = std::move(negatives.at);
  return out;
}

}  // namespace overtet
