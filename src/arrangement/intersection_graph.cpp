#include "src/arrangement/intersection_graph.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/arrangement/tuning.h"
#include "src/exact/in_plane.h"
#include "src/exact/piercing.h"
#include "src/exact/tuning.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::Vec;
using Cut = IntersectionGraph::Cut;
using Kind = IntersectionGraph::Kind;
using Meeting = IntersectionGraph::Meeting;
using Segment = IntersectionGraph::Segment;
using Simplex = IntersectionGraph::Simplex;

// What pairs of faces have in common, from predicates.
class PairMeeting {
 public:
  PairMeeting(const SurfaceTopology& topology, const Rays& rays) : topology_(topology), rays_(rays) {}

  Kind look(Index f, Index g, Segment& out) const {
    std::vector<Meeting> ends;
    if (!edges_through(f, g, false, ends)) return Kind::coplanar;
    edges_through(g, f, true, ends);
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    if (ends.empty()) return Kind::nothing;
    if (ends.size() == 1) return Kind::point;
    out.faces = {f, g};
    out.ends = {ends[0], ends[1]};
    out.along = {along(f, ends[0][0], ends[1][0]), along(g, ends[0][1], ends[1][1])};
    return Kind::segment;
  }

 private:
  const double* point(Index v) const { return rays_.V().data() + 3 * std::int64_t{v}; }
  Index edge_of(Index h) const { return std::min(h, topology_.twin[h]); }

  // Where edges of f meet g. False when the faces lie in one plane. swapped: g is the first face of the pair.
  bool edges_through(Index f, Index g, bool swapped, std::vector<Meeting>& ends) const {
    const double *p = rays_.corner(g, 0), *q = rays_.corner(g, 1), *r = rays_.corner(g, 2);
    int side[3];
    for (int k = 0; k < 3; ++k) side[k] = orient3d(p, q, r, rays_.corner(f, k));
    if (side[0] == 0 && side[1] == 0 && side[2] == 0) return false;
    const auto add = [&](Simplex in_f, Simplex in_g) {
      ends.push_back(swapped ? Meeting{in_g, in_f} : Meeting{in_f, in_g});
    };
    for (int k = 0; k < 3; ++k) {
      if (side[k] == 0) {
        const Index v = rays_.F()(f, k);
        if (const auto where = locate(v, g)) add({0, v}, *where);
      }
      if (side[k] * side[(k + 1) % 3] >= 0) continue;
      const double *a = rays_.corner(f, k), *b = rays_.corner(f, (k + 1) % 3);
      const int turn[3] = {orient3d(a, b, p, q), orient3d(a, b, q, r), orient3d(a, b, r, p)};
      if (const auto where = inside(g, turn)) add({1, edge_of(3 * f + k)}, *where);
    }
    return true;
  }

  // The simplex of g in which a point lies, from the sides of g's half-edges that it is on.
  std::optional<Simplex> inside(Index g, const int* side) const {
    int zeros = 0, sum = 0;
    for (int k = 0; k < 3; ++k) zeros += side[k] == 0, sum += side[k];
    if (std::abs(sum) + zeros != 3) return std::nullopt;
    if (zeros == 0) return Simplex{2, g};
    for (int k = 0; k < 3; ++k) {
      if (side[k] != 0) continue;
      if (zeros == 1) return Simplex{1, edge_of(3 * g + k)};
      if (side[(k + 1) % 3] == 0) return Simplex{0, rays_.F()(g, (k + 1) % 3)};
    }
    return std::nullopt;
  }

  // A vertex in the plane of g.
  std::optional<Simplex> locate(Index v, Index g) const {
    for (int k = 0; k < 3; ++k)
      if (rays_.F()(g, k) == v) return Simplex{0, v};
    const exact::PlaneView view(rays_, g);
    int side[3];
    for (int k = 0; k < 3; ++k) {
      side[k] = view.side(rays_.corner(g, k), rays_.corner(g, (k + 1) % 3), point(v));
      if (side[k] < 0) return std::nullopt;
    }
    return inside(g, side);
  }

  Simplex along(Index f, const Simplex& a, const Simplex& b) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const auto on = [&](const Simplex& x) {
        return x == Simplex{1, edge_of(h)} || x == Simplex{0, half_edge_source(rays_.F(), h)} ||
               x == Simplex{0, half_edge_target(rays_.F(), h)};
      };
      if (on(a) && on(b)) return {1, edge_of(h)};
    }
    return {2, f};
  }

  const SurfaceTopology& topology_;
  const Rays& rays_;
};

Meeting unordered(const Meeting& m) { return m[0] <= m[1] ? m : Meeting{m[1], m[0]}; }

// Whether a face's box and a segment's have nothing in common.
bool apart(const Rays& rays, const Point& a, const Point& b, Index h) {
  for (int k = 0; k < 3; ++k) {
    // The points are rounded by an ulp.
    const double slack = 1e-15 * (std::fabs(a.near[k]) + std::fabs(b.near[k]));
    const double x = rays.corner(h, 0)[k], y = rays.corner(h, 1)[k], z = rays.corner(h, 2)[k];
    if (std::max({x, y, z}) < std::min(a.near[k], b.near[k]) - slack ||
        std::min({x, y, z}) > std::max(a.near[k], b.near[k]) + slack)
      return true;
  }
  return false;
}

}  // namespace

IntersectionGraph::IntersectionGraph(const Surface& surface, const SurfaceTopology& topology,
                                     const TriangleBvh& bvh, const std::vector<FacePair>& pairs)
    : pairs_(pairs), kind_(pairs.size(), Kind::nothing) {
  const Rays rays(surface.V, surface.F, bvh);
  const PairMeeting meeting(topology, rays);
  std::vector<Segment> found(pairs.size());
  parallel_for(static_cast<std::int64_t>(pairs.size()), kHeavyGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i)
                   kind_[i] = meeting.look(pairs[i].first, pairs[i].second, found[i]);
               });
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    first_segment_.push_back(static_cast<Index>(segments_.size()));
    if (kind_[i] == Kind::segment) segments_.push_back(found[i]);
  }
  partners_.reserve(2 * pairs.size());
  for (const auto& [f, g] : pairs) partners_.emplace_back(f, g), partners_.emplace_back(g, f);
  std::sort(partners_.begin(), partners_.end());
  number_nodes();
}

void IntersectionGraph::number_nodes() {
  nodes_.reserve(2 * segments_.size());
  for (const Segment& s : segments_)
    for (const Meeting& m : s.ends) nodes_.push_back(unordered(m));
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  for (Segment& s : segments_) {
    for (int e = 0; e < 2; ++e)
      s.node[e] = static_cast<Index>(std::lower_bound(nodes_.begin(), nodes_.end(), unordered(s.ends[e])) -
                                     nodes_.begin());
    if (s.node[0] > s.node[1]) {
      std::swap(s.node[0], s.node[1]);
      std::swap(s.ends[0], s.ends[1]);
    }
  }
  position_.resize(nodes_.size());
  cuts_.resize(segments_.size());
}

Status IntersectionGraph::prepare(const Rays& rays, Index first, Index last, const RunContext& context) {
  std::vector<Index> open;
  for (Index s = first; s < last; ++s)
    for (const Index node : segments_[s].node)
      if (!position_[node]) open.push_back(node);
  std::sort(open.begin(), open.end());
  open.erase(std::unique(open.begin(), open.end()), open.end());
  parallel_for(static_cast<std::int64_t>(open.size()), kHeavyGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 if (context.stop()) return;
                 for (std::int64_t i = begin; i < end; ++i)
                   position_[open[i]] = locate(rays, nodes_[open[i]]);
               });
  if (auto stop = context.stop()) return *stop;
  parallel_for(last - first, kHeavyGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end && !context.stop(); ++i)
      if (auto& cuts = cuts_[first + i]; !cuts) cuts = find_cuts(rays, segments_[first + i]);
  });
  if (auto stop = context.stop()) return *stop;
  return success();
}

// The dimensions of the simplices do not decrease.
Point IntersectionGraph::locate(const Rays& rays, const Meeting& m) const {
  const auto point = [&](Index v) { return rays.V().data() + 3 * std::int64_t{v}; };
  const auto exact_point = [&](Index v) { return exact::vec(point(v)); };
  if (m[0].dimension == 0) return Point(point(m[0].id));
  const Index from = half_edge_source(rays.F(), m[0].id), to = half_edge_target(rays.F(), m[0].id);
  if (const Index f = m[1].id; m[1].dimension == 2)
    return Point(
        exact::piercing(point(from), point(to), rays.corner(f, 0), rays.corner(f, 1), rays.corner(f, 2)));
  const Vec a = exact_point(from), e = exact_point(to) - a;
  const Vec c = exact_point(half_edge_source(rays.F(), m[1].id));
  const Vec d = exact_point(half_edge_target(rays.F(), m[1].id)) - c;
  const Vec n = exact::cross(e, d);
  return Point(a + (exact::det(c - a, d, n) / dot(n, n)) * e);
}

IntersectionGraph::Cuts IntersectionGraph::find_cuts(const Rays& rays, const Segment& s) const {
  const Point &a = position(s.node[0]), &b = position(s.node[1]);
  std::optional<Point> direction;
  Cuts found;
  const auto refine = [&](Cut& cut) {
    if (cut.exact) return;
    cut.exact = rays.cut(a, b, cut.by);
    cut.near = cut.exact->get_d();
    cut.error = kSure;
  };
  for (const Index h : common_partners(s.faces.first, s.faces.second)) {
    const int sa = rays.side(a, h), sb = rays.side(b, h);
    if (sa * sb > 0 || (sa == 0) != (sb == 0)) continue;
    if (sa == 0) {
      cut_in_plane(rays, s, h, found);
      continue;
    }
    if (apart(rays, a, b, h)) continue;
    if (!direction) direction.emplace(b.x - a.x);
    const int passes = rays.passes(a, *direction, h);
    if (passes == 0) continue;
    Cut& cut = found.places.emplace_back();
    const bool inside = passes != Rays::kGrazes;
    cut.plain = inside && s.plain();
    cut.step = inside ? -passes : 0;
    cut.by = h;
    cut.faces = {h};
    double error_a, error_b;
    const double x = rays.height(a, h, error_a), y = rays.height(b, h, error_b);
    const double span = std::fabs(x - y) - error_a - error_b;
    cut.near = x / (x - y);
    cut.error = span > 0 ? kPlaceError * (error_a + error_b) / span + kSure : HUGE_VAL;
    if (!(cut.error < kRounding)) refine(cut);
  }
  // The order of exact arithmetic; the doubles decide wherever they are far enough apart.
  const auto compare = [&](Cut& x, Cut& y) {
    const double gap = x.near - y.near;
    if (std::fabs(gap) > x.error + y.error) return gap < 0 ? -1 : 1;
    refine(x);
    refine(y);
    return cmp(*x.exact, *y.exact);
  };
  std::vector<Cut*> order;
  for (Cut& c : found.places) order.push_back(&c);
  std::sort(order.begin(), order.end(), [&](Cut* x, Cut* y) { return compare(*x, *y) < 0; });
  Cuts out;
  out.overlaid = found.overlaid;
  out.in_plane = found.in_plane;
  for (Cut* c : order) {
    if (out.places.empty() || compare(out.places.back(), *c) != 0) {
      out.places.push_back(std::move(*c));
      continue;
    }
    Cut& here = out.places.back();
    here.step += c->step;
    here.plain = here.plain && c->plain;
    here.faces.insert(here.faces.end(), c->faces.begin(), c->faces.end());
  }
  return out;
}

// The segment runs in the plane of a third face: it is cut at the lines of that face's edges.
void IntersectionGraph::cut_in_plane(const Rays& rays, const Segment& s, Index third, Cuts& out) const {
  const Point &a = position(s.node[0]), &b = position(s.node[1]);
  const exact::PlaneView view(rays, third);
  out.in_plane = true;
  std::vector<Rational> crossed;
  Rational lo = 0, hi = 1;  // where it is inside the face
  for (int k = 0; k < 3; ++k) {
    const auto c = view.crossing(a, b, rays.corner(third, k), rays.corner(third, (k + 1) % 3));
    if (c.from < 0 && c.to < 0) hi = -1;
    if (!c.crosses()) continue;
    const Rational& t = crossed.emplace_back(c.place());
    if (c.from < 0) lo = std::max(lo, t);
    if (c.from > 0) hi = std::min(hi, t);
  }
  out.overlaid = out.overlaid || lo <= hi;
  for (Rational& t : crossed) {
    Cut& cut = out.places.emplace_back();
    cut.by = third;
    const bool border = lo <= hi && (t == lo || t == hi);
    cut.plain = !border;
    if (border) cut.faces = {third};
    cut.near = t.get_d();
    cut.error = kSure;
    cut.exact = std::move(t);
  }
}

std::vector<Index> IntersectionGraph::common_partners(Index f, Index g) const {
  std::vector<Index> out;
  auto i = std::lower_bound(partners_.begin(), partners_.end(), FacePair(f, -1));
  auto j = std::lower_bound(partners_.begin(), partners_.end(), FacePair(g, -1));
  while (i != partners_.end() && j != partners_.end() && i->first == f && j->first == g) {
    if (i->second == j->second) {
      out.push_back(i->second);
      ++i, ++j;
    } else if (i->second < j->second) {
      ++i;
    } else {
      ++j;
    }
  }
  return out;
}

Rational IntersectionGraph::place(const Rays& rays, Index segment, const Cut& cut) const {
  if (cut.exact) return *cut.exact;
  const Segment& s = segments_[segment];
  return rays.cut(position(s.node[0]), position(s.node[1]), cut.by);
}

}  // namespace overtet
