#include "src/cleanup/raw_edges.h"

#include <algorithm>
#include <compare>
#include <numeric>

#include "kernels/core/point_table.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/topology.h"

namespace overtet {

bool runs_up(const TriangleMatrix& F, const std::vector<Index>& place, Index h) {
  return place[half_edge_source(F, h)] < place[half_edge_target(F, h)];
}

namespace {

void pair_up(RawEdges& e, Index begin) {
  e.partner[e.list[begin]] = e.list[begin + 1];
  e.partner[e.list[begin + 1]] = e.list[begin];
}

// Sorted by the smaller vertex; half-edges of one edge then are in one short list.
void group_by_vertices(Index vertices, const TriangleMatrix& F, RawEdges& e) {
  const Index half_edges = 3 * static_cast<Index>(F.rows());
  const auto low = [&](Index h) { return std::min(half_edge_source(F, h), half_edge_target(F, h)); };
  const auto high = [&](Index h) { return std::max(half_edge_source(F, h), half_edge_target(F, h)); };
  std::vector<Index> begin(static_cast<std::size_t>(vertices) + 1, 0);
  for (Index h = 0; h < half_edges; ++h) ++begin[low(h) + 1];
  for (Index v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  std::vector<Index> at(begin.begin(), begin.end() - 1);
  e.list.resize(half_edges);
  for (Index h = 0; h < half_edges; ++h) e.list[at[low(h)]++] = h;
  e.partner.assign(half_edges, -1);
  e.others = parallel_collect<EdgeGroup>(
      vertices, kLightGrain, [&](std::int64_t from, std::int64_t to, std::vector<EdgeGroup>& out) {
        for (std::int64_t v = from; v < to; ++v) {
          std::sort(e.list.begin() + begin[v], e.list.begin() + begin[v + 1],
                    [&](Index x, Index y) { return high(x) != high(y) ? high(x) < high(y) : x < y; });
          for (Index i = begin[v], j = i; i < begin[v + 1]; i = j) {
            for (j = i + 1; j < begin[v + 1] && high(e.list[j]) == high(e.list[i]);) ++j;
            if (j - i == 2)
              pair_up(e, i);
            else
              out.push_back({i, j - i});
          }
        }
      });
}

// Vertices of odd edges that are in one place get one number.
void find_places(const VertexMatrix& V, const TriangleMatrix& F, RawEdges& e) {
  std::vector<char> open(V.rows(), 0);
  Index odd = 0;
  for (const EdgeGroup& g : e.others) {
    if (g.count % 2 == 0) continue;
    open[half_edge_source(F, e.list[g.begin])] = open[half_edge_target(F, e.list[g.begin])] = 1;
    ++odd;
  }
  PointTable table(static_cast<std::size_t>(odd) / 2);
  std::vector<Index> first;  // vertex of each point
  for (Index v = 0; v < V.rows(); ++v) {
    if (!open[v]) continue;
    const auto point = static_cast<std::size_t>(table.number_of(V.data() + 3 * std::int64_t{v}));
    if (point == first.size()) first.push_back(v);
    e.place[v] = first[point];
    e.merges = e.merges || first[point] != v;
  }
}

// Whether the faces of two half-edges in one place are one face twice.
bool are_copies(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& e, Index g, Index h) {
  return runs_up(F, e.place, g) == runs_up(F, e.place, h) &&
         V.row(half_edge_opposite(F, g)) == V.row(half_edge_opposite(F, h));
}

// Puts odd edges together whose ends are in the same places; but not the borders of a sheet and its copy.
void join_odd_edges(const VertexMatrix& V, const TriangleMatrix& F, RawEdges& e) {
  struct Odd {
    Index low, high, half_edge;
    auto operator<=>(const Odd&) const = default;
  };
  std::vector<Odd> odd;
  std::vector<EdgeGroup> even;
  for (const EdgeGroup& g : e.others) {
    if (g.count % 2 == 0) {
      even.push_back(g);
      continue;
    }
    for (Index i = g.begin; i < g.begin + g.count; ++i) {
      const Index h = e.list[i], a = e.place[half_edge_source(F, h)], b = e.place[half_edge_target(F, h)];
      odd.push_back({std::min(a, b), std::max(a, b), h});
    }
  }
  parallel_sort_groups(odd, static_cast<std::int64_t>(e.place.size()), [](const Odd& o) { return o.low; });
  e.others = std::move(even);
  const Index end = static_cast<Index>(odd.size());
  for (Index i = 0, j = 0; i < end; i = j) {
    for (j = i; j < end && odd[j].low == odd[i].low && odd[j].high == odd[i].high; ++j)
      e.list.push_back(odd[j].half_edge);
    const EdgeGroup g{static_cast<Index>(e.list.size()) - (j - i), j - i};
    if (g.count != 2) {
      e.others.push_back(g);
    } else if (!are_copies(V, F, e, e.list[g.begin], e.list[g.begin + 1])) {
      pair_up(e, g.begin);
    } else {
      e.others.push_back({g.begin, 1});
      e.others.push_back({g.begin + 1, 1});
    }
  }
}

}  // namespace

RawEdges find_edges(const VertexMatrix& V, const TriangleMatrix& F) {
  RawEdges e;
  group_by_vertices(static_cast<Index>(V.rows()), F, e);
  e.place.resize(V.rows());
  std::iota(e.place.begin(), e.place.end(), 0);
  if (std::none_of(e.others.begin(), e.others.end(), [](const EdgeGroup& g) { return g.count % 2 == 1; }))
    return e;
  find_places(V, F, e);
  if (e.merges) join_odd_edges(V, F, e);
  return e;
}

}  // namespace overtet
