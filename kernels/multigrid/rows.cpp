#include "kernels/multigrid/rows.h"

#include <algorithm>
#include <cstdint>

#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/sparse/rows.h"

namespace overtet {

namespace {

struct Entry {
  Index column;
  double value;
};

// The entries of A by their inner index; those that `keep` does not want are left out.
template <class Matrix, class Keep>
void turn(const Matrix& A, RawVector<int>& start, RawVector<Entry>& entries, Keep&& keep) {
  group_items(A.innerSize(), start, entries, [&](auto visit) {
    const int* const first = A.outerIndexPtr();
    for (Index i = 0; i < A.outerSize(); ++i)
      for (int at = first[i]; at < first[i + 1]; ++at)
        if (const Index j = A.innerIndexPtr()[at]; keep(i, j)) visit(j, Entry{i, A.valuePtr()[at]});
  });
}

}  // namespace

RowMatrix both_triangles(const SymmetricMatrix& A) {
  RawVector<int> left;
  RawVector<Entry> entries;
  turn(A, left, entries, [](Index column, Index row) { return row > column; });
  RowMatrix out(A.rows(), A.cols());
  int* const start = out.outerIndexPtr();
  const int* const right = A.outerIndexPtr();
  start[0] = 0;
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    start[i + 1] = start[i] + (left[i + 1] - left[i]) + (right[i + 1] - right[i]);
  out.resizeNonZeros(start[A.rows()]);
  parallel_for(A.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    int at = start[begin];
    for (std::int64_t i = begin; i < end; ++i) {
      for (int k = left[i]; k < left[i + 1]; ++k, ++at)
        out.innerIndexPtr()[at] = entries[k].column, out.valuePtr()[at] = entries[k].value;
      for (int k = right[i]; k < right[i + 1]; ++k, ++at)
        out.innerIndexPtr()[at] = A.innerIndexPtr()[k], out.valuePtr()[at] = A.valuePtr()[k];
    }
  });
  return out;
}

RowMatrix transposed(const RowMatrix& A) {
  RawVector<int> start;
  RawVector<Entry> entries;
  turn(A, start, entries, [](Index, Index) { return true; });
  RowMatrix out(A.cols(), A.rows());
  std::copy(start.begin(), start.end(), out.outerIndexPtr());
  out.resizeNonZeros(std::ssize(entries));
  parallel_for(std::ssize(entries), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
      out.innerIndexPtr()[k] = entries[k].column, out.valuePtr()[k] = entries[k].value;
  });
  return out;
}

RowMatrix product(const RowMatrix& A, const RowMatrix& B) {
  return matrix_of_rows<RowMatrix>(A.rows(), B.cols(), [&](Index i, RowSums& sums) {
    for (RowMatrix::InnerIterator a(A, i); a; ++a)
      for (RowMatrix::InnerIterator b(B, a.col()); b; ++b) sums.add(b.col(), a.value() * b.value());
  });
}

}  // namespace overtet
