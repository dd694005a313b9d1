// The box around points, along the axes.
#pragma once

#include <cmath>

#include "overtet/types.h"

namespace overtet {

// The length of its diagonal, of points of any size; 0 where there are none.
inline double diagonal_of(const VertexMatrix& V) {
  if (V.rows() == 0) return 0;
  const Eigen::RowVector3d extent = V.colwise().maxCoeff() - V.colwise().minCoeff();
  return std::isnormal(extent.squaredNorm()) ? extent.norm() : extent.stableNorm();
}

}  // namespace overtet
