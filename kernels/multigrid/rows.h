// Products of sparse matrices, by rows and all threads. Results are the same bytes on any number of threads.
#pragma once

#include <Eigen/SparseCore>

#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

RowMatrix both_triangles(const SymmetricMatrix& A);
RowMatrix transposed(const RowMatrix& A);
RowMatrix product(const RowMatrix& A, const RowMatrix& B);

}  // namespace overtet
