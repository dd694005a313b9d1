#include "src/arrangement/face_cuts.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "kernels/core/union_find.h"

namespace overtet {

using exact::Rational;
using exact::Vec;

namespace {

using Half = FaceCuts::Half;
using Flat = FaceCuts::Flat;
using NodePairs = FaceCuts::NodePairs;

bool by_nodes(const Half& a, const Half& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); }

int orientation(const Flat& d, const Flat& e) { return exact::sign(d[0] * e[1] - d[1] * e[0]); }

Flat minus(const Flat& a, const Flat& b) { return {a[0] - b[0], a[1] - b[1]}; }

// Divides one face: joins half-pieces to loops; those that run around something counter-clockwise bound
// parts, the others holes of parts, or the face from outside.
class FaceDivision {
 public:
  // The first `border` pieces run along the face's border, as it turns. flat: the places of their nodes.
  FaceDivision(Index f, const NodePairs& found, std::size_t border, std::map<Index, Flat> flat)
      : f_(f), flat_(std::move(flat)), component_(flat_.size()) {
    for (std::size_t k = 0; k < found.size(); ++k) {
      const auto [x, y] = found[k];
      halves_.push_back({x, y});
      halves_.push_back({y, x});
      if (k < border) outside_.emplace(y, x);
    }
    std::sort(halves_.begin(), halves_.end(), by_nodes);
    for (const auto& [x, p] : flat_) number_.emplace(x, static_cast<Index>(number_.size()));
    for (const auto& [x, y] : found) component_.join(number_[x], number_[y]);
    whole_ = component_.root(number_.at(found[0].first));
  }

  // Numbers parts from first_part on. Throws Degenerate.
  void run(Index first_part) {
    for (std::size_t b = 0; b < halves_.size();) {
      std::size_t e = b;
      while (e < halves_.size() && halves_[e].from == halves_[b].from) ++e;
      join_around(b, e);
      b = e;
    }
    find_loops();
    for (Loop& loop : loops_) {
      if (exact::sign(loop.area) <= 0) continue;
      loop.part = first_part + static_cast<Index>(holes_.size());
      holes_.push_back(0);
      around(loop.first, [&](Index h) { halves_[h].part = loop.part; });
    }
    for (const Loop& loop : loops_) {
      if (loop.part >= 0) continue;
      if (component_of(loop.first) == whole_) {
        check_outside(loop);
        continue;
      }
      const Index part = part_around(loop);
      ++holes_[part - first_part];
      around(loop.first, [&](Index h) { halves_[h].part = part; });
    }
  }

  const std::vector<Half>& halves() const { return halves_; }  // next: among them; part -1: outside the face
  const std::vector<int>& holes() const { return holes_; }     // of each part

 private:
  struct Loop {
    Index first;
    Rational area;
    Index part = -1;
  };

  Index find(Index x, Index y) const {
    const auto at =
        std::lower_bound(halves_.begin(), halves_.end(), std::make_pair(x, y),
                         [](const Half& h, const auto& key) { return std::make_pair(h.from, h.to) < key; });
    return static_cast<Index>(at - halves_.begin());
  }

  Index component_of(Index h) { return component_.root(number_.at(halves_[h].from)); }

  template <class Use>
  void around(Index first, Use&& use) const {
    Index h = first;
    do {
      use(h);
      h = halves_[h].next;
    } while (h != first);
  }

  // Halves [b, e) leave one node y. After x -> y: what leaves y next, clockwise from y -> x.
  void join_around(std::size_t b, std::size_t e) {
    struct Direction {
      Flat d;
      bool low;
      Index to;
    };
    std::vector<Direction> out;
    for (std::size_t k = b; k < e; ++k) {
      Flat d = minus(flat_[halves_[k].to], flat_[halves_[k].from]);
      const int up = exact::sign(d[1]);
      const bool low = !(up > 0 || (up == 0 && exact::sign(d[0]) > 0));
      out.push_back({std::move(d), low, halves_[k].to});
    }
    std::sort(out.begin(), out.end(), [&](const Direction& p, const Direction& q) {
      return p.low != q.low ? q.low : orientation(p.d, q.d) > 0;
    });
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::size_t last = (k + out.size() - 1) % out.size();
      if (out.size() > 1 && out[k].low == out[last].low && orientation(out[k].d, out[last].d) == 0)
        throw Degenerate{"curves overlap in face " + std::to_string(f_)};
      halves_[find(out[k].to, halves_[b].from)].next = find(halves_[b].from, out[last].to);
    }
  }

  void find_loops() {
    std::vector<char> seen(halves_.size(), 0);
    for (Index start = 0; start < static_cast<Index>(halves_.size()); ++start) {
      if (seen[start]) continue;
      Loop loop{start, 0};
      for (Index h = start; !seen[h]; h = halves_[h].next) {
        seen[h] = 1;
        const Flat &a = flat_[halves_[h].from], &b = flat_[halves_[h].to];
        loop.area += a[0] * b[1] - a[1] * b[0];
      }
      loops_.push_back(std::move(loop));
    }
  }

  // Throws where the loop is not that of the border seen from outside the face.
  void check_outside(const Loop& loop) const {
    around(loop.first, [&](Index h) {
      if (!outside_.count({halves_[h].from, halves_[h].to}))
        throw Degenerate{"face " + std::to_string(f_) + " cannot be divided"};
    });
  }

  // Of the parts that surround a hole, the smallest.
  Index part_around(const Loop& hole) {
    const Flat& p = flat_[halves_[hole.first].from];
    const Loop* best = nullptr;
    for (const Loop& ring : loops_) {
      if (ring.part < 0 || component_of(ring.first) == component_of(hole.first)) continue;
      bool inside = false;
      around(ring.first, [&](Index h) {
        const Flat &a = flat_[halves_[h].from], &b = flat_[halves_[h].to];
        if ((a[1] > p[1]) == (b[1] > p[1])) return;
        const int left = orientation(minus(b, a), minus(p, a));
        if (left == 0) throw Degenerate{"curves touch in face " + std::to_string(f_)};
        if ((left > 0) == (b[1] > a[1])) inside = !inside;
      });
      if (inside && (!best || ring.area < best->area)) best = &ring;
    }
    if (!best) throw Degenerate{"face " + std::to_string(f_) + " cannot be divided"};
    return best->part;
  }

  const Index f_;
  std::map<Index, Flat> flat_;  // by node
  std::vector<Half> halves_;
  std::set<std::pair<Index, Index>> outside_;
  std::map<Index, Index> number_;  // of the nodes, in component_
  UnionFind component_;
  Index whole_ = -1;  // the component of the border
  std::vector<Loop> loops_;
  std::vector<int> holes_;
};

}  // namespace

void FaceCuts::run(const exact::Rays& rays, const RunContext& context) {
  if (!graph_.prepare_all(rays, context)) return;
  for (std::size_t i = 0; i < graph_.pairs().size(); ++i) number_ends(i);
  for (auto& [f, list] : partners_) std::sort(list.begin(), list.end());
  find_triples(rays);
  const Index n = static_cast<Index>(surface_.F.rows());
  for (Index f = 0; f < n; ++f) {
    if ((f & 255) == 0 && context.stop()) return;
    half_begin.push_back(static_cast<Index>(halves.size()));
    cut(f);
  }
  half_begin.push_back(static_cast<Index>(halves.size()));
}

Index FaceCuts::half(Index f, Index x, Index y) const {
  const auto begin = halves.begin() + half_begin[f], end = halves.begin() + half_begin[f + 1];
  const auto at = std::lower_bound(begin, end, std::make_pair(x, y), [](const Half& h, const auto& key) {
    return std::make_pair(h.from, h.to) < key;
  });
  if (at == end || at->from != x || at->to != y) throw Degenerate{"the parts of a face do not fit together"};
  return static_cast<Index>(at - halves.begin());
}

std::vector<Index> FaceCuts::edge_chain(Index h) const {
  const Index a = half_edge_source(surface_.F, h), b = half_edge_target(surface_.F, h);
  std::vector<Index> out{a, b};
  const auto at = on_edge_.find({std::min(a, b), std::max(a, b)});
  if (at == on_edge_.end()) return out;
  out.insert(out.end(), at->second.begin(), at->second.end());
  return chain(std::move(out), place(b) - place(a));
}

Vec FaceCuts::place(Index node) const {
  const Index n = static_cast<Index>(surface_.V.rows());
  return node < n ? exact::vec(point(node)) : added_[node - n];
}

const double* FaceCuts::point(Index v) const { return surface_.V.data() + 3 * std::int64_t{v}; }

const double* FaceCuts::corner(Index f, int k) const { return point(surface_.F(f, k % 3)); }

Vec FaceCuts::normal(Index f) const {
  const Vec a = exact::vec(corner(f, 0));
  return exact::cross(exact::vec(corner(f, 1)) - a, exact::vec(corner(f, 2)) - a);
}

std::string FaceCuts::name(Index f, Index g) {
  return "faces " + std::to_string(f) + " and " + std::to_string(g);
}

// In the order in which a walk around both faces meets them, edge by edge.
void FaceCuts::number_ends(std::size_t pair) {
  const auto [f, g] = graph_.pairs()[pair];
  if (graph_.kind(pair) == IntersectionGraph::Kind::coplanar)
    throw Degenerate{name(f, g) + " lie on each other"};
  if (graph_.kind(pair) != IntersectionGraph::Kind::segment) throw Degenerate{name(f, g) + " touch"};
  const IntersectionGraph::Segment& s = graph_.segments()[graph_.segment_of(pair)];
  if (!s.plain()) throw Degenerate{name(f, g) + " touch"};
  std::array<std::pair<int, Index>, 2> order;
  for (int e = 0; e < 2; ++e) {
    const auto& [in_f, in_g] = s.ends[e];
    if (in_f.dimension == 0 && in_f == in_g) {
      order[e] = {-1, in_f.id};
      continue;
    }
    if (in_f.dimension + in_g.dimension != 3 || std::min(in_f.dimension, in_g.dimension) != 1)
      throw Degenerate{name(f, g) + " touch"};
    const bool of_f = in_f.dimension == 1;
    const Index face = of_f ? f : g, edge = (of_f ? in_f : in_g).id;
    const Index a = half_edge_source(surface_.F, edge), b = half_edge_target(surface_.F, edge);
    int k = 0;  // of the face's corners a and b are k and k + 1
    for (const auto& F = surface_.F; F(face, (k + 2) % 3) == a || F(face, (k + 2) % 3) == b;) ++k;
    order[e] = {2 * k + !of_f, s.node[e]};
  }
  std::sort(order.begin(), order.end());
  std::array<Index, 2> ends;
  for (int e = 0; e < 2; ++e) ends[e] = order[e].first < 0 ? order[e].second : number(order[e].second);
  crossings_[{f, g}].ends = ends;
  partners_[f].push_back(g);
  partners_[g].push_back(f);
}

Index FaceCuts::number(Index graph_node) {
  const auto [at, added] =
      number_.try_emplace(graph_node, static_cast<Index>(surface_.V.rows() + added_.size()));
  if (!added) return at->second;
  added_.push_back(graph_.position(graph_node).x);
  const IntersectionGraph::Meeting& m = graph_.nodes()[graph_node];  // an edge, and a face
  const Index a = half_edge_source(surface_.F, m[0].id), b = half_edge_target(surface_.F, m[0].id);
  on_edge_[{std::min(a, b), std::max(a, b)}].push_back(at->second);
  return at->second;
}

void FaceCuts::find_triples(const exact::Rays& rays) {
  std::map<std::array<Index, 3>, Vec> found;
  for (Index i = 0; i < static_cast<Index>(graph_.segments().size()); ++i) {
    const IntersectionGraph::Segment& s = graph_.segments()[i];
    for (const IntersectionGraph::Cut& cut : graph_.cuts(i).places) {
      if (cut.faces.empty()) continue;
      if (!cut.plain || cut.faces.size() > 1)
        throw Degenerate{name(s.faces.first, s.faces.second) + " and " + std::to_string(cut.faces[0]) +
                         " meet in special position"};
      std::array<Index, 3> faces{s.faces.first, s.faces.second, cut.faces[0]};
      if (faces[2] < faces[1]) continue;  // found from the first two
      const Vec &a = graph_.position(s.node[0]).x, &b = graph_.position(s.node[1]).x;
      found.emplace(faces, a + graph_.place(rays, i, cut) * (b - a));
    }
    if (graph_.cuts(i).overlaid)
      throw Degenerate{name(s.faces.first, s.faces.second) + " touch a third face"};
  }
  for (const auto& [faces, place] : found) {
    const Index node = static_cast<Index>(surface_.V.rows() + added_.size());
    added_.push_back(place);
    const auto [f, g, h] = faces;
    for (const FacePair& pair : {FacePair{f, g}, FacePair{g, h}, FacePair{f, h}})
      crossings_[pair].triples.push_back(node);
  }
}

std::vector<Index> FaceCuts::chain(std::vector<Index> nodes, const Vec& along) const {
  std::vector<std::pair<Rational, Index>> at;
  for (const Index x : nodes) at.emplace_back(dot(along, place(x)), x);
  std::sort(at.begin(), at.end());
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (i > 0 && at[i - 1].first == at[i].first) throw Degenerate{"curves meet on an edge"};
    nodes[i] = at[i].second;
  }
  return nodes;
}

void FaceCuts::cut(Index f) {
  NodePairs found;
  for (int k = 0; k < 3; ++k) {
    const std::vector<Index> nodes = edge_chain(3 * f + k);
    for (std::size_t i = 1; i < nodes.size(); ++i) found.emplace_back(nodes[i - 1], nodes[i]);
  }
  const std::size_t border = found.size();
  const auto mine = partners_.find(f);
  if (mine != partners_.end())
    for (const Index g : mine->second) {
      const FacePair pair{std::min(f, g), std::max(f, g)};
      const Crossing& crossing = crossings_.at(pair);
      std::vector<Index> nodes{crossing.ends[0], crossing.ends[1]};
      nodes.insert(nodes.end(), crossing.triples.begin(), crossing.triples.end());
      nodes = chain(std::move(nodes), exact::cross(normal(pair.first), normal(pair.second)));
      for (std::size_t i = 1; i < nodes.size(); ++i) {
        found.emplace_back(nodes[i - 1], nodes[i]);
        if (f < g) pieces.push_back({f, g, nodes[i - 1], nodes[i]});
      }
    }
  if (found.size() == 3)
    add_whole(f, found);
  else
    divide(f, found, border);
}

std::map<Index, Flat> FaceCuts::flattened(Index f, const NodePairs& found) const {
  const Vec n = normal(f);
  int drop = 0;
  for (int k = 1; k < 3; ++k)
    if (abs(n[k]) > abs(n[drop])) drop = k;
  int i = (drop + 1) % 3, j = (drop + 2) % 3;
  if (exact::sign(n[drop]) < 0) std::swap(i, j);
  std::map<Index, Flat> flat;
  for (const auto& [x, y] : found)
    for (const Index z : {x, y})
      if (!flat.count(z)) {
        const Vec p = place(z);
        flat[z] = {p[i], p[j]};
      }
  return flat;
}

void FaceCuts::add_whole(Index f, const NodePairs& border) {
  const Index base = static_cast<Index>(halves.size());
  for (const auto& [x, y] : border) halves.push_back({x, y, static_cast<Index>(face_of_part.size()), -1});
  std::sort(halves.begin() + base, halves.end(), by_nodes);
  for (Index h = base; h < base + 3; ++h)
    for (Index g = base; g < base + 3; ++g)
      if (halves[g].from == halves[h].to) halves[h].next = g;
  face_of_part.push_back(f);
  holes.push_back(0);
}

void FaceCuts::divide(Index f, const NodePairs& found, std::size_t border) {
  const Index base = static_cast<Index>(halves.size());
  FaceDivision division(f, found, border, flattened(f, found));
  division.run(static_cast<Index>(face_of_part.size()));
  face_of_part.insert(face_of_part.end(), division.holes().size(), f);
  holes.insert(holes.end(), division.holes().begin(), division.holes().end());
  const std::vector<Half>& local = division.halves();
  std::vector<Index> to(local.size(), -1);
  for (std::size_t h = 0; h < local.size(); ++h)
    if (local[h].part >= 0) {
      to[h] = static_cast<Index>(halves.size());
      halves.push_back(local[h]);
    }
  for (std::size_t h = base; h < halves.size(); ++h) halves[h].next = to[halves[h].next];
}

}  // namespace overtet
