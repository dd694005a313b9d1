// What the solvers share. Internal to src/solve.
#pragma once

#include <optional>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/attributes.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet::solve_detail {

// The component of the tets that each vertex belongs to, counted from 0 in the order of their first tets; -1:
// no tet.
struct Components {
  std::vector<Index> of_vertex;
  std::vector<Index> first_tet;
};
Components components_of(const VertexMatrix& V, const TetMatrix& T);

// The boundary triangles with this label, or all; at least one. Errors: usage.
Result<std::vector<Index>> triangles_with(const LabelledTetMesh& mesh, const std::optional<Index>& label);

// That a function's value is not.
Error not_finite(const char* what, const Eigen::Vector3d& place);

// Errors: bad_input, where a tet is not positive.
Status check(const TetMesh& mesh);

// Rows and columns that are kept, numbered by `number` (-1: left out), which must be increasing.
SymmetricMatrix kept_part(const SymmetricMatrix& A, const std::vector<Index>& number, Index count);

// A x, of one column.
Eigen::VectorXd times(const SymmetricMatrix& A, const Eigen::VectorXd& x);

// Of a system that cannot be factored: flat tets, or memory.
Error not_definite();

// Of matrices of volume meshes. natural: rows stay in their order. Errors: unsolved (not positive definite,
// or out of memory), interrupted, limit.
Result<SparseCholesky> factored(const SymmetricMatrix& A, const RunContext& context,
                                CholeskyOptions::Ordering ordering = CholeskyOptions::Ordering::automatic);

// Errors: limit.
Result<Eigen::VectorXd> solved_by(const SparseCholesky& factor, const Eigen::VectorXd& b);

}  // namespace overtet::solve_detail
