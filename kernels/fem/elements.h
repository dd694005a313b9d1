// Linear and quadratic finite elements on tets [Ciarlet 1978, section 2.2]: nodes, and the matrices of
// -Laplace and of mass, as lower triangles.
//
// Nodes are the vertices and, of quadratic elements, the middles of the edges, which follow them in the order
// of (smaller vertex, larger vertex): the order in which tets of second order are written (overtet/io.h).
// Tets have straight edges, so that their integrals are polynomials of the gradients of barycentric
// coordinates and exact up to rounding. Entries are sums over tets in their order: the same bytes on any
// number of threads.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

using NodeMatrix = Eigen::Matrix<Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Of a tet: its volume, and the gradients of its barycentric coordinates, one a row.
struct TetShape {
  double volume = 0;
  Eigen::Matrix<double, 4, 3> gradient;
};
TetShape tet_shape(const VertexMatrix& V, const TetMatrix& T, Eigen::Index t);

// pre: every tet is positive.
class TetElements {
 public:
  TetElements(const VertexMatrix& V, const TetMatrix& T, int order);  // order: 1 or 2

  int order() const { return order_; }
  int nodes_each() const { return order_ == 1 ? 4 : 10; }
  Index nodes() const { return static_cast<Index>(place_.rows()); }
  Index tets() const { return static_cast<Index>(node_.rows()); }
  const VertexMatrix& places() const { return place_; }  // #N x 3
  Index node(Index t, int k) const {
    return node_(t, k);
  }  // k: a corner, or 4 + the number of an edge (kTetEdge)
  const TetShape& shape(Index t) const { return shape_[static_cast<std::size_t>(t)]; }
  // Between two vertices that an edge joins.
  Index middle(Index a, Index b) const;

  SymmetricMatrix stiffness() const;  // integrals of grad N_i . grad N_j
  SymmetricMatrix mass() const;       // integrals of N_i N_j
  // Of linear elements: a quarter of the volume of the tets around each vertex.
  Eigen::VectorXd lumped_mass() const;
  // The integral of |grad u|^2 / 2 over each tet: #T.
  Eigen::VectorXd energy(const Eigen::VectorXd& u) const;
  // Of linear elements: the gradient of u in each tet, #T x 3.
  VertexMatrix gradient(const Eigen::VectorXd& u) const;
  // Of linear elements: the integrals of X . grad N_i, for a vector X a tet (#T x 3).
  Eigen::VectorXd divergence(const VertexMatrix& X) const;

 private:
  struct Incidence {
    Index tet;
    int corner;
  };
  void add_middles(const VertexMatrix& V);
  void find_incidences();
  template <class Entry>
  SymmetricMatrix assemble(Entry&& entry) const;
  template <class Part>
  Eigen::VectorXd gather(Part&& part) const;

  int order_;
  VertexMatrix place_;
  NodeMatrix node_;
  std::vector<TetShape> shape_;
  std::vector<std::array<Index, 2>> edge_;  // of quadratic elements: a < b, sorted
  Index vertices_ = 0;
  std::vector<std::int64_t> first_;  // of each node in incidences_
  std::vector<Incidence> incidences_;
};

// The integrals of N_i N_j over a simplex of volume 1, of dimension 2 or 3: nodes are its corners, then
// (order 2) the middles of its edges in lexicographic order.
Eigen::MatrixXd reference_mass(int dimension, int order);

}  // namespace overtet
