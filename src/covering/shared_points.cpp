#include "src/covering/shared_points.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "kernels/predicates/predicates.h"
#include "src/covering/edge_parts.h"
#include "src/covering/link.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/tuning.h"
#include "src/exact/rays.h"
#include "src/exact/tuning.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::RayStatus;
using exact::Vec;

Point direction(int attempt) {
  const double d[3] = {exact::scatter(3 * attempt), exact::scatter(5 * attempt + 1),
                       exact::scatter(7 * attempt + 2)};
  return Point(d);
}

// The faces at a vertex, closed by a cone over their rim: a surface by itself, in which the vertex is 0.
// Around it the winding number is how often a disc covers the sphere, up to a number.
class Star {
 public:
  Star(const Surface& s, const SurfaceTopology& topology, const Hinge& hinge) {
    if (!has_regular_link(s, topology, hinge.vertex, hinge.crossings)) return;
    const std::vector<Index> half_edges = half_edges_around(topology, hinge.vertex);
    const auto n = static_cast<Index>(half_edges.size());
    if (n < 3) return;
    surface_.V.resize(n + 2, 3);
    surface_.F.resize(2 * Eigen::Index{n}, 3);
    surface_.V.row(0) = s.V.row(hinge.vertex);
    double reach = 0;
    std::vector<Index> face;  // of the whole surface
    for (Index i = 0; i < n; ++i) {
      ends_.push_back(half_edge_target(s.F, half_edges[i]));
      face.push_back(half_edge_face(half_edges[i]));
      rim_.push_back(i);
      surface_.V.row(1 + i) = s.V.row(ends_.back());
      reach = std::max(reach, (surface_.V.row(1 + i) - surface_.V.row(0)).cwiseAbs().maxCoeff());
      surface_.F.row(i) << 0, 1 + i, 1 + (i + 1) % n;
      surface_.F.row(n + i) << n + 1, 1 + (i + 1) % n, 1 + i;
    }
    for (int attempt = 0; attempt < kRayAttempts && !defined_; ++attempt) {
      const auto d = direction(attempt).near;
      for (int k = 0; k < 3; ++k) surface_.V(n + 1, k) = surface_.V(0, k) + reach * d[k];
      const TopologyCheck check = check_topology(surface_);
      if (!check.ok()) return;
      if (!degenerate_faces(surface_).empty()) continue;
      topology_ = check.topology;
      bvh_.build(surface_.V, surface_.F);
      rays_.emplace(surface_.V, surface_.F, bvh_);
      hinge_ = {0, {}, 0, 0, {}};
      const auto index = [&](Index f) {
        return static_cast<Index>(std::find(face.begin(), face.end(), f) - face.begin());
      };
      for (const auto& [f, g] : hinge.crossings) hinge_.crossings.emplace_back(index(f), index(g));
      if (rays_->faces_at(Point(surface_.V.data())) != rim_) continue;
      const auto least = smallest_winding(surface_, topology_, bvh_, 0, hinge_.crossings);
      hinge_.B0 = vertex_b0(surface_, topology_, bvh_, 0);
      if (!least || !hinge_.B0) continue;
      hinge_.covering = *least;
      pierced_ =
          find_pierced_edges(surface_, topology_, find_self_intersections(surface_.V, surface_.F, bvh_));
      defined_ = true;
    }
  }

  bool defined() const { return defined_; }

  // w_i of shared_points.h.
  std::optional<int> layers(const Point& d) const {
    for (const Index f : rim_)
      if (exact::sign(dot(rays_->normal(f), d.x)) == 0) return std::nullopt;
    const exact::RayCount ray = rays_->count(Point(surface_.V.data()), d, nullptr, rim_);
    if (ray.status != RayStatus::counted) return std::nullopt;
    return ray.winding - hinge_.covering;
  }

  // The least number of layers more than w_i with which there is a disc, or `most` + 1; a lower bound where
  // the search gives up. turns: the most at the edge to each vertex.
  template <class Turns>
  int needed(int most, const Turns& turns, std::int64_t& steps) const {
    if (hinge_.crossings.empty()) return 0;  // the polygon bounds a disc of one layer
    std::vector<int> near, at_most;
    for (const Index h : half_edges_around(topology_, 0)) {
      const auto levels = edge_levels(surface_, topology_, bvh_, h, piercing_faces(pierced_, topology_, h));
      if (!levels || levels->empty()) return 0;
      near.push_back(levels->front() - hinge_.covering);
      at_most.push_back(turns(ends_[half_edge_target(surface_.F, h) - 1]));
    }
    for (int a = 0; a <= most; ++a) {
      if (steps > kMostGluingSteps) return a;
      Hinge hinge = hinge_;
      *hinge.B0 += 2 * (a - hinge_.covering);
      const LinkAnswer answer = fill_link(surface_, topology_, hinge, near, at_most);
      steps += answer.steps;
      if (answer.verdict != LinkVerdict::unfillable) return a;
      for (int& level : near) ++level;
    }
    return most + 1;
  }

 private:
  Surface surface_;
  SurfaceTopology topology_;
  TriangleBvh bvh_;
  std::optional<exact::Rays> rays_;
  Hinge hinge_;
  std::vector<PiercedEdge> pierced_;
  std::vector<Index> ends_, rim_;  // by corner; the star's faces
  bool defined_ = false;
};

struct Things {
  std::vector<Index> faces;                // all that contain the point, sorted
  std::set<Index> vertices, edges, inner;  // edges by their smaller half-edge; faces that have it inside
};

class Study {
 public:
  Study(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
        const std::vector<Hinge>& hinges, const std::vector<PiercedEdge>& pierced)
      : s_(surface),
        topology_(topology),
        hinges_(hinges),
        pierced_(pierced),
        rays_(surface.V, surface.F, bvh) {}

  std::optional<SharedPoint> look(Index vertex, std::int64_t& steps) const {
    const Point p(position(vertex));
    const Things things = through(p);
    std::vector<std::pair<Index, std::unique_ptr<Star>>> stars;
    for (const Index v : things.vertices) {
      stars.emplace_back(v, std::make_unique<Star>(s_, topology_, hinge_of(v)));
      if (!stars.back().second->defined()) return std::nullopt;
    }
    std::optional<int> room;
    for (int attempt = 0; attempt < kRayAttempts && !room; ++attempt) {
      const Point d = direction(attempt);
      room = left_over(p, things, d);
      for (const auto& [v, star] : stars) {
        const auto w = room ? star->layers(d) : std::nullopt;
        room = w ? std::optional(*room - *w) : std::nullopt;
      }
    }
    if (!room) return std::nullopt;
    SharedPoint out;
    out.room = *room;
    int sum = 0;
    for (const auto& [vertex, star] : stars) {
      const Index v = vertex;  // clang 14 takes no structured binding into a lambda
      const int layers = star->needed(
          std::max(0, *room - sum), [&](Index end) { return most_turns(v, end); }, steps);
      if (layers == 0 && *room >= 0) continue;
      out.vertices.push_back(v);
      out.layers.push_back(layers);
      sum += layers;
      if (sum > *room) return out;
    }
    return std::nullopt;
  }

 private:
  const double* position(Index v) const { return s_.V.data() + 3 * std::int64_t{v}; }

  Hinge hinge_of(Index v) const {
    const auto at = std::lower_bound(hinges_.begin(), hinges_.end(), v,
                                     [](const Hinge& h, Index x) { return h.vertex < x; });
    if (at != hinges_.end() && at->vertex == v) return *at;
    Hinge none;
    none.vertex = v;
    return none;
  }

  Things through(const Point& p) const {
    Things out;
    out.faces = rays_.faces_at(p);
    for (const Index f : out.faces) {
      std::array<Vec, 3> to;
      Index corner = -1, edge = -1;
      for (int k = 0; k < 3; ++k) {
        to[k] = exact::vec(rays_.corner(f, k)) - p.x;
        if (exact::is_zero(to[k])) corner = s_.F(f, k);
      }
      for (int k = 0; k < 3; ++k)
        if (exact::is_zero(exact::cross(to[k], to[(k + 1) % 3]))) edge = 3 * f + k;
      if (corner >= 0)
        out.vertices.insert(corner);
      else if (edge >= 0)
        out.edges.insert(std::min(edge, topology_.twin[edge]));
      else
        out.inner.insert(f);
    }
    return out;
  }

  // What winds around the point in direction d, without edges and faces that pass through it.
  std::optional<int> left_over(const Point& p, const Things& things, const Point& d) const {
    for (const Index f : things.faces)
      if (exact::sign(dot(rays_.normal(f), d.x)) == 0) return std::nullopt;
    const exact::RayCount ray = rays_.count(p, d, nullptr, things.faces);
    if (ray.status != RayStatus::counted) return std::nullopt;
    const auto behind = [&](Index f) { return exact::sign(dot(rays_.normal(f), d.x)) < 0; };
    int rest = ray.winding;
    for (const Index f : things.inner) rest -= behind(f);
    for (const Index h : things.edges) {
      const Index twin = topology_.twin[h], f = half_edge_face(h), g = half_edge_face(twin);
      const int side =
          orient3d(position(half_edge_source(s_.F, h)), position(half_edge_target(s_.F, h)),
                   position(half_edge_opposite(s_.F, h)), position(half_edge_opposite(s_.F, twin)));
      // Of a fold, a full turn: what is less has no room for tets.
      const bool fold = side == 0 && exact::sign(dot(rays_.normal(f), rays_.normal(g))) < 0;
      rest -= fold || (side < 0 ? behind(f) && behind(g) : behind(f) || behind(g));
    }
    return rest;
  }

  // How often the tets at the edge from v can turn beyond what it shows.
  int most_turns(Index v, Index end) const {
    const Index h = find_half_edge(s_.F, topology_, v, end);
    const Point a(position(v)), b(position(end));
    const Vec along = b.x - a.x;
    std::vector<Rational> cuts{0, 1};
    std::vector<Index> in_plane;
    for (EdgeCut& cut : edge_cuts(rays_, a.x, along, piercing_faces(pierced_, topology_, h), in_plane))
      cuts.push_back(std::move(cut.at));
    // Where it runs in the plane of a face: more cuts than needed do no harm.
    for (const Index g : in_plane) {
      const Vec n = rays_.normal(g);
      for (int k = 0; k < 3; ++k) {
        const Vec o = exact::vec(rays_.corner(g, k));
        const Vec wall = exact::cross(n, exact::vec(rays_.corner(g, (k + 1) % 3)) - o);
        const Rational slope = dot(wall, along);
        if (exact::sign(slope) == 0) continue;
        Rational t = dot(wall, o - a.x) / slope;
        if (exact::sign(t) > 0 && t < 1) cuts.push_back(std::move(t));
      }
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    int most = std::numeric_limits<int>::max();
    for (std::size_t i = 1; i < cuts.size(); ++i)
      if (const auto room = room_between(a, along, cuts[i - 1], cuts[i])) most = std::min(most, *room);
    return most;
  }

  std::optional<int> room_between(const Point& a, const Vec& along, const Rational& t0,
                                  const Rational& t1) const {
    for (int place = 1; place <= kRayAttempts; ++place) {
      const Point m(a.x + ((place * t0 + t1) / (place + 1)) * along);
      const Things things = through(m);
      if (!things.vertices.empty()) continue;
      for (int attempt = 0; attempt < kRayAttempts; ++attempt)
        if (const auto room = left_over(m, things, direction(attempt))) return room;
    }
    return std::nullopt;
  }

  const Surface& s_;
  const SurfaceTopology& topology_;
  const std::vector<Hinge>& hinges_;
  const std::vector<PiercedEdge>& pierced_;
  const exact::Rays rays_;
};

}  // namespace

Result<std::vector<SharedPoint>> find_shared(const Surface& surface, const SurfaceTopology& topology,
                                             const TriangleBvh& bvh, const std::vector<Hinge>& hinges,
                                             const std::vector<PiercedEdge>& pierced,
                                             const std::vector<Index>& vertices, const RunContext& context) {
  const Study study(surface, topology, bvh, hinges, pierced);
  std::vector<SharedPoint> out;
  std::set<std::array<double, 3>> seen;
  std::int64_t steps = 0;
  for (const Index v : vertices) {
    if (auto stop = context.stop()) return *stop;
    if (steps > kMostGluingSteps) break;
    if (!seen.insert({surface.V(v, 0), surface.V(v, 1), surface.V(v, 2)}).second) continue;
    steps += kFirstSteps;  // about what a look takes
    if (auto found = study.look(v, steps)) out.push_back(std::move(*found));
  }
  return out;
}

}  // namespace overtet
