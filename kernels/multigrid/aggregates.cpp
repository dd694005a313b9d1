#include "kernels/multigrid/aggregates.h"

#include <cmath>

#include "kernels/sparse/rows.h"

namespace overtet {

namespace {

// Whether two unknowns are coupled strongly.
class Strength {
 public:
  Strength(const RowMatrix& A, double strong)
      : root_(A.diagonal().cwiseMax(0).cwiseSqrt()), strong_(strong) {}
  bool operator()(Index i, Index j, double a) const { return i != j && -a > strong_ * root_[i] * root_[j]; }

 private:
  Eigen::VectorXd root_;
  double strong_;
};

}  // namespace

Aggregates aggregates_of(const RowMatrix& A, double strong) {
  const Strength is_strong(A, strong);
  const auto rows = static_cast<Index>(A.rows());
  Aggregates out;
  out.of.assign(static_cast<std::size_t>(rows), -1);
  const auto group = [&](Index i) -> Index& { return out.of[static_cast<std::size_t>(i)]; };
  const auto gather = [&](Index i, bool only_whole) {
    bool any = false, whole = true;
    for (RowMatrix::InnerIterator it(A, i); it; ++it)
      if (is_strong(i, it.col(), it.value())) any = true, whole = whole && group(it.col()) < 0;
    if (!any || (only_whole && !whole)) return;
    for (RowMatrix::InnerIterator it(A, i); it; ++it)
      if (is_strong(i, it.col(), it.value()) && group(it.col()) < 0) group(it.col()) = out.count;
    group(i) = out.count++;
  };
  for (Index i = 0; i < rows; ++i)
    if (group(i) < 0) gather(i, true);
  // What is left joins a neighbour of an aggregate made above, if it has one.
  std::vector<Index> joined(out.of);
  for (Index i = 0; i < rows; ++i) {
    if (group(i) >= 0) continue;
    double most = 0;
    for (RowMatrix::InnerIterator it(A, i); it; ++it)
      if (it.col() != i && -it.value() > most && group(it.col()) >= 0)
        most = -it.value(), joined[static_cast<std::size_t>(i)] = group(it.col());
  }
  out.of.swap(joined);
  for (Index i = 0; i < rows; ++i)
    if (group(i) < 0) gather(i, false);
  return out;
}

RowMatrix smoothed_prolongation(const RowMatrix& A, const Aggregates& aggregates, double strong) {
  const Strength is_strong(A, strong);
  return matrix_of_rows<RowMatrix>(A.rows(), aggregates.count, [&](Index i, RowSums& sums) {
    double diagonal = 0, norm = 0;
    for (RowMatrix::InnerIterator it(A, i); it; ++it) {
      if (is_strong(i, it.col(), it.value()))
        norm += std::abs(it.value());
      else
        diagonal += it.value();
    }
    norm += std::abs(diagonal);
    // No eigenvalue is larger than 1 then, and 4/3 damps the upper part of them best (ibid., section 3).
    const double factor = norm > 0 ? 4.0 / 3 / norm : 0;
    const auto add = [&](Index j, double value) {
      if (const Index g = aggregates.of[static_cast<std::size_t>(j)]; g >= 0) sums.add(g, value);
    };
    add(i, 1 - factor * diagonal);
    for (RowMatrix::InnerIterator it(A, i); it; ++it)
      if (is_strong(i, it.col(), it.value())) add(it.col(), -factor * it.value());
  });
}

}  // namespace overtet
