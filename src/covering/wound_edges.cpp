#include "src/covering/wound_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/covering/link.h"
#include "src/covering/shared_points.h"
#include "src/covering/tuning.h"

namespace overtet {

namespace {

// More than 12 members: what is known of the surface (six), and tables of it that each hinge uses (nine).
class Assigner {
 public:
  Assigner(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
           const std::vector<Hinge>& hinges, const std::vector<PiercedEdge>& pierced,
           const RunContext& context)
      : surface_(surface),
        topology_(topology),
        bvh_(bvh),
        hinges_(hinges),
        pierced_(pierced),
        context_(context) {
    if (std::any_of(hinges.begin(), hinges.end(), [](const Hinge& h) { return h.B0 && *h.B0 % 2 != 0; }))
      study_pierced();
  }

  Result<WoundEdges> run() {
    prepare();
    WoundEdges best;
    if (auto stop = find_odd_groups(best)) return *stop;
    find_crowded(best);
    if (auto stop = find_unfillable(best)) return *stop;
    if (best.forbidden()) {  // nothing to assign
      std::sort(best.unmet.begin(), best.unmet.end());
      best.unmet.erase(std::unique(best.unmet.begin(), best.unmet.end()), best.unmet.end());
      return best;
    }
    std::vector<int> extra(hinges_.size(), 0);
    // First with as many layers over every hinge as its winding allows, which asks for the fewest chains;
    // then with closed chains through a hinge allowed; then with one layer fewer over the unmet ones.
    bool first = true;
    for (int round = 0; round < 3 && (first || !best.complete()); ++round) {
      std::vector<Index> unmet;
      for (const double closed_cost : {kFarMore * kFarMore, 0.0}) {
        if (auto stop = context_.stop()) return *stop;
        Result<WoundEdges> got = attempt(extra, closed_cost);
        if (!got.ok()) return got;
        unmet = got.value().unmet;
        if (first || unmet.size() < best.unmet.size()) best = got.value();
        first = false;
        if (best.complete()) break;
      }
      bool changed = false;
      for (const Index v : unmet) {
        const int i = hinge_at_[v];
        const auto& h = hinges_[i];
        if (h.B0 && demand(i, extra) + 2 <= *h.B0) extra[i] += 2, changed = true;
      }
      if (!changed) break;
    }
    return best;
  }

 private:
  // Floods the covered edges from every odd hinge, through everything. Over all vertices of a flood the sums
  // of k count every edge twice, so they are even; and the sum at a vertex is B0 - 2 c. That must be known of
  // every vertex of the flood: where another vertex lies in the same place the two share the equation, so
  // such a flood proves nothing. (A point of another face or edge in the same place does no harm at an
  // ordinary vertex: what it adds is a multiple of two.)
  std::optional<Error> find_odd_groups(WoundEdges& out) {
    std::unordered_set<Index> seen;
    for (const Hinge& start : hinges_) {
      if (auto stop = context_.stop()) return stop;
      if (!start.B0 || *start.B0 % 2 == 0 || !seen.insert(start.vertex).second) continue;
      std::vector<Index> stack{start.vertex}, odd;
      bool sure = true;
      while (!stack.empty()) {
        const Index v = stack.back();
        stack.pop_back();
        if (const Index i = hinge_at_[v]; i >= 0) {
          sure = sure && hinges_[i].B0.has_value();
          if (hinges_[i].B0 && *hinges_[i].B0 % 2 != 0) odd.push_back(v);
        } else {
          sure = sure && !meets_vertex(v);
        }
        around(v, [&](Index h) {
          sure = sure && is_known(h);
          if (least(h) >= 1 && seen.insert(half_edge_target(surface_.F, h)).second)
            stack.push_back(half_edge_target(surface_.F, h));
        });
      }
      if (sure && odd.size() % 2 != 0) {
        std::sort(odd.begin(), odd.end());
        out.odd_groups.push_back(std::move(odd));
      }
    }
    if (out.odd_groups.empty()) return std::nullopt;
    // The smallest first: the easiest to understand and to check.
    std::stable_sort(out.odd_groups.begin(), out.odd_groups.end(),
                     [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (const auto& odd : out.odd_groups) out.unmet.insert(out.unmet.end(), odd.begin(), odd.end());
    return std::nullopt;
  }

  void find_crowded(WoundEdges& out) {
    for (const Hinge& hinge : hinges_) {
      if (!hinge.B0 || *hinge.B0 <= 0) continue;
      bool sure = true;
      std::vector<std::pair<int, int>> room;  // next to the hinge, all along
      around(hinge.vertex, [&](Index h) {
        sure = sure && is_known(h);
        if (sure) room.emplace_back(level_at(h, hinge.vertex), least(h));
      });
      if (!sure) continue;
      int most = *hinge.B0 / 2;
      for (const auto& [near, all_along] : room) most = std::min(most, near);
      bool fits = false;
      for (int c = 0; c <= std::max(0, most) && !fits; ++c) {
        int turns = 0;
        for (const auto& [near, all_along] : room) turns += std::max(0, std::min(near - c, all_along));
        fits = turns >= *hinge.B0 - 2 * c;
      }
      if (fits) continue;
      out.crowded.push_back(hinge.vertex);
      out.unmet.push_back(hinge.vertex);
    }
  }

  std::optional<Error> find_unfillable(WoundEdges& out) {
    std::int64_t steps = 0;
    std::vector<Index> unsure;
    for (const Hinge& hinge : hinges_) {
      if (auto stop = context_.stop()) return stop;
      if (std::binary_search(out.crowded.begin(), out.crowded.end(), hinge.vertex)) continue;
      bool sure = hinge.B0.has_value();
      std::vector<int> near, all_along;
      around(hinge.vertex, [&](Index h) {
        sure = sure && is_known(h);
        if (!sure) return;
        near.push_back(level_at(h, hinge.vertex));
        all_along.push_back(least(h));
      });
      if (!sure) unsure.push_back(hinge.vertex);
      if (!sure || steps > kMostGluingSteps) continue;
      const LinkAnswer answer = fill_link(surface_, topology_, hinge, near, all_along);
      steps += answer.steps;
      if (answer.verdict != LinkVerdict::unfillable) continue;
      out.unfillable.push_back(hinge.vertex);
      out.unmet.push_back(hinge.vertex);
    }
    if (out.forbidden()) return std::nullopt;
    auto shared = find_shared(surface_, topology_, bvh_, hinges_, pierced_, unsure, context_);
    if (!shared.ok()) return shared.error();
    for (const SharedPoint& p : shared.value()) {
      out.unfillable.insert(out.unfillable.end(), p.vertices.begin(), p.vertices.end());
      if (!out.shared) out.shared = p;
    }
    std::sort(out.unfillable.begin(), out.unfillable.end());
    out.unmet = out.unfillable;
    return std::nullopt;
  }

  // Whether another vertex lies where v does: its faces then pierce the edges of v.
  bool meets_vertex(Index v) const {
    bool found = false;
    around(v, [&](Index h) {
      if (found) return;
      for (const Index g : piercing_faces(pierced_, topology_, h))
        for (int k = 0; k < 3; ++k) {
          const Index u = surface_.F(g, k);
          found = found || (u != v && surface_.V.row(u) == surface_.V.row(v));
        }
    });
    return found;
  }

  struct Edge {
    bool known = true;        // false: a fold or an edge inside a face; counted as uncovered
    std::vector<int> levels;  // from the source of the smaller half-edge
    int least = 0;
  };

  Index edge_of(Index h) const { return std::min(h, topology_.twin[h]); }

  void prepare() {
    const Index n = static_cast<Index>(surface_.V.rows());
    hinge_at_.assign(n, -1);
    for (std::size_t i = 0; i < hinges_.size(); ++i) hinge_at_[hinges_[i].vertex] = static_cast<Index>(i);
    // Ordinary vertices joined by edges that nothing pierces have the same number of layers over them.
    patch_.reset(static_cast<std::size_t>(n));
    layers_.assign(n, {});
    region_of_.assign(n, -1);
    tree_.distance.assign(n, HUGE_VAL);
    tree_.from.assign(n, -1);
    is_pierced_.assign(surface_.F.rows() * 3, 0);
    for (const PiercedEdge& e : pierced_) is_pierced_[e.half_edge] = 1;
    double total = 0;
    Index count = 0;
    for (Index h = 0; h < 3 * static_cast<Index>(surface_.F.rows()); ++h) {
      if (h > topology_.twin[h]) continue;
      const Index a = half_edge_source(surface_.F, h), b = half_edge_target(surface_.F, h);
      total += (surface_.V.row(a) - surface_.V.row(b)).norm();
      ++count;
      if (hinge_at_[a] < 0 && hinge_at_[b] < 0 && !is_pierced_[h]) patch_.join(a, b);
    }
    mean_length_ = count > 0 && total > 0 ? total / count : 1;
  }

  // Layers over an ordinary vertex. None where no edge tells.
  std::optional<int> layers(Index v) {
    Layers& here = layers_[patch_.root(v)];
    if (here.looked_for) return here.number;
    here.looked_for = true;
    for (const Index h : half_edges_around(topology_, v)) {
      const auto levels = edge_levels(surface_, topology_, bvh_, h, piercing_faces(pierced_, topology_, h));
      if (!levels || levels->empty()) continue;
      here.number = levels->front();
      break;
    }
    return here.number;
  }

  Edge study(Index e, const std::vector<Index>& piercing) const {
    Edge out;
    const auto levels = edge_levels(surface_, topology_, bvh_, e, piercing);
    out.known = levels && !levels->empty();
    out.levels = out.known ? *levels : std::vector<int>{0};
    out.least = *std::min_element(out.levels.begin(), out.levels.end());
    return out;
  }

  const Edge& edge(Index h) {
    const Index e = edge_of(h);
    const auto known = edges_.find(e);
    if (known != edges_.end()) return known->second;
    return edges_.emplace(e, study(e, piercing_faces(pierced_, topology_, e))).first->second;
  }

  // Floods from odd hinges ask for nearly all of them: all at once, then.
  void study_pierced() {
    std::vector<Edge> found(pierced_.size());
    parallel_for(static_cast<std::int64_t>(pierced_.size()), kHeavyGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i)
                     found[i] = study(pierced_[i].half_edge, pierced_[i].faces);
                 });
    for (std::size_t i = 0; i < pierced_.size(); ++i)
      edges_.emplace(pierced_[i].half_edge, std::move(found[i]));
  }

  // Whether the levels of the edge are defined.
  bool is_known(Index h) {
    if (!simple(h)) return edge(h).known;
    const Index a = half_edge_source(surface_.F, h);
    return layers(hinge_at_[a] < 0 ? a : half_edge_target(surface_.F, h)).has_value();
  }
  // Edges that nothing pierces, with an ordinary end, are the bulk and need no entry of their own.
  bool simple(Index h) const {
    return !is_pierced_[edge_of(h)] &&
           (hinge_at_[half_edge_source(surface_.F, h)] < 0 || hinge_at_[half_edge_target(surface_.F, h)] < 0);
  }
  // Negative, as nothing fits there, where the levels are not defined.
  int least(Index h) {
    if (!simple(h)) return edge(h).least;
    const Index a = half_edge_source(surface_.F, h);
    return layers(hinge_at_[a] < 0 ? a : half_edge_target(surface_.F, h)).value_or(-1);
  }
  int level_at(Index h, Index v) {  // next to its end v
    if (simple(h)) return least(h);
    const Edge& x = edge(h);
    return half_edge_source(surface_.F, edge_of(h)) == v ? x.levels.front() : x.levels.back();
  }
  double cost(Index h) {
    const double length =
        (surface_.V.row(half_edge_source(surface_.F, h)) - surface_.V.row(half_edge_target(surface_.F, h)))
            .norm();
    return 1 + 1 / kFarMore * length / mean_length_ + (is_pierced_[edge_of(h)] ? kFarMore : 0);
  }

  // How many chains must end at a hinge.
  int demand(std::size_t i, const std::vector<int>& extra) const {
    const Hinge& h = hinges_[i];
    if (!h.B0 || *h.B0 <= 0) return 0;
    const int layers_over = std::clamp(h.covering, 0, *h.B0 / 2);
    return std::min(*h.B0 - 2 * layers_over + extra[i], *h.B0);
  }

  struct Usage {
    std::map<Index, int> edge;    // k so far
    std::map<Index, int> vertex;  // sum of k so far
    int of_edge(Index e) const {
      const auto at = edge.find(e);
      return at == edge.end() ? 0 : at->second;
    }
    int of_vertex(Index v) const {
      const auto at = vertex.find(v);
      return at == vertex.end() ? 0 : at->second;
    }
  };

  // Whether a chain may use half-edge h on its way, given what others use.
  bool legal(Index h, const Usage& usage) { return usage.of_edge(edge_of(h)) + 1 <= least(h); }
  // Whether a chain that ends at hinge v may leave through h: k_e <= m_e - c_v next to v.
  bool legal_end(Index h, Index v, int chains) {
    const Hinge& hinge = hinges_[hinge_at_[v]];
    const int over = (*hinge.B0 - chains) / 2;
    return level_at(h, v) >= 1 + over;
  }
  bool passable(Index v, const Usage& usage, const std::vector<int>& chains) {
    const int i = hinge_at_[v];
    if (i < 0) return usage.of_vertex(v) + 2 <= 2 * layers(v).value_or(0);
    return hinges_[i].B0 && chains[i] + 2 + std::max(0, usage.of_vertex(v) - chains[i]) <= *hinges_[i].B0;
  }

  // Of the last search; arrays over all vertices, cleaned where they were touched.
  struct Tree {
    std::vector<double> distance;
    std::vector<Index> from;  // half-edge by which a vertex is reached
    std::vector<Index> touched;
    void clear() {
      for (const Index v : touched) distance[v] = HUGE_VAL, from[v] = -1;
      touched.clear();
    }
  };

  // f(half-edge) for all that leave v.
  template <class F>
  void around(Index v, F&& f) const {
    const Index first = topology_.out[v];
    Index h = first;
    do {
      f(h);
      h = topology_.twin[previous_half_edge(h)];
    } while (h != first);
  }

  // Shortest legal chains from `start` (a hinge, or a vertex next to one), until all of `targets` are
  // reached. The result is valid until the next call.
  const Tree& dijkstra(Index start, const std::set<Index>& targets, const Usage& usage,
                       const std::vector<int>& chains) {
    Tree& tree = tree_;
    tree.clear();
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    std::size_t left = targets.size() - targets.count(start);
    tree.distance[start] = 0;
    tree.touched.push_back(start);
    queue.emplace(0, start);
    while (!queue.empty() && left > 0) {
      const double d = queue.top().first;
      const Index v = queue.top().second;
      queue.pop();
      if (d > tree.distance[v]) continue;
      const bool is_target = hinge_at_[v] >= 0 && targets.count(v);
      if (v != start && is_target) --left;
      if (v != start && !passable(v, usage, chains)) continue;
      around(v, [&](Index h) {
        const Index w = half_edge_target(surface_.F, h);
        if (w == start || !legal(h, usage)) return;
        const int hinge = hinge_at_[w];
        if (hinge >= 0) {
          const bool target = targets.count(w) > 0;
          if (!target && !passable(w, usage, chains)) return;
          if (target && !legal_end(h, w, chains[hinge])) return;
        }
        if (v == start && hinge_at_[v] >= 0 && !legal_end(h, v, chains[hinge_at_[v]])) return;
        const double next = d + cost(h);
        if (tree.distance[w] <= next) return;
        if (tree.distance[w] == HUGE_VAL) tree.touched.push_back(w);
        tree.distance[w] = next;
        tree.from[w] = h;
        queue.emplace(next, w);
      });
    }
    return tree;
  }

  static void chain(const TriangleMatrix& F, const Tree& tree, Index start, Index end,
                    std::vector<Index>& out) {
    for (Index v = end; v != start;) {
      const Index h = tree.from[v];
      out.push_back(h);
      v = half_edge_source(F, h);
    }
  }

  Result<WoundEdges> attempt(const std::vector<int>& extra, double closed_cost) {
    std::fill(region_of_.begin(), region_of_.end(), -1);
    region_targets_.clear();
    std::vector<int> chains(hinges_.size(), 0);
    std::vector<int> ends;  // hinge of every chain end
    std::set<Index> targets;
    for (std::size_t i = 0; i < hinges_.size(); ++i) {
      chains[i] = demand(i, extra);
      for (int k = 0; k < chains[i]; ++k) ends.push_back(static_cast<int>(i));
      if (chains[i] > 0) targets.insert(hinges_[i].vertex);
    }
    const int n = static_cast<int>(ends.size());
    std::vector<std::vector<double>> distance(n, std::vector<double>(n, HUGE_VAL));
    for (int i = 0; i < n; ++i) {
      if (auto stop = context_.stop()) return *stop;
      if (i > 0 && ends[i] == ends[i - 1]) {
        distance[i] = distance[i - 1];
        distance[i][i - 1] = closed_cost + closed_distance(hinges_[ends[i]].vertex, chains);
        continue;
      }
      const Tree& tree = dijkstra(hinges_[ends[i]].vertex, reachable(ends[i], targets, chains), {}, chains);
      for (int j = 0; j < n; ++j) {
        if (ends[j] != ends[i]) distance[i][j] = tree.distance[hinges_[ends[j]].vertex];
      }
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) distance[i][j] = distance[j][i] = std::min(distance[i][j], distance[j][i]);

    std::vector<int> partner(n, -1);
    for (const std::vector<int>& group : groups(distance)) match(distance, group, partner);

    // Route the pairs, cheapest first, each within what the others left.
    std::vector<std::pair<int, int>> routed;
    for (int i = 0; i < n; ++i)
      if (partner[i] > i) routed.emplace_back(i, partner[i]);
    std::stable_sort(routed.begin(), routed.end(), [&](const auto& a, const auto& b) {
      return distance[a.first][a.second] < distance[b.first][b.second];
    });
    Usage usage;
    std::vector<std::pair<int, int>> failed;
    for (int pass = 0; pass < 4; ++pass) {
      usage = {};
      failed.clear();
      for (const auto& pair : routed) {
        const Index a = hinges_[ends[pair.first]].vertex, b = hinges_[ends[pair.second]].vertex;
        const std::vector<Index> path = route(a, b, usage, chains);
        if (path.empty()) {
          failed.push_back(pair);
          continue;
        }
        for (const Index h : path) {
          ++usage.edge[edge_of(h)];
          ++usage.vertex[half_edge_source(surface_.F, h)];
          ++usage.vertex[half_edge_target(surface_.F, h)];
        }
      }
      if (failed.empty()) break;
      // Those that found no way go first the next time.
      std::stable_partition(routed.begin(), routed.end(), [&](const auto& pair) {
        return std::find(failed.begin(), failed.end(), pair) != failed.end();
      });
    }
    return collect(usage, distance, ends);
  }

  // The cheapest legal chain from hinge a to hinge b, or closed through a == b; empty when there is none.
  std::vector<Index> route(Index a, Index b, const Usage& usage, const std::vector<int>& chains) {
    std::vector<Index> path;
    if (a != b) {
      const Tree& tree = dijkstra(a, {b}, usage, chains);
      if (tree.from[b] >= 0) chain(surface_.F, tree, a, b, path);
      return path;
    }
    double best = HUGE_VAL;
    for (const Index h : half_edges_around(topology_, a)) {
      const Index u = half_edge_target(surface_.F, h);
      if (!legal(h, usage) || !legal_end(h, a, chains[hinge_at_[a]]) || !passable(u, usage, chains)) continue;
      Usage with = usage;
      with.edge[edge_of(h)] += least(h);  // not back the same way
      const Tree& tree = dijkstra(u, {a}, with, chains);
      if (tree.from[a] < 0 || tree.distance[a] + cost(h) >= best) continue;
      best = tree.distance[a] + cost(h);
      path.assign(1, h);
      chain(surface_.F, tree, u, a, path);
    }
    return path;
  }
  double closed_distance(Index a, const std::vector<int>& chains) {
    double sum = 0;
    const auto path = route(a, a, {}, chains);
    for (const Index h : path) sum += cost(h);
    return path.empty() ? HUGE_VAL : sum;
  }

  // Targets that a chain from hinge i could reach at all: found by flooding legal edges once per region.
  std::set<Index> reachable(int i, const std::set<Index>& targets, const std::vector<int>& chains) {
    std::set<Index> out;
    std::set<Index> regions;
    const Usage none;
    const auto look = [&](Index v) {
      for (const Index h : half_edges_around(topology_, v)) {
        if (!legal(h, none)) continue;
        const Index w = half_edge_target(surface_.F, h);
        if (hinge_at_[w] >= 0 && !passable(w, none, chains)) {
          if (targets.count(w)) out.insert(w);
          continue;
        }
        regions.insert(region(w, targets, chains));
      }
    };
    look(hinges_[i].vertex);
    for (const Index r : regions) out.insert(region_targets_[r].begin(), region_targets_[r].end());
    out.erase(hinges_[i].vertex);
    return out;
  }
  Index region(Index v, const std::set<Index>& targets, const std::vector<int>& chains) {
    if (region_of_[v] >= 0) return region_of_[v];
    const Index r = static_cast<Index>(region_targets_.size());
    region_targets_.emplace_back();
    const Usage none;
    std::vector<Index> stack{v};
    region_of_[v] = r;
    while (!stack.empty()) {
      const Index u = stack.back();
      stack.pop_back();
      if (targets.count(u)) region_targets_[r].insert(u);
      around(u, [&](Index h) {
        if (!legal(h, none)) return;
        const Index w = half_edge_target(surface_.F, h);
        if (hinge_at_[w] >= 0) {
          if (targets.count(w)) region_targets_[r].insert(w);
          if (!passable(w, none, chains)) return;
        }
        if (region_of_[w] < 0) region_of_[w] = r, stack.push_back(w);
      });
    }
    return r;
  }

  static std::vector<std::vector<int>> groups(const std::vector<std::vector<double>>& distance) {
    const int n = static_cast<int>(distance.size());
    std::vector<int> seen(n, 0);
    std::vector<std::vector<int>> out;
    for (int s = 0; s < n; ++s) {
      if (seen[s]) continue;
      std::vector<int> group{s};
      seen[s] = 1;
      for (std::size_t i = 0; i < group.size(); ++i)
        for (int j = 0; j < n; ++j)
          if (!seen[j] && distance[group[i]][j] < HUGE_VAL) seen[j] = 1, group.push_back(j);
      std::sort(group.begin(), group.end());
      out.push_back(std::move(group));
    }
    return out;
  }

  // A pairing of as many ends as possible at minimum total cost.
  static void match(const std::vector<std::vector<double>>& distance, const std::vector<int>& group,
                    std::vector<int>& partner) {
    const int n = static_cast<int>(group.size());
    constexpr double alone = 1e9;  // an end without a partner: worse than any chain
    const auto between = [&](int i, int j) { return std::min(distance[group[i]][group[j]], 2 * alone); };
    if (n <= kExactEnds) {
      std::vector<double> best(std::size_t{1} << n, 0);
      std::vector<int> choice(best.size(), -1);  // partner of the lowest member
      for (std::size_t set = 1; set < best.size(); ++set) {
        const int i = __builtin_ctzll(set);
        best[set] = alone + best[set & (set - 1)];
        choice[set] = i;
        for (int j = i + 1; j < n; ++j) {
          if (!(set >> j & 1)) continue;
          const double value = between(i, j) + best[set & ~(std::size_t{1} << i) & ~(std::size_t{1} << j)];
          if (value < best[set]) best[set] = value, choice[set] = j;
        }
      }
      for (std::size_t set = best.size() - 1; set != 0;) {
        const int i = __builtin_ctzll(set), j = choice[set];
        if (j != i) partner[group[i]] = group[j], partner[group[j]] = group[i];
        set &= ~(std::size_t{1} << i) & ~(std::size_t{1} << j);
      }
      return;
    }
    // Cheapest first, then exchanges of two pairs (or a pair and a single) until none helps.
    std::vector<int> mate(n, -1);
    std::vector<std::pair<double, std::pair<int, int>>> all;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) all.push_back({between(i, j), {i, j}});
    std::sort(all.begin(), all.end());
    for (const auto& [d, ij] : all)
      if (d < alone && mate[ij.first] < 0 && mate[ij.second] < 0)
        mate[ij.first] = ij.second, mate[ij.second] = ij.first;
    const auto pair_cost = [&](int i, int j) {
      return i < 0 || j < 0 ? (i < 0 && j < 0 ? 0 : alone) : between(i, j);
    };
    const auto join = [&](int i, int j) {
      if (i >= 0) mate[i] = j;
      if (j >= 0) mate[j] = i;
    };
    for (bool better = true; better;) {
      better = false;
      for (int a = 0; a < n; ++a)
        for (int c = a + 1; c < n; ++c) {
          const int b = mate[a], d = mate[c];
          if (b == c) continue;
          const double now = pair_cost(a, b) + pair_cost(c, d);
          if (pair_cost(a, c) + pair_cost(b, d) < now - 1e-9) {
            join(a, c);
            join(b, d);
            better = true;
          } else if (b >= 0 && d >= 0 && pair_cost(a, d) + pair_cost(c, b) < now - 1e-9) {
            join(a, d);
            join(c, b);
            better = true;
          }
        }
    }
    for (int i = 0; i < n; ++i)
      if (mate[i] >= 0) partner[group[i]] = group[mate[i]];
  }

  // The edges, and every equation once more.
  WoundEdges collect(const Usage& usage, const std::vector<std::vector<double>>& distance,
                     const std::vector<int>& ends) {
    WoundEdges out;
    for (const auto& [e, k] : usage.edge) {
      const Index a = half_edge_source(surface_.F, e), b = half_edge_target(surface_.F, e);
      out.edges.push_back({std::min(a, b), std::max(a, b), k, is_pierced_[e] != 0});
    }
    std::sort(out.edges.begin(), out.edges.end(),
              [](const WoundEdge& x, const WoundEdge& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    for (const Hinge& h : hinges_) {
      const int sum = usage.of_vertex(h.vertex);
      bool met = h.B0 && *h.B0 >= 0 && sum <= *h.B0 && (*h.B0 - sum) % 2 == 0 &&
                 (*h.B0 - sum) / 2 <= std::max(0, h.covering);
      if (met) {
        const int over = (*h.B0 - sum) / 2;
        for (const Index x : half_edges_around(topology_, h.vertex)) {
          const int k = usage.of_edge(edge_of(x));
          if (k > 0 && k > level_at(x, h.vertex) - over) met = false;
        }
      }
      if (!met) out.unmet.push_back(h.vertex);
    }
    std::sort(out.unmet.begin(), out.unmet.end());
    if (out.unmet.empty()) return out;
    const Index v = out.unmet.front();
    const Hinge& hinge = hinges_[hinge_at_[v]];
    std::string why;
    if (!hinge.B0) {
      why = "B0 is not defined there (the surface is folded flat, or another part of it touches the vertex)";
    } else if (*hinge.B0 < 0) {
      why = "B0 = " + std::to_string(*hinge.B0) + " is negative, which positive tets cannot make";
    } else {
      bool connected = false;
      for (std::size_t i = 0; i < ends.size(); ++i)
        if (hinges_[ends[i]].vertex == v)
          for (const double d : distance[i]) connected = connected || d < HUGE_VAL;
      why = connected ? "too few chains of covered edges can end there, or they need the same edges"
                      : "no chain of covered edges leads from it to another hinge";
    }
    out.explanation = "No edges were found for the extra turns of " + std::to_string(out.unmet.size()) +
                      " of " + std::to_string(hinges_.size()) + " hinges; vertex " + std::to_string(v) +
                      ": " + why + ".";
    return out;
  }

  const Surface& surface_;
  const SurfaceTopology& topology_;
  const TriangleBvh& bvh_;
  const std::vector<Hinge>& hinges_;
  const std::vector<PiercedEdge>& pierced_;
  const RunContext& context_;
  std::vector<Index> hinge_at_;
  UnionFind patch_;
  struct Layers {
    bool looked_for = false;
    std::optional<int> number;
  };
  std::vector<Layers> layers_;  // by root
  std::unordered_map<Index, Edge> edges_;
  std::vector<char> is_pierced_;  // by smaller half-edge
  std::vector<Index> region_of_;
  Tree tree_;
  std::vector<std::set<Index>> region_targets_;
  double mean_length_ = 1;
};

}  // namespace

Result<WoundEdges> assign_wound_edges(const Surface& surface, const SurfaceTopology& topology,
                                      const TriangleBvh& bvh, const std::vector<Hinge>& hinges,
                                      const std::vector<PiercedEdge>& pierced, const RunContext& context) {
  return Assigner(surface, topology, bvh, hinges, pierced, context).run();
}

}  // namespace overtet
