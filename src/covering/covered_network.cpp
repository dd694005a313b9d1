#include "src/covering/covered_network.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "kernels/core/union_find.h"
#include "src/arrangement/face_cuts.h"
#include "src/covering/tuning.h"
#include "src/exact/rays.h"

namespace overtet {

namespace {

using NetworkLink = CoveredNetwork::Link;

// Places in a face, in doubles: what is found with them is diagnosed anew by those who use it.
struct InFace {
  using Place = std::array<double, 3>;  // barycentric coordinates

  static double turn(const Place& a, const Place& b, const Place& c) {
    return (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
  }
  static Place mean(const Place& a, const Place& b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
  }
  static bool cross(const Place& a, const Place& b, const Place& c, const Place& d) {
    return (turn(a, b, c) > 0) != (turn(a, b, d) > 0) && (turn(c, d, a) > 0) != (turn(c, d, b) > 0);
  }
  static FacePoint on_grid(Index face, const Place& p) {
    FacePoint out{face, {}};
    std::int64_t rest = kFaceGrid;
    for (int k = 0; k < 3; ++k) out.weight[k] = std::llround(p[k] * static_cast<double>(kFaceGrid));
    for (const std::int64_t w : out.weight) rest -= w;
    *std::max_element(out.weight.begin(), out.weight.end()) += rest;
    return out;
  }
  static Place place(const FacePoint& p) {
    const auto share = [&](int k) {
      return static_cast<double>(p.weight[k]) / static_cast<double>(kFaceGrid);
    };
    return {share(0), share(1), share(2)};
  }
};

// A part of a face, cut into triangles.
struct TriangulatedPart {
  std::vector<Index> nodes;  // around it
  std::vector<InFace::Place> places;
  std::vector<std::array<int, 3>> triangles;  // of the nodes' positions around the part

  // Ear clipping, the best ear first. Empty where rounding has spoilt the part.
  void triangulate() {
    std::vector<int> left(nodes.size());
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = static_cast<int>(i);
    std::vector<double> quality(left.size());  // of the ear at each of them, as far as known
    const auto look = [&](std::size_t i) { quality[i] = ear(left, i); };
    for (std::size_t i = 0; i < left.size(); ++i) look(i);
    while (left.size() > 2) {
      auto best = std::max_element(quality.begin(), quality.end());
      if (!(*best > 0)) {  // what was in the way of an ear may be gone
        for (std::size_t i = 0; i < left.size(); ++i) look(i);
        best = std::max_element(quality.begin(), quality.end());
        if (!(*best > 0)) return triangles.clear();
      }
      const std::size_t m = left.size(), i = static_cast<std::size_t>(best - quality.begin());
      triangles.push_back({left[(i + m - 1) % m], left[i], left[(i + 1) % m]});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      quality.erase(best);
      look((i + m - 2) % (m - 1)), look(i % (m - 1));
    }
  }

 private:
  double ear(const std::vector<int>& left, std::size_t i) const {
    const std::size_t m = left.size();
    const int ia = left[(i + m - 1) % m], ib = left[i], ic = left[(i + 1) % m];
    const auto &a = places[ia], &b = places[ib], &c = places[ic];
    const double area = InFace::turn(a, b, c);
    if (!(area > 0)) return 0;
    for (const int j : left) {
      if (nodes[j] == nodes[ia] || nodes[j] == nodes[ib] || nodes[j] == nodes[ic]) continue;
      if (InFace::turn(a, b, places[j]) >= 0 && InFace::turn(b, c, places[j]) >= 0 &&
          InFace::turn(c, a, places[j]) >= 0)
        return 0;
    }
    const auto square = [](const InFace::Place& p, const InFace::Place& q) {
      return std::pow(p[1] - q[1], 2) + std::pow(p[2] - q[2], 2);
    };
    return area / std::max({square(a, b), square(b, c), square(c, a)});
  }
};

class NetworkMaker {
 public:
  NetworkMaker(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
               IntersectionGraph& graph, const RunContext& context)
      : surface_(surface),
        topology_(topology),
        rays_(surface.V, surface.F, bvh),
        context_(context),
        cuts_(surface, graph),
        vertices_(static_cast<Index>(surface.V.rows())) {}

  Result<CoveredNetwork> run() {
    try {
      cuts_.run(rays_, context_);
      if (auto stop = context_.stop()) return *stop;
      find_chains();
      find_levels();
    } catch (const Degenerate& where) {
      out_.problem = "the surface is not in general position: " + where.what;
      return std::move(out_);
    }
    if (auto stop = context_.stop()) return *stop;
    for (Index h = 0; h < half_edges(); ++h)
      if (h < topology_.twin[h]) link_along(h);
    for (Index f = 0; f < surface_.F.rows(); ++f)
      if (is_cut(f)) add_face(f);
    return std::move(out_);
  }

 private:
  Index half_edges() const { return static_cast<Index>(topology_.twin.size()); }
  Index first_of(Index h) const { return std::min(h, topology_.twin[h]); }
  bool is_cut(Index f) const { return cuts_.half_begin[f + 1] - cuts_.half_begin[f] != 3; }
  bool covered(Index part) { return level_[region_.root(part)] > 0; }

  // The nodes on pierced edges, and where they are.
  struct Chain {
    std::vector<Index> nodes;
    std::vector<double> at;  // 0 at the source of the edge's smaller half-edge, 1 at its target
  };

  void find_chains() {
    for (Index h = 0; h < half_edges(); ++h) {
      if (h > topology_.twin[h] || !(is_cut(h / 3) && is_cut(topology_.twin[h] / 3))) continue;
      Chain c{cuts_.edge_chain(h), {}};
      if (c.nodes.size() < 3) continue;
      const exact::Vec a = cuts_.place(c.nodes.front()), e = cuts_.place(c.nodes.back()) - a;
      const exact::Rational whole = exact::dot(e, e);
      for (const Index x : c.nodes)
        c.at.push_back(exact::approximate(exact::Rational(exact::dot(cuts_.place(x) - a, e) / whole)));
      chains_.emplace(h, std::move(c));
    }
  }

  // The part to the left of the i-th piece of an edge, from the source of its smaller half-edge on.
  Index part_at(Index h, std::size_t i) const {
    const auto chain = chains_.find(h);
    const Index a = chain == chains_.end() ? half_edge_source(surface_.F, h) : chain->second.nodes[i];
    const Index b = chain == chains_.end() ? half_edge_target(surface_.F, h) : chain->second.nodes[i + 1];
    return cuts_.halves[cuts_.half(h / 3, a, b)].part;
  }
  std::size_t pieces_of(Index h) const {
    const auto chain = chains_.find(h);
    return chain == chains_.end() ? 1 : chain->second.nodes.size() - 1;
  }

  // The winding number in front of each part: the same for all that hang together over edges.
  void find_levels() {
    const std::size_t parts = cuts_.face_of_part.size();
    region_.reset(parts);
    for (Index h = 0; h < half_edges(); ++h) {
      const Index other = topology_.twin[h];
      if (other < h) continue;
      for (std::size_t i = 0; i < pieces_of(h); ++i) {
        const auto chain = chains_.find(h);
        const Index a = chain == chains_.end() ? half_edge_source(surface_.F, h) : chain->second.nodes[i];
        const Index b = chain == chains_.end() ? half_edge_target(surface_.F, h) : chain->second.nodes[i + 1];
        region_.join(part_at(h, i), cuts_.halves[cuts_.half(other / 3, b, a)].part);
      }
    }
    level_.assign(parts, 0);
    std::vector<char> known(parts, 0);
    for (const bool whole : {true, false})  // whole faces need no triangulation
      for (Index p = 0; p < static_cast<Index>(parts); ++p) {
        const Index r = region_.root(p);
        if (known[r] || is_cut(cuts_.face_of_part[p]) == whole) continue;
        if (const auto level = level_in_front(p)) level_[r] = *level, known[r] = 1;
      }
  }

  std::optional<int> level_in_front(Index p) {
    const Index f = cuts_.face_of_part[p];
    TriangulatedPart part;
    if (is_cut(f)) {
      part = triangulated(p);
    } else {
      part.places = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      part.triangles = {{0, 1, 2}};
    }
    for (const auto& t : part.triangles) {
      exact::Vec at{};
      const FacePoint hub = middle(f, part, t);
      for (int k = 0; k < 3; ++k)
        at = at + exact::Rational(hub.weight[k], kFaceGrid) * exact::vec(rays_.corner(f, k));
      const exact::RayCount ray = rays_.count(exact::Point(at), exact::Point(rays_.normal(f)), nullptr, {f});
      if (ray.status == exact::RayStatus::counted) return ray.winding;
    }
    return std::nullopt;
  }

  static FacePoint middle(Index f, const TriangulatedPart& part, const std::array<int, 3>& t) {
    InFace::Place p{};
    for (const int i : t)
      for (int k = 0; k < 3; ++k) p[k] += part.places[i][k] / 3;
    return InFace::on_grid(f, p);
  }

  InFace::Place place_of(Index f, Index node) {
    for (int k = 0; k < 3; ++k) {
      InFace::Place p{};
      p[k] = 1;
      if (surface_.F(f, k) == node) return p;
    }
    for (int k = 0; k < 3; ++k) {
      const Index h = first_of(3 * f + k);
      const auto chain = chains_.find(h);
      if (chain == chains_.end()) continue;
      const auto at = std::find(chain->second.nodes.begin(), chain->second.nodes.end(), node);
      if (at != chain->second.nodes.end())
        return on_edge(f, k, chain->second.at[static_cast<std::size_t>(at - chain->second.nodes.begin())]);
    }
    const exact::Vec p = cuts_.place(node), n = rays_.normal(f);
    const exact::Rational whole = exact::dot(n, n);
    InFace::Place out{};
    for (int k = 0; k < 3; ++k) {
      const exact::Vec b = exact::vec(rays_.corner(f, (k + 1) % 3)),
                       c = exact::vec(rays_.corner(f, (k + 2) % 3));
      out[k] = exact::approximate(exact::Rational(exact::dot(exact::cross(b - p, c - p), n) / whole));
    }
    return out;
  }

  // at: from the source of the edge's smaller half-edge on.
  InFace::Place on_edge(Index f, int k, double at) const {
    if (first_of(3 * f + k) != 3 * f + k) at = 1 - at;
    InFace::Place p{};
    p[k] = 1 - at;
    p[(k + 1) % 3] = at;
    return p;
  }

  TriangulatedPart triangulated(Index p) {
    TriangulatedPart part;
    const Index f = cuts_.face_of_part[p];
    if (cuts_.holes[p] > 0) return part;
    Index start = cuts_.half_begin[f];
    while (cuts_.halves[start].part != p) ++start;
    Index h = start;
    do {
      part.nodes.push_back(cuts_.halves[h].from);
      part.places.push_back(place_of(f, cuts_.halves[h].from));
      h = cuts_.halves[h].next;
    } while (h != start);
    part.triangulate();
    return part;
  }

  Index add_point(const FacePoint& p) {
    out_.points.push_back(p);
    return vertices_ + static_cast<Index>(out_.points.size()) - 1;
  }

  Eigen::Vector3d space(Index node) const {
    return node < vertices_
               ? Eigen::Vector3d(surface_.V.row(node))
               : place_in_space(surface_, out_.points[static_cast<std::size_t>(node - vertices_)]);
  }
  void link(Index a, Index b, Index face) {
    out_.links.push_back({a, b, face, (space(a) - space(b)).norm()});
  }

  // The middle of a piece of a pierced edge.
  Index gate(Index h, std::size_t piece) {
    const auto [at, added] = gates_.try_emplace({h, piece}, -1);
    if (!added) return at->second;
    const std::vector<double>& t = chains_.at(h).at;
    FacePoint p = InFace::on_grid(h / 3, on_edge(h / 3, h % 3, (t[piece] + t[piece + 1]) / 2));
    return at->second = add_point(p);
  }

  void link_along(Index h) {
    const Index a = half_edge_source(surface_.F, h), b = half_edge_target(surface_.F, h);
    const std::size_t pieces = pieces_of(h);
    bool all = true;
    std::vector<char> is_covered;
    for (std::size_t i = 0; i < pieces; ++i) {
      is_covered.push_back(covered(part_at(h, i)));
      all = all && is_covered.back();
    }
    if (all) link(a, b, -1);
    if (pieces == 1) return;
    for (std::size_t i = 0; i < pieces; ++i) {
      if (!is_covered[i]) continue;
      if (i == 0) link(a, gate(h, i), -1);
      if (i + 1 == pieces)
        link(gate(h, i), b, -1);
      else if (is_covered[i + 1])
        link(gate(h, i), gate(h, i + 1), -1);
    }
  }

  // What a piece of a part's border leads to, by its two ends.
  struct Door {
    Index hub;
    InFace::Place middle;
  };
  using Doors = std::map<std::pair<Index, Index>, std::vector<Door>>;

  void add_face(Index f) {
    std::map<std::pair<Index, Index>, std::pair<Index, std::size_t>> on_border;
    for (int k = 0; k < 3; ++k) {
      const Index h = first_of(3 * f + k);
      if (const auto chain = chains_.find(h); chain != chains_.end())
        for (std::size_t i = 0; i + 1 < chain->second.nodes.size(); ++i)
          on_border[std::minmax(chain->second.nodes[i], chain->second.nodes[i + 1])] = {h, i};
    }
    std::set<Index> parts;
    std::map<std::pair<Index, Index>, int> dry;  // pieces with a side that is not covered
    for (Index h = cuts_.half_begin[f]; h < cuts_.half_begin[f + 1]; ++h) {
      parts.insert(cuts_.halves[h].part);
      const auto key = std::minmax(cuts_.halves[h].from, cuts_.halves[h].to);
      if (!covered(cuts_.halves[h].part) && !on_border.count(key)) dry[key] = 1;
    }
    Doors curves;
    for (const Index p : parts)
      if (covered(p)) add_part(f, triangulated(p), on_border, curves);
    for (const auto& [ends, doors] : curves)
      if (doors.size() == 2 && cross_at(f, ends, doors)) link(doors[0].hub, doors[1].hub, f);
    for (const auto& [ends, one] : dry)
      out_.barriers.push_back({f, {place_of(f, ends.first), place_of(f, ends.second)}});
  }

  bool cross_at(Index f, const std::pair<Index, Index>& ends, const std::vector<Door>& doors) {
    return InFace::cross(doors[0].middle, doors[1].middle, place_of(f, ends.first), place_of(f, ends.second));
  }

  void add_part(Index f, const TriangulatedPart& part,
                const std::map<std::pair<Index, Index>, std::pair<Index, std::size_t>>& on_border,
                Doors& curves) {
    const int m = static_cast<int>(part.nodes.size());
    std::map<std::pair<int, int>, std::vector<Door>> diagonals;
    for (const auto& t : part.triangles) {
      const FacePoint middle_point = middle(f, part, t);
      const InFace::Place at = InFace::place(middle_point);
      bool inside = true;
      for (int k = 0; k < 3; ++k)
        inside = inside && InFace::turn(part.places[t[k]], part.places[t[(k + 1) % 3]], at) > 0;
      if (!inside) continue;  // finer than the grid
      const Index hub = add_point(middle_point);
      for (int k = 0; k < 3; ++k) {
        const int i = t[k], j = t[(k + 1) % 3];
        if (part.nodes[i] < vertices_) link(hub, part.nodes[i], f);
        if ((i + 1) % m != j) {
          diagonals[std::minmax(i, j)].push_back({hub, at});
          continue;
        }
        const auto ends = std::minmax(part.nodes[i], part.nodes[j]);
        const auto border = on_border.find(ends);
        if (border != on_border.end())
          link(hub, gate(border->second.first, border->second.second), f);
        else
          curves[ends].push_back({hub, at});
      }
    }
    for (const auto& [ends, doors] : diagonals) {
      if (doors.size() != 2) continue;
      const InFace::Place &a = part.places[ends.first], &b = part.places[ends.second];
      if (InFace::cross(doors[0].middle, doors[1].middle, a, b)) {
        link(doors[0].hub, doors[1].hub, f);
        continue;
      }
      const Index door = add_point(InFace::on_grid(f, InFace::mean(a, b)));
      for (const Door& d : doors) link(d.hub, door, f);
    }
  }

  const Surface& surface_;
  const SurfaceTopology& topology_;
  const exact::Rays rays_;
  const RunContext& context_;
  FaceCuts cuts_;
  const Index vertices_;
  std::map<Index, Chain> chains_;  // by the smaller half-edge
  UnionFind region_;               // of parts
  std::vector<int> level_;         // by the root of a region
  std::map<std::pair<Index, std::size_t>, Index> gates_;
  CoveredNetwork out_;
};

}  // namespace

Result<CoveredNetwork> find_covered_network(const Surface& surface, const SurfaceTopology& topology,
                                            const TriangleBvh& bvh, IntersectionGraph& graph,
                                            const RunContext& context) {
  return NetworkMaker(surface, topology, bvh, graph, context).run();
}

bool CoveredNetwork::sees(const Surface& surface, const SurfaceTopology& topology, Index face, Index a,
                          Index b) const {
  const Index n = static_cast<Index>(surface.V.rows());
  const auto place = [&](Index node) {
    InFace::Place p{};
    if (node < n) {
      for (int k = 0; k < 3; ++k) p[k] = surface.F(face, k) == node;
      return p;
    }
    const FacePoint& point = points[static_cast<std::size_t>(node - n)];
    return InFace::place(point.face == face ? point : seen_from_other_side(topology, point));
  };
  const InFace::Place p = place(a), q = place(b);
  for (int k = 0; k < 3; ++k)
    if (p[k] == 0 && q[k] == 0) return false;  // along the face's edge
  auto at = std::lower_bound(barriers.begin(), barriers.end(), face,
                             [](const Barrier& x, Index f) { return x.face < f; });
  for (; at != barriers.end() && at->face == face; ++at)
    if (InFace::cross(p, q, at->ends[0], at->ends[1])) return false;
  return true;
}

namespace {

// Shortest ways through the network.
class WaysThroughNetwork {
 public:
  WaysThroughNetwork(const Surface& surface, const CoveredNetwork& network)
      : network_(network),
        vertices_(static_cast<Index>(surface.V.rows())),
        links_(static_cast<std::size_t>(surface.V.rows()) + network.points.size()),
        group_(links_.size()) {
    double longest = 0;
    for (std::size_t i = 0; i < network.links.size(); ++i) {
      const NetworkLink& l = network.links[i];
      links_[l.a].push_back(i), links_[l.b].push_back(i);
      longest = std::max(longest, l.length);
      if (l.face < 0 && l.a < vertices_ && l.b < vertices_) group_.join(l.a, l.b);
    }
    // So that lengths decide between equal numbers of links only.
    per_length_ = 1 / (std::max(longest, 1e-300) * kFarMore);
  }

  std::vector<NetworkLink> join(const std::vector<Index>& odd) {
    std::vector<NetworkLink> out;
    for (;;) {
      std::map<Index, int> parity;
      for (const Index v : odd) parity[group_.root(v)] ^= 1;
      std::erase_if(parity, [](const auto& p) { return p.second == 0; });
      if (parity.empty()) return out;
      const std::vector<NetworkLink> way = way_from(parity.begin()->first, parity);
      if (way.empty()) return {};
      for (const NetworkLink& l : way) {
        group_.join(l.a, l.b);
        if (l.face >= 0) out.push_back(l);
      }
    }
  }

 private:
  double cost(const NetworkLink& l) const { return (l.face >= 0 ? 1 : 0) + per_length_ * l.length; }

  // From a group to the nearest other one with an odd number.
  std::vector<NetworkLink> way_from(Index group, const std::map<Index, int>& odd_groups) {
    std::vector<double> best(links_.size(), HUGE_VAL);
    std::vector<std::ptrdiff_t> by(links_.size(), -1);
    std::priority_queue<std::pair<double, Index>, std::vector<std::pair<double, Index>>, std::greater<>>
        queue;
    for (Index v = 0; v < static_cast<Index>(links_.size()); ++v)
      if (group_.root(v) == group) best[v] = 0, queue.emplace(0, v);
    while (!queue.empty()) {
      const auto [d, v] = queue.top();
      queue.pop();
      if (d > best[v]) continue;
      if (const Index g = group_.root(v); g != group && odd_groups.count(g)) return way_to(v, by);
      for (const std::size_t i : links_[v]) {
        const NetworkLink& l = network_.links[i];
        const Index u = l.a == v ? l.b : l.a;
        if (d + cost(l) >= best[u]) continue;
        best[u] = d + cost(l);
        by[u] = static_cast<std::ptrdiff_t>(i);
        queue.emplace(best[u], u);
      }
    }
    return {};
  }

  std::vector<NetworkLink> way_to(Index v, const std::vector<std::ptrdiff_t>& by) const {
    std::vector<NetworkLink> way;  // each from a to b
    for (; by[v] >= 0;) {
      NetworkLink l = network_.links[static_cast<std::size_t>(by[v])];
      if (l.b != v) std::swap(l.a, l.b);
      v = l.a;
      way.push_back(l);
    }
    std::reverse(way.begin(), way.end());
    return way;
  }

  const CoveredNetwork& network_;
  const Index vertices_;
  std::vector<std::vector<std::size_t>> links_;  // at each node
  UnionFind group_;
  double per_length_ = 0;
};

}  // namespace

std::vector<NetworkLink> links_between(const Surface& surface, const CoveredNetwork& network,
                                       const std::vector<Index>& odd) {
  return WaysThroughNetwork(surface, network).join(odd);
}

std::vector<NetworkLink> pulled_tight(const Surface& surface, const SurfaceTopology& topology,
                                      const CoveredNetwork& network, const std::vector<NetworkLink>& links) {
  const Index n = static_cast<Index>(surface.V.rows());
  std::map<std::array<Index, 3>, NetworkLink> left;  // by face and ends
  std::map<Index, std::set<std::array<Index, 3>>> at;
  const auto put = [&](const NetworkLink& l) {
    const std::array<Index, 3> key{l.face, std::min(l.a, l.b), std::max(l.a, l.b)};
    left.emplace(key, l);
    at[l.a].insert(key), at[l.b].insert(key);
  };
  for (const NetworkLink& l : links)
    if (l.face >= 0) put(l);
  std::vector<Index> nodes;
  for (const auto& [v, keys] : at)
    if (v >= n) nodes.push_back(v);
  for (const Index v : nodes) {
    const std::vector<std::array<Index, 3>> mine(at[v].begin(), at[v].end());
    if (mine.size() != 2 || mine[0][0] != mine[1][0]) continue;
    const Index p = mine[0][1] == v ? mine[0][2] : mine[0][1], q = mine[1][1] == v ? mine[1][2] : mine[1][1];
    if (p == q || !network.sees(surface, topology, mine[0][0], p, q)) continue;
    const NetworkLink joined{p, q, mine[0][0], left.at(mine[0]).length + left.at(mine[1]).length};
    for (const auto& key : mine) {
      left.erase(key);
      for (const Index u : {p, q, v}) at[u].erase(key);
    }
    put(joined);
  }
  std::vector<NetworkLink> out;
  for (const auto& [key, l] : left) out.push_back(l);
  return out;
}

std::vector<NetworkLink> without_loops(const Surface& surface, const std::vector<NetworkLink>& links) {
  std::map<Index, std::vector<std::size_t>> at;
  for (std::size_t i = 0; i < links.size(); ++i)
    for (const Index v : {links[i].a, links[i].b}) at[v].push_back(i);
  const auto passes = [&](Index v) { return v >= surface.V.rows() && at.at(v).size() == 2; };
  std::vector<char> seen(links.size(), 0);
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> chains;  // by their ends
  for (const auto& [start, mine] : at) {
    if (passes(start)) continue;
    for (const std::size_t first : mine) {
      std::vector<std::size_t> chain;
      Index v = start;
      for (std::size_t i = first; !seen[i];) {
        seen[i] = 1;
        chain.push_back(i);
        v = links[i].a == v ? links[i].b : links[i].a;
        if (!passes(v)) break;
        i = at.at(v)[0] == i ? at.at(v)[1] : at.at(v)[0];
      }
      if (chain.empty() || v == start) continue;
      std::vector<std::size_t>& best = chains[std::minmax(start, v)];
      if (best.empty() || chain.size() < best.size()) best = std::move(chain);
    }
  }
  std::vector<NetworkLink> out;
  for (const auto& [ends, chain] : chains)
    for (const std::size_t i : chain) out.push_back(links[i]);
  return out;
}

Additions additions(const Surface& surface, const CoveredNetwork& network,
                    const std::vector<NetworkLink>& links) {
  const Index n = static_cast<Index>(surface.V.rows());
  std::set<Index> nodes;
  for (const NetworkLink& l : links)
    for (const Index v : {l.a, l.b})
      if (v >= n) nodes.insert(v);
  std::map<Index, Index> number;
  Additions out;
  for (const Index v : nodes) {
    number[v] = n + static_cast<Index>(out.points.size());
    out.points.push_back(network.points[static_cast<std::size_t>(v - n)]);
    out.nodes.push_back(v);
  }
  const auto renumbered = [&](Index v) { return v < n ? v : number.at(v); };
  std::set<std::array<Index, 3>> seen;
  for (const NetworkLink& l : links)
    if (l.face >= 0 && seen.insert({l.face, std::min(l.a, l.b), std::max(l.a, l.b)}).second)
      out.edges.push_back({l.face, renumbered(l.a), renumbered(l.b)});
  return out;
}

}  // namespace overtet
