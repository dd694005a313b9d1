#include "src/covering/link.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "kernels/predicates/predicates.h"
#include "src/exact/exact.h"

namespace overtet {

namespace {

using exact::Vec;

// More layers, or a longer search, count as undecided. scripts/check_witness repeats the search.
constexpr int kMostLayers = 6;
constexpr std::int64_t kMostSteps = 200'000;

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
  constexpr int kUnknown = -1000;
  std::fill(g.layers.begin(), g.layers.end(), kUnknown);
  std::vector<int> stack{g.cell[g.around[0][0].piece][1]};
  g.layers[stack[0]] = near[0];
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    for (const auto& [right, left] : g.cell)
      for (const auto& [here, there, jump] : {std::array{right, left, -1}, std::array{left, right, 1}})
        if (here == c && g.layers[there] == kUnknown) {
          g.layers[there] = g.layers[c] + jump;
          stack.push_back(there);
        }
  }
  for (const auto& [right, left] : g.cell)
    if (g.layers[right] != g.layers[left] + 1) return false;
  for (int i = 0; i < g.corners; ++i)
    if (g.layers[g.cell[g.around[i][0].piece][1]] != near[i]) return false;
  const auto [low, high] = std::minmax_element(g.layers.begin(), g.layers.end());
  return *low >= 0 && *high <= kMostLayers;
}

class Search {
 public:
  Search(const Graph& g, int B0, const std::vector<int>& least) : g_(g), B0_(B0), least_(least) {}

  std::int64_t steps() const { return steps_; }

  LinkVerdict run(std::vector<int>& turns) {
    list_options();
    order_pieces();
    inner_of_.resize(g_.pieces.size());
    outer_of_.resize(g_.pieces.size());
    turns_.assign(g_.corners, 0);
    const bool found = descend(0);
    if (found) turns = turns_;
    return found                 ? LinkVerdict::filled
           : steps_ > kMostSteps ? LinkVerdict::undecided
                                 : LinkVerdict::unfillable;
  }

 private:
  int inside(int piece) const { return g_.layers[g_.cell[piece][0]]; }
  int outside(int piece) const { return g_.layers[g_.cell[piece][1]]; }

  // Per piece, all ways to glue: the copy inside of every copy outside. Copies carry no names: across the
  // pieces of a spanning forest of the cells one way stands for all that differ by names.
  void list_options() {
    const int n = static_cast<int>(g_.pieces.size()), cells = static_cast<int>(g_.layers.size());
    options_.resize(n);
    for (int k = 0; k < n; ++k) {
      // All choices of the copy that ends, times all orders of the others.
      for (int ends = 0; ends <= outside(k); ++ends) {
        std::vector<int> way;
        for (int c = 0; c <= outside(k); ++c)
          if (c != ends) way.push_back(c);
        do options_[k].push_back(way);
        while (std::next_permutation(way.begin(), way.end()));
      }
    }
    std::vector<int> order(cells);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return g_.layers[a] < g_.layers[b]; });
    std::vector<char> named(cells, 0);
    for (const int root : order) {
      if (named[root]) continue;
      named[root] = 1;
      std::vector<int> queue{root};
      for (std::size_t head = 0; head < queue.size(); ++head)
        for (int k = 0; k < n; ++k) {
          const auto [right, left] = g_.cell[k];
          if (left == queue[head] && !named[right]) {
            std::vector<int> way(outside(k));
            std::iota(way.begin(), way.end(), 0);
            options_[k] = {way};
            named[right] = 1;
            queue.push_back(right);
          } else if (right == queue[head] && !named[left]) {
            std::erase_if(options_[k],
                          [](const auto& way) { return !std::is_sorted(way.begin(), way.end()); });
            named[left] = 1;
            queue.push_back(left);
          }
        }
    }
  }

  // Nodes are completed one after the other, along the polygon.
  void order_pieces() {
    const int n = static_cast<int>(g_.pieces.size());
    std::vector<char> taken(n, 0);
    for (int step = 0; step < n; ++step) {
      std::array<int, 3> best_key{};
      int best = -1;
      for (int k = 0; k < n; ++k) {
        if (taken[k]) continue;
        int open = 1000;
        for (const int node : {g_.pieces[k].from, g_.pieces[k].to}) {
          int others = 0;
          for (const auto& h : g_.around[node]) others += h.piece != k && !taken[h.piece];
          open = std::min(open, others);
        }
        const std::array<int, 3> key{options_[k].size() > 1, open, static_cast<int>(options_[k].size())};
        if (best < 0 || key < best_key) best = k, best_key = key;
      }
      taken[best] = 1;
      order_.push_back(best);
      completes_.emplace_back();
      for (const int node : std::set<int>{g_.pieces[best].from, g_.pieces[best].to}) {
        const auto& halves = g_.around[node];
        if (std::all_of(halves.begin(), halves.end(), [&](const auto& h) { return taken[h.piece]; }))
          completes_.back().push_back(node);
      }
    }
  }

  bool descend(std::size_t level) {
    if (level == order_.size()) {
      return std::accumulate(turns_.begin(), turns_.end(), 2 * closed_parts()) == B0_;
    }
    const int piece = order_[level];
    for (const std::vector<int>& way : options_[piece]) {
      if (++steps_ > kMostSteps) return false;
      inner_of_[piece] = way;
      outer_of_[piece].assign(inside(piece), -1);
      for (std::size_t c = 0; c < way.size(); ++c) outer_of_[piece][way[c]] = static_cast<int>(c);
      bool fits = true;
      for (const int node : completes_[level]) fits = fits && closes(node);
      if (fits && descend(level + 1)) return true;
    }
    return false;
  }

  // Follows all copies around a node, counter-clockwise. Sector q lies between its halves q and q + 1.
  bool closes(int node) {
    const auto& halves = g_.around[node];
    const int m = static_cast<int>(halves.size());
    const auto cross_half = [&](int q, int copy) {  // from sector q over half q + 1
      const Graph::Half& h = halves[(q + 1) % m];
      return h.leaves ? outer_of_[h.piece][copy] : inner_of_[h.piece][copy];
    };
    std::uint64_t passed = 0;  // a bit for each sector and copy
    const auto bit = [](int sector, int copy) { return std::uint64_t{1} << (8 * sector + copy); };
    for (int q = 0; q < m; ++q) {
      if (halves[q].leaves) continue;  // its left side is the outside: nothing begins there
      const int piece = halves[q].piece;
      int copy = 0;
      while (outer_of_[piece][copy] >= 0) ++copy;
      int sector = q, steps = 0;
      for (;;) {
        if (passed & bit(sector, copy)) return false;
        passed |= bit(sector, copy);
        const int next = cross_half(sector, copy);
        sector = (sector + 1) % m;
        if (next < 0) break;
        copy = next;
        ++steps;
      }
      const Graph::Half& end = halves[sector];
      if (!end.leaves) return false;
      if (node < g_.corners) {
        turns_[node] = steps / m;
        if (turns_[node] > least_[node]) return false;
      } else if (g_.pieces[end.piece].arc != g_.pieces[piece].arc || steps != 1) {
        return false;
      }
    }
    for (int q = 0; q < m; ++q) {
      const Graph::Half& h = halves[q];
      const int copies = h.leaves ? outside(h.piece) : inside(h.piece);
      for (int start = 0; start < copies; ++start) {
        if (passed & bit(q, start)) continue;
        int copy = start;
        for (int step = 0; step < m && copy >= 0; ++step) copy = cross_half((q + step) % m, copy);
        if (copy != start) return false;
      }
    }
    return true;
  }

  int closed_parts() const {
    std::vector<int> first(g_.layers.size() + 1, 0);
    std::partial_sum(g_.layers.begin(), g_.layers.end(), first.begin() + 1);
    std::vector<int> up(first.back());
    std::iota(up.begin(), up.end(), 0);
    const auto root = [&](int x) {
      while (up[x] != x) x = up[x] = up[up[x]];
      return x;
    };
    const auto copy = [&](int cell, int c) { return first[cell] + c; };
    for (std::size_t k = 0; k < g_.pieces.size(); ++k)
      for (std::size_t c = 0; c < inner_of_[k].size(); ++c)
        up[root(copy(g_.cell[k][1], static_cast<int>(c)))] = root(copy(g_.cell[k][0], inner_of_[k][c]));
    std::set<int> all, bounded;
    for (int x = 0; x < first.back(); ++x) all.insert(root(x));
    for (std::size_t k = 0; k < g_.pieces.size(); ++k)
      for (std::size_t c = 0; c < outer_of_[k].size(); ++c)
        if (outer_of_[k][c] < 0) bounded.insert(root(copy(g_.cell[k][0], static_cast<int>(c))));
    return static_cast<int>(all.size() - bounded.size());
  }

  const Graph& g_;
  const int B0_;
  const std::vector<int>& least_;
  std::vector<std::vector<std::vector<int>>> options_;
  std::vector<int> order_;
  std::vector<std::vector<int>> completes_;  // per level, the nodes whose pieces are then all chosen
  std::vector<std::vector<int>> inner_of_, outer_of_;  // chosen, per piece and copy
  std::vector<int> turns_;
  std::int64_t steps_ = 0;
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
  Search search(*graph, *hinge.B0, least);
  out.verdict = search.run(out.turns);
  out.steps = search.steps();
  return out;
}

}  // namespace overtet
