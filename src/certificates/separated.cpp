#include "src/certificates/separated.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "src/certificates/facts.h"
#include "src/certificates/tuning.h"
#include "src/covering/edge_parts.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/wound_edges.h"
#include "src/exact/rays.h"
#include "src/mesh/submesh.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Vec;

using Direction = std::array<int, 3>;

// The winding number of the rest just beside points of the component.
class Rest {
 public:
  explicit Rest(const Surface& surface) : bvh_(surface.V, surface.F), rays_(surface.V, surface.F, bvh_) {}
  std::optional<int> beside(const Point& m, const Point& direction) const {
    const std::vector<Index> at = rays_.faces_at(m);
    for (const Index f : at)
      if (exact::sign(dot(rays_.normal(f), direction.x)) == 0) return std::nullopt;
    const exact::RayCount ray = rays_.count(m, direction, nullptr, at);
    if (ray.status != exact::RayStatus::counted) return std::nullopt;
    return ray.winding;
  }

 private:
  const TriangleBvh bvh_;
  const exact::Rays rays_;
};

using Pieces = std::vector<std::pair<Point, int>>;  // of an edge: a place on each, and its level

// What must hold beside the component for an odd group to stay one: no place touches the rest, and of each
// list at least one is covered by nothing that makes its level positive.
struct Conditions {
  std::vector<Point> clear;
  std::vector<Pieces> one_of;
};

class Study {
 public:
  explicit Study(const Surface& s)
      : s_(s),
        topology_(check_topology(s).topology),
        bvh_(s.V, s.F),
        rays_(s.V, s.F, bvh_),
        pairs_(find_self_intersections(s.V, s.F, bvh_)) {
    hinges_ = find_hinges(s, topology_, bvh_, pairs_);
    pierced_ = find_pierced_edges(s, topology_, pairs_);
  }

  Result<WoundEdges> wound(const RunContext& context) const {
    return assign_wound_edges(s_, topology_, bvh_, hinges_, pierced_, context);
  }
  const std::vector<Hinge>& hinges() const { return hinges_; }
  Point at(Index v) const { return Point(s_.V.data() + 3 * std::int64_t{v}); }
  std::vector<Index> around(Index v) const { return half_edges_around(topology_, v); }
  const Surface& surface() const { return s_; }

  // Edges that leave what covered edges join to the vertices must stay uncovered.
  std::optional<Conditions> of_group(const std::vector<Index>& group) const {
    Conditions out;
    std::set<Index> seen(group.begin(), group.end());
    std::vector<Index> stack = group;
    std::vector<Index> closed;  // half-edges
    while (!stack.empty()) {
      const Index v = stack.back();
      stack.pop_back();
      out.clear.push_back(at(v));
      for (const Index h : around(v)) {
        const auto pieces = pieces_of(h);
        if (!pieces) return std::nullopt;
        const bool covered =
            std::all_of(pieces->begin(), pieces->end(), [](const auto& piece) { return piece.second >= 1; });
        const Index w = half_edge_target(s_.F, h);
        if (!covered)
          closed.push_back(h);
        else if (seen.insert(w).second)
          stack.push_back(w);
      }
      if (seen.size() > kMostCoveredEdges) return std::nullopt;
    }
    for (const Index h : closed) {
      if (seen.count(half_edge_target(s_.F, h))) continue;
      const auto pieces = pieces_of(h);
      if (!pieces) return std::nullopt;
      auto& list = out.one_of.emplace_back();
      for (const auto& [place, level] : *pieces)
        if (level <= 0) list.emplace_back(place, level);
    }
    return out;
  }

 private:
  // A point of each piece between the crossings of an edge, with the level there.
  std::optional<Pieces> pieces_of(Index half_edge) const {
    const Index e = std::min(half_edge, topology_.twin[half_edge]);
    const auto parts = edge_parts(rays_, topology_, e, piercing_faces(pierced_, topology_, e));
    if (!parts) return std::nullopt;
    const Point a = at(half_edge_source(s_.F, e)), b = at(half_edge_target(s_.F, e));
    const Vec along = b.x - a.x;
    Pieces out;
    for (const EdgePart& part : *parts)
      out.emplace_back(Point(a.x + ((part.from + part.to) / 2) * along), part.level);
    return out;
  }

  const Surface& s_;
  const SurfaceTopology topology_;
  TriangleBvh bvh_;
  const exact::Rays rays_;
  const std::vector<FacePair> pairs_;
  std::vector<Hinge> hinges_;
  std::vector<PiercedEdge> pierced_;
};

bool holds(const Conditions& conditions, const Rest& rest, const Point& direction) {
  for (const Point& p : conditions.clear)
    if (!rest.beside(p, direction)) return false;
  return std::all_of(conditions.one_of.begin(), conditions.one_of.end(), [&](const Pieces& list) {
    return std::any_of(list.begin(), list.end(), [&](const auto& piece) {
      const auto covered = rest.beside(piece.first, direction);
      return covered && piece.second + *covered <= 0;
    });
  });
}

// Away from the faces at a vertex first, then everywhere.
std::vector<Direction> directions(const Study& study, Index v) {
  std::vector<Direction> out;
  const auto add = [&](const Eigen::Vector3d& d) {
    const double longest = d.cwiseAbs().maxCoeff();
    if (!(longest > 0)) return;  // not a number
    const Eigen::Vector3d scaled = d * (kLongest / longest);
    const int z = static_cast<int>(std::lround(scaled[2]));  // a checker may look along it: not 0
    out.push_back(
        {static_cast<int>(std::lround(scaled[0])), static_cast<int>(std::lround(scaled[1])), z == 0 ? 1 : z});
  };
  const Surface& s = study.surface();
  const TriangleBvh bvh(s.V, s.F);
  const exact::Rays rays(s.V, s.F, bvh);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> normals;
  for (const Index h : study.around(v)) {
    const auto n = rays.unit_normal(half_edge_face(h));
    normals.emplace_back(n[0], n[1], n[2]);
    sum += normals.back();
  }
  // Not quite those of the normals: edges of the other faces there lie across them.
  add(sum + Eigen::Vector3d(0.0137, 0.0071, -0.0113));
  for (const Eigen::Vector3d& n : normals) add(n + 0.1 * sum + Eigen::Vector3d(0.0137, 0.0071, -0.0113));
  for (int k = 0; k < kScattered; ++k) {
    // Evenly over the sphere, from a spiral.
    const double z = 1 - (2 * k + 1.0) / kScattered, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * k;
    add({r * std::cos(turn), r * std::sin(turn), z});
  }
  return out;
}

}  // namespace

Result<std::optional<SeparatedCertificate>> find_separated_part(const Surface& surface,
                                                                const SurfaceTopology& topology,
                                                                const std::vector<Hinge>& hinges,
                                                                const RunContext& context) {
  std::optional<SeparatedCertificate> nothing;
  if (topology.components.size() < 2) return nothing;
  std::set<Index> components;
  for (const Hinge& h : hinges)
    if (!h.B0) components.insert(topology.component_of_face[half_edge_face(topology.out[h.vertex])]);
  for (const Index c : components) {
    if (auto stop = context.stop()) return *stop;
    std::vector<char> wanted(topology.components.size(), 0);
    wanted[c] = 1;
    const SubSurface own = sub_surface(surface, topology, wanted);
    const Study study(own.surface);
    const Result<WoundEdges> wound = study.wound(context);
    if (!wound.ok()) return wound.error();
    if (wound.value().odd_groups.empty()) continue;
    for (char& w : wanted) w = !w;
    const SubSurface others = sub_surface(surface, topology, wanted);
    const Rest rest(others.surface);
    for (const auto& group : wound.value().odd_groups) {
      const std::optional<Conditions> conditions = study.of_group(group);
      if (!conditions) continue;
      for (const Direction& d : directions(study, group.front())) {
        if (auto stop = context.stop()) return *stop;
        const double coordinates[3] = {static_cast<double>(d[0]), static_cast<double>(d[1]),
                                       static_cast<double>(d[2])};
        if (!holds(*conditions, rest, Point(coordinates))) continue;
        SeparatedCertificate out;
        out.direction = d;
        for (const Index v : group) {
          out.vertices.push_back(own.vertices[v]);
          out.B0.push_back(b0_of(study.hinges(), v));
        }
        out.positions = positions_of(surface, out.vertices);
        return std::optional(std::move(out));
      }
    }
  }
  return nothing;
}

}  // namespace overtet
