#include "src/covering/link.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "kernels/core/union_find.h"
#include "kernels/predicates/predicates.h"
#include "src/covering/gluing_search.h"
#include "src/covering/tuning.h"
#include "src/exact/rational.h"

namespace overtet {

namespace {

using exact::Vec;

// The link polygon as a plane graph on the sphere: corners first, then crossings.
struct Graph {
  struct Piece {
    int from, to, arc;
  };
  struct Half {
    int piece;
    bool leaves;  // the piece begins at this node
  };
  int corners = 0;
  std::vector<Piece> pieces;
  std::vector<std::vector<Half>> around;  // per node, counter-clockwise seen from outside the sphere
  std::vector<std::array<int, 2>> cell;   // per piece: to the right (inside), to the left (outside)
  std::vector<int> layers;                // per cell
};

class Link {
 public:
  Link(const Surface& surface, const SurfaceTopology& topology, Index v)
      : p_(surface.V.data() + 3 * std::int64_t{v}) {
    for (const Index h : half_edges_around(topology, v)) {
      faces_.push_back(half_edge_face(h));
      ends_.push_back(surface.V.data() + 3 * std::int64_t{half_edge_target(surface.F, h)});
    }
  }

  // crossings: pairs of faces at the vertex that have more than the vertex, or their edge, in common.
  std::optional<Graph> graph(const std::vector<FacePair>& crossings) const {
    const int n = static_cast<int>(ends_.size());
    struct Crossing {
      int i, j;
      bool to_left;  // of arc i goes arc j
      Vec at;
    };
    std::vector<Crossing> found;
    std::vector<std::vector<int>> on(n);  // crossings of each arc
    for (const auto& [f, g] : crossings) {
      const int i = index(f), j = index(g);
      if (i < 0 || j < 0) return std::nullopt;
      const int a = left_of(j, i), b = left_of(j, i + 1), c = left_of(i, j), d = left_of(i, j + 1);
      if (a == 0 || b == 0 || c == 0 || d == 0) return std::nullopt;
      if (a == b || c == d || a == c) return std::nullopt;  // not a crossing of arcs
      Vec x = cross(normal(i), normal(j));
      if (a < 0)
        for (int k = 0; k < 3; ++k) x[k] = -x[k];
      for (const int arc : {i, j}) on[arc].push_back(static_cast<int>(found.size()));
      found.push_back({i, j, d > 0, std::move(x)});
    }
    Graph out;
    out.corners = n;
    out.around.resize(n + found.size());
    std::map<std::pair<int, int>, int> into, outof;  // arc, node
    for (int i = 0; i < n; ++i) {
      const Vec axis = normal(i);
      bool distinct = true;
      std::sort(on[i].begin(), on[i].end(), [&](int x, int y) {
        return x != y && exact::sign(dot(cross(found[x].at, found[y].at), axis)) > 0;
      });
      for (std::size_t k = 1; k < on[i].size(); ++k)
        distinct = distinct && exact::sign(dot(cross(found[on[i][k - 1]].at, found[on[i][k]].at), axis)) > 0;
      if (!distinct) return std::nullopt;
      int at = i;
      const auto go = [&](int node) {
        outof[{i, at}] = into[{i, node}] = static_cast<int>(out.pieces.size());
        out.pieces.push_back({at, node, i});
        at = node;
      };
      for (const int x : on[i]) go(n + x);
      go((i + 1) % n);
    }
    for (int i = 0; i < n; ++i)
      out.around[i] = {{outof.at({i, i}), true}, {into.at({(i + n - 1) % n, i}), false}};
    for (std::size_t x = 0; x < found.size(); ++x) {
      const int node = n + static_cast<int>(x), i = found[x].i, j = found[x].j;
      const Graph::Half i_out{outof.at({i, node}), true}, i_in{into.at({i, node}), false};
      const Graph::Half j_out{outof.at({j, node}), true}, j_in{into.at({j, node}), false};
      if (found[x].to_left)
        out.around[node] = {i_out, j_out, i_in, j_in};
      else
        out.around[node] = {i_out, j_in, i_in, j_out};
    }
    find_cells(out);
    return out;
  }

 private:
  int index(Index face) const {
    const auto at = std::find(faces_.begin(), faces_.end(), face);
    return at == faces_.end() ? -1 : static_cast<int>(at - faces_.begin());
  }
  const double* end(int i) const { return ends_[i % ends_.size()]; }
  int left_of(int arc, int corner) const { return orient3d(p_, end(arc), end(arc + 1), end(corner)); }
  Vec normal(int arc) const {
    const Vec p = exact::vec(p_);
    return exact::cross(exact::vec(end(arc)) - p, exact::vec(end(arc + 1)) - p);
  }

  // The polygon is connected, so every cell has one boundary.
  static void find_cells(Graph& g) {
    std::vector<int> next(2 * g.pieces.size());  // per directed piece: 2 piece + along
    for (const auto& halves : g.around)
      for (std::size_t q = 0; q < halves.size(); ++q) {
        const Graph::Half& leave = halves[q];
        const Graph::Half& arrive = halves[(q + 1) % halves.size()];
        next[2 * arrive.piece + !arrive.leaves] = 2 * leave.piece + leave.leaves;
      }
    g.cell.assign(g.pieces.size(), {-1, -1});
    int cells = 0;
    for (int start = 0; start < static_cast<int>(next.size()); ++start) {
      if (g.cell[start / 2][start % 2] >= 0) continue;
      for (int h = start; g.cell[h / 2][h % 2] < 0; h = next[h]) g.cell[h / 2][h % 2] = cells;
      ++cells;
    }
    g.layers.assign(cells, 0);
  }

  const double* p_;
  std::vector<Index> faces_;
  std::vector<const double*> ends_;
};

// False when the layers do not agree or are too many.
bool count_layers(Graph& g, const std::vector<int>& near) {
  std::vector<char> counted(g.layers.size(), 0);
  std::vector<int> stack{g.cell[g.around[0][0].piece][1]};
  g.layers[stack[0]] = near[0];
  counted[stack[0]] = 1;
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    for (const auto& [right, left] : g.cell)
      for (const auto& [here, there, jump] : {std::array{right, left, -1}, std::array{left, right, 1}})
        if (here == c && !counted[there]) {
          counted[there] = 1;
          g.layers[there] = g.layers[c] + jump;
          stack.push_back(there);
        }
  }
  for (const auto& [right, left] : g.cell)
    if (g.layers[right] != g.layers[left] + 1) return false;
  for (int i = 0; i < g.corners; ++i)
    if (g.layers[g.cell[g.around[i][0].piece][1]] != near[i]) return false;
  const auto [low, high] = std::minmax_element(g.layers.begin(), g.layers.end());
  return *low >= 0 && *high <= *std::rbegin(kSheets) &&
         std::all_of(counted.begin(), counted.end(), [](char c) { return c != 0; });
}

// The search: pieces are regions, their left side is the outer one.
class Search {
 public:
  Search(const Graph& g, int B0, const std::vector<int>& least) : g_(g), B0_(B0) {
    for (const auto& [right, left] : g.cell) cells_.push_back({left, right});
    for (std::size_t node = 0; node < g.around.size(); ++node) {
      const auto& halves = g.around[node];
      GluingCondition c;
      if (static_cast<int>(node) < g.corners) {
        c.regions = {halves[0].piece, halves[1].piece, -1, -1};
        c.most = least[node];
      } else {
        // Of the arc i that halves[0] leaves along, what lies left of the other one j, and the other way
        // round; then what lies on the right. Seen from i, j goes to the left or to the right.
        const bool to_left = halves[1].leaves;
        const Index i_out = halves[0].piece, i_in = halves[2].piece;
        const Index j_out = halves[to_left ? 1 : 3].piece, j_in = halves[to_left ? 3 : 1].piece;
        if (to_left)
          c.regions = {i_in, j_out, i_out, j_in};
        else
          c.regions = {i_out, j_in, i_in, j_out};
      }
      conditions_.push_back(c);
    }
  }

  LinkAnswer run() const {
    const RunContext context;
    GluingSearch search(conditions_, cells_, g_.layers, context,
                        [this](const std::vector<const Way*>& ways) { return is_disc(ways); });
    const SolverAnswer found = search.run(kMostStepsOfLink);
    LinkAnswer out;
    out.steps = search.steps();
    out.verdict = found == SolverAnswer::found  ? LinkVerdict::filled
                  : found == SolverAnswer::none ? LinkVerdict::unfillable
                                                : LinkVerdict::undecided;
    return out;
  }

 private:
  // Whether the layers and the turns make as much as they must.
  bool is_disc(const std::vector<const Way*>& ways) const {
    int sum = 2 * closed_parts(ways);
    for (int i = 0; i < g_.corners; ++i) sum += *turns_at(conditions_[i], ways);
    return sum == B0_;
  }

  // Layers that hang together and end nowhere.
  int closed_parts(const std::vector<const Way*>& ways) const {
    std::vector<int> first(g_.layers.size() + 1, 0);
    std::partial_sum(g_.layers.begin(), g_.layers.end(), first.begin() + 1);
    UnionFind parts(first.back());
    int closed = first.back();
    std::vector<int> ending;
    for (std::size_t k = 0; k < cells_.size(); ++k) {
      const auto [outer, inner] = cells_[k];
      const Way& way = *ways[k];
      int end = g_.layers[inner] * (g_.layers[inner] - 1) / 2;  // the only one that no other goes on into
      for (std::size_t c = 0; c < way.size(); ++c) {
        closed -= parts.join(first[outer] + static_cast<int>(c), first[inner] + way[c]);
        end -= way[c];
      }
      ending.push_back(first[inner] + end);
    }
    std::set<int> bounded;
    for (const int x : ending) bounded.insert(parts.root(x));
    return closed - static_cast<int>(bounded.size());
  }

  const Graph& g_;
  const int B0_;
  std::vector<std::array<Index, 2>> cells_;  // per piece
  std::vector<GluingCondition> conditions_;  // per node
};

}  // namespace

bool has_regular_link(const Surface& surface, const SurfaceTopology& topology, Index vertex,
                      const std::vector<FacePair>& crossings) {
  return Link(surface, topology, vertex).graph(crossings).has_value();
}

LinkAnswer fill_link(const Surface& surface, const SurfaceTopology& topology, const Hinge& hinge,
                     const std::vector<int>& near, const std::vector<int>& least) {
  LinkAnswer out;
  if (!hinge.B0) return out;
  std::optional<Graph> graph = Link(surface, topology, hinge.vertex).graph(hinge.crossings);
  if (!graph || !count_layers(*graph, near)) return out;
  if (std::any_of(least.begin(), least.end(), [](int most) { return most < 0; })) {
    out.verdict = LinkVerdict::unfillable;
    return out;
  }
  return Search(*graph, *hinge.B0, least).run();
}

}  // namespace overtet
