// A tetrahedral mesh that can be changed locally: the abstract 3-manifold with boundary that the stages
// after tet_mesh work on. It may overlap itself in space; neighbours are neighbours in the complex.
//
// Threads: star(), has_edge(), edge_on_boundary(), on_boundary() and ring() by vertices write marks that
// belong to the object, so one object serves one thread at a time, also for const calls. (Marks make a
// star cost its size; a copy of the object is the way to a second thread.)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/assertions.h"
#include "overtet/types.h"

namespace overtet {

class TetComplex {
 public:
  using Tet = std::array<Index, 4>;

  TetComplex() = default;
  // T: #T x 4. Neighbours are found by matching faces; a face of one tet only is a boundary face.
  // pre: every face belongs to at most two tets.
  TetComplex(const VertexMatrix& V, const TetMatrix& T);
  // The same where the neighbours are known. N: #T x 4, as neighbour().
  TetComplex(const VertexMatrix& V, const TetMatrix& T, const TetMatrix& N);

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
  // As ring(), with the link: link[i], link[i + 1] are the other two corners of tets[i], so that
  // (a, b, link[i], link[i + 1]) is an even permutation of that tet. Interior edge: as many link vertices
  // as tets, the last tet has link.back(), link.front(). Boundary edge: one more link vertex than tets.
  // pre: t is a live tet with both corners.
  void ring(Index t, Index a, Index b, std::vector<Index>& tets, std::vector<Index>& link) const;
  Index tet_of(Index v) const { return vertex_tet_[v]; }  // one live tet of v, or -1
  // A live tet with the edge a-b, or -1.
  Index tet_with_edge(Index a, Index b) const;
  // A live tet with the face a-b-c, or -1.
  Index tet_with_face(Index a, Index b, Index c) const;
  bool has_edge(Index a, Index b) const;
  bool on_boundary(Index v) const;  // has a boundary face in its star
  bool edge_on_boundary(Index a, Index b) const;
  std::vector<std::array<Index, 3>> boundary() const;  // oriented outward

  // The corner of t that is v. pre: it has it.
  int corner(Index t, Index v) const {
    const Tet& c = tet_[t];
    OVERTET_EXPECTS(c[0] == v || c[1] == v || c[2] == v || c[3] == v);
    return c[0] == v ? 0 : c[1] == v ? 1 : c[2] == v ? 2 : 3;
  }

  // Replaces a set of tets by another one. The outer faces of both sets must match each other or
  // be boundary faces (this is how boundary faces appear and disappear). Returns the new tets' numbers.
  // Neighbours and the vertex-to-tet table are kept up to date. Cost: linear in the two sets.
  // pre: a vertex that keeps tets keeps one that shares a face with the removed set (true for stars, rings
  // and everything else whose complement around each vertex is connected).
  std::vector<Index> replace(std::span<const Index> removed, std::span<const Tet> added);
  // The same without an allocation; `created` is overwritten.
  void replace(std::span<const Index> removed, std::span<const Tet> added, std::vector<Index>& created);

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

  struct Face {  // sorted corners; the tet and corner that look at it
    Index a, b, c, t, k;
  };
  Face face(Index t, int k) const;
  bool turns_up(const Face& f) const;
  void take(const VertexMatrix& V, const TetMatrix& T);  // all but the neighbours
  void next_mark() const;
  bool every_vertex_has_its_tet() const;
  mutable std::vector<std::uint32_t> mark_;  // per tet; equal to stamp_: seen in this call
  mutable std::uint32_t stamp_ = 0;
  mutable std::vector<Index> scratch_;
  std::vector<Face> outer_, inner_;  // of replace()
  std::vector<Index> slots_;
};

// The first tet that is not exactly positive, or -1.
Index first_not_positive(const TetMesh& mesh);

}  // namespace overtet
