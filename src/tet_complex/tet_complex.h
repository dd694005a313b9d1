// A tetrahedral mesh that can be changed locally: the abstract 3-manifold with boundary that the stages
// after tet_mesh work on. It may overlap itself in space; neighbours are neighbours in the complex.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "overtet/types.h"

namespace overtet {

class TetComplex {
 public:
  using Tet = std::array<Index, 4>;

  TetComplex() = default;
  // T: #T x 4. Neighbours are found by matching faces; a face of one tet only is a boundary face.
  // pre: every face belongs to at most two tets.
  TetComplex(const VertexMatrix& V, const TetMatrix& T);

  // Vertices. Removed or unused vertices keep their number until compact().
  Index vertex_count() const { return static_cast<Index>(position_.size()); }
  Index add_vertex(const Eigen::Vector3d& p);
  const Eigen::Vector3d& position(Index v) const { return position_[v]; }
  void move(Index v, const Eigen::Vector3d& p) { position_[v] = p; }
  const std::vector<Eigen::Vector3d>& positions() const { return position_; }

  // Tets, 0 .. tet_capacity() - 1, some of them dead.
  Index tet_capacity() const { return static_cast<Index>(tet_.size()); }
  Index tet_count() const { return live_; }
  bool alive(Index t) const { return tet_[t][0] >= 0; }
  const Tet& tet(Index t) const { return tet_[t]; }
  // The tet beyond the face opposite to corner k of t; -1 on the boundary.
  Index neighbour(Index t, int k) const { return next_[t][k]; }

  // The live tets around a vertex, in an order that depends only on the complex's history.
  // Linear in the size of the star. Empty for an unused vertex.
  void star(Index v, std::vector<Index>& tets) const;
  // The live tets around the edge a-b (empty: no such edge). Ordered around the edge; for a boundary
  // edge from one boundary face to the other.
  void ring(Index a, Index b, std::vector<Index>& tets) const;
  bool has_edge(Index a, Index b) const;
  bool on_boundary(Index v) const;             // has a boundary face in its star
  bool edge_on_boundary(Index a, Index b) const;
  std::vector<std::array<Index, 3>> boundary() const;  // oriented outward

  // Replaces a set of tets by another one. The outer faces of both sets must match each other or
  // be boundary faces (this is how boundary faces appear and disappear). Returns the new tets' numbers.
  // Neighbours and the vertex-to-tet table are kept up to date. Cost: linear in the two sets.
  std::vector<Index> replace(std::span<const Index> removed, std::span<const Tet> added);

  // Renumbers: drops dead tets, and unused vertices from `keep_vertices` on. Order is kept.
  void compact(Index keep_vertices);
  TetMesh to_mesh(Index surface_vertices) const;  // pre: compact

 private:
  std::vector<Eigen::Vector3d> position_;
  std::vector<Index> vertex_tet_;           // one live tet of each vertex, or -1
  std::vector<Tet> tet_;                    // dead: first entry -1
  std::vector<std::array<Index, 4>> next_;  // neighbours
  std::vector<Index> free_;
  Index live_ = 0;
};

}  // namespace overtet
