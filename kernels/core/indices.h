// Whether numbers name things that exist.
#pragma once

#include <Eigen/Core>

namespace overtet {

// 0 <= x < n for every entry.
template <class Matrix>
bool all_below(const Eigen::DenseBase<Matrix>& M, Eigen::Index n) {
  return M.size() == 0 || (M.minCoeff() >= 0 && M.maxCoeff() < n);
}

}  // namespace overtet
