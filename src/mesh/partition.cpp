#include "src/mesh/partition.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "kernels/core/union_find.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

// A tet's box, for cuts across the axes.
struct TetBox {
  float low[3], high[3];
  Index tet;
  int weight;
};

// For one axis: weights by the places of the tets' ends and middles.
struct Places {
  std::array<std::int64_t, kPlaces> low{}, high{}, middle{};
  void add(const Places& other) {
    for (int i = 0; i < kPlaces; ++i) {
      low[i] += other.low[i];
      high[i] += other.high[i];
      middle[i] += other.middle[i];
    }
  }
};

// Places along an axis.
struct Ruler {
  float begin = 0, scale = 0;
  int place(float x) const { return std::clamp(static_cast<int>((x - begin) * scale), 0, kPlaces - 1); }
  int middle(const TetBox& b, int axis) const { return place((b.low[axis] + b.high[axis]) / 2); }
};

// The part's tets around a shared edge, for the comparison with its ring.
struct EdgeAt {
  Index a, b, tet;
};

// Along a curve that fills space (Morton's), in the box of all.
void sort_by_place(const TetMesh& mesh, std::vector<Index>& tets) {
  constexpr int kBits = 10;
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(HUGE_VAL), high = -low;
  for (const Index t : tets) {
    low = low.cwiseMin(mesh.V.row(mesh.T(t, 0)));
    high = high.cwiseMax(mesh.V.row(mesh.T(t, 0)));
  }
  const double size = (high - low).maxCoeff();
  const double scale = size > 0 ? ((1 << kBits) - 1) / size : 0;
  std::vector<std::pair<std::uint32_t, Index>> keys;
  keys.reserve(tets.size());
  for (const Index t : tets) {
    const Eigen::RowVector3d at = (mesh.V.row(mesh.T(t, 0)) - low) * scale;
    std::uint32_t key = 0;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<std::uint32_t>(at[k]);
      for (int bit = 0; bit < kBits; ++bit) key |= (x >> bit & 1) << (3 * bit + k);
    }
    keys.emplace_back(key, t);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < tets.size(); ++i) tets[i] = keys[i].second;
}

void find_pinched(MeshPart& part, const std::vector<char>& shared) {
  const TetComplex& c = part.complex;
  std::vector<Index> around(c.vertex_count(), 0);
  std::vector<EdgeAt> edges;
  for (Index t = 0; t < c.tet_capacity(); ++t) {
    const auto& v = c.tet(t);
    for (int i = 0; i < 4; ++i) {
      if (!shared[v[i]]) continue;
      ++around[v[i]];
      for (int j = 0; j < i; ++j)
        if (shared[v[j]]) edges.push_back({std::min(v[i], v[j]), std::max(v[i], v[j]), t});
    }
  }
  std::vector<char> pinched(c.vertex_count(), 0);
  std::vector<Index> tets, link;
  for (const Index v : part.shared) {
    c.star(v, tets);
    if (static_cast<Index>(tets.size()) != around[v]) pinched[v] = 1;
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeAt& x, const EdgeAt& y) {
    return std::tie(x.a, x.b, x.tet) < std::tie(y.a, y.b, y.tet);
  });
  for (std::size_t i = 0, j; i < edges.size(); i = j) {
    for (j = i; j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b;) ++j;
    c.ring(edges[i].tet, edges[i].a, edges[i].b, tets, link);
    if (tets.size() != j - i) pinched[edges[i].a] = pinched[edges[i].b] = 1;
  }
  for (const Index v : part.shared)
    if (pinched[v]) part.pinched.push_back(v);
}

void count_copied(std::int64_t vertices, std::int64_t tets) {
  count(Count::copied_bytes,
        vertices * std::int64_t{3 * sizeof(double)} + tets * std::int64_t{4 * sizeof(Index)});
}

// corners(t): of each of the tets; position(v); is_shared(v, n): v has tets elsewhere, and n of these.
// Vertices are numbered in the order of first use: what is near lies near in memory.
template <class Corners, class Position, class IsShared>
MeshPart make_part(std::span<const Index> tets, Index vertices, Corners&& corners, Position&& position,
                   IsShared&& is_shared) {
  static thread_local std::vector<Index> local;
  local.resize(std::max<std::size_t>(local.size(), vertices), -1);
  MeshPart part;
  std::vector<Index>& vertex = part.vertex;
  std::vector<Index> times;
  TetMatrix T(static_cast<Eigen::Index>(tets.size()), 4);
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const TetComplex::Tet c = corners(tets[i]);
    for (int k = 0; k < 4; ++k) {
      Index& v = local[c[k]];
      if (v < 0) {
        v = static_cast<Index>(vertex.size());
        vertex.push_back(c[k]);
        times.push_back(0);
      }
      ++times[v];
      T(static_cast<Eigen::Index>(i), k) = v;
    }
  }
  VertexMatrix V(static_cast<Eigen::Index>(vertex.size()), 3);
  std::vector<char> shared(vertex.size(), 0);
  for (std::size_t i = 0; i < vertex.size(); ++i) {
    local[vertex[i]] = -1;
    V.row(static_cast<Eigen::Index>(i)) = position(vertex[i]);
    if (!is_shared(vertex[i], times[i])) continue;
    shared[i] = 1;
    part.shared.push_back(static_cast<Index>(i));
  }
  count_copied(V.rows(), T.rows());
  part.complex = TetComplex(V, T);
  find_pinched(part, shared);
  return part;
}

// The tets of each part, ascending.
std::vector<std::vector<Index>> tets_of_parts(std::span<const int> part_of, int parts) {
  const auto tets = static_cast<std::int64_t>(part_of.size());
  constexpr std::int64_t block = 16 * kLightGrain;
  // Of each block, how many tets each part has in it; then, where its first one goes.
  std::vector<std::vector<std::int64_t>> at(static_cast<std::size_t>((tets + block - 1) / block));
  parallel_for(tets, block, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::int64_t>& count = at[begin / block];
    count.assign(parts, 0);
    for (std::int64_t t = begin; t < end; ++t)
      if (part_of[t] >= 0) ++count[part_of[t]];
  });
  std::vector<std::vector<Index>> out(parts);
  parallel_for(parts, 1, [&](std::int64_t p, std::int64_t) {
    std::int64_t sum = 0;
    for (auto& count : at) sum += std::exchange(count[p], sum);
    out[p].resize(static_cast<std::size_t>(sum));
  });
  parallel_for(tets, block, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::int64_t>& next = at[begin / block];
    for (std::int64_t t = begin; t < end; ++t)
      if (part_of[t] >= 0) out[part_of[t]][next[part_of[t]]++] = static_cast<Index>(t);
  });
  return out;
}

// Of each vertex, whether it has tets of several parts; those in no part are one, too.
std::vector<char> in_several(const TetMesh& mesh, std::span<const int> part_of) {
  std::vector<char> several(static_cast<std::size_t>(mesh.V.rows()), 0);
  std::vector<int> one(several.size(), -1);  // the part of some tet; which one does not matter
  const auto for_each_corner = [&](auto&& visit) {
    parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        for (int k = 0; k < 4; ++k) visit(mesh.T(t, k), part_of[t]);
    });
  };
  for_each_corner([&](Index v, int part) { std::atomic_ref(one[v]).store(part, std::memory_order_relaxed); });
  for_each_corner([&](Index v, int part) {
    if (one[v] != part) std::atomic_ref(several[v]).store(1, std::memory_order_relaxed);
  });
  return several;
}

// The boxes of the chosen tets.
std::vector<TetBox> boxes_of(const TetMesh& mesh, std::span<const Index> chosen,
                             std::span<const int> weight) {
  std::vector<TetBox> boxes(chosen.size());
  parallel_for(static_cast<std::int64_t>(chosen.size()), kLightGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   TetBox& b = boxes[i];
                   b.tet = chosen[i];
                   b.weight = weight.empty() ? 1 : weight[i];
                   for (int k = 0; k < 3; ++k) {
                     b.low[k] = b.high[k] = static_cast<float>(mesh.V(mesh.T(chosen[i], 0), k));
                     for (int j = 1; j < 4; ++j) {
                       const auto x = static_cast<float>(mesh.V(mesh.T(chosen[i], j), k));
                       b.low[k] = std::min(b.low[k], x);
                       b.high[k] = std::max(b.high[k], x);
                     }
                   }
                 }
               });
  return boxes;
}

struct Extent {
  std::array<float, 3> low, high;
};

Extent extent_of(std::span<const TetBox> boxes) {
  Extent none;
  none.low.fill(HUGE_VALF), none.high.fill(-HUGE_VALF);
  return parallel_reduce(
      static_cast<std::int64_t>(boxes.size()), kLightGrain, none,
      [&](std::int64_t begin, std::int64_t end) {
        Extent e = none;
        for (std::int64_t i = begin; i < end; ++i)
          for (int k = 0; k < 3; ++k) {
            e.low[k] = std::min(e.low[k], boxes[i].low[k]);
            e.high[k] = std::max(e.high[k], boxes[i].high[k]);
          }
        return e;
      },
      [](Extent x, const Extent& y) {
        for (int k = 0; k < 3; ++k) {
          x.low[k] = std::min(x.low[k], y.low[k]);
          x.high[k] = std::max(x.high[k], y.high[k]);
        }
        return x;
      });
}

using Rulers = std::array<Ruler, 3>;
using AllPlaces = std::array<Places, 3>;

AllPlaces places_of(std::span<const TetBox> boxes, const Rulers& rulers) {
  return parallel_reduce(
      static_cast<std::int64_t>(boxes.size()), 4 * kLightGrain, AllPlaces{},
      [&](std::int64_t begin, std::int64_t end) {
        AllPlaces p{};
        for (std::int64_t i = begin; i < end; ++i)
          for (int k = 0; k < 3; ++k) {
            const TetBox& b = boxes[i];
            p[k].low[rulers[k].place(b.low[k])] += b.weight;
            p[k].high[rulers[k].place(b.high[k])] += b.weight;
            p[k].middle[rulers[k].middle(b, k)] += b.weight;
          }
        return p;
      },
      [](AllPlaces x, const AllPlaces& y) {
        for (int k = 0; k < 3; ++k) x[k].add(y[k]);
        return x;
      });
}

struct Cut {
  int axis, place;
};

// Where a plane meets least, with at most `most_off` more or less than `wanted` before it.
std::optional<Cut> best_cut(const AllPlaces& places, double wanted, double most_off) {
  std::optional<Cut> best;
  double least_met = HUGE_VAL, least_off = HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    std::int64_t begun = 0, ended = 0, before = 0;
    for (int p = 1; p < kPlaces; ++p) {
      begun += places[k].low[p - 1];
      ended += places[k].high[p - 1];
      before += places[k].middle[p - 1];
      const auto met = static_cast<double>(begun - ended);
      const double off = std::abs(static_cast<double>(before) - wanted);
      if (off > most_off || !(met < least_met || (met == least_met && off < least_off))) continue;
      best = Cut{k, p};
      least_met = met, least_off = off;
    }
  }
  return best;
}

// Sorts along the longest side; returns how many first ones have the wanted weight.
std::size_t cut_exactly(std::span<TetBox> boxes, const Extent& extent, double wanted) {
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (extent.high[k] - extent.low[k] > extent.high[axis] - extent.low[axis]) axis = k;
  std::sort(boxes.begin(), boxes.end(), [axis](const TetBox& x, const TetBox& y) {
    const float p = x.low[axis] + x.high[axis], q = y.low[axis] + y.high[axis];
    return p != q ? p < q : x.tet < y.tet;
  });
  std::size_t middle = 0;
  for (double before = 0; middle < boxes.size() && before + boxes[middle].weight <= wanted; ++middle)
    before += boxes[middle].weight;
  return middle;
}

}  // namespace

void MeshPart::mark_shared(LocalOperations& work) const {
  for (const Index v : shared) work.share(v, LocalOperations::Sharing::plain);
  for (const Index v : pinched) work.share(v, LocalOperations::Sharing::pinched);
}

std::vector<int> cut_apart(const TetMesh& mesh, std::span<const Index> chosen, int parts, double slack,
                           std::span<const int> weight) {
  std::vector<int> part_of(static_cast<std::size_t>(mesh.T.rows()), -1);
  std::vector<TetBox> boxes = boxes_of(mesh, chosen, weight);
  const auto cut = [&](const auto& self, std::span<TetBox> here, int first, int count) -> void {
    if (count == 1 || here.empty()) {
      for (const TetBox& b : here) part_of[b.tet] = first;
      return;
    }
    const Extent extent = extent_of(here);
    Rulers rulers;
    for (int k = 0; k < 3; ++k)
      rulers[k] = {extent.low[k],
                   extent.high[k] > extent.low[k] ? kPlaces / (extent.high[k] - extent.low[k]) : 0};
    const AllPlaces places = places_of(here, rulers);
    const int left = count / 2;
    const auto all =
        static_cast<double>(std::accumulate(places[0].low.begin(), places[0].low.end(), std::int64_t{0}));
    const double wanted = all * left / count;
    std::size_t middle;
    if (const std::optional<Cut> best = best_cut(places, wanted, slack * all)) {
      const Ruler ruler = rulers[best->axis];
      middle = static_cast<std::size_t>(
          std::partition(here.begin(), here.end(),
                         [&](const TetBox& b) { return ruler.middle(b, best->axis) < best->place; }) -
          here.begin());
    } else {
      middle = cut_exactly(here, extent, wanted);  // few tets, or large ones
    }
    parallel_invoke([&] { self(self, here.subspan(0, middle), first, left); },
                    [&] { self(self, here.subspan(middle), first + left, count - left); });
  };
  cut(cut, boxes, 0, parts);
  return part_of;
}

std::vector<int> connected_pieces(const TetMesh& mesh, std::span<const char> chosen, int& count) {
  UnionFind joined(static_cast<std::size_t>(mesh.V.rows()));
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 1; chosen[t] && k < 4; ++k) joined.join(mesh.T(t, k), mesh.T(t, 0));
  std::vector<int> piece_at(joined.size(), -1);  // by root
  std::vector<int> piece_of(static_cast<std::size_t>(mesh.T.rows()), -1);
  count = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    if (!chosen[t]) continue;
    int& p = piece_at[joined.root(mesh.T(t, 0))];
    if (p < 0) p = count++;
    piece_of[t] = p;
  }
  return piece_of;
}

Pieces in_pieces(const TetMesh& mesh, std::span<const Index> chosen, int parts, std::span<const int> weight) {
  std::vector<char> is_chosen(static_cast<std::size_t>(mesh.T.rows()), 0);
  for (const Index t : chosen) is_chosen[t] = 1;
  int count = 0;
  const std::vector<int> piece_of = connected_pieces(mesh, is_chosen, count);
  struct Piece {
    std::int64_t weight = 0;
    int number = 0;
  };
  std::vector<Piece> pieces(count);
  for (int p = 0; p < count; ++p) pieces[p].number = p;
  std::int64_t all = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    pieces[piece_of[chosen[i]]].weight += weight[i];
    all += weight[i];
  }
  // The heaviest first, each to the part that has least.
  std::vector<Piece> sorted = pieces;
  std::sort(sorted.begin(), sorted.end(), [](const Piece& x, const Piece& y) {
    return x.weight != y.weight ? x.weight > y.weight : x.number < y.number;
  });
  std::vector<std::int64_t> load(parts, 0);
  std::vector<int> part_of_piece(pieces.size());
  for (const Piece& piece : sorted) {
    const auto least = std::min_element(load.begin(), load.end());
    part_of_piece[piece.number] = static_cast<int>(least - load.begin());
    *least += piece.weight;
  }
  Pieces result;
  result.part_of.assign(static_cast<std::size_t>(mesh.T.rows()), -1);
  for (std::size_t i = 0; i < chosen.size(); ++i)
    result.part_of[chosen[i]] = part_of_piece[piece_of[chosen[i]]];
  if (all > 0)
    result.uneven =
        static_cast<double>(*std::max_element(load.begin(), load.end())) * parts / static_cast<double>(all);
  return result;
}

std::vector<MeshPart> take_parts(const TetMesh& mesh, std::span<const int> part_of, int parts) {
  count(Count::touched_tets, 3 * mesh.T.rows());
  std::vector<std::vector<Index>> tets;
  std::vector<char> shared;
  parallel_invoke([&] { tets = tets_of_parts(part_of, parts); }, [&] { shared = in_several(mesh, part_of); });
  std::vector<MeshPart> result(parts);
  parallel_for(parts, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      sort_by_place(mesh, tets[p]);
      result[p] = make_part(
          tets[p], static_cast<Index>(mesh.V.rows()),
          [&](Index t) {
            return TetComplex::Tet{mesh.T(t, 0), mesh.T(t, 1), mesh.T(t, 2), mesh.T(t, 3)};
          },
          [&](Index v) { return Eigen::Vector3d(mesh.V.row(v)); },
          [&](Index v, Index) { return shared[v] != 0; });
    }
  });
  return result;
}

MeshPart take_part(const TetComplex& mesh, std::span<const Index> tets) {
  std::vector<Index> star;
  return make_part(
      tets, mesh.vertex_count(), [&](Index t) { return mesh.tet(t); },
      [&](Index v) { return mesh.position(v); },
      [&](Index v, Index times) {
        mesh.star(v, star);
        return static_cast<Index>(star.size()) != times;
      });
}

void put_part(TetComplex& mesh, std::span<const Index> tets, const MeshPart& part,
              std::vector<Index>& created) {
  const TetComplex& c = part.complex;
  const Index own = static_cast<Index>(part.vertex.size());
  std::vector<Index> number(c.vertex_count(), -1);
  for (Index v = 0; v < c.vertex_count(); ++v) {
    if (c.tet_of(v) < 0) continue;
    number[v] = v < own ? part.vertex[v] : mesh.add_vertex(c.position(v));
    if (v < own) mesh.move(number[v], c.position(v));
  }
  std::vector<TetComplex::Tet> added;
  added.reserve(c.tet_count());
  for (Index t = 0; t < c.tet_capacity(); ++t) {
    if (!c.alive(t)) continue;
    TetComplex::Tet corners = c.tet(t);
    for (Index& v : corners) v = number[v];
    added.push_back(corners);
  }
  mesh.replace(tets, added, created);
}

std::vector<Index> put_parts(TetMesh& mesh, std::span<const int> part_of,
                             const std::vector<MeshPart>& parts) {
  const Index old_vertices = static_cast<Index>(mesh.V.rows());
  std::vector<char> used(old_vertices, 0);  // vertices on cuts are marked from both sides
  const auto use = [&](Index v) { std::atomic_ref(used[v]).store(1, std::memory_order_relaxed); };
  std::fill(used.begin(), used.begin() + mesh.surface_vertices, 1);
  const std::vector<Index> kept = parallel_collect<Index>(
      mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end, std::vector<Index>& list) {
        for (Index t = static_cast<Index>(begin); t < end; ++t)
          if (part_of[t] < 0) list.push_back(t);
      });
  const auto count = static_cast<std::int64_t>(parts.size()), others = static_cast<std::int64_t>(kept.size());
  parallel_for(others, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      for (int k = 0; k < 4; ++k) use(mesh.T(kept[i], k));
  });
  std::vector<std::vector<Index>> number(parts.size());  // of the complexes' vertices in the result
  std::vector<Index> new_vertices(parts.size(), 0);
  parallel_for(count, 1, [&](std::int64_t p, std::int64_t) {
    const TetComplex& c = parts[p].complex;
    number[p].assign(c.vertex_count(), -1);
    for (Index v = 0; v < c.vertex_count(); ++v) {
      if (c.tet_of(v) < 0) continue;
      number[p][v] = 0;
      if (v < static_cast<Index>(parts[p].vertex.size()))
        use(parts[p].vertex[v]);
      else
        ++new_vertices[p];
    }
  });
  std::vector<Index> moved(old_vertices, -1);
  Index vertices = 0;
  for (Index v = 0; v < old_vertices; ++v)
    if (used[v]) moved[v] = vertices++;
  std::vector<std::int64_t> first_row, first_vertex;
  std::int64_t tets = others;
  for (std::int64_t p = 0; p < count; ++p) {
    first_vertex.push_back(vertices);
    first_row.push_back(tets);
    vertices += new_vertices[p];
    tets += parts[p].complex.tet_count();
  }
  count_copied(vertices, tets);
  VertexMatrix V(vertices, 3);
  TetMatrix T(tets, 4);
  parallel_for(old_vertices, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      if (moved[v] >= 0) V.row(moved[v]) = mesh.V.row(v);
  });
  parallel_for(others, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      for (int k = 0; k < 4; ++k) T(i, k) = moved[mesh.T(kept[i], k)];
  });
  parallel_for(count, 1, [&](std::int64_t p, std::int64_t) {
    const MeshPart& part = parts[p];
    const TetComplex& c = part.complex;
    const Index own = static_cast<Index>(part.vertex.size());
    std::vector<char> shared(c.vertex_count(), 0);  // several parts have them: below
    for (const Index v : part.shared) shared[v] = 1;
    auto next = static_cast<Index>(first_vertex[p]);
    for (Index v = 0; v < c.vertex_count(); ++v) {
      Index& to = number[p][v];
      if (to < 0) continue;
      to = v < own ? moved[part.vertex[v]] : next++;
      if (!shared[v]) V.row(to) = c.position(v);
    }
    std::int64_t row = first_row[p];
    for (Index t = 0; t < c.tet_capacity(); ++t) {
      if (!c.alive(t)) continue;
      for (int k = 0; k < 4; ++k) T(row, k) = number[p][c.tet(t)[k]];
      ++row;
    }
  });
  for (std::int64_t p = 0; p < count; ++p)
    for (const Index v : parts[p].shared)
      if (number[p][v] >= 0) V.row(number[p][v]) = parts[p].complex.position(v);
  mesh.V = std::move(V);
  mesh.T = std::move(T);
  return moved;
}

}  // namespace overtet
