#include "kernels/arap/arap.h"

#include <Eigen/Dense>
#include <cmath>

#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/laplacian/laplacian.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

Eigen::Matrix3d best_rotation_by_svd(const Eigen::Matrix3d& S) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d V = svd.matrixV();
  const Eigen::Matrix3d U = svd.matrixU();
  if ((V * U.transpose()).determinant() < 0) V.col(2) = -V.col(2);
  return V * U.transpose();
}

}  // namespace

Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& S_in) {
  const double size = S_in.norm();
  if (!(size > 1e-280) || !std::isfinite(size)) return Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d S = S_in / size;
  // trace(R S) = q' N q for the unit quaternion q of R; S = sum w u', so S(a, b) = sum w_a u_b.
  const double xx = S(0, 0), xy = S(0, 1), xz = S(0, 2), yx = S(1, 0), yy = S(1, 1), yz = S(1, 2),
               zx = S(2, 0), zy = S(2, 1), zz = S(2, 2);
  Eigen::Matrix4d N;
  N << xx + yy + zz, yz - zy, zx - xz, xy - yx,  //
      yz - zy, xx - yy - zz, xy + yx, zx + xz,   //
      zx - xz, xy + yx, -xx + yy - zz, yz + zy,  //
      xy - yx, zx + xz, yz + zy, -xx - yy + zz;
  const double c2 = -2.0, c1 = -8 * S.determinant(), c0 = N.determinant();  // |S| = 1
  double x = 1.7320508075688774;                                            // sqrt(3) |S| >= the root
  bool converged = false;
  for (int i = 0; i < 30 && !converged; ++i) {
    const double x2 = x * x, value = (x2 + c2) * x2 + c1 * x + c0, slope = 4 * x2 * x + 2 * c2 * x + c1;
    if (!(slope > 1e-4)) break;  // nearly a double root
    const double step = value / slope;
    x -= step;
    converged = std::abs(step) < 1e-14;
  }
  if (converged) {
    N.diagonal().array() -= x;
    // Any non-zero column of the adjugate is the eigenvector; the largest is the most accurate.
    Eigen::Vector4d best = Eigen::Vector4d::Zero();
    double largest = 0;
    for (int col = 0; col < 4; ++col) {
      Eigen::Vector4d q;
      for (int r = 0; r < 4; ++r) {
        Eigen::Matrix3d minor;
        for (int i = 0, a = 0; i < 4; ++i) {
          if (i == col) continue;
          for (int j = 0, b = 0; j < 4; ++j) {
            if (j == r) continue;
            minor(a, b++) = N(i, j);
          }
          ++a;
        }
        q[r] = ((r + col) % 2 ? -1 : 1) * minor.determinant();
      }
      const double norm = q.squaredNorm();
      if (norm > largest) largest = norm, best = q;
      if (largest > 0.01) break;  // accurate enough; the order of columns is fixed
    }
    if (largest > 1e-8) {
      best /= std::sqrt(largest);
      const double w = best[0], a = best[1], b = best[2], c = best[3];
      Eigen::Matrix3d R;
      R << 1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b),  //
          2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a),   //
          2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b);
      return R;
    }
  }
  return best_rotation_by_svd(S);
}

Arap::Arap(const VertexMatrix& W, const TriangleMatrix& F) : F_(F) {
  OVERTET_EXPECTS(all_below(F, W.rows()));
  const Eigen::Index faces = F.rows(), vertices = W.rows();
  weight_ = half_cotangents(W, F);
  L_ = cotangent_laplacian(W, F);
  rest_edges_.resize(3 * faces, 3);
  std::vector<Index> count(static_cast<std::size_t>(vertices), 0);
  for (Eigen::Index f = 0; f < faces; ++f) {
    for (int k = 0; k < 3; ++k) {
      rest_edges_.row(3 * f + k) = W.row(F(f, (k + 2) % 3)) - W.row(F(f, (k + 1) % 3));
      ++count[F(f, k)];
    }
  }
  std::vector<Index> slot(static_cast<std::size_t>(vertices), -1);
  star_begin_.push_back(0);
  for (Index v = 0; v < vertices; ++v) {
    if (count[v] == 0) continue;
    slot[v] = static_cast<Index>(used_.size());
    used_.push_back(v);
    star_begin_.push_back(star_begin_.back() + count[v]);
  }
  star_.resize(static_cast<std::size_t>(3 * faces));
  std::vector<Index> next(star_begin_.begin(), star_begin_.end() - 1);
  for (Eigen::Index f = 0; f < faces; ++f)
    for (int k = 0; k < 3; ++k) star_[next[slot[F(f, k)]]++] = static_cast<Index>(3 * f + k);
  rotation_.assign(static_cast<std::size_t>(vertices), Eigen::Matrix3d::Identity());
  face_.resize(static_cast<std::size_t>(faces));
}

void Arap::fit_rotations(const VertexMatrix& U) {
  parallel_for(F_.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 3; ++k)
        S += weight_(f, k) * rest_edges_.row(3 * f + k).transpose() *
             (U.row(F_(f, (k + 2) % 3)) - U.row(F_(f, (k + 1) % 3)));
      face_[f] = S;
    }
  });
  parallel_for(static_cast<std::int64_t>(used_.size()), kMediumGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
                   for (Index s = star_begin_[i]; s < star_begin_[i + 1]; ++s) S += face_[star_[s] / 3];
                   rotation_[used_[i]] = best_rotation(S);
                 }
               });
}

void Arap::gradient(const VertexMatrix& U, VertexMatrix& G) const {
  G.setZero(U.rows(), 3);
  // Per face: the sum over its edges c ((u_j - u_k) - mean R (w_j - w_k)), one row per corner.
  VertexMatrix corner(3 * F_.rows(), 3);
  parallel_for(F_.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      const Index a = F_(f, 0), b = F_(f, 1), c = F_(f, 2);
      const Eigen::Matrix3d R = (rotation_[a] + rotation_[b] + rotation_[c]) / 3;
      Eigen::RowVector3d e[3];
      for (int k = 0; k < 3; ++k)
        e[k] = weight_(f, k) * (U.row(F_(f, (k + 2) % 3)) - U.row(F_(f, (k + 1) % 3)) -
                                rest_edges_.row(3 * f + k) * R.transpose());
      // Edge k runs from corner k+1 to corner k+2.
      for (int k = 0; k < 3; ++k) corner.row(3 * f + k) = e[(k + 1) % 3] - e[(k + 2) % 3];
    }
  });
  parallel_for(static_cast<std::int64_t>(used_.size()), kMediumGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                   for (Index s = star_begin_[i]; s < star_begin_[i + 1]; ++s) sum += corner.row(star_[s]);
                   G.row(used_[i]) = sum;
                 }
               });
}

double Arap::energy(const VertexMatrix& U) const {
  return parallel_reduce(
      F_.rows(), 2 * kMediumGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (std::int64_t f = begin; f < end; ++f) {
          for (int k = 0; k < 3; ++k) {
            const Eigen::RowVector3d u = U.row(F_(f, (k + 2) % 3)) - U.row(F_(f, (k + 1) % 3));
            for (int i = 0; i < 3; ++i)
              sum += weight_(f, k) / 6 *
                     (u - rest_edges_.row(3 * f + k) * rotation_[F_(f, i)].transpose()).squaredNorm();
          }
        }
        return sum;
      },
      [](double x, double y) { return x + y; });
}

}  // namespace overtet
