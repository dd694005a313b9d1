#include "src/covering/hinges.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/predicates/predicates.h"
#include "src/exact/rays.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::RayStatus;
using exact::Vec;
using Real = long double;
using Real3 = std::array<Real, 3>;

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
  Real least = std::numbers::pi_v<Real>;
  for (int i = 0; i < n; ++i) {
    const Real3 u = cross(direction(i), direction(i + 1)), w = cross(direction(i), direction(i - 1));
    const Real cosine = dot(u, w), sine = std::sqrt(dot(cross(u, w), cross(u, w)));
    const bool flat = orient3d(p, end(i), end(i + 1), end(i - 1)) == 0;
    least = std::min(least, flat ? (cosine > 0 ? 0 : std::numbers::pi_v<Real>) : std::atan2(sine, cosine));
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

}  // namespace overtet
