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

#include "kernels/parallel/raw_vector.h"
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

  // Nodes in the order in which the tets name them first: neighbours are near each other. Those of no tet
  // come last, from used() on.
  const std::vector<Index>& sequence() const { return sequence_; }
  Index used() const { return used_; }
  // The vertices that a middle lies between. pre: node >= the number of vertices.
  const std::array<Index, 2>& ends(Index node) const {
    return edge_[static_cast<std::size_t>(node - vertices_)];
  }

  SymmetricMatrix stiffness() const;  // integrals of grad N_i . grad N_j
  SymmetricMatrix mass() const;       // integrals of N_i N_j
  // Rows and columns of some nodes: by node their numbers, each of 0 .. count - 1 once; -1: left out.
  SymmetricMatrix stiffness(const std::vector<Index>& number, Index count) const;
  // The same of the linear elements in the same tets; number: at least by vertex.
  SymmetricMatrix linear_stiffness(const std::vector<Index>& number, Index count) const;
  // Products with these matrices, without making them.
  Eigen::VectorXd stiffness_times(const Eigen::VectorXd& u) const;
  Eigen::VectorXd mass_times(const Eigen::VectorXd& f) const;
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
  void find_sequence();
  std::vector<Index> every_node() const;
  void stiffness_row(Index t, int i, double* row) const;
  // f(t, k) for the tets at a node, its k-th, in their order.
  template <class F>
  void each_tet_of(Index node, F&& f) const {
    const auto at = static_cast<std::size_t>(place_in_sequence_[static_cast<std::size_t>(node)]);
    for (std::int64_t i = first_[at]; i < first_[at + 1]; ++i)
      f(incidences_[static_cast<std::size_t>(i)].tet, incidences_[static_cast<std::size_t>(i)].corner);
  }
  template <class Fill>
  SymmetricMatrix assemble(int each, const std::vector<Index>& number, Index count, Fill&& fill) const;
  template <class Part>
  Eigen::VectorXd gather(Part&& part) const;

  int order_;
  VertexMatrix place_;
  NodeMatrix node_;
  std::vector<TetShape> shape_;
  std::vector<std::array<Index, 2>> edge_;  // of quadratic elements: a < b, sorted
  std::vector<Index> first_edge_;           // by vertex: of the edges that it is the smaller end of
  Index vertices_ = 0;
  std::vector<Index> sequence_, place_in_sequence_;
  Index used_ = 0;
  // Of each node, by its place in the sequence.
  RawVector<std::int64_t> first_;
  RawVector<Incidence> incidences_;
};

// The integrals of N_i N_j over a simplex of volume 1, of dimension 2 or 3: nodes are its corners, then
// (order 2) the middles of its edges in lexicographic order.
Eigen::MatrixXd reference_mass(int dimension, int order);

}  // namespace overtet
