#include "src/solve/parts.h"

#include <array>
#include <cstdio>
#include <string>

#include "kernels/core/union_find.h"
#include "src/mesh/tet_complex.h"

namespace overtet::solve_detail {

Components components_of(const VertexMatrix& V, const TetMatrix& T) {
  UnionFind sets(static_cast<std::size_t>(V.rows()));
  for (Eigen::Index t = 0; t < T.rows(); ++t)
    for (int k = 1; k < 4; ++k) sets.join_smaller(T(t, 0), T(t, k));
  Components out;
  out.of_vertex.assign(static_cast<std::size_t>(V.rows()), -1);
  std::vector<Index> number(static_cast<std::size_t>(V.rows()), -1);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    Index& n = number[static_cast<std::size_t>(sets.root(T(t, 0)))];
    if (n < 0) {
      n = static_cast<Index>(out.first_tet.size());
      out.first_tet.push_back(static_cast<Index>(t));
    }
    for (int k = 0; k < 4; ++k) out.of_vertex[static_cast<std::size_t>(T(t, k))] = n;
  }
  return out;
}

Result<std::vector<Index>> triangles_with(const LabelledTetMesh& mesh, const std::optional<Index>& label) {
  const std::vector<Index>& labels = mesh.attributes.labels.of;
  std::vector<Index> out;
  for (Eigen::Index i = 0; i < mesh.attributes.triangles.rows(); ++i)
    if (!label || (!labels.empty() && labels[static_cast<std::size_t>(i)] == *label))
      out.push_back(static_cast<Index>(i));
  if (!out.empty()) return out;
  return Error{ErrorCode::usage,
               label ? "No triangle of the mesh has the label " + std::to_string(*label) + "."
                     : std::string("The mesh has no boundary triangles; write it with its boundary, "
                                   "or give values at vertices.")};
}

Error not_finite(const char* what, const Eigen::Vector3d& p) {
  char text[160];
  std::snprintf(text, sizeof text, "The %s at (%.6g, %.6g, %.6g) is not finite.", what, p[0], p[1], p[2]);
  return {ErrorCode::bad_input, text, std::array<double, 3>{p[0], p[1], p[2]}};
}

Status check(const TetMesh& mesh) {
  const Index t = first_not_positive(mesh);
  if (t < 0) return success();
  return Error{ErrorCode::bad_input, "Tet " + std::to_string(t) + " (counted from 0) is not positive."};
}

SymmetricMatrix kept_part(const SymmetricMatrix& A, const std::vector<Index>& number, Index count) {
  SymmetricMatrix out(count, count);
  out.reserve(A.nonZeros());
  for (Eigen::Index j = 0; j < A.outerSize(); ++j) {
    const Index column = number[static_cast<std::size_t>(j)];
    if (column < 0) continue;
    out.startVec(column);
    for (SymmetricMatrix::InnerIterator it(A, j); it; ++it)
      if (const Index row = number[static_cast<std::size_t>(it.row())]; row >= 0)
        out.insertBack(row, column) = it.value();
  }
  out.finalize();
  return out;
}

Eigen::VectorXd times(const SymmetricMatrix& A, const Eigen::VectorXd& x) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index j = 0; j < A.outerSize(); ++j)
    for (SymmetricMatrix::InnerIterator it(A, j); it; ++it) {
      y[it.row()] += it.value() * x[j];
      if (it.row() != j) y[j] += it.value() * x[it.row()];
    }
  return y;
}

Error not_definite() {
  return {ErrorCode::unsolved,
          "The system of equations is not positive definite in double precision: the mesh has tets that are "
          "too flat, or memory ran out. Improve the mesh."};
}

Result<SparseCholesky> factored(const SymmetricMatrix& A, const RunContext& context,
                                CholeskyOptions::Ordering ordering) {
  if (auto stop = context.stop()) return *stop;
  SparseCholesky factor({.ordering = ordering, .method = CholeskyOptions::Method::automatic});
  if (!factor.analyze(A))
    return Error{ErrorCode::limit, "There is not enough memory for the factor of this system."};
  if (auto e = context.no_room_for(static_cast<std::size_t>(8 * factor.factor_entries()))) return *e;
  if (auto stop = context.stop()) return *stop;
  if (!factor.factor(A)) return not_definite();
  if (auto stop = context.stop()) return *stop;
  return factor;
}

Result<Eigen::VectorXd> solved_by(const SparseCholesky& factor, const Eigen::VectorXd& b) {
  Eigen::VectorXd x;
  if (factor.solve(b, x)) return x;
  return Error{ErrorCode::limit, "There is not enough memory to solve this system."};
}

}  // namespace overtet::solve_detail
