#include "src/tet_complex/parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "kernels/parallel/parallel.h"

namespace overtet {

namespace {

struct Centre {
  double x[3];
  Index tet;
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

}  // namespace

void MeshPart::mark_shared(LocalOperations& work) const {
  for (const Index v : shared) work.share(v, false);
  for (const Index v : pinched) work.share(v, true);
}

std::vector<int> halve(const TetMesh& mesh, std::span<const Index> chosen, int parts) {
  std::vector<Centre> centres(chosen.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    centres[i].tet = chosen[i];
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (int j = 0; j < 4; ++j) sum += mesh.V(mesh.T(chosen[i], j), k);
      centres[i].x[k] = sum;
    }
  }
  std::vector<int> part_of(static_cast<std::size_t>(mesh.T.rows()), -1);
  for (const Index t : chosen) part_of[t] = 0;
  const auto cut = [&](const auto& self, std::size_t begin, std::size_t end, int first, int count) -> void {
    if (count == 1) {
      for (std::size_t i = begin; i < end; ++i) part_of[centres[i].tet] = first;
      return;
    }
    std::array<double, 3> low, high;
    low.fill(1e300), high.fill(-1e300);
    for (std::size_t i = begin; i < end; ++i)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], centres[i].x[k]);
        high[k] = std::max(high[k], centres[i].x[k]);
      }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return centres.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Centre& x, const Centre& y) {
      return x.x[axis] != y.x[axis] ? x.x[axis] < y.x[axis] : x.tet < y.tet;
    });
    parallel_invoke([&] { self(self, begin, middle, first, count / 2); },
                    [&] { self(self, middle, end, first + count / 2, count / 2); });
  };
  cut(cut, 0, centres.size(), 0, parts);
  return part_of;
}

std::vector<MeshPart> take_parts(const TetMesh& mesh, std::span<const int> part_of, int parts) {
  constexpr int kSeveral = -2, kNone = -3;
  std::vector<int> owner(static_cast<std::size_t>(mesh.V.rows()), kNone);  // the only part, -1: none of them
  std::vector<std::vector<Index>> tets(parts);
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    if (part_of[t] >= 0) tets[part_of[t]].push_back(t);
    for (int k = 0; k < 4; ++k) {
      int& o = owner[mesh.T(t, k)];
      o = o == kNone || o == part_of[t] ? part_of[t] : kSeveral;
    }
  }
  std::vector<MeshPart> result(parts);
  parallel_for(parts, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t p = begin; p < end; ++p) {
      MeshPart& part = result[p];
      sort_by_place(mesh, tets[p]);
      // Numbers in the order of first use: what is near lies near in memory.
      static thread_local std::vector<Index> local;
      local.resize(std::max<std::size_t>(local.size(), owner.size()), -1);
      std::vector<Index>& vertex = part.vertex;
      TetMatrix T(static_cast<Eigen::Index>(tets[p].size()), 4);
      for (std::size_t i = 0; i < tets[p].size(); ++i)
        for (int k = 0; k < 4; ++k) {
          Index& v = local[mesh.T(tets[p][i], k)];
          if (v < 0) {
            v = static_cast<Index>(vertex.size());
            vertex.push_back(mesh.T(tets[p][i], k));
          }
          T(static_cast<Eigen::Index>(i), k) = v;
        }
      VertexMatrix V(static_cast<Eigen::Index>(vertex.size()), 3);
      std::vector<char> shared(vertex.size(), 0);
      for (std::size_t i = 0; i < vertex.size(); ++i) {
        local[vertex[i]] = -1;
        V.row(static_cast<Eigen::Index>(i)) = mesh.V.row(vertex[i]);
        if (owner[vertex[i]] != kSeveral) continue;
        shared[i] = 1;
        part.shared.push_back(static_cast<Index>(i));
      }
      part.complex = TetComplex(V, T);
      find_pinched(part, shared);
    }
  });
  return result;
}

std::vector<Index> put_parts(TetMesh& mesh, std::span<const int> part_of,
                             const std::vector<MeshPart>& parts) {
  const Index old_vertices = static_cast<Index>(mesh.V.rows());
  std::vector<char> used(old_vertices, 0);
  std::fill(used.begin(), used.begin() + mesh.surface_vertices, 1);
  std::int64_t tets = 0, vertices = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    if (part_of[t] >= 0) continue;
    ++tets;
    for (int k = 0; k < 4; ++k) used[mesh.T(t, k)] = 1;
  }
  std::vector<std::vector<Index>> number(parts.size());  // of the complexes' vertices in the result
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const TetComplex& c = parts[p].complex;
    tets += c.tet_count();
    number[p].assign(c.vertex_count(), -1);
    for (Index v = 0; v < c.vertex_count(); ++v) {
      if (c.tet_of(v) < 0) continue;
      number[p][v] = 0;
      if (v < static_cast<Index>(parts[p].vertex.size())) used[parts[p].vertex[v]] = 1;
    }
  }
  std::vector<Index> moved(old_vertices, -1);
  for (Index v = 0; v < old_vertices; ++v)
    if (used[v]) moved[v] = static_cast<Index>(vertices++);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t v = 0; v < number[p].size(); ++v)
      if (number[p][v] >= 0)
        number[p][v] =
            v < parts[p].vertex.size() ? moved[parts[p].vertex[v]] : static_cast<Index>(vertices++);

  VertexMatrix V(vertices, 3);
  for (Index v = 0; v < old_vertices; ++v)
    if (moved[v] >= 0) V.row(moved[v]) = mesh.V.row(v);
  TetMatrix T(tets, 4);
  std::int64_t row = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    if (part_of[t] < 0) {
      for (int k = 0; k < 4; ++k) T(row, k) = moved[mesh.T(t, k)];
      ++row;
    }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const TetComplex& c = parts[p].complex;
    for (Index v = 0; v < c.vertex_count(); ++v)
      if (number[p][v] >= 0) V.row(number[p][v]) = c.position(v);
    for (Index t = 0; t < c.tet_capacity(); ++t) {
      if (!c.alive(t)) continue;
      for (int k = 0; k < 4; ++k) T(row, k) = number[p][c.tet(t)[k]];
      ++row;
    }
  }
  mesh.V = std::move(V);
  mesh.T = std::move(T);
  return moved;
}

}  // namespace overtet
