#include "src/cdt/manifold.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/predicates/predicates.h"
#include "src/cdt/unsolved.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

namespace {

// Corners of tets that hang together over faces are one vertex; returns how many got a number of their own.
Index separate_vertices(TetMesh& mesh, const TetMatrix& N) {
  TetMatrix& T = mesh.T;
  UnionFind joined(static_cast<std::size_t>(4 * T.rows()));
  const auto corner_of = [&](Index t, Index v) {
    int k = 0;
    while (T(t, k) != v) ++k;
    return 4 * t + k;
  };
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const Index next = N(t, k);
      if (next < 0) continue;
      for (int i = 0; i < 4; ++i)
        if (i != k) joined.join_smaller(4 * t + i, corner_of(next, T(t, i)));
    }
  // The group that keeps the number: the one on the boundary, else the first.
  std::vector<Index> keeper(static_cast<std::size_t>(mesh.V.rows()), -1);
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k)
      if (N(t, k) < 0)
        for (int i = 0; i < 4; ++i)
          if (i != k) keeper[T(t, i)] = joined.root(4 * t + i);
  std::vector<Index> number(static_cast<std::size_t>(4 * T.rows()), -1);
  std::vector<Index> copied;  // from where
  for (Index c = 0; c < static_cast<Index>(number.size()); ++c) {
    const Index root = joined.root(c), v = T(c / 4, c % 4);
    if (keeper[v] < 0) keeper[v] = root;
    if (keeper[v] == root || number[root] >= 0) continue;
    number[root] = static_cast<Index>(mesh.V.rows()) + static_cast<Index>(copied.size());
    copied.push_back(v);
  }
  for (Index c = 0; c < static_cast<Index>(number.size()); ++c)
    if (const Index n = number[joined.root(c)]; n >= 0) T(c / 4, c % 4) = n;
  const Eigen::Index old = mesh.V.rows();
  mesh.V.conservativeResize(old + std::ssize(copied), 3);
  for (std::size_t i = 0; i < copied.size(); ++i)
    mesh.V.row(old + static_cast<Eigen::Index>(i)) = mesh.V.row(copied[i]);
  return static_cast<Index>(copied.size());
}

class Splitter {
 public:
  explicit Splitter(TetComplex& mesh) : mesh_(mesh) {}

  // One pass over edges, or over faces. Returns how many were found; those whose tets another one has changed
  // wait for the next pass.
  Result<Index> edges() {
    struct Use {
      Index a, b, tet;
      auto operator<=>(const Use&) const = default;
    };
    std::vector<Use> uses;
    for (Index t = 0; t < mesh_.tet_capacity(); ++t)
      if (mesh_.alive(t))
        for (const auto& [i, j] : kTetEdge) {
          const Index a = mesh_.tet(t)[i], b = mesh_.tet(t)[j];
          uses.push_back({std::min(a, b), std::max(a, b), t});
        }
    std::sort(uses.begin(), uses.end());
    std::vector<Spare> spares;
    for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
      while (end < uses.size() && uses[end].a == uses[begin].a && uses[end].b == uses[begin].b) ++end;
      std::vector<Index> tets;
      for (std::size_t i = begin; i < end; ++i) tets.push_back(uses[i].tet);
      for (std::vector<Index>& ring : spare_rings({uses[begin].a, uses[begin].b}, tets))
        spares.push_back({{uses[begin].a, uses[begin].b}, std::move(ring)});
    }
    return split(spares);
  }

  Result<Index> faces() {
    struct Side {
      std::array<Index, 3> corners;
      Index tet, next;
      auto operator<=>(const Side&) const = default;
    };
    std::vector<Side> sides;
    for (Index t = 0; t < mesh_.tet_capacity(); ++t)
      if (mesh_.alive(t))
        for (int k = 0; k < 4; ++k)
          if (const Index next = mesh_.neighbour(t, k); next < t)  // each once
            sides.push_back({sorted(tet_face(mesh_.tet(t), k)), t, next});
    std::sort(sides.begin(), sides.end());
    std::vector<Spare> spares;
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      while (end < sides.size() && sides[end].corners == sides[begin].corners) ++end;
      bool keep_one = std::none_of(sides.begin() + static_cast<std::ptrdiff_t>(begin),
                                   sides.begin() + static_cast<std::ptrdiff_t>(end),
                                   [](const Side& s) { return s.next < 0; });
      for (std::size_t i = begin; i < end; ++i)
        if (sides[i].next >= 0 && !std::exchange(keep_one, false))
          spares.push_back(
              {{sides[i].corners.begin(), sides[i].corners.end()}, {sides[i].tet, sides[i].next}});
    }
    return split(spares);
  }

 private:
  struct Spare {  // an edge or a face that is there another time, with the tets around it
    std::vector<Index> corners, tets;
  };

  // Of an edge's tets: the rings they fall apart into, but for one, and never one of the boundary.
  std::vector<std::vector<Index>> spare_rings(const std::array<Index, 2>& edge,
                                              const std::vector<Index>& tets) const {
    UnionFind joined(tets.size());
    std::size_t pieces = tets.size();
    std::vector<char> on_boundary(tets.size(), 0);
    for (std::size_t i = 0; i < tets.size(); ++i)
      for (int k = 0; k < 4; ++k) {
        const Index v = mesh_.tet(tets[i])[k], next = mesh_.neighbour(tets[i], k);
        if (v == edge[0] || v == edge[1]) continue;
        if (next < 0) {
          on_boundary[i] = 1;
          continue;
        }
        const auto at = std::lower_bound(tets.begin(), tets.end(), next) - tets.begin();
        if (joined.join_smaller(static_cast<Index>(i), static_cast<Index>(at))) --pieces;
      }
    std::vector<std::vector<Index>> spare;
    if (pieces == 1) return spare;
    std::vector<std::vector<Index>> rings(tets.size());
    std::vector<char> fixed(tets.size(), 0);
    for (std::size_t i = 0; i < tets.size(); ++i) {
      const Index root = joined.root(static_cast<Index>(i));
      rings[root].push_back(tets[i]);
      if (on_boundary[i]) fixed[root] = 1;
    }
    bool keep_one = std::none_of(fixed.begin(), fixed.end(), [](char f) { return f != 0; });
    for (std::size_t r = 0; r < rings.size(); ++r)
      if (!rings[r].empty() && !fixed[r] && !std::exchange(keep_one, false))
        spare.push_back(std::move(rings[r]));
    return spare;
  }

  // Each of the tets falls into as many as there are corners, one of which is the new vertex.
  Result<Index> split(const std::vector<Spare>& spares) {
    std::vector<char> old(static_cast<std::size_t>(mesh_.tet_capacity()), 1);
    for (const Spare& spare : spares) {
      if (std::any_of(spare.tets.begin(), spare.tets.end(),
                      [&](Index t) { return !old[t] || !mesh_.alive(t); }))
        continue;
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const Index v : spare.corners)
        middle += mesh_.position(v) / static_cast<double>(spare.corners.size());
      const Index m = mesh_.add_vertex(middle);
      std::vector<TetComplex::Tet> added;
      for (const Index t : spare.tets)
        for (const Index v : spare.corners) {
          added.push_back(mesh_.tet(t));
          added.back()[mesh_.corner(t, v)] = m;
          const auto& [a, b, c, d] = added.back();
          const auto at = [&](Index w) { return mesh_.position(w).data(); };
          if (orient3d(at(a), at(b), at(c), at(d)) <= 0)
            return unsolved("What TetGen made twice is too small to split.");
        }
      for (const Index t : spare.tets) old[t] = 0;
      for (const Index t : mesh_.replace(spare.tets, added))
        if (t < static_cast<Index>(old.size())) old[t] = 0;  // their numbers may be used again
    }
    return static_cast<Index>(spares.size());
  }

  TetComplex& mesh_;
};

}  // namespace

Result<Index> make_manifold(TetMesh& mesh, const TetMatrix& N) {
  Index all = separate_vertices(mesh, N);
  TetComplex complex(mesh.V, mesh.T, N);
  Splitter splitter(complex);
  for (int round = 0; round < kMostRounds; ++round) {
    const Result<Index> edges = splitter.edges();
    if (!edges) return edges;
    all += edges.value();
    if (edges.value() > 0) continue;
    const Result<Index> faces = splitter.faces();
    if (!faces) return faces;
    all += faces.value();
    if (faces.value() > 0) continue;
    if (all > 0) {
      complex.compact(mesh.surface_vertices);
      mesh = complex.to_mesh(mesh.surface_vertices);
    }
    return all;
  }
  return unsolved("TetGen made too much twice.");
}

}  // namespace overtet
