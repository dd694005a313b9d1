#include "src/arrangement/face_cuts.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "kernels/core/union_find.h"

namespace overtet {

using exact::Rational;
using exact::Vec;

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
  segments_[{f, g}] = ends;
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
      triples_[pair].push_back(node);
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
  std::vector<std::pair<Index, Index>> found;
  for (int k = 0; k < 3; ++k) {
    const std::vector<Index> nodes = edge_chain(3 * f + k);
    for (std::size_t i = 1; i < nodes.size(); ++i) found.emplace_back(nodes[i - 1], nodes[i]);
  }
  const std::size_t border = found.size();
  const auto mine = partners_.find(f);
  if (mine != partners_.end())
    for (const Index g : mine->second) {
      const FacePair pair{std::min(f, g), std::max(f, g)};
      const auto& ends = segments_.at(pair);
      std::vector<Index> nodes{ends[0], ends[1]};
      if (const auto at = triples_.find(pair); at != triples_.end())
        nodes.insert(nodes.end(), at->second.begin(), at->second.end());
      nodes = chain(std::move(nodes), exact::cross(normal(pair.first), normal(pair.second)));
      for (std::size_t i = 1; i < nodes.size(); ++i) {
        found.emplace_back(nodes[i - 1], nodes[i]);
        if (f < g) pieces.push_back({f, g, nodes[i - 1], nodes[i]});
      }
    }
  divide(f, found, border);
}

void FaceCuts::divide(Index f, const std::vector<std::pair<Index, Index>>& found, std::size_t border) {
  const Index base = static_cast<Index>(halves.size());
  if (found.size() == 3) {
    for (const auto& [x, y] : found) halves.push_back({x, y, static_cast<Index>(face_of_part.size()), -1});
    std::sort(halves.begin() + base, halves.end(),
              [](const Half& a, const Half& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
    for (Index h = base; h < base + 3; ++h)
      for (Index g = base; g < base + 3; ++g)
        if (halves[g].from == halves[h].to) halves[h].next = g;
    face_of_part.push_back(f);
    holes.push_back(0);
    return;
  }
  const Vec n = normal(f);
  int drop = 0;
  for (int k = 1; k < 3; ++k)
    if (abs(n[k]) > abs(n[drop])) drop = k;
  int i = (drop + 1) % 3, j = (drop + 2) % 3;
  if (exact::sign(n[drop]) < 0) std::swap(i, j);
  using Flat = std::array<Rational, 2>;
  std::map<Index, Flat> flat;
  for (const auto& [x, y] : found)
    for (const Index z : {x, y})
      if (!flat.count(z)) {
        const Vec p = place(z);
        flat[z] = {p[i], p[j]};
      }
  const auto turn = [](const Flat& d, const Flat& e) { return exact::sign(d[0] * e[1] - d[1] * e[0]); };
  const auto minus = [](const Flat& a, const Flat& b) { return Flat{a[0] - b[0], a[1] - b[1]}; };
  std::vector<Half> local;
  std::set<std::pair<Index, Index>> outside;  // the other halves of the border belong to nothing
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto [x, y] = found[k];
    local.push_back({x, y});
    local.push_back({y, x});
    if (k < border) outside.emplace(y, x);
  }
  std::sort(local.begin(), local.end(),
            [](const Half& a, const Half& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
  const auto find = [&](Index x, Index y) {
    const auto at =
        std::lower_bound(local.begin(), local.end(), std::make_pair(x, y),
                         [](const Half& h, const auto& key) { return std::make_pair(h.from, h.to) < key; });
    return static_cast<Index>(at - local.begin());
  };
  // After x -> y: what leaves y next, clockwise from y -> x.
  for (std::size_t b = 0; b < local.size();) {
    std::size_t e = b;
    while (e < local.size() && local[e].from == local[b].from) ++e;
    struct Way {
      Flat d;
      bool low;
      Index to;
    };
    std::vector<Way> ways;
    for (std::size_t k = b; k < e; ++k) {
      Flat d = minus(flat[local[k].to], flat[local[k].from]);
      const int up = exact::sign(d[1]);
      const bool low = !(up > 0 || (up == 0 && exact::sign(d[0]) > 0));
      ways.push_back({std::move(d), low, local[k].to});
    }
    std::sort(ways.begin(), ways.end(),
              [&](const Way& p, const Way& q) { return p.low != q.low ? q.low : turn(p.d, q.d) > 0; });
    for (std::size_t k = 0; k < ways.size(); ++k) {
      const std::size_t last = (k + ways.size() - 1) % ways.size();
      if (ways.size() > 1 && ways[k].low == ways[last].low && turn(ways[k].d, ways[last].d) == 0)
        throw Degenerate{"curves overlap in face " + std::to_string(f)};
      local[find(ways[k].to, local[b].from)].next = find(local[b].from, ways[last].to);
    }
    b = e;
  }
  std::map<Index, Index> number;
  for (const auto& [x, p] : flat) number.emplace(x, static_cast<Index>(number.size()));
  UnionFind component(number.size());
  for (const auto& [x, y] : found) component.join(number[x], number[y]);
  const auto part_of = [&](Index h) { return component.root(number.at(local[h].from)); };

  struct Loop {
    Index first;
    Rational area;
    Index part = -1;
  };
  std::vector<Loop> loops;
  std::vector<char> seen(local.size(), 0);
  for (Index start = 0; start < static_cast<Index>(local.size()); ++start) {
    if (seen[start]) continue;
    Loop loop{start, 0};
    for (Index h = start; !seen[h]; h = local[h].next) {
      seen[h] = 1;
      const Flat &a = flat[local[h].from], &b = flat[local[h].to];
      loop.area += a[0] * b[1] - a[1] * b[0];
    }
    loops.push_back(std::move(loop));
  }
  const auto around = [&](Index first, auto&& use) {
    Index h = first;
    do {
      use(h);
      h = local[h].next;
    } while (h != first);
  };
  for (Loop& loop : loops) {
    if (exact::sign(loop.area) <= 0) continue;
    loop.part = static_cast<Index>(face_of_part.size());
    face_of_part.push_back(f);
    holes.push_back(0);
    around(loop.first, [&](Index h) { local[h].part = loop.part; });
  }
  const Index whole = component.root(number.at(found[0].first));
  for (const Loop& loop : loops) {
    if (loop.part >= 0) continue;
    if (part_of(loop.first) == whole) {
      around(loop.first, [&](Index h) {
        if (!outside.count({local[h].from, local[h].to}))
          throw Degenerate{"face " + std::to_string(f) + " cannot be divided"};
      });
      continue;
    }
    // A hole: of the parts that surround it, the smallest.
    const Flat& p = flat[local[loop.first].from];
    const Loop* best = nullptr;
    for (const Loop& ring : loops) {
      if (ring.part < 0 || part_of(ring.first) == part_of(loop.first)) continue;
      bool inside = false;
      around(ring.first, [&](Index h) {
        const Flat &a = flat[local[h].from], &b = flat[local[h].to];
        if ((a[1] > p[1]) == (b[1] > p[1])) return;
        const int left = turn(minus(b, a), minus(p, a));
        if (left == 0) throw Degenerate{"curves touch in face " + std::to_string(f)};
        if ((left > 0) == (b[1] > a[1])) inside = !inside;
      });
      if (inside && (!best || ring.area < best->area)) best = &ring;
    }
    if (!best) throw Degenerate{"face " + std::to_string(f) + " cannot be divided"};
    ++holes[best->part];
    around(loop.first, [&](Index h) { local[h].part = best->part; });
  }
  std::vector<Index> to(local.size(), -1);
  for (std::size_t h = 0; h < local.size(); ++h)
    if (local[h].part >= 0) {
      to[h] = static_cast<Index>(halves.size());
      halves.push_back(local[h]);
    }
  for (std::size_t h = base; h < halves.size(); ++h) halves[h].next = to[halves[h].next];
}

}  // namespace overtet
