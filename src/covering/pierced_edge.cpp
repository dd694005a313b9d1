#include "src/covering/pierced_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/predicates/predicates.h"
#include "src/covering/edge_parts.h"
#include "src/exact/rays.h"
#include "src/exact/tuning.h"

namespace overtet {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;

namespace {

double length(const Vec& x) {
  const auto y = exact::approximate(x);
  const double l = std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
  // The squares may be out of the range of doubles.
  return l > 1e-140 && l < 1e150 ? l
                                 : std::min(std::hypot(y[0], y[1], y[2]), std::numeric_limits<double>::max());
}

// The outer side of one edge.
class OuterSide {
 public:
  OuterSide(const Rays& rays, const SurfaceTopology& topology, Index half_edge) : rays_(rays) {
    const Index twin = topology.twin[half_edge];
    const auto point = [&](Index v) { return rays.V().data() + 3 * std::int64_t{v}; };
    const double *pa = point(half_edge_source(rays.F(), half_edge)),
                 *pb = point(half_edge_target(rays.F(), half_edge)),
                 *pc = point(half_edge_opposite(rays.F(), half_edge)),
                 *pd = point(half_edge_opposite(rays.F(), twin));
    own_ = {half_edge_face(half_edge), half_edge_face(twin)};
    std::sort(own_.begin(), own_.end());
    a_ = exact::vec(pa);
    e_ = exact::vec(pb) - a_;
    c_ = exact::vec(pc) - a_;
    d_ = exact::vec(pd) - a_;
    side_ = orient3d(pa, pb, pc, pd);
    fold_ = side_ == 0 && exact::sign(dot(exact::cross(e_, c_), exact::cross(e_, d_))) > 0;
  }

  const Vec& source() const { return a_; }
  const Vec& along() const { return e_; }

  // The level between two places. None where another face contains the edge there, or no ray could be
  // counted.
  std::optional<int> level(const Rational& from, const Rational& to) const {
    for (int attempt = 0; attempt < kRayAttempts; ++attempt) {
      const Rational part(1 + attempt % 4);
      const Rational t = (part * from + to) / (part + 1);
      const auto ray = rays_.count(Point(a_ + t * e_), Point(direction(attempt)), nullptr, own_);
      if (ray.status == RayStatus::starts_on_surface) break;
      if (ray.status != RayStatus::counted) continue;
      return fold_ ? ray.winding - 1 : ray.winding;
    }
    return std::nullopt;
  }

 private:
  // Outwards from the edge. Positive combinations of the two faces' directions lie in the wedge of less than
  // half a turn.
  Vec direction(int attempt) const {
    const double weight = 1 + 0.5 * exact::scatter(attempt);
    const Rational lean(0.3 * exact::scatter(attempt + 3));
    const double ee = std::max(length(e_), 1e-300);
    // Straight, or a fold: its angle counts as a full turn, so the outer side is one layer less than what
    // both sides show.
    if (side_ == 0) return rays_.normal(own_[0]) + (lean / Rational(std::max(1.0, ee))) * e_;
    // The parts across the edge, so that both directions count alike; any multiple of e may be added.
    const auto across = [&](const Vec& x) {
      const auto xn = exact::approximate(x), en = exact::approximate(e_);
      const double along = (xn[0] * en[0] + xn[1] * en[1] + xn[2] * en[2]) / (ee * ee);
      return x - Rational(std::isfinite(along) ? along : 0.0) * e_;
    };
    const Vec ca = across(c_), da = across(d_);
    const double lc = length(ca), ld = length(da);
    const Rational wc(std::isfinite(weight / lc) ? weight / lc : 1.0),
        wd(std::isfinite(1 / ld) ? 1 / ld : 1.0);
    Vec out = wc * ca + wd * da;
    if (side_ < 0) out = Rational(-1) * out;
    if (attempt > 0) out = out + (lean / Rational(ee)) * e_;
    return out;
  }

  const Rays& rays_;
  std::vector<Index> own_;  // the edge's faces, sorted
  Vec a_, e_, c_, d_;       // the source, and from there to the target and to the faces' other corners
  int side_ = 0;            // > 0: reflex inside, so the outer wedge is the narrow one
  bool fold_ = false;
};

}  // namespace

std::vector<PiercedEdge> find_pierced_edges(const Surface& surface, const SurfaceTopology& topology,
                                            const std::vector<FacePair>& pairs) {
  std::vector<std::pair<Index, Index>> found;  // edge, face
  const auto point = [&](Index v) { return surface.V.data() + 3 * std::int64_t{v}; };
  const auto look = [&](Index f, Index g) {  // edges of f through g
    const auto *a = point(surface.F(g, 0)), *b = point(surface.F(g, 1)), *c = point(surface.F(g, 2));
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const Index s = half_edge_source(surface.F, h), t = half_edge_target(surface.F, h);
      bool at_s = false, at_t = false;
      for (int k = 0; k < 3; ++k) at_s = at_s || surface.F(g, k) == s, at_t = at_t || surface.F(g, k) == t;
      if (at_s && at_t) continue;
      // A corner in common: the rest of the edge meets the face only when it runs in its plane.
      if (at_s && orient3d(a, b, c, point(t)) != 0) continue;
      if (at_t && orient3d(a, b, c, point(s)) != 0) continue;
      if (segment_triangle_intersect(point(s), point(t), a, b, c))
        found.emplace_back(std::min(h, topology.twin[h]), g);
    }
  };
  for (const auto& [f, g] : pairs) {
    look(f, g);
    look(g, f);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<PiercedEdge> out;
  for (const auto& [edge, face] : found) {
    if (out.empty() || out.back().half_edge != edge) out.push_back({edge, {}});
    out.back().faces.push_back(face);
  }
  return out;
}

const std::vector<Index>& piercing_faces(const std::vector<PiercedEdge>& pierced,
                                         const SurfaceTopology& topology, Index half_edge) {
  static const std::vector<Index> none;
  const Index edge = std::min(half_edge, topology.twin[half_edge]);
  const auto at = std::lower_bound(pierced.begin(), pierced.end(), edge,
                                   [](const PiercedEdge& p, Index x) { return p.half_edge < x; });
  return at == pierced.end() || at->half_edge != edge ? none : at->faces;
}

std::vector<EdgeCut> edge_cuts(const Rays& rays, const Vec& a, const Vec& e,
                               const std::vector<Index>& piercing, std::vector<Index>& in_plane) {
  std::vector<EdgeCut> cuts;
  for (const Index g : piercing) {
    const Vec n = rays.normal(g);
    const Rational from = dot(n, a - exact::vec(rays.corner(g, 0))), along = dot(n, e);
    if (exact::sign(along) == 0) {
      in_plane.push_back(g);
      continue;
    }
    Rational t = -from / along;
    if (exact::sign(t) > 0 && t < 1) cuts.push_back({std::move(t), -exact::sign(along)});
  }
  std::sort(cuts.begin(), cuts.end(), [](const EdgeCut& x, const EdgeCut& y) { return x.at < y.at; });
  return cuts;
}

std::optional<std::vector<EdgePart>> edge_parts(const Rays& rays, const SurfaceTopology& topology,
                                                Index half_edge, const std::vector<Index>& piercing) {
  const OuterSide outer(rays, topology, half_edge);
  std::vector<Index> in_plane;
  const std::vector<EdgeCut> cuts = edge_cuts(rays, outer.source(), outer.along(), piercing, in_plane);
  if (!in_plane.empty()) return std::nullopt;
  std::vector<EdgePart> parts;
  // A part begins at the source, and behind the cuts [begin, end) at one place.
  for (std::size_t begin = 0, end = 0;; begin = end) {
    while (!parts.empty() && end < cuts.size() && cuts[end].at == cuts[begin].at) ++end;
    EdgePart part;
    part.from = parts.empty() ? Rational(0) : cuts[begin].at;
    part.to = end == cuts.size() ? Rational(1) : cuts[end].at;
    // One face alone is passed through its inside: where its border is, its neighbour is cut as well.
    if (end - begin == 1) {
      part.level = parts.back().level + cuts[begin].change;
    } else {
      const std::optional<int> level = outer.level(part.from, part.to);
      if (!level) return std::nullopt;
      part.level = *level;
    }
    parts.push_back(std::move(part));
    if (end == cuts.size()) break;
  }
  return parts;
}

std::optional<std::vector<int>> edge_levels(const Surface& surface, const SurfaceTopology& topology,
                                            const TriangleBvh& bvh, Index half_edge,
                                            const std::vector<Index>& piercing) {
  const auto parts = edge_parts(Rays(surface.V, surface.F, bvh), topology, half_edge, piercing);
  if (!parts) return std::nullopt;
  std::vector<int> levels;
  for (const EdgePart& part : *parts) levels.push_back(part.level);
  return levels;
}

}  // namespace overtet
