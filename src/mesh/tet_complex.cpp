#include "src/mesh/tet_complex.h"

#include <algorithm>
#include <bit>
#include <tuple>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

// (i, j, kOther[i][j][0], kOther[i][j][1]) is an even permutation of 0..3.
struct OtherCorners {
  int c[4][4][2] = {};
  constexpr OtherCorners() {
    constexpr int even[12][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 0, 3, 2},
                                 {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 0, 1, 3}, {2, 1, 3, 0},
                                 {2, 3, 0, 1}, {3, 0, 2, 1}, {3, 1, 0, 2}, {3, 2, 1, 0}};
    for (const auto& e : even) {
      c[e[0]][e[1]][0] = e[2];
      c[e[0]][e[1]][1] = e[3];
    }
  }
};
constexpr OtherCorners kOther;

void sort3(Index& a, Index& b, Index& c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
}

bool same(const auto& x, const auto& y) { return x.a == y.a && x.b == y.b && x.c == y.c; }

std::size_t hash(const auto& f) {
  const auto part = [](Index v, std::uint64_t factor) { return static_cast<std::uint64_t>(v) * factor; };
  return (part(f.a, 0x9E3779B97F4A7C15u) + part(f.b, 0xC2B2AE3D27D4EB4Fu) + part(f.c, 0x165667B19E3779F9u)) >>
         24;
}

}  // namespace

TetComplex::Face TetComplex::face(Index t, int k) const {
  const auto [a, b, c] = tet_face(tet_[t], k);
  Face f{a, b, c, t, k};
  sort3(f.a, f.b, f.c);
  return f;
}

// Whether the tet sees the corners a, b, c in this order, from outside. One of the two tets of a face does.
bool TetComplex::turns_up(const Face& f) const {
  const auto [a, b, c] = tet_face(tet_[f.t], f.k);
  return f.a == a ? f.b == b : f.a == b ? f.b == c : f.b == a;
}

void TetComplex::take(const VertexMatrix& V, const TetMatrix& T) {
  const Index n = static_cast<Index>(V.rows()), m = static_cast<Index>(T.rows());
  position_.resize(n);
  for (Index v = 0; v < n; ++v) position_[v] = V.row(v);
  vertex_tet_.assign(n, -1);
  tet_.resize(m);
  next_.assign(m, {-1, -1, -1, -1});
  mark_.assign(m, 0);
  live_ = m;
  for (Index t = 0; t < m; ++t)
    for (int k = 0; k < 4; ++k) {
      tet_[t][k] = T(t, k);
      if (vertex_tet_[T(t, k)] < 0) vertex_tet_[T(t, k)] = t;
    }
}

TetComplex::TetComplex(const VertexMatrix& V, const TetMatrix& T, const TetMatrix& N) {
  take(V, T);
  for (Index t = 0; t < T.rows(); ++t) next_[t] = {N(t, 0), N(t, 1), N(t, 2), N(t, 3)};
}

TetComplex::TetComplex(const VertexMatrix& V, const TetMatrix& T) {
  take(V, T);
  const Index n = static_cast<Index>(V.rows()), m = static_cast<Index>(T.rows());
  count(Count::touched_tets, m);
  // Faces in buckets by their smallest vertex: much cheaper than sorting all of them at once.
  std::vector<std::int64_t> begin(static_cast<std::size_t>(n) + 1, 0);
  for (Index t = 0; t < m; ++t)
    for (int k = 0; k < 4; ++k) ++begin[face(t, k).a + 1];
  for (Index v = 0; v < n; ++v) begin[v + 1] += begin[v];
  std::vector<Face> faces(4 * static_cast<std::size_t>(m));
  {
    std::vector<std::int64_t> at(begin.begin(), begin.end() - 1);
    for (Index t = 0; t < m; ++t)
      for (int k = 0; k < 4; ++k) {
        const Face f = face(t, k);
        faces[at[f.a]++] = f;
      }
  }
  // A face has one smallest vertex, so no two blocks write the same neighbours.
  parallel_for(n, kLightGrain, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v) {
      const auto first = faces.begin() + begin[v], last = faces.begin() + begin[v + 1];
      std::sort(first, last, [](const Face& x, const Face& y) {
        return std::tie(x.b, x.c, x.t, x.k) < std::tie(y.b, y.c, y.t, y.k);
      });
      for (auto f = first; f != last; ++f)
        // Two tets on one side (a mesh that is wrong) are no neighbours: rings would not end.
        if (f + 1 != last && same(*f, *(f + 1)) && turns_up(*f) != turns_up(*(f + 1))) {
          OVERTET_EXPECTS(f + 2 == last || !same(*f, *(f + 2)));
          next_[f->t][f->k] = (f + 1)->t;
          next_[(f + 1)->t][(f + 1)->k] = f->t;
          ++f;
        }
    }
  });
}

Index TetComplex::add_vertex(const Eigen::Vector3d& p) {
  position_.push_back(p);
  vertex_tet_.push_back(-1);
  return vertex_count() - 1;
}

void TetComplex::next_mark() const {
  if (++stamp_ == 0) {
    std::fill(mark_.begin(), mark_.end(), 0);
    stamp_ = 1;
  }
}

void TetComplex::star(Index v, std::vector<Index>& tets) const {
  tets.clear();
  if (vertex_tet_[v] < 0) return;
  next_mark();
  tets.push_back(vertex_tet_[v]);
  mark_[tets[0]] = stamp_;
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const Index t = tets[i];
    for (int k = 0; k < 4; ++k) {
      if (tet_[t][k] == v) continue;
      const Index u = next_[t][k];
      if (u < 0 || mark_[u] == stamp_) continue;
      mark_[u] = stamp_;
      tets.push_back(u);
    }
  }
  count(Count::touched_tets, std::ssize(tets));
}

Index TetComplex::tet_with_edge(Index a, Index b) const {
  if (vertex_tet_[a] < 0 || vertex_tet_[b] < 0) return -1;
  const auto has_b = [&](Index t) {
    const Tet& c = tet_[t];
    return c[0] == b || c[1] == b || c[2] == b || c[3] == b;
  };
  // The same flood as star(), left as soon as b is met.
  next_mark();
  scratch_.clear();
  scratch_.push_back(vertex_tet_[a]);
  mark_[scratch_[0]] = stamp_;
  for (std::size_t i = 0; i < scratch_.size(); ++i) {
    const Index t = scratch_[i];
    if (has_b(t)) return t;
    for (int k = 0; k < 4; ++k) {
      if (tet_[t][k] == a) continue;
      const Index u = next_[t][k];
      if (u < 0 || mark_[u] == stamp_) continue;
      mark_[u] = stamp_;
      scratch_.push_back(u);
    }
  }
  return -1;
}

Index TetComplex::tet_with_face(Index a, Index b, Index c) const {
  std::vector<Index> tets, link;
  const Index t = tet_with_edge(a, b);
  if (t < 0) return -1;
  ring(t, a, b, tets, link);
  for (std::size_t i = 0; i < tets.size(); ++i)
    if (link[i] == c || link[i + 1 < link.size() ? i + 1 : 0] == c) return tets[i];
  return -1;
}

bool TetComplex::has_edge(Index a, Index b) const { return a != b && tet_with_edge(a, b) >= 0; }

void TetComplex::ring(Index t, Index a, Index b, std::vector<Index>& tets, std::vector<Index>& link) const {
  OVERTET_EXPECTS(alive(t) && a != b && tet_[t][corner(t, a)] == a && tet_[t][corner(t, b)] == b);
  tets.clear();
  link.clear();
  // Backwards first (across the face a, b, link[i + 1]'s opposite number) until the boundary or round.
  const Index start = t;
  Index first = t;
  for (;;) {
    const int i = corner(first, a), j = corner(first, b);
    const Index before = next_[first][kOther.c[i][j][1]];  // shares a, b, link[i]
    if (before < 0) break;
    first = before;
    if (first == start) break;
  }
  const bool closed = first == start && [&] {
    const int i = corner(start, a), j = corner(start, b);
    return next_[start][kOther.c[i][j][1]] >= 0;
  }();
  for (Index u = first;;) {
    const int i = corner(u, a), j = corner(u, b);
    const int p = kOther.c[i][j][0], q = kOther.c[i][j][1];
    tets.push_back(u);
    link.push_back(tet_[u][p]);
    const Index after = next_[u][p];  // shares a, b, link[i + 1]
    if (after < 0) link.push_back(tet_[u][q]);
    if (after < 0 || (closed && after == first)) break;
    u = after;
  }
  count(Count::touched_tets, std::ssize(tets));
}

void TetComplex::ring(Index a, Index b, std::vector<Index>& tets) const {
  tets.clear();
  const Index t = a == b ? -1 : tet_with_edge(a, b);
  if (t < 0) return;
  std::vector<Index> link;
  ring(t, a, b, tets, link);
}

bool TetComplex::on_boundary(Index v) const {
  if (vertex_tet_[v] < 0) return false;
  next_mark();
  scratch_.clear();
  scratch_.push_back(vertex_tet_[v]);
  mark_[scratch_[0]] = stamp_;
  for (std::size_t i = 0; i < scratch_.size(); ++i) {
    const Index t = scratch_[i];
    for (int k = 0; k < 4; ++k) {
      if (tet_[t][k] == v) continue;
      const Index u = next_[t][k];
      if (u < 0) return true;
      if (mark_[u] == stamp_) continue;
      mark_[u] = stamp_;
      scratch_.push_back(u);
    }
  }
  return false;
}

bool TetComplex::edge_on_boundary(Index a, Index b) const {
  const Index t = a == b ? -1 : tet_with_edge(a, b);
  if (t < 0) return false;
  std::vector<Index> tets, link;
  ring(t, a, b, tets, link);
  return link.size() > tets.size();
}

std::vector<std::array<Index, 3>> TetComplex::boundary() const {
  std::vector<std::array<Index, 3>> faces;
  for (Index t = 0; t < tet_capacity(); ++t) {
    if (!alive(t)) continue;
    for (int k = 0; k < 4; ++k)
      if (next_[t][k] < 0) faces.push_back(tet_face(tet_[t], k));
  }
  return faces;
}

std::vector<Index> TetComplex::replace(std::span<const Index> removed, std::span<const Tet> added) {
  std::vector<Index> created;
  replace(removed, added, created);
  return created;
}

void TetComplex::replace(std::span<const Index> removed, std::span<const Tet> added,
                         std::vector<Index>& created) {
  created.clear();
  count(Count::touched_tets, std::ssize(removed) + std::ssize(added));
  next_mark();
  for (const Index t : removed) mark_[t] = stamp_;
  outer_.clear();
  for (const Index t : removed)
    for (int k = 0; k < 4; ++k) {
      const Index u = next_[t][k];
      if (u >= 0 && mark_[u] == stamp_) continue;
      Face f = face(t, k);
      f.t = u;  // what lies beyond, and the corner of it that looks back
      f.k = -1;
      if (u >= 0)
        for (int j = 0; j < 4; ++j)
          if (next_[u][j] == t) {
            const Face g = face(u, j);
            if (same(f, g)) f.k = j;
          }
      outer_.push_back(f);
    }

  // Every vertex of the removed set gets a tet that stays, where it has one.
  for (const Index t : removed)
    for (const Index v : tet_[t]) vertex_tet_[v] = -1;
  for (const Face& f : outer_) {
    if (f.t < 0) continue;
    vertex_tet_[f.a] = vertex_tet_[f.b] = vertex_tet_[f.c] = f.t;
    next_[f.t][f.k] = -1;
  }

  for (const Index t : removed) {
    tet_[t][0] = -1;
    free_.push_back(t);
  }
  live_ += static_cast<Index>(added.size()) - static_cast<Index>(removed.size());
  inner_.clear();
  for (const Tet& tet : added) {
    Index t;
    if (!free_.empty()) {
      t = free_.back();
      free_.pop_back();
      tet_[t] = tet;
    } else {
      t = tet_capacity();
      tet_.push_back(tet);
      next_.push_back({});
      mark_.push_back(0);
    }
    next_[t] = {-1, -1, -1, -1};
    created.push_back(t);
    for (int k = 0; k < 4; ++k) {
      vertex_tet_[tet[k]] = t;
      inner_.push_back(face(t, k));
    }
  }

  for (const Face& f : outer_)
    if (f.t >= 0) inner_.push_back(f);
  // Equal faces meet in a table.
  const std::size_t mask = std::bit_ceil(2 * inner_.size() + 1) - 1;
  slots_.assign(mask + 1, -1);
  for (std::size_t i = 0; i < inner_.size(); ++i) {
    const Face& f = inner_[i];
    std::size_t at = hash(f) & mask;
    while (slots_[at] >= 0 && !same(inner_[slots_[at]], f)) at = (at + 1) & mask;
    if (slots_[at] < 0) {
      slots_[at] = static_cast<Index>(i);
      continue;
    }
    const Face& g = inner_[slots_[at]];
    next_[f.t][f.k] = g.t;
    next_[g.t][g.k] = f.t;
  }
  OVERTET_EXPECTS_COSTLY(every_vertex_has_its_tet());
}

bool TetComplex::every_vertex_has_its_tet() const {
  for (Index t = 0; t < tet_capacity(); ++t)
    for (int k = 0; alive(t) && k < 4; ++k)
      if (vertex_tet_[tet_[t][k]] < 0) return false;
  return true;
}

void TetComplex::compact(Index keep_vertices) {
  std::vector<char> used(position_.size(), 0);
  std::vector<Index> tet_number(tet_.size(), -1), vertex_number(position_.size(), -1);
  Index tets = 0, vertices = 0;
  for (Index t = 0; t < tet_capacity(); ++t) {
    if (!alive(t)) continue;
    tet_number[t] = tets++;
    for (const Index v : tet_[t]) used[v] = 1;
  }
  for (Index v = 0; v < vertex_count(); ++v)
    if (v < keep_vertices || used[v]) vertex_number[v] = vertices++;
  for (Index v = 0; v < vertex_count(); ++v) {
    const Index to = vertex_number[v];
    if (to < 0) continue;
    position_[to] = position_[v];
    vertex_tet_[to] = vertex_tet_[v] < 0 ? -1 : tet_number[vertex_tet_[v]];
  }
  for (Index t = 0; t < tet_capacity(); ++t) {
    const Index to = tet_number[t];
    if (to < 0) continue;
    Tet corners = tet_[t];
    for (Index& v : corners) v = vertex_number[v];
    tet_[to] = corners;
    auto next = next_[t];
    for (Index& u : next) u = u < 0 ? -1 : tet_number[u];
    next_[to] = next;
  }
  position_.resize(vertices);
  vertex_tet_.resize(vertices);
  tet_.resize(tets);
  next_.resize(tets);
  mark_.assign(tets, 0);
  stamp_ = 0;
  free_.clear();
}

Index first_not_positive(const TetMesh& mesh) {
  const auto at = [&](Index t, int k) { return mesh.V.data() + 3 * std::int64_t{mesh.T(t, k)}; };
  const auto none = static_cast<Index>(mesh.T.rows());
  const Index first = parallel_reduce(
      mesh.T.rows(), kLightGrain, none,
      [&](std::int64_t begin, std::int64_t end) {
        for (auto t = static_cast<Index>(begin); t < end; ++t)
          if (orient3d(at(t, 0), at(t, 1), at(t, 2), at(t, 3)) <= 0) return t;
        return none;
      },
      [](Index a, Index b) { return std::min(a, b); });
  return first < none ? first : -1;
}

TetMesh TetComplex::to_mesh(Index surface_vertices) const {
  OVERTET_EXPECTS(live_ == tet_capacity());
  TetMesh mesh;
  mesh.surface_vertices = surface_vertices;
  mesh.V.resize(vertex_count(), 3);
  for (Index v = 0; v < vertex_count(); ++v) mesh.V.row(v) = position_[v];
  mesh.T.resize(live_, 4);
  Index row = 0;
  for (Index t = 0; t < tet_capacity(); ++t)
    if (alive(t)) mesh.T.row(row++) << tet_[t][0], tet_[t][1], tet_[t][2], tet_[t][3];
  return mesh;
}

}  // namespace overtet
