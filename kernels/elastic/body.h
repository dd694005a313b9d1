// An elastic body on linear tets: energy, forces and stiffness of all of it.
//
// Sums over tets are gathered by vertex, in the order of the tets: the same bytes on any number of threads.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "kernels/elastic/material.h"
#include "kernels/fem/elements.h"
#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

// x, d: #V x 3; places of the vertices, and ways that they go.
class ElasticBody {
 public:
  // A 3 x 3 matrix a tet, times the tet's volume: of stress.
  using Stresses = std::vector<Eigen::Matrix3d>;
  using Tangents = std::vector<MaterialTangent>;

  // number: of each vertex that of its rows in matrices, three from 3 n on, increasing; -1: it has none.
  // pre: every tet of `rest` is positive.
  ElasticBody(const VertexMatrix& rest, const TetMatrix& T, const ElasticLaw& law, std::vector<Index> number);

  Index tets() const { return static_cast<Index>(T_.rows()); }
  Index rows() const { return 3 * free_; }
  const Index* tet(Index t) const { return T_.data() + 4 * static_cast<std::ptrdiff_t>(t); }  // its corners
  const VertexMatrix& rest() const { return rest_; }
  const TetShape& shape(Index t) const { return shape_[static_cast<std::size_t>(t)]; }

  // Infinite where a tet is not positive.
  double energy(const VertexMatrix& x) const;
  // The same, with the stresses; they are not finite where a tet is not positive.
  double stresses(const VertexMatrix& x, Stresses& P) const;
  // pre for those: every tet of x is positive.
  void tangents(const VertexMatrix& x, Tangent kind, Tangents& out) const;
  Eigen::VectorXd von_mises(const VertexMatrix& x) const;  // #T

  // P += factor times what the way d changes the stresses by.
  void add_change(const Tangents& tangents, const VertexMatrix& d, double factor, Stresses& P) const;
  // d' K d.
  double curvature(const Tangents& tangents, const VertexMatrix& d) const;
  // How long gathered() may be for nothing but the rounding of places as large as those at rest.
  double rounding() const;
  // The derivative of the energy by the places: #V x 3. size: the length of all tets' parts of it, in which
  // nothing has cancelled.
  VertexMatrix gathered(const Stresses& P, double& size) const;

  // A = sum of factor K(tangents) + diagonal (#V, at the three rows of each vertex). Its pattern is always
  // the same; made where A is empty.
  struct Part {
    const Tangents* tangents = nullptr;
    double factor = 0;
  };
  void assemble(std::initializer_list<Part> parts, const Eigen::VectorXd& diagonal, SymmetricMatrix& A) const;

  // For what part of the way d every tet stays positive, at most `most`; and the tet that allows no more, or
  // -1.
  struct Way {
    double part = 0;
    Index tet = -1;
  };
  Way way(const VertexMatrix& x, const VertexMatrix& d, double most) const;
  // Exact. The first tet that is not positive; -1: none.
  Index first_flipped(const VertexMatrix& x) const;
  // The least ratio of a tet's volume to that at rest.
  double least_ratio(const VertexMatrix& x) const;

 private:
  Eigen::Matrix3d gradient(std::int64_t t, const VertexMatrix& d) const;
  void find_pattern();

  VertexMatrix rest_;
  TetMatrix T_;
  ElasticLaw law_;
  std::vector<TetShape> shape_;
  // Of each vertex its tets, and which corner of them it is.
  struct Incidence {
    Index tet;
    int corner;
    std::array<Index, 4> block;  // of the tet's corners: in the vertex's columns; -1: not there
  };
  std::vector<std::int64_t> first_;
  std::vector<Incidence> incidences_;
  // Of the matrix, in blocks of 3 x 3: of each vertex the rows of blocks, the diagonal one first.
  std::vector<Index> number_, vertex_;
  std::vector<std::int64_t> first_block_;
  std::vector<Index> block_row_;
  Index free_ = 0;
};

}  // namespace overtet
