#include "src/solve/elastic_potential.h"

#include <cmath>

namespace overtet::solve_detail {

namespace {

// Sum of w_v |d_v|^2.
double weighed_square(const Eigen::VectorXd& w, const VertexMatrix& d) {
  return (w.array() * d.rowwise().squaredNorm().array()).sum();
}

}  // namespace

ElasticPotential::Value ElasticPotential::value(const VertexMatrix& x) const {
  Value v;
  const auto add = [&](double part, double size) { v.sum += part, v.size += size; };
  const double elastic = body->energy(x);
  add(elastic, std::abs(elastic));
  const VertexMatrix d = x - base;
  const VertexMatrix work = force.cwiseProduct(d);
  add(-work.sum(), work.cwiseAbs().sum());
  const auto add_positive = [&](double part) { add(part, part); };
  if (inertia > 0) add_positive(inertia / 2 * weighed_square(*mass, x - predicted));
  if (drag > 0) add_positive(drag / 2 * weighed_square(*mass, d));
  if (viscosity > 0) add_positive(viscosity / 2 * body->curvature(at_base, d));
  return v;
}

VertexMatrix ElasticPotential::gradient(const VertexMatrix& x, double& size) const {
  ElasticBody::Stresses P;
  body->stresses(x, P);
  const VertexMatrix d = x - base;
  if (viscosity > 0) body->add_change(at_base, d, viscosity, P);
  double inside = 0;
  VertexMatrix g = body->gathered(P, inside);
  double squares = inside * inside + force.squaredNorm();
  g -= force;
  const auto add = [&](double rate, const VertexMatrix& way) {
    const VertexMatrix part = rate * (mass->asDiagonal() * way);
    squares += part.squaredNorm();
    g += part;
  };
  if (inertia > 0) add(inertia, x - predicted);
  if (drag > 0) add(drag, d);
  size = std::sqrt(squares);
  return g;
}

VertexMatrix ElasticPotential::change(const ElasticBody::Tangents& tangents, const VertexMatrix& d) const {
  ElasticBody::Stresses P(tangents.size(), Eigen::Matrix3d::Zero());
  body->add_change(tangents, d, 1, P);
  if (viscosity > 0) body->add_change(at_base, d, viscosity, P);
  double size = 0;
  return body->gathered(P, size) + (inertia + drag) * (mass->asDiagonal() * d);
}

void ElasticPotential::assemble(const ElasticBody::Tangents& tangents, SymmetricMatrix& A) const {
  const Eigen::VectorXd diagonal = (inertia + drag) * *mass;
  if (viscosity > 0)
    body->assemble({{&tangents, 1}, {&at_base, viscosity}}, diagonal, A);
  else
    body->assemble({{&tangents, 1}}, diagonal, A);
}

}  // namespace overtet::solve_detail
