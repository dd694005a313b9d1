#include "src/covering/hinges.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/predicates/predicates.h"
#include "src/exact/exact.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;
using Real = long double;
using Real3 = std::array<Real, 3>;

constexpr Real kPi = 3.14159265358979323846264338327950288L;

Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real3 unit(const Real3& a) {
  const Real l = std::sqrt(dot(a, a));
  return {a[0] / l, a[1] / l, a[2] / l};
}

// The one-ring of a vertex: half-edges that leave it and the unit directions of their ends.
struct Ring {
  Index vertex;
  std::vector<Index> half_edges;
  std::vector<Index> ends;
  std::vector<Index> faces;  // sorted
  std::vector<Real3> directions;

  Ring(const Surface& surface, const SurfaceTopology& topology, Index v) : vertex(v) {
    half_edges = half_edges_around(topology, v);
    for (const Index h : half_edges) {
      ends.push_back(half_edge_target(surface.F, h));
      faces.push_back(half_edge_face(h));
      Real3 d;
      for (int k = 0; k < 3; ++k) d[k] = Real(surface.V(ends.back(), k)) - Real(surface.V(v, k));
      directions.push_back(unit(d));
    }
    std::sort(faces.begin(), faces.end());
  }
  int size() const { return static_cast<int>(half_edges.size()); }
};

// How far the dihedral nearest to a fold is from 0 or 2 pi.
double opening_of(const Surface& surface, const Ring& ring) {
  const int n = ring.size();
  const double* p = surface.V.data() + 3 * std::int64_t{ring.vertex};
  const auto end = [&](int i) { return surface.V.data() + 3 * std::int64_t{ring.ends[(i + n) % n]}; };
  const auto direction = [&](int i) -> const Real3& { return ring.directions[(i + n) % n]; };
  Real least = kPi;
  for (int i = 0; i < n; ++i) {
    const Real3 u = cross(direction(i), direction(i + 1)), w = cross(direction(i), direction(i - 1));
    const Real cosine = dot(u, w), sine = std::sqrt(dot(cross(u, w), cross(u, w)));
    const bool flat = orient3d(p, end(i), end(i + 1), end(i - 1)) == 0;
    least = std::min(least, flat ? (cosine > 0 ? 0 : kPi) : std::atan2(sine, cosine));
  }
  return static_cast<double>(least);
}

// Whether the edge to corner i of the ring is a fold: both faces in one plane, on the same side of it.
bool is_fold(const Surface& surface, const Ring& ring, int i) {
  const int n = ring.size();
  const double* p = surface.V.data() + 3 * std::int64_t{ring.vertex};
  const auto vector = [&](int k) {
    return exact::vec(surface.V.data() + 3 * std::int64_t{ring.ends[(k + n) % n]}) - exact::vec(p);
  };
  return exact::sign(dot(exact::cross(vector(i), vector(i + 1)), exact::cross(vector(i), vector(i - 1)))) > 0;
}

std::optional<int> b0(const Surface& surface, const Rays& rays, const Ring& ring) {
  const int n = ring.size();
  const double* p = surface.V.data() + 3 * std::int64_t{ring.vertex};
  const auto end = [&](int i) { return surface.V.data() + 3 * std::int64_t{ring.ends[(i + n) % n]}; };

  std::vector<Vec> normals;  // of the face after corner i
  std::vector<Real3> rounded;
  std::vector<int> turn;  // of the link at corner i: 1 to the left, where the outside is; -1; 0 straight on
  for (int i = 0; i < n; ++i) {
    const Index f = half_edge_face(ring.half_edges[i]);
    normals.push_back(rays.normal(f));
    const auto normal = rays.unit_normal(f);
    rounded.push_back({normal[0], normal[1], normal[2]});
    const int side = orient3d(p, end(i), end(i + 1), end(i - 1));
    turn.push_back(side == 0 && is_fold(surface, ring, i) ? 1 : side);
  }

  // Candidates for the axis: the farther from the planes of the faces the fewer digits it takes.
  std::vector<std::pair<Real, Real3>> candidates;
  for (int c = 0; c < 40; ++c) {
    Real3 d{exact::scatter(3 * c), exact::scatter(5 * c + 1), exact::scatter(7 * c + 2)};
    if (!(dot(d, d) > 1e-6)) continue;
    d = unit(d);
    Real clearance = 1;
    for (const Real3& normal : rounded) clearance = std::min(clearance, std::fabs(dot(d, normal)));
    candidates.emplace_back(-clearance, d);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const Point start(p);
  for (const auto& [clearance, d] : candidates) {
    const double ahead[3] = {double(d[0]), double(d[1]), double(d[2])};
    const double behind[3] = {-ahead[0], -ahead[1], -ahead[2]};
    const Vec axis = exact::vec(ahead);
    // On which side of the meridians (towards `ahead`) the link runs, arc by arc.
    std::vector<int> side;
    for (const Vec& normal : normals) side.push_back(-exact::sign(dot(axis, normal)));
    if (std::count(side.begin(), side.end(), 0) > 0) continue;
    const auto one = rays.count(start, Point(ahead), nullptr, ring.faces);
    if (one.status == RayStatus::starts_on_surface) return std::nullopt;
    if (one.status != RayStatus::counted) continue;
    const auto other = rays.count(start, Point(behind), nullptr, ring.faces);
    if (other.status == RayStatus::starts_on_surface) return std::nullopt;
    if (other.status != RayStatus::counted) continue;
    // It crosses them at corners only. Passing `ahead` to the left counts 1, to the right -1.
    int rotation = 0;
    for (int i = 0; i < n; ++i) {
      const int before = side[(i + n - 1) % n], after = side[i];
      if (before < after && turn[i] > 0) ++rotation;
      if (before > after && turn[i] < 0) --rotation;
    }
    return one.winding + other.winding - rotation - 1;
  }
  return std::nullopt;
}

// The smallest winding number around p: in front of the pieces into which the arcs of the link cut each
// other. None where another part of the surface contains p.
std::optional<int> smallest_around(const Surface& surface, const Rays& rays, const Ring& ring,
                                   const std::vector<FacePair>& crossings) {
  std::optional<int> least;
  const double* p = surface.V.data() + 3 * std::int64_t{ring.vertex};
  const Point start(p);
  const Vec origin = exact::vec(p);
  for (const Index h : ring.half_edges) {
    const Index f = half_edge_face(h);
    const Vec a = exact::vec(surface.V.data() + 3 * std::int64_t{half_edge_target(surface.F, h)}) - origin;
    const Vec b = exact::vec(surface.V.data() + 3 * std::int64_t{half_edge_opposite(surface.F, h)}) - origin;
    std::vector<Rational> cuts{0, 1};
    for (const auto& [x, y] : crossings) {
      if (x != f && y != f) continue;
      const Vec n = rays.normal(x == f ? y : x);
      const Rational at_a = dot(n, a), at_b = dot(n, b);
      if (exact::sign(at_a) * exact::sign(at_b) < 0) cuts.push_back(at_a / (at_a - at_b));
    }
    std::sort(cuts.begin(), cuts.end());
    const Point normal(rays.normal(f));
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      if (cuts[i - 1] == cuts[i]) continue;
      for (int attempt = 0; attempt < 6; ++attempt) {
        const Rational part(1 + attempt);
        const Rational s = (part * cuts[i - 1] + cuts[i]) / (part + 1);
        const auto ray = rays.count(start, Point(a + s * (b - a)), &normal, ring.faces);
        if (ray.status == RayStatus::starts_on_surface) return std::nullopt;
        if (ray.status != RayStatus::counted) continue;
        if (!least || ray.winding < *least) least = ray.winding;
        break;
      }
    }
  }
  return least;
}

Index edge_of(const SurfaceTopology& topology, Index h) { return std::min(h, topology.twin[h]); }

}  // namespace

std::optional<int> vertex_b0(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
                             Index vertex) {
  const Rays rays(surface.V, surface.F, bvh);
  return b0(surface, rays, Ring(surface, topology, vertex));
}

std::optional<int> smallest_winding(const Surface& surface, const SurfaceTopology& topology,
                                    const TriangleBvh& bvh, Index vertex,
                                    const std::vector<FacePair>& crossings) {
  return smallest_around(surface, Rays(surface.V, surface.F, bvh), Ring(surface, topology, vertex),
                         crossings);
}

std::vector<Hinge> find_hinges(const Surface& surface, const SurfaceTopology& topology,
                               const TriangleBvh& bvh, const std::vector<FacePair>& pairs) {
  struct At {
    Index vertex;
    FacePair pair;
  };
  std::vector<At> at;
  for (const FacePair& pair : pairs)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (surface.F(pair.first, i) == surface.F(pair.second, j))
          at.push_back({surface.F(pair.first, i), pair});
  std::stable_sort(at.begin(), at.end(), [](const At& a, const At& b) { return a.vertex < b.vertex; });
  std::vector<Hinge> hinges;
  for (const At& x : at) {
    if (hinges.empty() || hinges.back().vertex != x.vertex) {
      hinges.emplace_back();
      hinges.back().vertex = x.vertex;
    }
    hinges.back().crossings.push_back(x.pair);
  }
  const Rays rays(surface.V, surface.F, bvh);
  parallel_for(static_cast<std::int64_t>(hinges.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Ring ring(surface, topology, hinges[i].vertex);
      hinges[i].B0 = b0(surface, rays, ring);
      hinges[i].opening = opening_of(surface, ring);
      hinges[i].covering = smallest_around(surface, rays, ring, hinges[i].crossings).value_or(0);
    }
  });
  return hinges;
}

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
        found.emplace_back(edge_of(topology, h), g);
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

std::optional<std::vector<int>> edge_levels(const Surface& surface, const SurfaceTopology& topology,
                                            const TriangleBvh& bvh, Index half_edge,
                                            const std::vector<Index>& piercing) {
  const Rays rays(surface.V, surface.F, bvh);
  const auto point = [&](Index v) { return surface.V.data() + 3 * std::int64_t{v}; };
  const Index twin = topology.twin[half_edge];
  const double *pa = point(half_edge_source(surface.F, half_edge)),
               *pb = point(half_edge_target(surface.F, half_edge));
  const double *pc = point(half_edge_opposite(surface.F, half_edge)),
               *pd = point(half_edge_opposite(surface.F, twin));
  std::vector<Index> own{half_edge_face(half_edge), half_edge_face(twin)};
  std::sort(own.begin(), own.end());
  const Vec a = exact::vec(pa), e = exact::vec(pb) - a, c = exact::vec(pc) - a, d = exact::vec(pd) - a;

  struct Cut {
    Rational at;
    int change;  // of the level, from the source on
  };
  std::vector<Cut> cuts{{0, 0}, {1, 0}};
  for (const Index g : piercing) {
    const Vec n = rays.normal(g);
    const Rational from = dot(n, a - exact::vec(rays.corner(g, 0))), along = dot(n, e);
    if (exact::sign(along) == 0) return std::nullopt;
    const Rational t = -from / along;
    if (exact::sign(t) > 0 && t < 1) cuts.push_back({t, -exact::sign(along)});
  }
  std::sort(cuts.begin(), cuts.end(), [](const Cut& x, const Cut& y) { return x.at < y.at; });

  const int side = orient3d(pa, pb, pc, pd);  // > 0: reflex inside, so the outer wedge is the narrow one
  const bool fold = side == 0 && exact::sign(dot(exact::cross(e, c), exact::cross(e, d))) > 0;
  std::vector<int> levels;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    if (cuts[i - 1].at == cuts[i].at) continue;
    // One face alone is passed through its inside: where its border is, its neighbour is cut as well.
    if (i > 1 && cuts[i - 2].at != cuts[i - 1].at) {
      levels.push_back(levels.back() + cuts[i - 1].change);
      continue;
    }
    bool counted = false;
    for (int attempt = 0; attempt < 12 && !counted; ++attempt) {
      const Rational part(1 + attempt % 4);
      const Rational t = (part * cuts[i - 1].at + cuts[i].at) / (part + 1);
      // Positive combinations of the two faces' directions lie in the wedge of less than half a turn.
      const double weight = 1 + 0.5 * exact::scatter(attempt);
      const auto length = [](const Vec& x) {
        const auto y = exact::approximate(x);
        const double l = std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
        // The squares may be out of the range of doubles.
        return l > 1e-140 && l < 1e150
                   ? l
                   : std::min(std::hypot(y[0], y[1], y[2]), std::numeric_limits<double>::max());
      };
      const Rational lean(0.3 * exact::scatter(attempt + 3));
      // The parts across the edge, so that both directions count alike; any multiple of e may be added.
      const double ee = std::max(length(e), 1e-300);
      const auto across = [&](const Vec& x) {
        const auto xn = exact::approximate(x), en = exact::approximate(e);
        const double along = (xn[0] * en[0] + xn[1] * en[1] + xn[2] * en[2]) / (ee * ee);
        return x - Rational(std::isfinite(along) ? along : 0.0) * e;
      };
      const Vec ca = across(c), da = across(d);
      const double lc = length(ca), ld = length(da);
      const Rational wc(std::isfinite(weight / lc) ? weight / lc : 1.0),
          wd(std::isfinite(1 / ld) ? 1 / ld : 1.0);
      Vec direction;
      if (side == 0) {
        // Straight, or a fold: its angle counts as a full turn, so the outer side is one layer less than
        // what both sides show.
        direction = rays.normal(own[0]) + (lean / Rational(std::max(1.0, ee))) * e;
      } else {
        direction = wc * ca + wd * da;
        if (side < 0) direction = Rational(-1) * direction;
        if (attempt > 0) direction = direction + (lean / Rational(ee)) * e;
      }
      const auto ray = rays.count(Point(a + t * e), Point(direction), nullptr, own);
      if (ray.status == RayStatus::starts_on_surface) break;
      if (ray.status != RayStatus::counted) continue;
      counted = true;
      levels.push_back(fold ? ray.winding - 1 : ray.winding);
    }
    if (!counted) return std::nullopt;
  }
  return levels;
}

std::optional<int> edge_capacity(const Surface& surface, const SurfaceTopology& topology,
                                 const TriangleBvh& bvh, Index half_edge,
                                 const std::vector<Index>& piercing) {
  const auto levels = edge_levels(surface, topology, bvh, half_edge, piercing);
  if (!levels || levels->empty()) return std::nullopt;
  return *std::min_element(levels->begin(), levels->end());
}

}  // namespace overtet
