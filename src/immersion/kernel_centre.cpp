#include "src/immersion/kernel_centre.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;
// Twice the digits of a double where there is such a type.
#ifdef __SIZEOF_FLOAT128__
using Wide = __float128;
#else
using Wide = long double;
#endif

// Rows of the half-spaces n.x + d >= 0, in units of the star's size, x relative to the start.
struct Planes {
  Eigen::MatrixX3d normal;  // of length 1, inward
  Eigen::VectorXd distance;
  double size = 0;  // the largest distance of a corner from the start
};

// False where a wall has no normal.
bool plane_of(const Wall& wall, const Vector3d& start, Vector3d& normal, double& distance) {
  Wide u[3], w[3], s[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = Wide(wall[1][i]) - wall[0][i];
    w[i] = Wide(wall[2][i]) - wall[0][i];
    s[i] = Wide(start[i]) - wall[0][i];
  }
  Wide n[3], largest = 0, d = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    n[i] = u[j] * w[k] - u[k] * w[j];
    d += n[i] * s[i];
    largest = std::max(largest, n[i] < 0 ? -n[i] : n[i]);
  }
  if (!(largest > 0)) return false;
  for (int i = 0; i < 3; ++i) normal[i] = static_cast<double>(n[i] / largest);
  const double length = normal.norm();
  normal /= length;
  distance = static_cast<double>(d / largest) / length;
  return true;
}

std::optional<Planes> planes_of(const std::vector<Wall>& walls, const Vector3d& start) {
  Planes out;
  out.normal.resize(static_cast<Eigen::Index>(walls.size()), 3);
  out.distance.resize(static_cast<Eigen::Index>(walls.size()));
  for (std::size_t i = 0; i < walls.size(); ++i) {
    Vector3d normal;
    double distance;
    if (!plane_of(walls[i], start, normal, distance)) return std::nullopt;
    out.normal.row(static_cast<Eigen::Index>(i)) = normal;
    out.distance[static_cast<Eigen::Index>(i)] = distance;
    for (const Vector3d& corner : walls[i]) out.size = std::max(out.size, (corner - start).norm());
  }
  if (!(out.size > 0)) return std::nullopt;
  out.distance /= out.size;
  return out;
}

// Maximises weight.z + sum log(slack) from a point inside, where slack = d + M z, by Newton's method. The
// slacks are carried along and not computed anew from z: near the walls that keeps their digits.
class Barrier {
 public:
  // rows: M.
  Barrier(Eigen::MatrixXd rows, Eigen::VectorXd slack)
      : rows_(std::move(rows)), slack_(std::move(slack)), z_(Eigen::VectorXd::Zero(rows_.cols())) {}

  const Eigen::VectorXd& z() const { return z_; }

  // One damped step; the square of Newton's decrement, 0 where no step is left.
  double step(const Eigen::VectorXd& weight) {
    const Eigen::MatrixXd scaled = slack_.cwiseInverse().asDiagonal() * rows_;
    // QR, and not the normal matrix, whose condition is the square of the kernel's thinness.
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
    const Eigen::VectorXd gradient = scaled.transpose() * Eigen::VectorXd::Ones(rows_.rows()) + weight;
    const auto r = qr.matrixR().topRows(rows_.cols()).template triangularView<Eigen::Upper>();
    const Eigen::VectorXd half = r.transpose().solve(qr.colsPermutation().transpose() * gradient);
    const Eigen::VectorXd direction = qr.colsPermutation() * r.solve(half);
    const double decrement = half.squaredNorm();
    const Eigen::VectorXd change = rows_ * direction;
    if (!std::isfinite(decrement) || !change.allFinite()) return 0;
    double length = 1;  // at most half the way to a wall
    for (Eigen::Index i = 0; i < change.size(); ++i)
      if (change[i] < 0) length = std::min(length, slack_[i] / (-2 * change[i]));
    // The objective is concave: its slope decides how far.
    for (; length > kRounding; length /= 2) {
      double slope = weight.dot(direction);
      for (Eigen::Index i = 0; i < change.size(); ++i) slope += change[i] / (slack_[i] + length * change[i]);
      if (slope >= -decrement / 2) break;
    }
    if (!(length > kRounding)) return 0;
    z_ += length * direction;
    slack_ += length * change;
    return slack_.minCoeff() > 0 ? decrement : 0;
  }

 private:
  Eigen::MatrixXd rows_;
  Eigen::VectorXd slack_, z_;
};

// A point where all distances are positive, by pushing the least of them up: maximises weight * t + sum
// log(distance - t) for growing weights.
std::optional<Vector3d> inside(const Planes& planes) {
  const Eigen::Index n = planes.distance.size();
  if (planes.distance.minCoeff() > kPrecise) return Vector3d::Zero();
  // The walls moved out by some of the size may meet far away, where digits end: a box keeps the search near.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n + 6, 4);
  rows.topRows(n) << planes.normal, Eigen::VectorXd::Constant(n, -1);
  rows.block<3, 3>(n, 0).setIdentity();
  rows.block<3, 3>(n + 3, 0) = -Eigen::Matrix3d::Identity();
  const double least = planes.distance.minCoeff() - 0.25;
  Eigen::VectorXd slack = Eigen::VectorXd::Constant(n + 6, 2);
  slack.head(n) = planes.distance.array() - least;
  Barrier barrier(std::move(rows), std::move(slack));
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(4);
  // What opens less than that is closed.
  const double least_open = std::numeric_limits<double>::epsilon() / 16;
  for (weight[3] = static_cast<double>(n); weight[3] < static_cast<double>(n) / least_open; weight[3] *= 8) {
    for (int i = 0; i < kMostRounds; ++i)
      if (barrier.step(weight) < kPrecise) break;
    if (least + barrier.z()[3] <= 0) continue;
    const Vector3d x = barrier.z().head<3>();
    if ((planes.normal * x + planes.distance).minCoeff() > 0) return x;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Vector3d> kernel_centre(const std::vector<Wall>& walls, const Vector3d& start) {
  const std::optional<Planes> planes = planes_of(walls, start);
  if (!planes) return std::nullopt;
  const std::optional<Vector3d> first = inside(*planes);
  if (!first) return std::nullopt;
  Barrier barrier(planes->normal, planes->normal * *first + planes->distance);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(3);
  for (int i = 0; i < kMostRounds; ++i)
    if (barrier.step(none) < kPrecise) break;
  return Vector3d(planes->size * (*first + barrier.z()));
}

}  // namespace overtet
