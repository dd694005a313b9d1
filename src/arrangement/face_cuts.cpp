#include "src/arrangement/face_cuts.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "kernels/predicates/predicates.h"

namespace overtet {

using exact::Rational;
using exact::Vec;

void FaceCuts::run(const std::vector<FacePair>& pairs, const RunContext& context) {
  for (const auto& [f, g] : pairs) {
    if (context.stop()) return;
    meet(f, g);
  }
  for (auto& [f, list] : partners_) std::sort(list.begin(), list.end());
  for (const auto& [f, list] : partners_) {
    if (context.stop()) return;
    find_triples(f, list);
  }
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
  if (at == end || at->from != x || at->to != y) throw Degenerate{"the parts of a face do not fit"};
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

int FaceCuts::side(Index f, const double* p) const {
  return orient3d(corner(f, 0), corner(f, 1), corner(f, 2), p);
}

std::string FaceCuts::name(Index f, Index g) {
  return "faces " + std::to_string(f) + " and " + std::to_string(g);
}

Index FaceCuts::add(const std::array<Index, 4>& key, const std::function<Vec()>& where) {
  const auto [at, added] = number_.try_emplace(key, static_cast<Index>(surface_.V.rows() + added_.size()));
  if (added) added_.push_back(where());
  return at->second;
}

bool FaceCuts::in_triangle(const Vec& n, const std::array<Vec, 3>& p, const Vec& x) {
  for (int k = 0; k < 3; ++k)
    if (exact::sign(dot(n, exact::cross(p[(k + 1) % 3] - p[k], x - p[k]))) < 0) return false;
  return true;
}

bool FaceCuts::touches(Index a, Index b, Index f, int ha, int hb) const {
  const Vec n = normal(f), pa = exact::vec(point(a)), pb = exact::vec(point(b));
  const std::array<Vec, 3> p{exact::vec(corner(f, 0)), exact::vec(corner(f, 1)), exact::vec(corner(f, 2))};
  if ((ha == 0 && in_triangle(n, p, pa)) || (hb == 0 && in_triangle(n, p, pb))) return true;
  if (ha != 0 || hb != 0) return false;
  for (int k = 0; k < 3; ++k) {
    const Vec &c = p[k], &d = p[(k + 1) % 3];
    const auto turn = [&](const Vec& from, const Vec& to, const Vec& x) {
      return exact::sign(dot(n, exact::cross(to - from, x - from)));
    };
    if (turn(pa, pb, c) * turn(pa, pb, d) <= 0 && turn(c, d, pa) * turn(c, d, pb) <= 0) return true;
  }
  return false;
}

bool FaceCuts::pierces(Index a, Index b, Index f) const {
  const int ha = side(f, point(a)), hb = side(f, point(b));
  if (ha * hb > 0) return false;
  const auto odd = [&] {
    return Degenerate{"edge " + std::to_string(a) + "-" + std::to_string(b) + " touches face " +
                      std::to_string(f)};
  };
  if (ha == 0 || hb == 0) {
    if (touches(a, b, f, ha, hb)) throw odd();
    return false;
  }
  bool left = false, right = false, on = false;
  for (int k = 0; k < 3; ++k) {
    const int s = orient3d(point(a), point(b), corner(f, k), corner(f, k + 1));
    (s > 0 ? left : s < 0 ? right : on) = true;
  }
  if (left && right) return false;
  if (on) throw odd();
  return true;
}

void FaceCuts::meet(Index f, Index g) {
  std::vector<std::array<int, 2>> common;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (surface_.F(f, i) == surface_.F(g, j)) common.push_back({i, j});
  if (common.size() > 1) throw Degenerate{name(f, g) + " are folded onto each other"};
  std::vector<Index> ends;
  const auto look = [&](Index a, Index b, Index face) {
    if (a > b) std::swap(a, b);
    if (!pierces(a, b, face)) return;
    const std::size_t before = added_.size();
    const Index node = add({0, a, b, face}, [&] {
      const Vec n = normal(face), o = exact::vec(corner(face, 0)), pa = exact::vec(point(a)),
                pb = exact::vec(point(b));
      const Rational ha = dot(n, pa - o), hb = dot(n, pb - o);
      return pa + (ha / (ha - hb)) * (pb - pa);
    });
    if (added_.size() > before) on_edge_[{a, b}].push_back(node);
    ends.push_back(node);
  };
  const auto look_at_edge = [&](Index face, int k, Index other) {
    look(surface_.F(face, k % 3), surface_.F(face, (k + 1) % 3), other);
  };
  if (common.empty()) {
    for (int k = 0; k < 3; ++k) look_at_edge(f, k, g), look_at_edge(g, k, f);
    if (ends.empty()) return;
  } else {
    const auto [i, j] = common[0];
    // The directions from the common corner to the others: arcs that cross, or not.
    const double *a = corner(f, i + 1), *b = corner(f, i + 2), *c = corner(g, j + 1), *d = corner(g, j + 2);
    const int sa = side(g, a), sb = side(g, b), sc = side(f, c), sd = side(f, d);
    if (sa == 0 || sb == 0 || sc == 0 || sd == 0) throw Degenerate{name(f, g) + " touch"};
    if (sa == sb || sc == sd || sa == sc) return;
    ends.push_back(surface_.F(f, i));
    look_at_edge(f, i + 1, g);
    look_at_edge(g, j + 1, f);
  }
  if (ends.size() != 2) throw Degenerate{name(f, g) + " meet in an odd way"};
  segments_[{f, g}] = {ends[0], ends[1]};
  partners_[f].push_back(g);
  partners_[g].push_back(f);
}

int FaceCuts::shared(Index f, Index g) const {
  int n = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) n += surface_.F(f, i) == surface_.F(g, j);
  return n;
}

void FaceCuts::find_triples(Index f, const std::vector<Index>& list) {
  for (const Index g : list) {
    if (g < f) continue;
    for (const Index h : list) {
      if (h < g || !segments_.count({g, h}) || h == g) continue;
      if (shared(f, g) > 1 || shared(f, h) > 1 || shared(g, h) > 1) continue;
      bool vertex = false;  // of all three
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int k = 0; k < 3; ++k)
            vertex = vertex || (surface_.F(f, i) == surface_.F(g, j) && surface_.F(f, i) == surface_.F(h, k));
      if (!vertex) triple(f, g, h);
    }
  }
}

void FaceCuts::triple(Index f, Index g, Index h) {
  const Vec nf = normal(f), ng = normal(g), nh = normal(h);
  const Rational w = exact::det(nf, ng, nh);
  const auto odd = [&] {
    return Degenerate{name(f, g) + " and " + std::to_string(h) + " meet in an odd way"};
  };
  if (exact::sign(w) == 0) throw odd();
  const auto height = [&](const Vec& n, Index face) { return dot(n, exact::vec(corner(face, 0))); };
  const Vec x = (1 / w) * (height(nf, f) * exact::cross(ng, nh) + height(ng, g) * exact::cross(nh, nf) +
                           height(nh, h) * exact::cross(nf, ng));
  bool inside = true;
  for (const auto& [face, n] : {std::pair{f, &nf}, std::pair{g, &ng}, std::pair{h, &nh}})
    for (int k = 0; k < 3; ++k) {
      const Vec p = exact::vec(corner(face, k));
      const int s = exact::sign(dot(*n, exact::cross(exact::vec(corner(face, k + 1)) - p, x - p)));
      if (s == 0) throw odd();
      inside = inside && s > 0;
    }
  if (!inside) return;
  const Index node = add({1, f, g, h}, [&] { return x; });
  for (const FacePair& pair : {FacePair{f, g}, FacePair{g, h}, FacePair{f, h}})
    triples_[pair].push_back(node);
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
  Sets component(number.size());
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
