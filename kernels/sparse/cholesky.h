// Sparse Cholesky factors of symmetric positive definite matrices: analyse the pattern once, factor as
// often as the values change, solve for three coordinates at a time. The only room that names CHOLMOD, which
// is loaded when the first object is made.
//
// Everything runs in one thread: at the sizes of this program (10^3 to 10^6 rows, surfaces) the factor
// is too thin to feed several, the callers have other work for the cores, and a threaded BLAS under
// several callers oversubscribes the machine (SuiteSparse issues 34 and 92). Results are the same bytes
// on every run. Different objects may be used from different threads at the same time.
//
//   SparseCholesky factor;
//   factor.analyze(Q);                    // once per pattern
//   if (!factor.factor(Q)) ...            // not positive definite (or not finite)
//   factor.solve(B, X);                   // X = Q^-1 B
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "kernels/sparse/tuning.h"
#include "overtet/types.h"

namespace overtet {

// Symmetric: only the lower triangle (row >= column) is stored, columns compressed, rows sorted.
using SymmetricMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

struct CholeskyOptions {
  // Fill-reducing order. amd: computed in a sixth of metis' time, 15 to 40 % more fill on surface meshes. On
  // large ones metis pays even for a single factorisation (perf/README.md: at 416,000 rows 2.0 + 2.5 s
  // against 0.5 + 5.4 s, 199 against 272 MB). automatic: amd below kMetisRows rows, metis from there on.
  // natural: the matrix's own, or one of the same fill.
  enum class Ordering { automatic, amd, metis, natural } ordering = Ordering::automatic;
  // simplicial: no BLAS, the better choice on surfaces (solves 1.8 times faster at 86k faces);
  // supernodal: dense blocks, for volume meshes; automatic: CHOLMOD chooses by the work estimate.
  enum class Method { simplicial, supernodal, automatic } method = Method::simplicial;
};

class SparseCholesky {
 public:
  // Throws std::runtime_error where CHOLMOD cannot be loaded: the installation is broken.
  explicit SparseCholesky(const CholeskyOptions& options = {});
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  // Chooses the elimination order and the pattern of the factor. Values are not read.
  // False: out of memory, or A is not square and compressed. A 0 x 0 matrix is fine.
  bool analyze(const SymmetricMatrix& A);

  // False: not positive definite, not finite, or not of the size and number of entries that analyze saw. Then
  // nothing can be solved. That the pattern is the same is for the caller to see to.
  bool factor(const SymmetricMatrix& A);

  // X = A^-1 B. X may be B. False: factor did not return true, B has another number of rows, or out of
  // memory.
  bool solve(const VertexMatrix& B, VertexMatrix& X) const;
  // The same of one column. x may be b.
  bool solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;

  // Entries of the factor after the last analysis (for reports and memory estimates).
  double factor_entries() const;

  // The elimination order that the last analysis chose: the row that comes first, second, ... A part of the
  // rows, taken in this order, is a matrix that `natural` orders well.
  std::vector<int> order() const;

 private:
  struct Impl;
  bool solve_columns(Eigen::Index columns) const;
  std::unique_ptr<Impl> impl_;
};

// y = A x for a matrix stored as its lower triangle. Deterministic, one thread.
void multiply(const SymmetricMatrix& A, const VertexMatrix& x, VertexMatrix& y);

}  // namespace overtet
