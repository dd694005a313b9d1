#include "kernels/tet_energy/tet_energy.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

namespace overtet {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// J = sum of x_k w_k^T: the rows of W are the gradients of the reference tet's hat functions.
struct Reference {
  std::array<Vector3d, 4> w;
  Reference() {
    // A regular, positive tet with edge length 1, scaled to volume 1/6 (so that det(J) = 1 at size 1
    // means the volume of the regular tet with edge 2^(1/2), which is a cube's corner cut off).
    Matrix3d D;
    D.col(0) = Vector3d(1, 0, 0);
    D.col(1) = Vector3d(0.5, std::sqrt(3.0) / 2, 0);
    D.col(2) = Vector3d(0.5, std::sqrt(3.0) / 6, std::sqrt(2.0 / 3.0));
    // Inverse by cofactors; D is upper triangular.
    Matrix3d I = Matrix3d::Zero();
    I(0, 0) = 1 / D(0, 0);
    I(1, 1) = 1 / D(1, 1);
    I(2, 2) = 1 / D(2, 2);
    I(0, 1) = -D(0, 1) * I(1, 1) * I(0, 0);
    I(1, 2) = -D(1, 2) * I(2, 2) * I(1, 1);
    I(0, 2) = -(D(0, 1) * I(1, 2) + D(0, 2) * I(2, 2)) * I(0, 0);
    for (int k = 0; k < 3; ++k) w[k + 1] = I.row(k).transpose();
    w[0] = -(w[1] + w[2] + w[3]);
  }
};
const Reference& reference() {
  static const Reference r;
  return r;
}

Matrix3d jacobian(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, double size) {
  const auto& w = reference().w;
  return ((b - a) * w[1].transpose() + (c - a) * w[2].transpose() + (d - a) * w[3].transpose()) / size;
}

double det3(const Matrix3d& J) { return J.col(0).dot(J.col(1).cross(J.col(2))); }

}  // namespace

double relative_volume(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
                       double size) {
  return det3(jacobian(a, b, c, d, size));
}

double shape_energy(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, double size,
                    double eps) {
  const Matrix3d J = jacobian(a, b, c, d, size);
  const double det = det3(J), chi = eps > 0 ? 0.5 * (det + std::hypot(det, eps)) : det;
  if (!(chi > 0)) return std::numeric_limits<double>::infinity();
  return J.squaredNorm() / (3 * std::cbrt(chi * chi));
}

double shape_energy(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, double size,
                    double eps, TetEnergy& out) {
  const Matrix3d J = jacobian(a, b, c, d, size);
  const double det = det3(J), root = eps > 0 ? std::hypot(det, eps) : std::fabs(det);
  const double chi = eps > 0 ? 0.5 * (det + root) : det;
  if (!(chi > 0)) return out.value = std::numeric_limits<double>::infinity();
  const double chi1 = eps > 0 ? chi / root : 1;                            // d chi / d det
  const double chi2 = eps > 0 ? eps * eps / (2 * root * root * root) : 0;  // second derivative
  const double h = 1 / (3 * std::cbrt(chi * chi));                         // the energy is |J|^2 h(det)
  const double h1 = -2.0 / 3 * h / chi * chi1;
  double h2 = 10.0 / 9 * h / (chi * chi) * chi1 * chi1 - 2.0 / 3 * h / chi * chi2;
  const double norm = J.squaredNorm();
  out.value = norm * h;
  Matrix3d C;  // d det / d J
  C.col(0) = J.col(1).cross(J.col(2));
  C.col(1) = J.col(2).cross(J.col(0));
  C.col(2) = J.col(0).cross(J.col(1));
  // As a function of (J, det) the energy is convex when h h'' >= 2 h'^2; make it so where it is not.
  h2 = std::max(h2, 2 * h1 * h1 / h);
  const auto& w = reference().w;
  Eigen::Matrix<double, 3, 4> Jw, Cw;
  for (int k = 0; k < 4; ++k) {
    const Vector3d v = w[k] / size;
    Jw.col(k) = J * v;
    Cw.col(k) = C * v;
    out.gradient.segment<3>(3 * k) = 2 * h * Jw.col(k) + norm * h1 * Cw.col(k);
  }
  for (int k = 0; k < 4; ++k)
    for (int l = 0; l < 4; ++l) {
      Matrix3d block = 2 * h1 * (Jw.col(k) * Cw.col(l).transpose() + Cw.col(k) * Jw.col(l).transpose()) +
                       norm * h2 * Cw.col(k) * Cw.col(l).transpose();
      block.diagonal().array() += 2 * h * w[k].dot(w[l]) / (size * size);
      out.hessian.block<3, 3>(3 * k, 3 * l) = block;
    }
  return out.value;
}

double dihedral_angle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
                      Eigen::Matrix<double, 12, 1>* gradient) {
  const Vector3d e = b - a, u = c - a, w = d - a;
  const Vector3d n1 = e.cross(u), n2 = w.cross(e);  // of abc towards d, of abd towards c
  const double ee = e.squaredNorm(), length = std::sqrt(ee);
  const double angle = std::atan2(length * n1.dot(w), -n1.dot(n2));
  if (gradient) {
    const Vector3d gc = -length / n1.squaredNorm() * n1, gd = -length / n2.squaredNorm() * n2;
    const double tc = u.dot(e) / ee, td = w.dot(e) / ee;
    gradient->segment<3>(0) = -(1 - tc) * gc - (1 - td) * gd;
    gradient->segment<3>(3) = -tc * gc - td * gd;
    gradient->segment<3>(6) = gc;
    gradient->segment<3>(9) = gd;
  }
  return angle;
}

bool positive_on_the_way(const Vector3d* from, const Vector3d* to) {
  Vector3d p[3], q[3];
  for (int k = 0; k < 3; ++k) {
    p[k] = from[k + 1] - from[0];
    q[k] = to[k + 1] - to[0];
  }
  const auto det = [](const Vector3d& x, const Vector3d& y, const Vector3d& z) { return x.dot(y.cross(z)); };
  return det(p[0], p[1], p[2]) > 0 && det(q[0], q[1], q[2]) > 0 &&
         det(q[0], p[1], p[2]) + det(p[0], q[1], p[2]) + det(p[0], p[1], q[2]) > 0 &&
         det(p[0], q[1], q[2]) + det(q[0], p[1], q[2]) + det(q[0], q[1], p[2]) > 0;
}

}  // namespace overtet
