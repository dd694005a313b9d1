#include "kernels/elastic/material.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/elastic/tuning.h"

namespace overtet {

namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

Matrix3d cofactors(const Matrix3d& A) {
  Matrix3d C;
  for (int k = 0; k < 3; ++k) C.col(k) = A.col((k + 1) % 3).cross(A.col((k + 2) % 3));
  return C;
}

// det(I + G) - 1, of small G with all digits.
double volume_change(const Matrix3d& G) {
  const double trace = G.trace();
  return trace + (trace * trace - (G * G).trace()) / 2 + G.determinant();
}

// x - log(1 + x), of small x with all digits. pre: x > -1.
double over_log(double x) {
  if (std::abs(x) > 0.01) return x - std::log1p(x);
  double sum = 0;  // x^2/2 - x^3/3 + ...; the ninth term is below rounding
  for (int n = 9; n >= 2; --n) sum = sum * -x + 1.0 / n;
  return sum * x * x;
}

struct Barrier {
  double value = 0, first = 0, second = 0;  // derivatives by J
};

// pre: J > 0.
Barrier barrier(const Lame& lame, double J) {
  if (J >= kBarrierVolume) return {};
  const double k = 2 * lame.mu + lame.lambda, x = J / kBarrierVolume, y = 1 - x, log = std::log(x);
  return {-k * y * y * log, k * (2 * y * log - y * y / x) / kBarrierVolume,
          k * (-2 * log + 4 * y / x + y * y / (x * x)) / (kBarrierVolume * kBarrierVolume)};
}

struct Neo {
  double mu, lambda;  // of the stable neo-Hookean law
};
Neo neo_of(const Lame& lame) { return {4 * lame.mu / 3, lame.lambda + 5 * lame.mu / 6}; }

struct Frame {
  Matrix3d U, V;
  Vector3d sigma;
};

// The rotation nearest to F, by Newton's method on X'X = I, scaled [Higham 1986]: X becomes the mean of
// itself and its inverse transposed. pre: det F > 0.
Matrix3d rotation_of(const Matrix3d& F) {
  Matrix3d X = F;
  for (int round = 0; round < kMostRounds; ++round) {
    const Matrix3d C = cofactors(X), inverse = C / X.col(0).dot(C.col(0));
    const double scale = std::sqrt(inverse.norm() / X.norm());
    const Matrix3d next = (scale * X + inverse / scale) / 2;
    const bool near =
        (next - X).squaredNorm() <= kRounding * kPrecise;  // the next one is exact but for rounding
    X = next;
    if (near) {
      const Matrix3d D = cofactors(X);
      return (X + D / X.col(0).dot(D.col(0))) / 2;
    }
  }
  return X;
}

// pre: det F > 0.
Frame frame_of(const Matrix3d& F) {
  const Matrix3d R = rotation_of(F), S = R.transpose() * F;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> e((S + S.transpose()) / 2);
  Frame f{Matrix3d(), e.eigenvectors(), e.eigenvalues()};
  if (f.V.determinant() < 0) f.V.col(2) *= -1;
  f.U = R * f.V;
  return f;
}

// Derivatives by the stretches: second derivatives, and for the plane without axis k the eigenvalues of the
// mode that is symmetric and of the one that turns.
struct Curvatures {
  Matrix3d stretch;
  Vector3d shear, turn;
};

Curvatures st_venant_kirchhoff(const Lame& l, const Vector3d& s) {
  const double trace = (s.squaredNorm() - 3) / 2;
  Curvatures c;
  c.stretch = l.lambda * s * s.transpose();
  for (int k = 0; k < 3; ++k) {
    const double a = s[(k + 1) % 3], b = s[(k + 2) % 3];
    c.stretch(k, k) += l.mu * (3 * s[k] * s[k] - 1) + l.lambda * trace;
    c.shear[k] = l.mu * (a * a + a * b + b * b - 1) + l.lambda * trace;
    c.turn[k] = l.mu * (a * a - a * b + b * b - 1) + l.lambda * trace;
  }
  return c;
}

Curvatures corotated(const Lame& l, const Vector3d& s) {
  Curvatures c;
  c.stretch = Matrix3d::Constant(l.lambda) + 2 * l.mu * Matrix3d::Identity();
  c.shear.setConstant(2 * l.mu);
  for (int k = 0; k < 3; ++k) {
    const double sum = s[(k + 1) % 3] + s[(k + 2) % 3];
    c.turn[k] = 2 * (l.mu * (sum - 2) + l.lambda * (s.sum() - 3)) / sum;
  }
  return c;
}

Curvatures neo_hookean(const Lame& l, const Vector3d& s) {
  const auto [mu, lambda] = neo_of(l);
  const double n = s.squaredNorm() + 1, J = s.prod(), spread = mu * (1 - 1 / n);
  const double pressure = lambda * (J - 1) - 0.75 * mu;
  Curvatures c;
  c.stretch = 2 * mu / (n * n) * s * s.transpose();
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    c.stretch(k, k) += spread + lambda * s[i] * s[i] * s[j] * s[j];
    const double mixed = lambda * J * s[k] + pressure * s[k];
    c.stretch(i, j) += mixed, c.stretch(j, i) += mixed;
    c.shear[k] = spread - pressure * s[k];
    c.turn[k] = spread + pressure * s[k];
  }
  return c;
}

void add_barrier(const Barrier& b, const Vector3d& s, Curvatures& c) {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    c.stretch(k, k) += b.second * s[i] * s[i] * s[j] * s[j];
    const double mixed = (b.second * s.prod() + b.first) * s[k];
    c.stretch(i, j) += mixed, c.stretch(j, i) += mixed;
    c.shear[k] -= b.first * s[k];
    c.turn[k] += b.first * s[k];
  }
}

void make_definite(Curvatures& c) {
  c.shear = c.shear.cwiseMax(0.0), c.turn = c.turn.cwiseMax(0.0);
  const Matrix3d& A = c.stretch;
  if (A(0, 0) > 0 && A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1) > 0 && A.determinant() > 0) return;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> e(A);
  c.stretch = e.eigenvectors() * e.eigenvalues().cwiseMax(0.0).asDiagonal() * e.eigenvectors().transpose();
}

}  // namespace

Lame lame_of(double young, double poisson) {
  OVERTET_EXPECTS(young > 0 && poisson > -1 && poisson < 0.5);
  return {young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

double energy_density(const ElasticLaw& law, const Matrix3d& G) {
  const Lame& l = law.lame;
  const double change = volume_change(G);
  if (!(1 + change > 0)) return std::numeric_limits<double>::infinity();
  double energy = barrier(l, 1 + change).value;
  switch (law.material) {
    case ElasticMaterial::st_venant_kirchhoff: {
      const Matrix3d E = (G + G.transpose() + G.transpose() * G) / 2;
      energy += l.mu * E.squaredNorm() + l.lambda / 2 * E.trace() * E.trace();
      break;
    }
    case ElasticMaterial::corotated: {
      const Matrix3d F = Matrix3d::Identity() + G, R = rotation_of(F);
      const double trace = R.cwiseProduct(F).sum() - 3;
      energy += l.mu * (F - R).squaredNorm() + l.lambda / 2 * trace * trace;
      break;
    }
    case ElasticMaterial::neo_hookean: {
      const auto [mu, lambda] = neo_of(l);
      const double trace = G.trace(), square = G.squaredNorm();
      const double minors = (trace * trace - (G * G).trace()) / 2;
      energy += 0.375 * mu * (square - 2 * minors - 2 * G.determinant()) +
                mu / 2 * over_log((2 * trace + square) / 4) + lambda / 2 * change * change;
      break;
    }
  }
  return energy;
}

Matrix3d piola_stress(const ElasticLaw& law, const Matrix3d& G) {
  const Lame& l = law.lame;
  const Matrix3d F = Matrix3d::Identity() + G;
  const double change = volume_change(G);
  Matrix3d P = Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (!(1 + change > 0)) return P;
  switch (law.material) {
    case ElasticMaterial::st_venant_kirchhoff: {
      const Matrix3d E = (G + G.transpose() + G.transpose() * G) / 2;
      P = F * (2 * l.mu * E + l.lambda * E.trace() * Matrix3d::Identity());
      break;
    }
    case ElasticMaterial::corotated: {
      const Matrix3d R = rotation_of(F);
      P = 2 * l.mu * (F - R) + l.lambda * (R.cwiseProduct(F).sum() - 3) * R;
      break;
    }
    case ElasticMaterial::neo_hookean: {
      const auto [mu, lambda] = neo_of(l);
      const double d = 2 * G.trace() + G.squaredNorm();  // |F|^2 - 3
      P = 0.75 * mu * (G + G.transpose() - G.trace() * Matrix3d::Identity() - cofactors(G)) +
          mu * d / (4 * (4 + d)) * F + lambda * change * cofactors(F);
      break;
    }
  }
  if (const Barrier b = barrier(l, 1 + change); b.first != 0) P += b.first * cofactors(F);
  return P;
}

MaterialTangent material_tangent(const ElasticLaw& law, const Matrix3d& G, Tangent tangent) {
  const Frame f = frame_of(Matrix3d::Identity() + G);
  Curvatures c = law.material == ElasticMaterial::st_venant_kirchhoff ? st_venant_kirchhoff(law.lame, f.sigma)
                 : law.material == ElasticMaterial::corotated         ? corotated(law.lame, f.sigma)
                                                                      : neo_hookean(law.lame, f.sigma);
  if (const double J = f.sigma.prod(); J > 0 && J < kBarrierVolume)
    add_barrier(barrier(law.lame, J), f.sigma, c);
  if (tangent == Tangent::definite) make_definite(c);
  return {f.U, f.V, c.stretch, (c.shear + c.turn) / 2, (c.shear - c.turn) / 2};
}

Matrix3d MaterialTangent::times(const Matrix3d& dF) const {
  const Matrix3d D = U.transpose() * dF * V;
  Matrix3d T;
  T.diagonal() = stretch * D.diagonal();
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    T(i, j) = same[k] * D(i, j) + cross[k] * D(j, i);
    T(j, i) = same[k] * D(j, i) + cross[k] * D(i, j);
  }
  return U * T * V.transpose();
}

double von_mises_stress(const ElasticLaw& law, const Matrix3d& G) {
  const Matrix3d F = Matrix3d::Identity() + G;
  const Matrix3d cauchy = piola_stress(law, G) * F.transpose() / (1 + volume_change(G));
  const Matrix3d deviator = cauchy - cauchy.trace() / 3 * Matrix3d::Identity();
  return std::sqrt(1.5 * deviator.squaredNorm());
}

}  // namespace overtet
