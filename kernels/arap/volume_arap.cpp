#include "kernels/arap/volume_arap.h"

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

#include "kernels/arap/arap.h"
#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

VolumeArap::VolumeArap(const VertexMatrix& W, const TetMatrix& T) : T_(T) {
  OVERTET_EXPECTS(all_below(T, W.rows()));
  const std::size_t tets = static_cast<std::size_t>(T.rows()), vertices = static_cast<std::size_t>(W.rows());
  volume_.resize(tets);
  hats_.resize(tets);
  rotation_.assign(tets, Eigen::Matrix3d::Identity());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(10 * tets);
  star_begin_.assign(vertices + 1, 0);
  for (std::size_t t = 0; t < tets; ++t) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = W.row(T(t, k + 1)) - W.row(T(t, 0));
    volume_[t] = edges.determinant() / 6;
    OVERTET_EXPECTS(volume_[t] > 0);
    hats_[t].rightCols<3>() = edges.inverse().transpose();
    hats_[t].col(0) = -hats_[t].rightCols<3>().rowwise().sum();
    for (int k = 0; k < 4; ++k) {
      ++star_begin_[T(t, k) + 1];
      for (int l = 0; l <= k; ++l)
        entries.emplace_back(std::max(T(t, k), T(t, l)), std::min(T(t, k), T(t, l)),
                             volume_[t] * hats_[t].col(k).dot(hats_[t].col(l)));
    }
  }
  L_.resize(W.rows(), W.rows());
  L_.setFromTriplets(entries.begin(), entries.end());
  L_.makeCompressed();
  std::partial_sum(star_begin_.begin(), star_begin_.end(), star_begin_.begin());
  star_.resize(4 * tets);
  std::vector<Index> next(star_begin_.begin(), star_begin_.end() - 1);
  for (std::size_t t = 0; t < tets; ++t)
    for (int k = 0; k < 4; ++k) star_[next[T(t, k)]++] = static_cast<Index>(4 * t + k);
}

Eigen::Matrix3d VolumeArap::jacobian(const VertexMatrix& U, Eigen::Index t) const {
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 4; ++k) J += U.row(T_(t, k)).transpose() * hats_[t].col(k).transpose();
  return J;
}

void VolumeArap::fit_rotations(const VertexMatrix& U) {
  parallel_for(T_.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) rotation_[t] = best_rotation(jacobian(U, t).transpose());
  });
}

void VolumeArap::gradient(const VertexMatrix& U, VertexMatrix& G) const {
  std::vector<Eigen::Matrix3d> stress(volume_.size());
  parallel_for(T_.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) stress[t] = volume_[t] * (jacobian(U, t) - rotation_[t]);
  });
  G.setZero(U.rows(), 3);
  parallel_for(G.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      for (Index s = star_begin_[v]; s < star_begin_[v + 1]; ++s)
        G.row(v) += (stress[star_[s] / 4] * hats_[star_[s] / 4].col(star_[s] % 4)).transpose();
  });
}

double VolumeArap::energy(const VertexMatrix& U) const {
  return parallel_reduce(
      T_.rows(), 2 * kMediumGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (std::int64_t t = begin; t < end; ++t)
          sum += volume_[t] / 2 * (jacobian(U, t) - rotation_[t]).squaredNorm();
        return sum;
      },
      [](double x, double y) { return x + y; });
}

}  // namespace overtet
