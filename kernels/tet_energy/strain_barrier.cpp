#include "kernels/tet_energy/strain_barrier.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace overtet {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// phi and its first two derivatives. pre: x > 0.
struct Barrier {
  double value = 0, slope = 0, bend = 0;
  explicit Barrier(double x) {
    if (x >= 1) return;
    const double g = ((x - 3) * x + 3) * x, g1 = (3 * x - 6) * x + 3, g2 = 6 * x - 6;
    value = 1 / g - 1;
    slope = -g1 / (g * g);
    bend = (2 * g1 * g1 / g - g2) / (g * g);
  }
};

// J = U diag(s) V' with rotations U and V. pre: det J > 0.
struct Factors {
  Matrix3d U, V;
  Vector3d s;
  explicit Factors(const Matrix3d& J) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(J.transpose() * J);
    V = solver.eigenvectors();  // the largest last
    if (V.determinant() < 0) V.col(0) = -V.col(0);
    U.col(2) = (J * V.col(2)).normalized();
    const Vector3d second = J * V.col(1);
    U.col(1) = (second - U.col(2).dot(second) * U.col(2)).normalized();
    U.col(0) = U.col(1).cross(U.col(2));
    for (int i = 0; i < 3; ++i) s[i] = U.col(i).dot(J * V.col(i));
  }
};

}  // namespace

RestTet rest_tet(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  Matrix3d edges;
  edges << b - a, c - a, d - a;
  RestTet rest;
  rest.volume = edges.determinant() / 6;
  rest.hats.rightCols<3>() = edges.inverse().transpose();
  rest.hats.col(0) = -rest.hats.rightCols<3>().rowwise().sum();
  return rest;
}

double strain_barrier(const Eigen::Matrix<double, 3, 4>& x, const RestTet& rest, const StrainWeights& w) {
  const Matrix3d J = x * rest.hats.transpose();
  const double det = J.determinant();
  if (!(det > 0)) return std::numeric_limits<double>::infinity();
  return w.strain / 4 * (J.transpose() * J - Matrix3d::Identity()).squaredNorm() +
         w.barrier * Barrier(det).value;
}

// In the basis of J's singular vectors the Hessian falls apart: three by three for the singular values, and
// an eigenvalue for each twist and each flip of two axes [Smith, De Goes, Kim 2019].
double strain_barrier(const Eigen::Matrix<double, 3, 4>& x, const RestTet& rest, const StrainWeights& w,
                      Curvature curvature, TetEnergy& out) {
  const Matrix3d J = x * rest.hats.transpose();
  const double det = J.determinant();
  if (!(det > 0)) return out.value = std::numeric_limits<double>::infinity();
  const Barrier barrier(det);
  const Matrix3d strain = J.transpose() * J - Matrix3d::Identity();
  out.value = w.strain / 4 * strain.squaredNorm() + w.barrier * barrier.value;
  Matrix3d cofactors;
  cofactors << J.col(1).cross(J.col(2)), J.col(2).cross(J.col(0)), J.col(0).cross(J.col(1));
  const Matrix3d stress = w.strain * J * strain + w.barrier * barrier.slope * cofactors;
  Eigen::Map<Eigen::Matrix<double, 3, 4>>(out.gradient.data()) = stress * rest.hats;

  const Factors f(J);
  const Vector3d& s = f.s;
  const double slope = w.barrier * barrier.slope, bend = w.barrier * barrier.bend;
  Matrix3d scaling;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double ci = s[(i + 1) % 3] * s[(i + 2) % 3], cj = s[(j + 1) % 3] * s[(j + 2) % 3];
      scaling(i, j) = bend * ci * cj + (i == j ? w.strain * (3 * s[i] * s[i] - 1) : slope * s[3 - i - j]);
    }
  const auto allowed = [&](double eigenvalue) {
    return curvature == Curvature::definite ? std::max(eigenvalue, 0.0) : eigenvalue;
  };
  const Eigen::Matrix<double, 3, 4> turned = f.V.transpose() * rest.hats;
  out.hessian.setZero();
  Eigen::Matrix<double, 3, 4> direction;
  const auto add = [&](double eigenvalue) {
    if (eigenvalue == 0) return;
    const Eigen::Map<Eigen::Matrix<double, 12, 1>> g(direction.data());
    out.hessian.noalias() += eigenvalue * g * g.transpose();
  };
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scaling);
  for (int e = 0; e < 3; ++e) {
    direction = f.U * solver.eigenvectors().col(e).asDiagonal() * turned;
    add(allowed(solver.eigenvalues()[e]));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j) {
      const double squares = w.strain * (s[i] * s[i] + s[j] * s[j] - 1), product = w.strain * s[i] * s[j],
                   other = slope * s[3 - i - j];
      const Eigen::Matrix<double, 3, 4> a = f.U.col(i) * turned.row(j), b = f.U.col(j) * turned.row(i);
      direction = (a - b) * std::sqrt(0.5);
      add(allowed(squares - product + other));
      direction = (a + b) * std::sqrt(0.5);
      add(allowed(squares + product - other));
    }
  return out.value;
}

}  // namespace overtet
