#include "src/solve/elastic_potential.h"

#include <cmath>

namespace overtet::solve_detail {

ElasticPotential::Slope ElasticPotential::slope(const VertexMatrix& x) const {
  Slope out;
  Value& value = out.value;
  ElasticBody::Stresses P;
  const VertexMatrix d = x - base;
  value.sum = value.size = body->stresses(x, P);
  const VertexMatrix work = force.cwiseProduct(d);
  value.sum -= work.sum(), value.size += work.cwiseAbs().sum();
  const auto add_positive = [&](double part) { value.sum += part, value.size += part; };
  if (viscosity > 0) {
    add_positive(viscosity / 2 * body->curvature(at_base, d));
    body->add_change(at_base, d, viscosity, P);
  }
  double inside = 0;
  out.gradient = body->gathered(P, inside) - force;
  double squares = inside * inside + force.squaredNorm();
  const auto add = [&](double rate, const VertexMatrix& way) {
    const VertexMatrix part = rate * (mass->asDiagonal() * way);
    add_positive(part.cwiseProduct(way).sum() / 2);
    squares += part.squaredNorm();
    out.gradient += part;
  };
  if (inertia > 0) add(inertia, x - predicted);
  if (drag > 0) add(drag, d);
  out.size = std::sqrt(squares);
  return out;
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
