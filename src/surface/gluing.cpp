#include "src/surface/gluing.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "kernels/predicates/predicates.h"
#include "src/surface/exact.h"

namespace overtet {

namespace {

using exact::Rational;
using exact::Vec;

// Conditions of regions with at most so many sheets inside are tried first; then deeper ones, too. Beyond the
// last number a region has too many gluings.
constexpr int kSheets[] = {3, 4, 6};

// Gluings of single regions looked at in the first attempt; each one after it, which knows where the last
// ones failed, may look at half as many more. Beyond the total (about a second) the matter is left undecided.
constexpr std::int64_t kFirstSteps = 10'000;
constexpr std::int64_t kMostSteps = 4'000'000;

// To find out whether a conflict is still one without some condition.
constexpr std::int64_t kMostStepsToDrop = 50'000;

// Not in general position; says where.
struct Degenerate {
  std::string what;
};

class Sets {
 public:
  explicit Sets(std::size_t n) : up_(n) { std::iota(up_.begin(), up_.end(), 0); }
  Index root(Index x) const {
    while (up_[x] != x) x = up_[x] = up_[up_[x]];
    return x;
  }
  void join(Index x, Index y) { up_[root(x)] = root(y); }

 private:
  mutable std::vector<Index> up_;
};

// The surface cut along its curves. Nodes: the vertices, then points where an edge pierces a face, then
// triple points.
class Cuts {
 public:
  struct Half {  // a piece of a part's border, the part to its left
    Index from, to;
    Index part = -1, next = -1;
  };
  struct Piece {  // of a curve; along n_f x n_g, f < g
    Index f, g, from, to;
  };

  Cuts(const Surface& surface, const SurfaceTopology& topology) : surface_(surface), topology_(topology) {}

  std::vector<Half> halves;         // by face
  std::vector<Index> half_begin;    // #F + 1; within a face sorted by (from, to)
  std::vector<Index> face_of_part;  // parts of a face follow each other
  std::vector<int> holes;           // per part
  std::vector<Piece> pieces;

  void run(const std::vector<FacePair>& pairs, const RunContext& context) {
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

  // The half-edge of f from node x to node y.
  Index half(Index f, Index x, Index y) const {
    const auto begin = halves.begin() + half_begin[f], end = halves.begin() + half_begin[f + 1];
    const auto at = std::lower_bound(begin, end, std::make_pair(x, y), [](const Half& h, const auto& key) {
      return std::make_pair(h.from, h.to) < key;
    });
    if (at == end || at->from != x || at->to != y) throw Degenerate{"the parts of a face do not fit"};
    return static_cast<Index>(at - halves.begin());
  }

  // The nodes on an input edge, from the source of the half-edge on.
  std::vector<Index> edge_chain(Index h) const {
    const Index a = half_edge_source(surface_.F, h), b = half_edge_target(surface_.F, h);
    std::vector<Index> out{a, b};
    const auto at = on_edge_.find({std::min(a, b), std::max(a, b)});
    if (at == on_edge_.end()) return out;
    out.insert(out.end(), at->second.begin(), at->second.end());
    return chain(std::move(out), place(b) - place(a));
  }

  Vec place(Index node) const {
    const Index n = static_cast<Index>(surface_.V.rows());
    return node < n ? exact::vec(point(node)) : added_[node - n];
  }

 private:
  const double* point(Index v) const { return surface_.V.data() + 3 * std::int64_t{v}; }
  const double* corner(Index f, int k) const { return point(surface_.F(f, k % 3)); }
  Vec normal(Index f) const {
    const Vec a = exact::vec(corner(f, 0));
    return exact::cross(exact::vec(corner(f, 1)) - a, exact::vec(corner(f, 2)) - a);
  }
  int side(Index f, const double* p) const {  // 1 in front of the face
    return orient3d(corner(f, 0), corner(f, 1), corner(f, 2), p);
  }
  static std::string name(Index f, Index g) {
    return "faces " + std::to_string(f) + " and " + std::to_string(g);
  }

  Index add(const std::array<Index, 4>& key, const std::function<Vec()>& where) {
    const auto [at, added] = number_.try_emplace(key, static_cast<Index>(surface_.V.rows() + added_.size()));
    if (added) added_.push_back(where());
    return at->second;
  }

  static bool in_triangle(const Vec& n, const std::array<Vec, 3>& p, const Vec& x) {
    for (int k = 0; k < 3; ++k)
      if (exact::sign(dot(n, exact::cross(p[(k + 1) % 3] - p[k], x - p[k]))) < 0) return false;
    return true;
  }

  // Whether the segment from a to b has a point in common with face f; one of them lies in its plane.
  bool touches(Index a, Index b, Index f, int ha, int hb) const {
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

  // Whether edge a-b passes through face f, which has neither of its ends.
  bool pierces(Index a, Index b, Index f) const {
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

  void meet(Index f, Index g) {
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

  int shared(Index f, Index g) const {
    int n = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) n += surface_.F(f, i) == surface_.F(g, j);
    return n;
  }

  void find_triples(Index f, const std::vector<Index>& list) {
    for (const Index g : list) {
      if (g < f) continue;
      for (const Index h : list) {
        if (h < g || !segments_.count({g, h}) || h == g) continue;
        if (shared(f, g) > 1 || shared(f, h) > 1 || shared(g, h) > 1) continue;
        bool vertex = false;  // of all three
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
              vertex =
                  vertex || (surface_.F(f, i) == surface_.F(g, j) && surface_.F(f, i) == surface_.F(h, k));
        if (!vertex) triple(f, g, h);
      }
    }
  }

  void triple(Index f, Index g, Index h) {
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

  std::vector<Index> chain(std::vector<Index> nodes, const Vec& along) const {
    std::vector<std::pair<Rational, Index>> at;
    for (const Index x : nodes) at.emplace_back(dot(along, place(x)), x);
    std::sort(at.begin(), at.end());
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (i > 0 && at[i - 1].first == at[i].first) throw Degenerate{"curves meet on an edge"};
      nodes[i] = at[i].second;
    }
    return nodes;
  }

  void cut(Index f) {
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

  // The first `border` pieces run along the face's border, as it turns.
  void divide(Index f, const std::vector<std::pair<Index, Index>>& found, std::size_t border) {
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

  const Surface& surface_;
  const SurfaceTopology& topology_;
  std::map<std::array<Index, 4>, Index> number_;  // of added nodes
  std::vector<Vec> added_;
  std::map<FacePair, std::array<Index, 2>> segments_;
  std::map<Index, std::vector<Index>> partners_;
  std::map<std::pair<Index, Index>, std::vector<Index>> on_edge_;
  std::map<FacePair, std::vector<Index>> triples_;
};

// A condition on the gluings of some parts: around a piece of curve, or at an edge. Between the parts lie
// sectors; where a shell has been cut open in a sector, its sheets have other names on the other side.
struct Condition {
  // Around a curve of f and g: f's part in front of g, g's in front of f, f's behind g, g's behind f. At an
  // edge: two parts, then -1.
  std::array<Index, 4> regions{-1, -1, -1, -1};
  // Names in the sectors: in front of both faces, in front of g only, in front of f only, behind both; from
  // f's part to g's. At an edge: outside, inside; from the first part to the second. -1: the same on both
  // sides.
  std::array<Index, 4> names{-1, -1, -1, -1};
  std::array<char, 4> backwards{0, 0, 0, 0};
  int most = -1;                      // turns at an edge
  Index piece = -1;                   // of a curve
  std::array<Index, 2> edge{-1, -1};  // of the input

  template <class F>
  void each(F&& f) const {
    for (const Index r : regions)
      if (r >= 0) f(r);
    for (const Index r : names)
      if (r >= 0) f(r);
  }
};

// The sheets outside of a part go on into those inside: the number inside of each outside; one more is
// inside. Or the names of sheets across a cut.
using Way = std::vector<signed char>;

int ending(const Way& way) {
  int sum = 0;
  for (const int c : way) sum += c;
  const int n = static_cast<int>(way.size());
  return n * (n + 1) / 2 - sum;
}

bool holds(const Condition& c, const std::vector<const Way*>& ways) {
  const auto inverse = [](const Way& way, int x) {
    return static_cast<int>(std::find(way.begin(), way.end(), x) - way.begin());
  };
  const auto across = [&](int sector, int x, bool back = false) {
    if (c.names[sector] < 0) return x;
    const Way& way = *ways[c.names[sector]];
    return back != (c.backwards[sector] != 0) ? inverse(way, x) : static_cast<int>(way[x]);
  };
  if (c.most < 0) {
    const Way &fp = *ways[c.regions[0]], &gp = *ways[c.regions[1]], &fm = *ways[c.regions[2]],
              &gm = *ways[c.regions[3]];
    for (int k = 0; k < static_cast<int>(fp.size()); ++k)
      if (across(3, fm[across(2, gp[across(0, k)], true)]) != gm[across(1, fp[k])]) return false;
    return gm[across(1, ending(fp))] == across(3, ending(fm)) &&
           across(3, fm[across(2, ending(gp), true)]) == ending(gm);
  }
  // The second part in the names of the first.
  const Way &l = *ways[c.regions[0]], &other = *ways[c.regions[1]];
  Way r(l.size());
  for (int k = 0; k < static_cast<int>(l.size()); ++k)
    r[k] = static_cast<signed char>(across(1, other[across(0, k)], true));
  unsigned passed = 0;
  int at = ending(l), turns = 0;
  const int end = ending(r);
  while (at != end) {
    const int back = inverse(r, at);
    passed |= 1u << back;
    at = l[back];
    if (++turns > c.most) return false;
  }
  for (std::size_t k = 0; k < l.size(); ++k)
    if (!(passed >> k & 1) && l[k] != r[k]) return false;
  return true;
}

// All gluings of all regions that take part in some conditions.
class Search {
 public:
  // outer, inner: the shell on each side of a region; sheets: of each shell.
  Search(std::vector<Condition> conditions, const std::vector<Index>& outer, const std::vector<Index>& inner,
         const std::vector<int>& sheets, const RunContext& context)
      : conditions_(std::move(conditions)), outer_(outer), inner_(inner), sheets_(sheets), context_(context) {
    const std::size_t n = outer.size();
    of_.resize(n);
    ways_.resize(n);
    way_.assign(n, nullptr);
    weight_.assign(conditions_.size(), 1);
    used_.assign(conditions_.size(), 0);
    for (std::size_t k = 0; k < conditions_.size(); ++k)
      conditions_[k].each([&](Index r) {
        if (of_[r].empty()) regions_.push_back(r);
        if (of_[r].empty() || of_[r].back() != static_cast<Index>(k)) of_[r].push_back(static_cast<Index>(k));
      });
    std::sort(regions_.begin(), regions_.end());
    list_ways();
  }

  enum class Answer { found, none, too_long };
  std::int64_t steps() const { return steps_; }
  // Of `none`: the conditions that the search has needed.
  std::vector<Condition> needed() const {
    std::vector<Condition> out;
    for (std::size_t k = 0; k < used_.size(); ++k)
      if (used_[k]) out.push_back(conditions_[k]);
    return out;
  }

  Answer run(std::int64_t most) {
    for (std::size_t k = 0; k < conditions_.size(); ++k)
      if (is_known(conditions_[k]) && !holds(conditions_[k], way_)) {
        used_[k] = 1;
        return Answer::none;
      }
    // Independent parts one after the other.
    std::vector<char> seen(of_.size(), 0);
    for (const Index seed : regions_) {
      if (way_[seed] || seen[seed]) continue;
      std::vector<Index> part{seed};
      seen[seed] = 1;
      for (std::size_t i = 0; i < part.size(); ++i)
        for (const Index k : of_[part[i]])
          conditions_[k].each([&](Index r) {
            if (!way_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
          });
      for (std::int64_t now = kFirstSteps;; now += now / 2) {
        const Answer answer = attempt(part, std::min(now, most - steps_));
        if (answer == Answer::found) break;
        if (answer == Answer::none || steps_ >= most || context_.stop()) return answer;
      }
    }
    return Answer::found;
  }

 private:
  bool is_known(const Condition& c) const {
    bool known = true;
    c.each([&](Index r) { known = known && way_[r]; });
    return known;
  }

  // Sheets carry no names: across the regions of a spanning forest of the shells one way stands for all that
  // differ by names.
  void list_ways() {
    std::map<Index, std::vector<Index>> of_shell;
    for (const Index r : regions_) of_shell[outer_[r]].push_back(r), of_shell[inner_[r]].push_back(r);
    std::vector<Index> order;
    for (const auto& [shell, list] : of_shell) order.push_back(shell);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return sheets_[a] < sheets_[b]; });
    std::map<Index, int> named;  // 1: along the tree
    std::vector<char> first(outer_.size(), 0), sorted(outer_.size(), 0);
    std::vector<Index> queue;
    for (const Index s : order)
      if (sheets_[s] <= 1) named[s] = 1, queue.push_back(s);
    for (std::size_t head = 0, root = 0;;) {
      for (; head < queue.size(); ++head)
        for (const Index r : of_shell[queue[head]]) {
          if (outer_[r] == queue[head] && named.try_emplace(inner_[r], 1).second)
            first[r] = 1, queue.push_back(inner_[r]);
          else if (inner_[r] == queue[head] && named.try_emplace(outer_[r], 1).second)
            sorted[r] = 1, queue.push_back(outer_[r]);
        }
      while (root < order.size() && named.count(order[root])) ++root;
      if (root == order.size()) break;
      named[order[root]] = 1;
      queue.push_back(order[root]);
    }
    for (const Index r : regions_) {
      const int n = sheets_[outer_[r]];
      if (outer_[r] == inner_[r]) {
        Way way(n);
        std::iota(way.begin(), way.end(), static_cast<signed char>(0));
        do ways_[r].push_back(way);
        while (std::next_permutation(way.begin(), way.end()));
        continue;
      }
      for (int ends = n; ends >= 0; --ends) {
        Way way;
        for (int c = 0; c <= n; ++c)
          if (c != ends) way.push_back(static_cast<signed char>(c));
        do ways_[r].push_back(way);
        while (!first[r] && !sorted[r] && std::next_permutation(way.begin(), way.end()));
        if (first[r]) break;
      }
      if (ways_[r].size() == 1) way_[r] = &ways_[r][0];
    }
  }

  // The ways of r that contradict nothing; blame: a condition that one of the others contradicts.
  std::vector<Index> possible(Index r, Index& blame) {
    std::vector<Index> out;
    steps_ += static_cast<std::int64_t>(ways_[r].size());
    for (std::size_t o = 0; o < ways_[r].size(); ++o) {
      way_[r] = &ways_[r][o];
      bool fits = true;
      for (const Index k : of_[r]) {
        if (!is_known(conditions_[k]) || holds(conditions_[k], way_)) continue;
        used_[k] = 1;
        blame = k;
        fits = false;
        break;
      }
      if (fits) out.push_back(static_cast<Index>(o));
    }
    way_[r] = nullptr;
    return out;
  }

  // Backtracking. What is tried next: the region with the fewest ways for the weight of its conditions, which
  // grows with every dead end (dom/wdeg, Boussemart and others 2004), so that a second attempt begins where
  // the first has failed.
  Answer attempt(const std::vector<Index>& part, std::int64_t most) {
    std::fill(used_.begin(), used_.end(), 0);
    struct Level {
      Index region;
      std::vector<Index> ways;
      std::size_t next = 0;
    };
    std::vector<Level> levels;
    const std::size_t n = part.size();
    std::map<Index, std::size_t> at;
    for (std::size_t i = 0; i < n; ++i) at[part[i]] = i;
    std::vector<std::vector<Index>> left(n);
    std::vector<Index> blame(n, -1);
    std::vector<char> stale(n, 1);
    const auto spoil = [&](Index r) {
      for (const Index k : of_[r])
        conditions_[k].each([&](Index other) {
          if (const auto it = at.find(other); it != at.end()) stale[it->second] = 1;
        });
    };
    const std::int64_t end = steps_ + most;
    std::int64_t chosen = 0;
    const auto leave = [&](Answer answer) {
      if (answer != Answer::found)
        for (const Level& level : levels) way_[level.region] = nullptr;
      return answer;
    };
    for (;;) {
      std::size_t best = n;
      double best_key = 0;
      for (std::size_t i = 0; i < n; ++i) {
        if (way_[part[i]]) continue;
        if (stale[i]) left[i] = possible(part[i], blame[i]), stale[i] = 0;
        double weight = 0;
        for (const Index k : of_[part[i]]) weight += weight_[k];
        const double key = left[i].size() <= 1 ? -1 : static_cast<double>(left[i].size()) / weight;
        if (best == n || key < best_key || left[i].empty()) best = i, best_key = key;
        if (left[i].empty()) break;
      }
      if (best == n) return Answer::found;
      if (left[best].empty())
        ++weight_[blame[best]];
      else
        levels.push_back({part[best], left[best]});
      for (;;) {
        if (levels.empty()) return Answer::none;
        Level& level = levels.back();
        if (way_[level.region]) spoil(level.region);
        way_[level.region] = nullptr;
        if (level.next < level.ways.size()) {
          way_[level.region] = &ways_[level.region][level.ways[level.next++]];
          spoil(level.region);
          if (steps_ > end || (++chosen % 256 == 0 && context_.stop())) return leave(Answer::too_long);
          break;
        }
        stale[at[level.region]] = 1;
        levels.pop_back();
      }
    }
  }

  std::vector<Condition> conditions_;
  const std::vector<Index>&outer_, &inner_;
  const std::vector<int>& sheets_;
  const RunContext& context_;
  std::vector<Index> regions_;
  std::vector<std::vector<Index>> of_;  // conditions of each region
  std::vector<std::vector<Way>> ways_;  // of each region
  std::vector<const Way*> way_;         // the one chosen
  std::vector<double> weight_;          // of each condition
  std::vector<char> used_;
  std::int64_t steps_ = 0;
};

class Checker {
 public:
  Checker(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
          const RunContext& context)
      : surface_(surface),
        topology_(topology),
        rays_(surface.V, surface.F, bvh),
        context_(context),
        cuts_(surface, topology) {}

  Result<GluingAnswer> run(const std::vector<FacePair>& pairs) {
    GluingAnswer out;
    try {
      cuts_.run(pairs, context_);
      if (auto stop = context_.stop()) return *stop;
      find_shells();
    } catch (const Degenerate& where) {
      out.message = "Not in general position: " + where.what + ".";
      return out;
    }
    if (auto stop = context_.stop()) return *stop;
    find_conditions();
    out.parts = static_cast<Index>(cuts_.face_of_part.size());
    out.conditions = static_cast<Index>(conditions_.size());
    out.verdict = GluingVerdict::open;
    out.message = "Nothing contradicts a gluing along the curves.";
    std::size_t tried = 0;
    for (const int most : kSheets) {
      std::vector<Condition> some;
      for (const Condition& c : conditions_)
        if (std::all_of(c.regions.begin(), c.regions.end(),
                        [&](Index r) { return r < 0 || sheets_[inner_[r]] <= most; }))
          some.push_back(c);
      if (some.size() == tried) continue;
      tried = some.size();
      Search search = searching(std::move(some));
      const Search::Answer answer = search.run(kMostSteps);
      out.steps += search.steps();
      if (auto stop = context_.stop()) return *stop;
      if (answer == Search::Answer::found) continue;
      if (answer == Search::Answer::too_long) {
        out.verdict = GluingVerdict::undecided;
        out.message = "The search for a gluing was given up.";
        return out;
      }
      out.verdict = GluingVerdict::conflict;
      name(fewer(search.needed(), out.steps), out);
      if (auto stop = context_.stop()) return *stop;
      return out;
    }
    return out;
  }

 private:
  Search searching(std::vector<Condition> conditions) const {
    return Search(std::move(conditions), outer_, inner_, sheets_, context_);
  }

  // Two sides of parts with a sector between them.
  struct Sector {
    Index u, v;  // halves; v runs the other way, or the same way
    int ku, kv;  // in front (0) or behind (1)
    bool same;
  };

  // Shells: what the solid covers on one side of the surface, connected around edges and curves.
  void find_shells() {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    const Index n = static_cast<Index>(cuts_.halves.size());
    std::vector<Sector> sectors;
    for (Index h = 0; h < static_cast<Index>(topology_.twin.size()); ++h) {
      const Index other = topology_.twin[h];
      if (other < h) continue;
      const std::vector<Index> nodes = cuts_.edge_chain(h);
      for (std::size_t i = 1; i < nodes.size(); ++i) {
        const Index u = cuts_.half(h / 3, nodes[i - 1], nodes[i]),
                    v = cuts_.half(other / 3, nodes[i], nodes[i - 1]);
        edge_pieces_.push_back({h, cuts_.halves[u].part, cuts_.halves[v].part});
        for (const int k : {0, 1}) sectors.push_back({u, v, k, k, false});
      }
    }
    for (const Cuts::Piece& p : cuts_.pieces) {
      // Along n_f x n_g: on its left in f is what lies behind g, on its left in g what lies in front of f.
      const Index fm = cuts_.half(p.f, p.from, p.to), fp = cuts_.half(p.f, p.to, p.from);
      const Index gp = cuts_.half(p.g, p.from, p.to), gm = cuts_.half(p.g, p.to, p.from);
      sectors.push_back({fp, gp, 0, 0, false});
      sectors.push_back({fp, gm, 1, 0, true});
      sectors.push_back({fm, gp, 0, 1, true});
      sectors.push_back({fm, gm, 1, 1, false});
      const auto& halves = cuts_.halves;
      leaves_.push_back({halves[fp].part, halves[gp].part, halves[fm].part, halves[gm].part});
    }
    std::vector<Index> before(n);
    for (Index h = 0; h < n; ++h) before[cuts_.halves[h].next] = h;
    Sets side(2 * static_cast<std::size_t>(parts)), corner(2 * static_cast<std::size_t>(n));
    for (const Sector& s : sectors) {
      side.join(2 * cuts_.halves[s.u].part + s.ku, 2 * cuts_.halves[s.v].part + s.kv);
      // A half's corner is the one at its end.
      const Index ue = 2 * s.u + s.ku, ub = 2 * before[s.u] + s.ku;
      const Index ve = 2 * s.v + s.kv, vb = 2 * before[s.v] + s.kv;
      corner.join(ue, s.same ? ve : vb);
      corner.join(ub, s.same ? vb : ve);
    }
    std::vector<Index> number(2 * static_cast<std::size_t>(parts), -1);
    Index shells = 0;
    shell_.resize(number.size());
    for (Index x = 0; x < 2 * parts; ++x) {
      Index& s = number[side.root(x)];
      if (s < 0) s = shells++;
      shell_[x] = s;
    }
    // A sphere has two more corners and parts than pieces between them.
    std::vector<Index> euler(shells, 0);
    for (Index x = 0; x < 2 * parts; ++x) euler[shell_[x]] += 1 - cuts_.holes[x / 2];
    for (const Sector& s : sectors) --euler[shell_[side_of(s)]];
    for (Index x = 0; x < 2 * n; ++x)
      if (corner.root(x) == x) ++euler[shell_[2 * cuts_.halves[x / 2].part + x % 2]];
    find_sheets(shells);
    find_coverage();
    std::vector<char> cut(shells, 0);
    for (Index s = 0; s < shells; ++s) cut[s] = sheets_[s] > 1 && euler[s] != 2;
    cut_handles(cut, sectors, before, corner);
  }

  Index side_of(const Sector& s) const { return 2 * cuts_.halves[s.u].part + s.ku; }
  Index other_side_of(const Sector& s) const { return 2 * cuts_.halves[s.v].part + s.kv; }

  // How often each input edge is covered all along.
  void find_coverage() {
    for (const EdgePiece& e : edge_pieces_) {
      const int here = sheets_[shell_[2 * e.left]];
      const auto [at, added] = covered_.try_emplace(e.half_edge, here);
      if (!added) at->second = std::min(at->second, here);
    }
  }

  // Sheets over a shell with handles may change places on the way round. Such shells are cut open: what is
  // left is a tree of parts (those with holes left out), grown around every corner that but one cut leads to.
  // Across a cut names change, in the same way until the cut branches.
  void cut_handles(const std::vector<char>& cut, const std::vector<Sector>& sectors,
                   const std::vector<Index>& before, const Sets& corner) {
    sector_cut_.assign(sectors.size(), 0);
    left_out_.assign(cuts_.face_of_part.size(), 0);
    std::vector<std::pair<int, Index>> order;  // what had better not be cut comes first
    for (std::size_t i = 0; i < sectors.size(); ++i) {
      const Sector& s = sectors[i];
      if (!cut[shell_[side_of(s)]]) continue;
      sector_cut_[i] = 1;
      const bool at_edge = i < 2 * edge_pieces_.size();
      order.emplace_back(at_edge && covered_.at(edge_pieces_[i / 2].half_edge) > 0, static_cast<Index>(i));
      for (const Index p : {side_of(s) / 2, other_side_of(s) / 2})
        if (cuts_.holes[p] > 0) left_out_[p] = 1;
    }
    std::sort(order.begin(), order.end());
    const auto whole = [&](const Sector& s) {
      return !left_out_[side_of(s) / 2] && !left_out_[other_side_of(s) / 2];
    };
    Sets grown(2 * cuts_.face_of_part.size());
    std::map<Index, std::vector<Index>> at_corner;
    const auto corners = [&](const Sector& s) {
      return std::array<Index, 2>{corner.root(2 * s.u + s.ku), corner.root(2 * before[s.u] + s.ku)};
    };
    for (const auto& [late, i] : order) {
      const Sector& s = sectors[i];
      const Index a = grown.root(side_of(s)), b = grown.root(other_side_of(s));
      if (a != b && whole(s)) {
        grown.join(a, b);
        sector_cut_[i] = 0;
      } else {
        for (const Index x : corners(s)) at_corner[x].push_back(i);
      }
    }
    std::vector<Index> stack;
    for (const auto& [x, list] : at_corner) stack.push_back(x);
    while (!stack.empty()) {
      const Index x = stack.back();
      stack.pop_back();
      Index only = -1;
      int count = 0;
      for (const Index i : at_corner[x])
        if (sector_cut_[i]) only = i, ++count;
      if (count != 1 || !whole(sectors[only])) continue;
      sector_cut_[only] = 0;
      for (const Index y : corners(sectors[only])) stack.push_back(y);
    }
    // Around a corner with two cuts: what one does the other undoes.
    names_.assign(sectors.size(), -1);
    backwards_.assign(sectors.size(), 0);
    // From a half's left to its right is counter-clockwise at its end, clockwise at its beginning; behind the
    // face the other way round.
    const auto turns_left = [&](Index i, Index x) {
      return (corners(sectors[i])[0] == x) != (sectors[i].ku == 1);
    };
    for (Index first = 0; first < static_cast<Index>(sectors.size()); ++first) {
      if (!sector_cut_[first] || names_[first] >= 0) continue;
      const Index name = static_cast<Index>(name_shells_.size());
      name_shells_.push_back(shell_[side_of(sectors[first])]);
      names_[first] = name;
      std::vector<Index> arc{first};
      for (std::size_t k = 0; k < arc.size(); ++k) {
        const Index here = arc[k];
        for (const Index x : corners(sectors[here])) {
          std::vector<Index> met;  // twice where both ends are at x
          for (const Index i : at_corner[x])
            if (sector_cut_[i]) met.push_back(i);
          if (met.size() != 2 || met[0] == met[1]) continue;
          const Index other = met[0] == here ? met[1] : met[0];
          if (names_[other] >= 0) continue;
          names_[other] = name;
          backwards_[other] = (backwards_[here] != 0) != (turns_left(here, x) == turns_left(other, x));
          arc.push_back(other);
        }
      }
    }
  }

  // The winding number over each shell: by one ray, at the first face that is whole, for all that hang
  // together.
  void find_sheets(Index shells) {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    std::vector<std::vector<std::pair<Index, int>>> links(shells);
    for (Index p = 0; p < parts; ++p) {
      links[shell_[2 * p]].emplace_back(shell_[2 * p + 1], 1);
      links[shell_[2 * p + 1]].emplace_back(shell_[2 * p], -1);
    }
    for (auto& list : links) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    std::vector<char> known(shells, 0);
    sheets_.assign(shells, 0);
    for (Index p = 0; p < parts; ++p) {
      const Index f = cuts_.face_of_part[p];
      if (known[shell_[2 * p]] || cuts_.half_begin[f + 1] - cuts_.half_begin[f] != 3) continue;
      const auto winding = just_in_front(f);
      if (!winding) continue;
      std::vector<Index> stack{shell_[2 * p]};
      sheets_[stack[0]] = *winding;
      known[stack[0]] = 1;
      while (!stack.empty()) {
        const Index s = stack.back();
        stack.pop_back();
        for (const auto& [other, jump] : links[s]) {
          if (known[other] && sheets_[other] != sheets_[s] + jump)
            throw Degenerate{"winding numbers do not agree"};
          if (known[other]) continue;
          known[other] = 1;
          sheets_[other] = sheets_[s] + jump;
          stack.push_back(other);
        }
      }
    }
    for (Index s = 0; s < shells; ++s)
      if (!known[s] || sheets_[s] < 0) throw Degenerate{"a winding number is not known, or negative"};
  }

  std::optional<int> just_in_front(Index f) const {
    const Rational third(1, 3);
    for (int k = 0; k < 4; ++k) {
      const Rational a(3 + k, 9 + 2 * k), b(3, 9 + 2 * k), c = 1 - a - b;
      const exact::Point start(a * exact::vec(rays_.corner(f, 0)) + b * exact::vec(rays_.corner(f, 1)) +
                               c * exact::vec(rays_.corner(f, 2)));
      const exact::RayCount ray = rays_.count(start, exact::Point(rays_.normal(f)), nullptr, {f});
      if (ray.status == exact::RayStatus::counted) return ray.winding;
    }
    return std::nullopt;
  }

  void find_conditions() {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    Sets region(parts);
    // Edges that are not covered all along turn as they show: one gluing on both sides.
    const auto uncut = [&](std::size_t first, int count) {
      return std::none_of(sector_cut_.begin() + first, sector_cut_.begin() + first + count,
                          [](char c) { return c; });
    };
    for (std::size_t i = 0; i < edge_pieces_.size(); ++i) {
      const EdgePiece& e = edge_pieces_[i];
      if (covered_.at(e.half_edge) < 1 && uncut(2 * i, 2)) region.join(e.left, e.right);
    }
    outer_.assign(parts, -1);
    inner_.assign(parts, -1);
    for (Index p = 0; p < parts; ++p) {
      outer_[region.root(p)] = shell_[2 * p];
      inner_[region.root(p)] = shell_[2 * p + 1];
    }
    // Names across cuts are unknown like gluings.
    for (const Index shell : name_shells_) {
      outer_.push_back(shell);
      inner_.push_back(shell);
    }
    using Key = std::tuple<std::array<Index, 4>, std::array<Index, 4>, std::array<char, 4>, int>;
    std::set<Key> known;
    const auto add = [&](Condition& c, std::size_t sector, int sectors) {
      for (const Index r : c.regions)
        if (r >= 0 && (left_out_[r] || sheets_[inner_[r]] > *std::rbegin(kSheets))) return;
      for (int k = 0; k < sectors; ++k)
        if (names_[sector + k] >= 0) {
          c.names[k] = parts + names_[sector + k];
          c.backwards[k] = backwards_[sector + k];
        }
      if (known.insert({c.regions, c.names, c.backwards, c.most}).second) conditions_.push_back(c);
    };
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      Condition c;
      for (int k = 0; k < 4; ++k) c.regions[k] = region.root(leaves_[i][k]);
      c.piece = static_cast<Index>(i);
      add(c, 2 * edge_pieces_.size() + 4 * i, 4);
    }
    for (std::size_t i = 0; i < edge_pieces_.size(); ++i) {
      const EdgePiece& e = edge_pieces_[i];
      Condition c;
      c.regions = {region.root(e.left), region.root(e.right), -1, -1};
      c.most = covered_.at(e.half_edge);
      const Index a = half_edge_source(surface_.F, e.half_edge),
                  b = half_edge_target(surface_.F, e.half_edge);
      c.edge = {std::min(a, b), std::max(a, b)};
      // One sheet outside fits whatever happens, where it may turn.
      const bool idle = c.most > 0 && sheets_[outer_[c.regions[0]]] < 2;
      if (!idle && (c.regions[0] != c.regions[1] || !uncut(2 * i, 2))) add(c, 2 * i, 2);
    }
  }

  // A conflict in which nothing is left out that it can do without.
  std::vector<Condition> fewer(std::vector<Condition> conflict, std::int64_t& steps) const {
    const auto still = [&](const std::vector<Condition>& some) -> std::optional<std::vector<Condition>> {
      Search search = searching(some);
      const Search::Answer answer = search.run(kMostStepsToDrop);
      steps += search.steps();
      if (answer != Search::Answer::none) return std::nullopt;
      return search.needed();
    };
    while (auto less = still(conflict)) {
      if (less->size() >= conflict.size()) break;
      conflict = std::move(*less);
    }
    for (std::size_t i = 0; i < conflict.size() && !context_.stop();) {
      std::vector<Condition> without = conflict;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      if (auto less = still(without))
        conflict = std::move(*less), i = 0;
      else
        ++i;
    }
    return conflict;
  }

  void name(const std::vector<Condition>& conflict, GluingAnswer& out) const {
    for (const Condition& c : conflict) {
      if (c.most >= 0) {
        out.edges.push_back(c.edge);
        continue;
      }
      const Cuts::Piece& p = cuts_.pieces[c.piece];
      const Vec middle = Rational(1, 2) * (cuts_.place(p.from) + cuts_.place(p.to));
      out.crossings.push_back({{p.f, p.g}, sheets_[outer_[c.regions[0]]], exact::approximate(middle)});
    }
    std::sort(out.edges.begin(), out.edges.end());
    out.edges.erase(std::unique(out.edges.begin(), out.edges.end()), out.edges.end());
    std::sort(out.crossings.begin(), out.crossings.end(), [](const auto& a, const auto& b) {
      return std::tie(a.faces, a.layers, a.place) < std::tie(b.faces, b.layers, b.place);
    });
    const auto same = [](const auto& a, const auto& b) { return a.faces == b.faces && a.layers == b.layers; };
    out.crossings.erase(std::unique(out.crossings.begin(), out.crossings.end(), same), out.crossings.end());
    out.message = "No positive mesh exists: the sheets of the solid cannot be glued without a branch line";
    if (!out.crossings.empty())
      out.message += " where faces " + std::to_string(out.crossings[0].faces.first) + " and " +
                     std::to_string(out.crossings[0].faces.second) + " cross" +
                     (out.crossings.size() > 1
                          ? " and at " + std::to_string(out.crossings.size() - 1) + " other crossings at once"
                          : "");
    out.message += ".";
  }

  struct EdgePiece {
    Index half_edge;    // of the input
    Index left, right;  // parts
  };

  const Surface& surface_;
  const SurfaceTopology& topology_;
  const exact::Rays rays_;
  const RunContext& context_;
  Cuts cuts_;
  std::vector<EdgePiece> edge_pieces_;
  std::vector<std::array<Index, 4>> leaves_;  // per piece of a curve
  std::vector<Index> shell_;                  // per part: in front, behind
  std::map<Index, int> covered_;              // per edge of the input: how often, all along
  std::vector<char> sector_cut_;              // two a piece of an edge, then four a piece of a curve
  std::vector<char> left_out_;                // per part
  std::vector<Index> names_;                  // per sector: what changes there, or -1
  std::vector<char> backwards_;               // per sector
  std::vector<Index> name_shells_;            // per change of names
  std::vector<int> sheets_;                   // per shell
  std::vector<Index> outer_, inner_;          // per region, named by one of its parts: shells
  std::vector<Condition> conditions_;
};

}  // namespace

Result<GluingAnswer> check_gluing(const Surface& surface, const SurfaceTopology& topology,
                                  const TriangleBvh& bvh, const std::vector<FacePair>& pairs,
                                  const RunContext& context) {
  return Checker(surface, topology, bvh, context).run(pairs);
}

}  // namespace overtet
